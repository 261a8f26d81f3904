//! Readings of a run against predictions at other moments: whole samples away, or any time away.
//!
//! A reading's residual against the predictions of the samples about it is a smooth function of
//! their stamps. Between them it is interpolated (Lagrange's cubic), so that a shift of the clock
//! needs no other evaluation of the model and knows how unevenly samples are spaced.

use std::ops::Range;

use crate::campaign::Samples;
use crate::engine::part::SampleLeaves;
use crate::engine::{Part, Point, Problem};
use crate::estimate::residuals::Residuals;
use crate::statistics::upper_median;

mod nearest;
mod own_place;

/// Sample periods looked at, in both senses: of long runs fewer, so that about so many residuals are
/// computed and kept; of very long ones the fewest.
const PERIODS: std::ops::RangeInclusive<usize> = 12..=40;
const RESIDUALS: usize = 4_000_000;
/// Mean square of the readings of a shifted stretch where they stand, over their robust variance.
const FAR: f64 = 16.0;
/// The same where they belong.
const NEAR: f64 = 4.0;
/// A shorter stretch is one of outliers.
const SHORTEST: usize = 4;
/// Steps of a grid of shifts of the clock to either side, and how many grids there are, each about
/// the best of the one before: predictions may move by thousands of standard deviations a period.
const STEPS: isize = 12;
const ZOOMS: usize = 5;
/// Samples of a stretch by which shifts of the clock are judged at most.
const JUDGED: usize = 500;
/// Squared standard scores by which whole samples may fit worse than a shift of the clock.
const WORSE: f64 = 25.0;

/// Squares of one run's residuals, over their robust variance, against predictions.
pub(super) struct Shifted<'a> {
    part: &'a Part,
    run: usize,
    /// Of each residual component.
    scatter: Vec<f64>,
    predicted: Vec<Vec<f64>>,
    times: Vec<f64>,
    /// The usual sample period (s).
    pub(super) period: f64,
    /// How many sample periods are looked at, in both senses.
    reach: isize,
    /// Readings of each sample.
    readings: Vec<usize>,
    /// By shift from `-reach` on and sample: the sum over its readings; NaN without a prediction.
    squares: Vec<Vec<f32>>,
}

/// From a reading's stamp to the moment that it is compared with.
enum Shift {
    /// So many samples later.
    Samples(isize),
    /// So many usual periods later.
    Time(f64),
}

impl<'a> Shifted<'a> {
    /// The residuals of `sound` give the scatter of each component.
    pub(super) fn new(
        problem: &'a Problem,
        (p, run): (usize, usize),
        point: &Point,
        sound: &[Residuals],
    ) -> Self {
        let part = &problem.parts[p];
        let own = sound.iter().filter(|one| one.part == p);
        let scatter = own.map(|one| one.scatter(problem)).collect();
        let record = &part.runs[run].record;
        let parameters = problem.parameters::<f64>(p, run, point);
        let randoms = vec![0.0; part.random_sigma.len()];
        let (mut predicted, mut times) = (Vec::with_capacity(record.len()), Vec::new());
        let mut workspace = Vec::new();
        record.walk(|stretch| {
            for sample in stretch.each() {
                let (randoms, columns) = (&randoms[..], part.columns());
                let leaves = SampleLeaves { parameters: &parameters, randoms, columns, sample };
                predicted.push(part.evaluate(&leaves, &mut workspace).to_vec());
                times.push(sample.time());
            }
        });
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let period = upper_median(&mut steps).unwrap_or(f64::NAN);
        let reach = RESIDUALS / (2 * times.len().max(1));
        let reach = reach.clamp(*PERIODS.start(), *PERIODS.end()) as isize;
        let (readings, squares) = (Vec::new(), Vec::new());
        let all = Self { part, run, scatter, predicted, times, period, reach, readings, squares };
        let (mut readings, mut squares) = (Vec::new(), vec![Vec::new(); all.shifts().count()]);
        all.walk(&(0..all.times.len()), |number, residuals| {
            readings.push(residuals(number).map_or(0, |all| all.len()));
            for (shift, squares) in all.shifts().zip(&mut squares) {
                let there = number.checked_add_signed(shift).and_then(&residuals);
                squares.push(there.map_or(f32::NAN, |all| square(&all) as f32));
            }
        });
        Self { readings, squares, ..all }
    }

