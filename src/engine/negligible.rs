//! Columns of angles that are nothing but rounding: an angle without any effect on readings, as a turn
//! about the vertical where everything is level, has derivatives that cancel to the last digit, not to
//! zero. They are zero here, so that no step follows rounding and observability sees what has no effect.
//!
//! Angles alone: a radian is their natural size, while other unknowns may be 1e12 of their units.

use crate::engine::Point;
use crate::engine::gram::Normal;
use crate::engine::layout::Layout;
use crate::graph::Kind;

/// Length of an angle's column, in standard uncertainties of all readings for a radian (for its value,
/// where that is more), below which it is rounding...
const LENGTH: f64 = 1e-9;
/// ... or in parts of the longest column of an angle, ...
const PART: f64 = 1e-13;
/// ... but not beyond this length.
const LONGEST: f64 = 1e-3;

/// Puts zeros into the columns of a linearised problem that are rounding.
pub(super) fn without_rounding(normal: &mut Normal, layout: &Layout, point: &Point) {
    let mut sizes: Vec<Option<f64>> = vec![None; normal.columns.len()];
    for (index, one) in layout.instances.iter().enumerate() {
        let is_turn = one.kind == Kind::Rotation;
        if is_turn || one.unit.is_angle() {
            for (component, column) in layout.own_columns(index) {
                let value = if is_turn { 1.0 } else { point.values[index][component].abs() };
                sizes[column] = Some(value.max(1.0));
            }
        }
    }
    let touched: Vec<Vec<usize>> =
        (0..normal.runs.len()).map(|run| normal.columns.touched_by(run)).collect();
    let mut lengths = vec![0.0; sizes.len()];
    for (run, touched) in normal.runs.iter().zip(&touched) {
        for (at, column) in touched.iter().enumerate() {
            lengths[*column] += run.gram[(at, at)] * sizes[*column].map_or(0.0, |size| size * size);
        }
    }
    let longest = lengths.iter().copied().fold(0.0, f64::max).sqrt();
    let least = LENGTH.max(PART * longest).min(LONGEST);
    let is_rounding = |column: &usize| {
        let length = lengths[*column].sqrt();
        length > 0.0 && length < least
    };
    if !(0..lengths.len()).any(|column| is_rounding(&column)) {
        return;
    }
    for (run, touched) in normal.runs.iter_mut().zip(&touched) {
        let rounding = touched.iter().enumerate().filter(|(_, column)| is_rounding(column));
        for (at, _) in rounding {
            run.gram.row_mut(at).fill(0.0);
            run.gram.column_mut(at).fill(0.0);
        }
    }
}
