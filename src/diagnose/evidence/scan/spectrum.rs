//! Fast oscillations: a range of frequencies up to what the sampling carries has too many members for a
//! grid. The spectrum of the residuals of a fit has all of them at once; its highest peaks are then
//! tried as members of a grid are.
//!
//! Residuals of each run and component, without a running mean, are put into bins of time, weighed by a Hann
//! window and transformed. Whether a peak is significant is not its
//! business.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::structure::FAST;
use crate::engine::Problem;

use super::Scan;
use super::grid::NEIGHBOURS;

/// Peaks that are tried, in one pass.
const PEAKS: usize = 4;
/// Bins of time at most.
const MOST_BINS: f64 = (1_u32 << 22) as f64;
/// Residuals of a component at least.
const FEWEST: usize = 16;

impl Scan<'_> {
    /// The best member of a family of fast oscillations, and the number of members that it was chosen
    /// among.
    pub(super) fn best_of_spectrum(&self) -> Option<(f64, usize)> {
        let (sampling, lowest) = self.sampling.as_ref()?;
        let (bin, highest) = sampling.bins().filter(|(_, highest)| highest > lowest)?;
        let Spectrum { power, step, duration } = Spectrum::of(self.fitted, bin)?;
        let width = (1.0 - NEIGHBOURS) / duration;
        let apart = (2.0 * width / step).ceil() as usize;
        let from = (lowest / step).ceil() as usize;
        let to = ((highest / step) as usize + 1).min(power.len());
        let peaks = peaks(power.get(from..to)?, apart).into_iter();
        let members: Vec<f64> = peaks.map(|at| (from + at) as f64 * step).collect();
        let gains = self.gains(&members);
        let best = members.into_iter().zip(gains).max_by(|a, b| a.1.total_cmp(&b.1))?;
        let best = self.polished((best.0 - width, best.0 + width), best);
        Some((best.0, 2 * ((highest - lowest) / width) as usize))
    }
}

/// The power of residuals at multiples of a frequency.
struct Spectrum {
    power: Vec<f64>,
    /// That frequency (Hz).
    step: f64,
    /// Duration (s) of the longest run.
    duration: f64,
}

impl Spectrum {
    /// Of the residuals of a fit in bins of time (s); `None` of too many bins. The power of each run and
    /// component is in parts of its own, times the number of its residuals.
    fn of(fitted: &Fitted, bin: f64) -> Option<Self> {
        let problem = &fitted.problem;
        let duration = longest_run(problem);
        let bins = (duration / bin).ceil() + 1.0;
        if !(2.0..MOST_BINS).contains(&bins) {
            return None;
        }
        let length = (2 * bins as usize).next_power_of_two();
        let transform = FftPlanner::new().plan_fft_forward(length);
        let mut power = vec![0.0; length / 2];
        let runs = problem.parts.iter().enumerate();
        for at in runs.flat_map(|(part, own)| (0..own.runs.len()).map(move |run| (part, run))) {
            for series in residuals(fitted, at).iter().filter(|own| own.len() >= FEWEST) {
                let mut binned = vec![Complex::default(); length];
                let square = put_windowed(&without_slow(series), bin, &mut binned);
                transform.process(&mut binned);
                let by = series.len() as f64 / square.max(f64::MIN_POSITIVE);
                power.iter_mut().zip(&binned).for_each(|(sum, one)| *sum += by * one.norm_sqr());
            }
        }
        Some(Self { power, step: (length as f64 * bin).recip(), duration })
    }
}

/// Duration (s) of the longest run.
fn longest_run(problem: &Problem) -> f64 {
    let runs = problem.parts.iter().flat_map(|part| &part.runs);
    let spans = runs.filter_map(|run| run.record.ends(|samples| &samples.run_time));
    spans.map(|[first, last]| last - first).fold(0.0, f64::max)
}

/// Time (s) in the run and residual of the readings of each component.
type Series = Vec<(f64, f64)>;