    /// Shows samples with their residuals, over their scatter, against the prediction of any sample.
    fn walk(
        &self,
        samples: &Range<usize>,
        mut visit: impl FnMut(usize, &dyn Fn(usize) -> Option<Vec<f64>>),
    ) {
        let mut scratch = Samples::default();
        for sample in self.part.runs[self.run].record.stretch(samples.clone(), &mut scratch).each()
        {
            let residuals = |other: usize| {
                let outputs = self.predicted.get(other)?;
                let mut all = Vec::new();
                for slot in self.part.slots().iter().filter(|one| self.part.is_present(sample, one))
                {
                    let values = self.part.residual(sample, slot, outputs);
                    let scatter = &self.scatter[slot.residual..][..slot.components];
                    all.extend(values.iter().zip(scatter).map(|(value, one)| value / one));
                }
                Some(all)
            };
            visit(sample.number, &residuals);
        }
    }

    /// The shifts that are looked at, in sample periods.
    pub(super) fn shifts(&self) -> std::ops::RangeInclusive<isize> {
        -self.reach..=self.reach
    }

    /// The best shift, stretch and gain, of those that carry a stretch from far out back among the
    /// others; far nearer to them where a shift may be between samples (`is_between`).
    pub(super) fn best(&self, is_between: bool) -> Option<(isize, Range<usize>, f64)> {
        let here = &self.squares[self.reach as usize];
        let mut best: Option<(isize, Range<usize>, f64)> = None;
        for (shift, there) in self.shifts().zip(&self.squares).filter(|(n, _)| *n != 0) {
            let gain = |(here, there): (&f32, &f32)| f64::from(here - there);
            let gains = here.iter().zip(there).map(gain);
            let (stretch, gain) =
                largest_sum(gains.map(|gain| if gain.is_nan() { 0.0 } else { gain }));
            let readings: usize = self.readings[stretch.clone()].iter().sum();
            let mean = |all: &[f32]| {
                let present = all[stretch.clone()].iter().filter(|one| !one.is_nan());
                present.map(|one| f64::from(*one)).sum::<f64>() / readings.max(1) as f64
            };
            let (here, there) = (mean(here), mean(there));
            let near = if is_between { here / FAR } else { NEAR };
            let carried = stretch.len() >= SHORTEST && here >= FAR && there <= near;
            let stretch = self.to_the_end(stretch, shift);
            if carried && best.as_ref().is_none_or(|(.., most)| gain > *most) {
                best = Some((shift, stretch, gain));
            }
        }
        best
    }

    /// Where a stretch reaches as far as there is something to compare with, to the end of the run.
    fn to_the_end(&self, stretch: Range<usize>, shift: isize) -> Range<usize> {
        let (count, reach) = (self.times.len(), shift.unsigned_abs());
        let end = if shift > 0 && stretch.end + reach == count { count } else { stretch.end };
        let start = if shift < 0 && stretch.start == reach { 0 } else { stretch.start };
        start..end
    }

    /// Looks at some samples no more.
    pub(super) fn forget(&mut self, samples: &Range<usize>) {
        for squares in &mut self.squares {
            squares[samples.clone()].fill(0.0);
        }
    }

