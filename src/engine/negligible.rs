//! Columns that are nothing but rounding: an unknown without any effect on readings, as a turn about
//! the vertical where everything is level, or a height where an offset begins at zero, has derivatives
//! that cancel to the last digit, not to zero. They are zero here, so that no step follows rounding and
//! observability sees what has no effect. Each linearisation is looked at anew: such an unknown comes
//! back once others have moved.
//!
//! A radian is the natural size of an angle. Other unknowns may be 1e12 of their units, or 1e-12:
//! their columns are compared with those of the same kind, which readings see in the same way.

use crate::engine::Point;
use crate::engine::gram::Normal;
use crate::engine::layout::Layout;
use crate::graph::Kind;
use crate::units::Dimension;

/// Length of an angle's column, in standard uncertainties of all readings for a radian (for its value,
/// where that is more), below which it is rounding...
const LENGTH: f64 = 1e-9;
/// ... or in parts of the longest column of an angle, ...
const PART: f64 = 1e-13;
/// ... but not beyond this length.
const LONGEST: f64 = 1e-3;
/// The same of other unknowns, in parts of the longest column of their kind: about 50 units in the
/// last place. Beside it no double holds a change that is worth a standard uncertainty.
const PART_OF_KIND: f64 = 1e-14;

/// With which other columns one is compared.
#[derive(Clone, Copy, PartialEq)]
enum Like {
    /// Those of angles and turns.
    Angle,
    /// Those of one dimension.
    Dimension(Dimension),
    /// The components of one vector of plain numbers.
    Vector(usize),
    /// A plain number with none: coefficients of powers differ by any factor.
    Nothing,
}

/// With what each column is compared, and how far its unknown may change: an angle by a radian or,
/// where that is more, by its value.
fn likes(layout: &Layout, point: &Point) -> Vec<(Like, f64)> {
    let mut likes = vec![(Like::Nothing, 1.0); layout.columns.len()];
    for (index, one) in layout.instances.iter().enumerate() {
        for (component, column) in layout.own_columns(index) {
            likes[column] = match (one.kind, one.unit.dimension) {
                (Kind::Rotation, _) => (Like::Angle, 1.0),
                _ if one.unit.is_angle() => {
                    (Like::Angle, point.values[index][component].abs().max(1.0))
                }
                (Kind::Vector, Dimension::NONE) => (Like::Vector(index), 1.0),
                (Kind::Scalar, Dimension::NONE) => (Like::Nothing, 1.0),
                (_, dimension) => (Like::Dimension(dimension), 1.0),
            };
        }
    }
    likes
}

/// Puts zeros into the columns of a linearised problem that are rounding.
pub(super) fn without_rounding(normal: &mut Normal, layout: &Layout, point: &Point) {
    let likes = likes(layout, point);
    let mut lengths = vec![0.0; likes.len()];
    for (run, sums) in normal.runs.iter().enumerate() {
        for (at, column) in normal.columns.touched_by(run).into_iter().enumerate() {
            lengths[column] += sums.gram[(at, at)];
        }
    }
    let mut all: Vec<(Like, f64)> = Vec::new();
    for (length, (like, size)) in lengths.iter_mut().zip(&likes) {
        *length = length.sqrt() * size;
        match all.iter_mut().find(|(own, _)| own == like) {
            Some((_, longest)) => *longest = longest.max(*length),
            None => all.push((*like, *length)),
        }
    }
    let least: Vec<(Like, f64)> = all
        .into_iter()
        .map(|(like, longest)| match like {
            Like::Angle => (like, LENGTH.max(PART * longest).min(LONGEST)),
            Like::Nothing => (like, 0.0),
            Like::Dimension(_) | Like::Vector(_) => (like, PART_OF_KIND * longest),
        })
        .collect();
    let is_rounding = |column: usize| {
        let least = least.iter().find(|(like, _)| *like == likes[column].0);
        lengths[column] > 0.0 && least.is_some_and(|(_, least)| lengths[column] < *least)
    };
    let rounding: Vec<bool> = (0..lengths.len()).map(is_rounding).collect();
    if rounding.contains(&true) {
        normal.zero_columns(|column| rounding[column]);
    }
}
