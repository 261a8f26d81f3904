//! Bursts: stretches of readings that are far out, of one measurand or of whole samples.
//!
//! A range whose direct way is blocked, or an instrument that follows another target for a while, is
//! wrong from one sample to the next and right again as suddenly. So a burst has sharp ends, lies far
//! out nearly all along, and ends in the run that it began in. What rises and falls is structure, and
//! so is what lasts to an end of a run, what a shift of the clock explains, and what comes back at
//! the same place of an input or at the same time of a run.

use std::ops::Range;

use crate::engine::Problem;
use crate::estimate::residuals::Residuals;
use crate::statistics::{median_size, upper_median};

use super::left_out::{OfSamples, rare};
use super::limits::{MOST_OUTLIERS, OUTLIER, limit};
use super::places::comes_back;

/// Readings so many robust standard deviations out are far out.
pub(super) const TRIM: f64 = 4.5;
/// A stretch has so many readings at least, at most one in so many of its run's, and one in so many
/// where it reaches an end of the run.
const SHORTEST: usize = 4;
const LONGEST: usize = 4;
const LONGEST_AT_END: usize = 20;
/// So many of its readings next to each other may be near.
const GAP: usize = 2;
/// Part of them that is far out, and robust standard deviations that half of them are out at least.
const FULL: f64 = 0.8;
pub(super) const FAR: f64 = 6.0;
/// Part of that by which residuals leap at both ends.
const LEAP: f64 = 0.5;
/// Part of a stretch that is far out in each measurand where whole samples are wrong.
const WHOLE: f64 = 0.5;

/// How far out the readings of a measurand in a run are: samples and robust standard deviations.
type Sizes = Vec<(usize, f64)>;

/// The bursts among residuals seen from a fit that they do not bend.
pub(super) fn bursts(problem: &Problem, all: &[Residuals]) -> Vec<OfSamples> {
    let mut found = Vec::new();
    for of_part in all.chunk_by(|a, b| a.part == b.part) {
        let measurands: Vec<&[Residuals]> = of_part.chunk_by(|a, b| a.of() == b.of()).collect();
        for run in 0..of_part[0].runs.len() {
            let sizes: Vec<Sizes> = measurands.iter().map(|own| sizes(own, run)).collect();
            let whole = whole_samples(&sizes);
            let bursts: Vec<Option<Vec<Range<usize>>>> =
                sizes.iter().map(|sizes| of_one(sizes, &whole)).collect();
            // Where one measurand is wrong, so may be others, by less than shows reading by reading.
            for (own, known) in measurands.iter().zip(&bursts) {
                let Some(known) = known else { continue };
                let others = bursts.iter().flatten().flatten().filter(|samples| {
                    !overlaps(samples, known) && is_offset(own, run, samples, known)
                });
                let mut beside: Vec<Range<usize>> = others.cloned().collect();
                beside.sort_by_key(|samples| (samples.start, samples.end));
                beside.dedup();
                let of = own[0].in_run(run);
                found.extend(known.iter().cloned().chain(beside).map(|samples| (of, samples)));
            }
        }
    }
    rare(problem, found, |of, found| comes_back(problem, of, found))
}

/// The bursts of one measurand: those of whole samples, and its own. `None` where so much remains far
/// out that the stretches are not all of it.
fn of_one(sizes: &Sizes, whole: &[Range<usize>]) -> Option<Vec<Range<usize>>> {
    let new = stretches(sizes).into_iter().filter(|one| !overlaps(one, whole));
    let own: Vec<Range<usize>> = whole.iter().cloned().chain(new).collect();
    let rest = sizes.iter().filter(|(at, _)| !own.iter().any(|one| one.contains(at)));
    let far = rest.filter(|(_, size)| *size > TRIM).count();
    (far as f64 <= MOST_OUTLIERS * sizes.len() as f64).then_some(own)
}

/// Whether the median of a measurand's readings in a stretch differs from that of as many before and
/// after it, by one robust standard deviation and by [`FAR`] of those of a difference of medians.
/// Readings of its own bursts do not count.
fn is_offset(
    own: &[Residuals],
    run: usize,
    samples: &Range<usize>,
    bursts: &[Range<usize>],
) -> bool {
    let Range { start, end } = *samples;
    let count = end - start;
    let ranges = [start..end, start.saturating_sub(count)..start, end..end + count];
    let is_out = |at: &usize| bursts.iter().any(|one| one.contains(at));
    own.iter().any(|one| {
        let values = ranges.clone().map(|range| -> Vec<f64> {
            let all = range.filter(|at| !is_out(at)).filter_map(|at| one.runs[run].get(at));
            all.copied().filter(|value| !value.is_nan()).collect()
        });
        if values.iter().any(|some| some.len() < SHORTEST) {
            return false;
        }
        let [mut inside, before, after] = values;
        let mut outside = [before, after].concat();
        let parts = 1.0 / inside.len() as f64 + 1.0 / outside.len() as f64;
        let of_medians = (std::f64::consts::FRAC_PI_2 * parts).sqrt();
        let least = limit(one, run) / OUTLIER * (FAR * of_medians).max(1.0);
        let medians = upper_median(&mut inside).zip(upper_median(&mut outside));
        medians.is_some_and(|(inside, outside)| (inside - outside).abs() > least)
    })
}