    /// Whether the stamps of whole samples fit a stretch, and each half of it, as well as the best
    /// shift of the clock, and the whole better than a quarter of a period away from it: a drift may
    /// fit whole samples on average but not in each half.
    pub(super) fn is_whole(&self, periods: isize, samples: &Range<usize>) -> bool {
        let (about, reach) = (periods as f64, periods.abs() + 4);
        let shifts =
            [Shift::Samples(periods), Shift::Time(about - 0.25), Shift::Time(about + 0.25)];
        // Near the ends of a run a half may have no readings with others on both sides.
        let is_best = |samples: &Range<usize>, own: f64, count: f64| {
            let mut grids = self.grids((about, 1.0), samples, reach);
            count == 0.0 || grids.all(|(_, free, _)| !is_worse(own, free, count))
        };
        let (sums, count) = self.sums(&shifts, samples, reach);
        count > 0.0
            && sums[1..].iter().all(|apart| is_worse(*apart, sums[0], count))
            && is_best(samples, sums[0], count)
            && halves(samples).iter().filter(|half| half.len() >= SHORTEST).all(|half| {
                let (own, count) = self.sums(&shifts[..1], half, reach);
                is_best(half, own[0], count)
            })
    }

    /// Of finer and finer grids of moments about so many usual periods away the best, the least sum
    /// of squares of a stretch, and the number of readings.
    fn grids(
        &self,
        (mut about, mut width): (f64, f64),
        samples: &Range<usize>,
        reach: isize,
    ) -> impl Iterator<Item = (f64, f64, f64)> {
        (0..ZOOMS).map(move |_| {
            let grid = (-STEPS..=STEPS).map(|n| about + width * n as f64 / STEPS as f64);
            let grid: Vec<f64> = grid.collect();
            let shifts: Vec<Shift> = grid.iter().copied().map(Shift::Time).collect();
            let (sums, count) = self.sums(&shifts, samples, reach);
            let at = (0..grid.len()).min_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0);
            (about, width) = (grid[at], 2.0 * width / STEPS as f64);
            (grid[at], sums[at], count)
        })
    }

    /// The sums of squares of a stretch against predictions at each of some shifts, and the number
    /// of readings: of samples with so many others on both sides.
    fn sums(&self, shifts: &[Shift], samples: &Range<usize>, reach: isize) -> (Vec<f64>, f64) {
        let (mut sums, mut count) = (vec![0.0; shifts.len()], 0.0);
        let every = samples.len().div_ceil(JUDGED).max(1);
        let reach = reach.unsigned_abs();
        self.walk(samples, |number, residuals| {
            let is_inside = number >= reach && number + reach < self.times.len();
            if !is_inside || !(number - samples.start).is_multiple_of(every) {
                return;
            }
            let squares = shifts.iter().map(|shift| match shift {
                Shift::Samples(n) => {
                    residuals(number.checked_add_signed(*n)?).map(|all| square(&all))
                }
                Shift::Time(n) => self.at(self.times[number] + n * self.period, residuals),
            });
            let Some(squares) = squares.collect::<Option<Vec<f64>>>() else { return };
            count += self.readings[number] as f64;
            sums.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
        });
        (sums, count)
    }

    /// The square of residuals between the predictions of the four samples about a moment.
    fn at(&self, moment: f64, residuals: &dyn Fn(usize) -> Option<Vec<f64>>) -> Option<f64> {
        let next = self.times.partition_point(|time| *time <= moment);
        let first = next.checked_sub(2)?;
        let times = self.times.get(first..first + 4)?;
        let mut sum: Vec<f64> = Vec::new();
        for (k, own) in times.iter().enumerate() {
            let others = times.iter().enumerate().filter(|(other, _)| *other != k);
            let weight: f64 = others.map(|(_, other)| (moment - other) / (own - other)).product();
            let values = residuals(first + k)?;
            sum.resize(values.len(), 0.0);
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
        }
        Some(square(&sum)).filter(|sum| sum.is_finite())
    }
}

fn square(all: &[f64]) -> f64 {
    all.iter().map(|value| value * value).sum()
}

/// Whether a sum of squares of so many readings is worse than another one by more than chance. Residuals
/// that are larger than their scatter count for less.
fn is_worse(one: f64, other: f64, count: f64) -> bool {
    one - other > WORSE * (other / count.max(1.0)).max(1.0)
}

fn halves(samples: &Range<usize>) -> [Range<usize>; 2] {
    let middle = samples.start + samples.len() / 2;
    [samples.start..middle, middle..samples.end]
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
