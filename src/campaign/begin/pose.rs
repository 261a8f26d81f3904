//! Poses in a plane among the columns of a log: two axes, and a heading about the third one.

use crate::campaign::begin::axis_columns::PARTS;
use crate::campaign::begin::candidate::{Candidate, base};
use crate::campaign::begin::survey::Surveyed;
use crate::units::Unit;

/// Names of headings, those first that have no other meaning: theta and phi may be pitch and roll.
pub(super) const HEADINGS: [&str; 9] =
    ["yaw", "heading", "hdg", "psi", "rz", "theta", "th", "phi", "orientation"];
/// The third axis moves by so much of what the others do at most: no floor is even.
const HARDLY: f64 = 0.1;

/// Whether the last part of a column's name is one of these.
pub(super) fn is_called(column: &Surveyed, names: &[&str]) -> bool {
    let base = base(&column.name).0;
    base.rsplit(PARTS).next().is_some_and(|last| names.contains(&last))
}

/// The column of the heading.
pub(super) fn heading(all: &[Surveyed], free: &dyn Fn(&usize) -> bool) -> Option<usize> {
    let find = |is: &dyn Fn(&Surveyed, &str) -> bool| {
        HEADINGS.iter().find_map(|name| {
            let is_angle = |column: &Surveyed| column.unit.as_ref().is_none_or(Unit::is_angle);
            let fits = |at: &usize| is(&all[*at], name) && free(at) && is_angle(&all[*at]);
            (0..all.len()).find(fits)
        })
    };
    let whole = find(&|column, name| base(&column.name).0 == name);
    whole.or_else(|| find(&|column, name| is_called(column, &[name])))
}

/// The pose in a plane of a position or of two axes, and a heading; else why there is none.
pub(super) fn in_plane(
    all: &[Surveyed],
    position: Option<&[Candidate; 3]>,
    axes: Option<&[Candidate; 2]>,
    heading: Option<&Candidate>,
) -> Result<[Candidate; 3], String> {
    let Some(heading) = heading else {
        return Err(format!("no column of an angle that moves is called {}", HEADINGS.join(", ")));
    };
    let Some(position) = position else {
        let axes = axes.ok_or(
            "no two columns of lengths that both move have names that differ in x and y alone",
        )?;
        let [x, y] = axes.clone();
        return Ok([x, y, heading.clone()]);
    };
    let way = position.each_ref().map(|axis| all[axis.column].way() * axis.unit.factor);
    // The axis upwards is most often z; of motion capture it may be y.
    let upright = [2, 1, 0].into_iter().find_map(|up| {
        let [first, second] = [(up + 1) % 3, (up + 2) % 3];
        let is_still = way[up] <= HARDLY * way[first].max(way[second]);
        is_still.then(|| [position[first].clone(), position[second].clone(), heading.clone()])
    });
    upright.ok_or_else(|| {
        let names = position.each_ref().map(|axis| format!("`{}`", all[axis.column].name));
        format!("{} all move, and none is an axis upwards", names.join(", "))
    })
}
