//! Lost samples: stretches of a run whose readings belong to moments whole sample periods away.
//!
//! An instrument that drops a sample, or a logger that skips a trigger, puts reading `i` beside the
//! stamp of trigger `i`, though it was taken at trigger `i + n`. For each shift `n` up to `PERIODS`
//! every reading is compared with the prediction at sample `i + n`; the stretch over which that
//! lowers the sum of squares most is the stretch of largest sum (Bentley's and Kadane's scan). A
//! shift is a simple hypothesis, so for one stretch and one shift the probability of such a gain
//! `G` by chance is below `exp(-G / 2)` (Markov's inequality for a likelihood ratio), and all
//! stretches and shifts are paid for.
//!
//! A shift by a whole period is gross: several degrees of a fast arm. It spoils the fit in which it
//! is looked for, so that is made without what is far out (`trimmed`), residuals are measured by
//! their own robust scatter, and only stretches that a shift carries from far out (`FAR`) back
//! among the others (`NEAR`) count. What is found is left out, the rest is fitted again, and the
//! search is repeated. It looks at single shifts of a run's own readings; a delay that wanders is
//! not its business.

use std::ops::Range;

use crate::diagnose::found::Lost;
use crate::diagnose::sequences::{Sequence, seen_from};
use crate::diagnose::thresholds::LOST;
use crate::engine::layout::qualified;
use crate::engine::part::SampleLeaves;
use crate::engine::{Point, Problem};
use crate::estimate::batch::{FitError, Options};

use super::left_out::Far;
use super::trimmed::{TrimmedFit, trimmed_fit};

/// Sample periods looked at, in both senses.
const PERIODS: isize = 5;
/// Mean square of the readings of a shifted stretch where they stand, over their robust variance.
const FAR: f64 = 16.0;
/// The same where they belong.
const NEAR: f64 = 4.0;
/// A shorter stretch is one of wild readings.
const SHORTEST: usize = 4;
/// Stretches of one run at most.
const MOST: usize = 10;
/// Rounds of fitting without what is far out.
const ROUNDS: usize = 6;
/// What is far out, in robust standard deviations.
const GROSS: f64 = 3.5;
/// Variance factor below which no samples are looked for that were lost.
const GROSS_FACTOR: f64 = 4.0;
/// Rounds of looking for lost samples, leaving them out and fitting again.
pub const LOOKS: usize = 4;

/// Squares of one run's residuals, over their robust variance, against shifted predictions.
struct Shifted {
    /// For each shift from `-PERIODS`, for each sample: sum over readings, and their number.
    squares: Vec<Vec<(f64, usize)>>,
}

/// The stretches that a fit shows, beside one that they do not spoil; none without gross misfit.
///
/// # Errors
/// [`FitError`] where what is not far out cannot be fitted at all.
pub fn look(
    problem: &Problem,
    point: &Point,
    variance_factor: Option<f64>,
    options: &Options,
) -> Result<Vec<Lost>, FitError> {
    if variance_factor.is_none_or(|factor| factor < GROSS_FACTOR) {
        return Ok(Vec::new());
    }
    Ok(find(problem, &sturdy(problem, point, Among::Campaign, options)?.0))
}

/// The stretches of all runs, at a point.
pub fn find(problem: &Problem, point: &Point) -> Vec<Lost> {
    let runs: usize = problem.parts.iter().map(|part| part.runs.len()).sum();
    let seen = seen_from(problem, point);
    let mut found = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        let own = seen.iter().filter(|one| one.part == p);
        let scatter: Vec<f64> = own.map(|one| scatter(problem, one)).collect();
        for (r, run) in part.runs.iter().enumerate() {
            let mut shifted = Shifted::new(problem, (p, r), point, &scatter);
            let count = run.record.len() as f64;
            let price = (0.5 * count * count * (2 * PERIODS) as f64 * runs as f64).max(1.0).ln();
            for _ in 0..MOST {
                let Some((periods, samples, gain)) = shifted.best() else { break };
                let ln_p = (price - 0.5 * gain).min(0.0);
                if ln_p > LOST.ln() {
                    break;
                }
                shifted.forget(&samples);
                let rows = (run.record.row(samples.start), run.record.row(samples.end - 1));
                let name = qualified(part.label.as_deref(), &run.name);
                found.push(Lost { part: p, run: r, name, samples, rows, periods, ln_p });
            }
        }
    }
    found
}

/// Among which readings one is far out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Among {
    /// Among all of its measurand: where most of a run may be wrong.
    Campaign,
    /// Among those of its run, too: where noise grows with the rate.
    Run,
}

/// A fit that gross readings do not spoil: the point, and the campaigns without what is far out.
///
/// # Errors
/// [`FitError`] where the rest cannot be fitted at all.
pub fn sturdy(
    problem: &Problem,
    point: &Point,
    among: Among,
    options: &Options,
) -> Result<(Point, Problem), FitError> {
    let far = |one: &Sequence| -> Far {
        let of_all = scatter(problem, one);
        let far = |run: usize| {
            let own = (among == Among::Run).then(|| one.among(|other| other == run));
            let own = own.map_or(0.0, |own| scatter(problem, &own));
            let mut readings = one.readings(run);
            readings.retain(|(_, value)| value.abs() > GROSS * of_all.max(own));
            readings
        };
        (0..one.runs.len()).map(far).collect()
    };
    let TrimmedFit { point, rest, .. } = trimmed_fit(problem, point, ROUNDS, far, options)?;
    Ok((point, rest))
}