/// The sizes of a measurand's readings in a run, of the component that is farthest out.
fn sizes(own: &[Residuals], run: usize) -> Sizes {
    let of = |one: &Residuals| -> Sizes {
        let unit = limit(one, run) / OUTLIER;
        one.readings(run).into_iter().map(|(at, value)| (at, value.abs() / unit)).collect()
    };
    let farthest = |mut all: Sizes, other: Sizes| {
        all.iter_mut().zip(other).for_each(|(size, other)| size.1 = size.1.max(other.1));
        all
    };
    own.iter().map(of).reduce(farthest).unwrap_or_default()
}

/// Stretches in which all measurands of a run are wrong; none where there is but one.
fn whole_samples(all: &[Sizes]) -> Vec<Range<usize>> {
    let read: Vec<&Sizes> = all.iter().filter(|sizes| !sizes.is_empty()).collect();
    if read.len() < 2 {
        return Vec::new();
    }
    let mut joint: Sizes = read.iter().flat_map(|sizes| sizes.iter().copied()).collect();
    joint.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    joint.dedup_by_key(|one| one.0);
    let mut found = stretches(&joint);
    found.retain(|samples| {
        read.iter().all(|sizes| {
            let own = sizes.iter().filter(|(at, _)| samples.contains(at));
            let far = own.clone().filter(|(_, size)| *size > TRIM).count();
            far > 0 && far as f64 >= WHOLE * own.count() as f64
        })
    });
    found
}

/// The stretches that are bursts.
fn stretches(sizes: &[(usize, f64)]) -> Vec<Range<usize>> {
    let far: Vec<usize> = (0..sizes.len()).filter(|at| sizes[*at].1 > TRIM).collect();
    let groups = far.chunk_by(|before, after| after - before <= GAP + 1);
    let groups = groups.filter(|group| {
        let (first, last) = (group[0], group[group.len() - 1]);
        let count = last + 1 - first;
        let is_at_end = first < GAP || last + GAP >= sizes.len();
        let longest = sizes.len() / if is_at_end { LONGEST_AT_END } else { LONGEST };
        let own: Vec<f64> = sizes[first..=last].iter().map(|one| one.1).collect();
        // The two readings on either side of an end, for one of them may be off by chance.
        let farthest = |range: Range<usize>| own[range].iter().copied().fold(0.0, f64::max);
        let nearest = |range: Range<usize>| {
            let outside = sizes.get(range).unwrap_or_default();
            outside.iter().map(|one| one.1).reduce(f64::min).unwrap_or(0.0)
        };
        let inside = [farthest(0..2.min(count)), farthest(count.saturating_sub(2)..count)];
        let after = last + 1..(last + 3).min(sizes.len());
        let outside = [nearest(first.saturating_sub(2)..first), nearest(after)];
        let half = median_size(&own).unwrap_or(0.0);
        let leaps = inside.iter().zip(outside);
        let is_sharp =
            leaps.map(|(inside, outside)| inside - outside).all(|leap| leap >= LEAP * half);
        (SHORTEST..=longest).contains(&count)
            && group.len() as f64 >= FULL * count as f64
            && half >= FAR
            && is_sharp
    });
    groups.map(|group| sizes[group[0]].0..sizes[group[group.len() - 1]].0 + 1).collect()
}

fn overlaps(one: &Range<usize>, others: &[Range<usize>]) -> bool {
    others.iter().any(|other| one.start < other.end && other.start < one.end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(size: impl Fn(usize) -> f64) -> Vec<Range<usize>> {
        let sizes: Sizes = (0..400).map(|k| (k, 0.5 + size(k))).collect();
        stretches(&sizes)
    }

    #[test]
    fn what_is_suddenly_wrong_and_right_again_is_a_burst() {
        let within = |k: usize, range: Range<usize>| if range.contains(&k) { 12.0 } else { 0.0 };
        assert_eq!(found(|k| within(k, 100..130) + within(k, 250..260)), [100..130, 250..260]);
        // To the end, as long as half a run, and a crest.
        assert!(found(|k| within(k, 300..400)).is_empty());
        assert!(found(|k| within(k, 100..300)).is_empty());
        let crest = |k: usize| 30.0 * (-0.5 * ((k as f64 - 200.0) / 5.0).powi(2)).exp();
        assert!(found(crest).is_empty());
    }
}
