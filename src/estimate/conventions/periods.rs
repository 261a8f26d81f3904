//! Angles that are read beyond half a turn, where their formula comes back from the other side, and
//! whose period nobody stated: that is asked for elsewhere, and no convention is to make up for it.

use std::f64::consts::TAU;

use crate::engine::Problem;
use crate::estimate::checks::without_period;
use crate::graph::MeasurandKind;

/// The problem with a period of a turn for such angles.
pub(super) fn with_periods(problem: &Problem) -> Problem {
    let mut parts = problem.parts.clone();
    let mut is_changed = false;
    for part in &mut parts {
        let found = without_period(part);
        if found.is_empty() {
            continue;
        }
        let mut system = part.system.clone();
        for number in found {
            system.assembly.names.measurands[number].kind = MeasurandKind::Angle { period: TAU };
        }
        *part = part.with_system(system);
        is_changed = true;
    }
    if is_changed { problem.with_parts(parts) } else { problem.clone() }
}