/// The residuals of a run.
fn residuals(fitted: &Fitted, (part, run): (usize, usize)) -> Vec<Series> {
    let Fitted { problem, fit, .. } = fitted;
    let mut all: Vec<Series> = vec![Vec::new(); problem.parts[part].residual_count()];
    problem.visit_residuals(part, run, &fit.point, &mut |sample, values| {
        let time = sample.samples.run_time[sample.at];
        for (own, value) in all.iter_mut().zip(values).filter(|(_, value)| value.is_finite()) {
            own.push((time, *value));
        }
    });
    all
}

/// Residuals without their running mean over a period of the slowest fast oscillation: slow structure of which
/// rows are missing at even places would have lines there.
fn without_slow(series: &[(f64, f64)]) -> Series {
    let half = 0.5 / FAST;
    let (mut first, mut end, mut sum) = (0, 0, 0.0);
    let fast = |&(time, value): &(f64, f64)| {
        while let Some(next) = series.get(end).filter(|next| next.0 <= time + half) {
            sum += next.1;
            end += 1;
        }
        while let Some(past) = series.get(first).filter(|past| past.0 < time - half) {
            sum -= past.1;
            first += 1;
        }
        (time, value - sum / (end - first).max(1) as f64)
    };
    series.iter().map(fast).collect()
}

/// Puts residuals, weighed by a Hann window, into bins; returns the sum of their squares.
fn put_windowed(series: &[(f64, f64)], bin: f64, binned: &mut [Complex<f64>]) -> f64 {
    let (Some(first), Some(last)) = (series.first(), series.last()) else { return 0.0 };
    let span = last.0 - first.0 + bin;
    let mut square = 0.0;
    for (time, value) in series {
        let phase = std::f64::consts::PI * (time - first.0 + 0.5 * bin) / span;
        let own = value * phase.sin().powi(2);
        square += own * own;
        let place = ((time - first.0) / bin).round().max(0.0) as usize;
        if let Some(sum) = binned.get_mut(place) {
            *sum += own;
        }
    }
    square
}

/// The places of the highest values, so far apart from each other, highest first.
fn peaks(power: &[f64], apart: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..power.len()).filter(|at| is_peak(power, *at)).collect();
    order.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
    let mut found: Vec<usize> = Vec::new();
    for at in order {
        if found.len() < PEAKS && found.iter().all(|other| at.abs_diff(*other) > apart) {
            found.push(at);
        }
    }
    found
}

/// Whether a value is no less than those beside it.
fn is_peak(power: &[f64], at: usize) -> bool {
    let beside = [at.checked_sub(1), Some(at + 1)];
    beside.into_iter().flatten().filter_map(|other| power.get(other)).all(|one| *one <= power[at])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave beside a drift eight hundred times as large, with rows missing at even places.
    #[test]
    fn the_highest_peak_is_the_wave_and_not_the_drift() {
        let (bin, frequency) = (0.005, 63.2);
        let value = |time: f64| {
            1e2 * (time / 7.0).powi(2) + (std::f64::consts::TAU * frequency * time + 0.4).sin()
        };
        let rows = (0..4000).filter(|row| row % 17 != 3).map(|row| f64::from(row) * bin);
        let series: Series = rows.map(|time| (time, value(time))).collect();
        let mut binned = vec![Complex::default(); 8192];
        let square = put_windowed(&without_slow(&series), bin, &mut binned);
        FftPlanner::new().plan_fft_forward(8192).process(&mut binned);
        let step = (8192.0 * bin).recip();
        let from = (10.0 / step) as usize;
        let power: Vec<f64> = binned[from..4096].iter().map(Complex::norm_sqr).collect();
        let found = peaks(&power, 4);
        assert!(square > 0.0 && found.len() == PEAKS);
        assert!(((from + found[0]) as f64 * step - frequency).abs() < step, "{found:?}");
        assert_eq!(peaks(&[1.0, 3.0, 2.0, 5.0, 4.0, 0.0, 6.0], 2), [6, 3]);
    }
}
