//! Which of two starts fits better, and whether by so much that it is taken.

use crate::estimate::sample_squares::exceeded_by;

use super::thinned::{Thinned, Tried};
use super::{BETTER, FAR_BETTER, GOOD, ITERATIONS, KEPT, MOST};

/// Whether the best start fits so much better than the stated one that it takes its place. One that
/// fits badly all the same must fit far better, and nearly all samples: a few of them are fitted by
/// chance.
pub(super) fn is_enough(some: &Thinned, best: &Tried, [before, after]: [f64; 2]) -> bool {
    match after <= GOOD {
        true => before > GOOD && after <= BETTER * before,
        false => before > GOOD && keeps_most(some, best) && after <= FAR_BETTER * before,
    }
}

/// Whether a fit is one of nearly all samples.
fn keeps_most(some: &Thinned, one: &Tried) -> bool {
    one.readings as f64 >= KEPT * some.readings() as f64
}

/// The normalized residuals that most samples keep below, from the stated start and from the best,
/// where the best is far better: wrong readings may be most of both sums of squares.
pub(super) fn far_better_for_most(some: &Thinned, best: &Tried, own: &Tried) -> Option<[f64; 2]> {
    let exceeded = |one: &Tried| {
        exceeded_by(1.0 - MOST, &some.late_by(one.offset, &[one.offset])?, &one.point)
    };
    let [before, after] = [exceeded(own)?, exceeded(best)?];
    let is_far_better =
        own.variance_factor > GOOD && keeps_most(some, best) && after <= FAR_BETTER * before;
    is_far_better.then_some([before.sqrt(), after.sqrt()])
}

/// Whether a fit is better than another one, on the samples for which streams are there at both of
/// their offsets: a few samples are fitted more easily than many. One over fewer samples must fit
/// far better there.
pub(super) fn is_better(some: &Thinned, one: &Tried, other: &Tried) -> bool {
    let times = if one.readings < other.readings { BETTER } else { 1.0 };
    let on_both = |fit: &Tried| {
        let problem = some.late_by(fit.offset, &[one.offset, other.offset])?;
        let again = Tried::fit(problem, fit.point.clone(), fit.offset, ITERATIONS[1])?;
        Some(again.variance_factor)
    };
    match (on_both(one), on_both(other)) {
        (Some(one), Some(other)) => one < times * other,
        _ => one.variance_factor < times * other.variance_factor && one.readings >= other.readings,
    }
}