/// Leaves the readings of these stretches out.
pub fn leave_out(problem: &mut Problem, lost: &[Lost]) {
    let mut parts = problem.parts.clone();
    for one in lost {
        let part = &mut parts[one.part];
        let columns = part.reading_columns();
        part.runs[one.run].record.leave_out([(one.samples.clone(), columns)]);
    }
    let progress = problem.progress.clone();
    *problem = Problem::new(parts);
    problem.progress = progress;
}

/// Robust standard deviation of residuals, at least what is stated.
fn scatter(problem: &Problem, one: &Sequence) -> f64 {
    one.deviation().unwrap_or(0.0).max(problem.parts[one.part].sigma[one.measurand])
}

impl Shifted {
    fn new(problem: &Problem, (p, r): (usize, usize), point: &Point, scatter: &[f64]) -> Self {
        let part = &problem.parts[p];
        let record = &part.runs[r].record;
        let parameters = problem.parameters::<f64>(p, r, point);
        let randoms = vec![0.0; part.random_sigma.len()];
        let mut predicted: Vec<Vec<f64>> = Vec::with_capacity(record.len());
        let mut workspace = Vec::new();
        record.walk(|stretch| {
            for sample in stretch.each() {
                let (randoms, columns) = (&randoms[..], part.columns());
                let leaves = SampleLeaves { parameters: &parameters, randoms, columns, sample };
                predicted.push(part.evaluate(&leaves, &mut workspace).to_vec());
            }
        });
        let mut squares = vec![vec![(0.0, 0); record.len()]; 2 * PERIODS as usize + 1];
        record.walk(|stretch| {
            for sample in stretch.each() {
                for (shift, squares) in (-PERIODS..=PERIODS).zip(&mut squares) {
                    let other = sample.number.checked_add_signed(shift);
                    let Some(outputs) = other.and_then(|other| predicted.get(other)) else {
                        continue;
                    };
                    for slot in part.slots().iter().filter(|slot| part.is_present(sample, slot)) {
                        let residual = part.residual(sample, slot, outputs);
                        for (component, value) in residual.iter().take(slot.components).enumerate()
                        {
                            let square = (value / scatter[slot.residual + component]).powi(2);
                            let at = &mut squares[sample.number];
                            *at = (at.0 + square, at.1 + 1);
                        }
                    }
                }
            }
        });
        Self { squares }
    }

    /// The shift, stretch and gain that are best.
    fn best(&self) -> Option<(isize, Range<usize>, f64)> {
        let here = &self.squares[PERIODS as usize];
        let mut best: Option<(isize, Range<usize>, f64)> = None;
        for (shift, there) in (-PERIODS..=PERIODS).zip(&self.squares).filter(|(n, _)| *n != 0) {
            let gains = here.iter().zip(there).map(|(here, there)| match there.1 {
                0 => 0.0,
                _ => here.0 - there.0,
            });
            let (stretch, gain) = largest_sum(gains);
            let readings: usize = here[stretch.clone()].iter().map(|one| one.1).sum();
            let mean = |all: &[(f64, usize)]| {
                all[stretch.clone()].iter().map(|one| one.0).sum::<f64>() / readings.max(1) as f64
            };
            let carried = stretch.len() >= SHORTEST && mean(here) >= FAR && mean(there) <= NEAR;
            let stretch = self.to_the_end(stretch, shift);
            if carried && best.as_ref().is_none_or(|(.., most)| gain > *most) {
                best = Some((shift, stretch, gain));
            }
        }
        best
    }

    /// A stretch that reaches as far as there is something to compare with reaches to the end of
    /// the run.
    fn to_the_end(&self, stretch: Range<usize>, shift: isize) -> Range<usize> {
        let (count, reach) = (self.squares[0].len(), shift.unsigned_abs());
        let end = if shift > 0 && stretch.end + reach == count { count } else { stretch.end };
        let start = if shift < 0 && stretch.start == reach { 0 } else { stretch.start };
        start..end
    }

    fn forget(&mut self, samples: &Range<usize>) {
        for squares in &mut self.squares {
            squares[samples.clone()].fill((0.0, 0));
        }
    }
}

/// The stretch of largest sum, with the sum.
fn largest_sum(values: impl Iterator<Item = f64>) -> (Range<usize>, f64) {
    let (mut best, mut most) = (0..0, 0.0);
    let (mut start, mut sum) = (0, 0.0);
    for (index, value) in values.enumerate() {
        if sum <= 0.0 {
            (start, sum) = (index, 0.0);
        }
        sum += value;
        if sum > most {
            (best, most) = (start..index + 1, sum);
        }
    }
    (best, most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_sum_is_found() {
        let (stretch, sum) = largest_sum([-1.0, 3.0, -1.0, 2.0, -5.0, 3.0].into_iter());
        assert_eq!((stretch, sum), (1..4, 4.0));
        assert_eq!(largest_sum([-1.0, -2.0].into_iter()), (0..0, 0.0));
    }
}
