//! Trimmed fits: a few outliers do not bend them, such as a pose that was recognised the other way up:
//! beside one of them the right convention fits as badly as any other.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use crate::engine::{Point, Problem};
use crate::estimate::minima::thinned::Tried;
use crate::estimate::sample_squares::{Place, sample_squares};
use crate::statistics::upper_median;

/// A sample is an outlier whose squared residuals are so many times those in the middle.
const OUTLIER: f64 = 50.0;
/// Part of a run's samples that may be: a run that is one as a whole was read in another convention.
const MOST: f64 = 0.2;
/// Fits at most.
const ROUNDS: usize = 3;

/// A fit with outliers and without them.
pub(super) struct Trimmed {
    /// Of all samples.
    pub(super) whole: Tried,
    /// Without the samples that are outliers beside it.
    pub(super) fit: Tried,
    /// The samples that it is a fit of.
    pub(super) kept: Problem,
}

/// A fit from a start, and without the samples that are outliers beside it. `None` where the model has
/// no values.
pub(super) fn trimmed_fit(problem: &Problem, start: Point, iterations: usize) -> Option<Trimmed> {
    let mut fitted = Tried::fit(problem.clone(), start, 0.0, iterations)?;
    let whole = fitted.clone();
    let (mut out, mut kept) = (BTreeSet::new(), problem.clone());
    for _ in 1..ROUNDS {
        let outliers = outliers(problem, &fitted.point);
        if outliers.is_empty() || outliers == out {
            break;
        }
        kept = problem.clone();
        for (part, run, sample) in &outliers {
            let part = &mut kept.parts[*part];
            let columns: Range<usize> = part.reading_columns();
            part.runs[*run].record.leave_out([(*sample..*sample + 1, columns)]);
        }
        fitted = Tried::fit(kept.clone(), fitted.point, 0.0, iterations)?;
        out = outliers;
    }
    Some(Trimmed { whole, fit: fitted, kept })
}

/// Campaign, run and number of the samples that are outliers; none where they are many of a run.
fn outliers(problem: &Problem, point: &Point) -> BTreeSet<Place> {
    let sizes = sample_squares(problem, point);
    let middle = upper_median(&mut sizes.iter().map(|one| one.0).collect::<Vec<_>>());
    let limit = OUTLIER * middle.unwrap_or(f64::INFINITY);
    let outliers: BTreeSet<_> = sizes.iter().filter(|one| one.0 > limit).map(|one| one.1).collect();
    let mut counts: BTreeMap<(usize, usize), [usize; 2]> = BTreeMap::new();
    for (_, at) in &sizes {
        let [all, out] = counts.entry((at.0, at.1)).or_default();
        *all += 1;
        *out += usize::from(outliers.contains(at));
    }
    let are_few = counts.values().all(|[all, out]| *out as f64 <= MOST * *all as f64);
    if are_few { outliers } else { BTreeSet::new() }
}
