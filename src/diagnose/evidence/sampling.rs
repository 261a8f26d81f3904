//! Frequencies that evenly sampled runs cannot tell from nothing: at a multiple of the sampling
//! rate every sample meets the same phase, and a wave with an amplitude for each run is an offset
//! of that run.
//!
//! Near to such a multiple it is a slow wave of that run, and says nothing for a family of fast
//! ones. Where the intervals of all runs are multiples of one, a wave beyond half its reciprocal is
//! one below. A wave of which half a period is longer than what was recorded is not distinguishable from a
//! drift. Members of families that are such frequencies are not looked at.

use crate::diagnose::library::candidate::Candidate;
use crate::engine::Problem;
use crate::statistics::upper_median;
use crate::units::Unit;

/// Standard deviation of sampling times from even ones, in intervals, below which they are even.
const EVEN: f64 = 0.1;
/// Parts of the shortest interval of which all others are looked for as multiples.
const PARTS: u32 = 24;
/// The least part of its period for which a wave is recorded.
pub(super) const HALF_PERIOD: f64 = 0.5;
/// Periods of a wave that nobody describes, in two short intervals between readings, at most; and how
/// many of the intervals are as short.
const CARRIED: f64 = 3.0;
const SHORT: usize = 10;
/// Rows that are there of those that an even grid has, at least.
const PRESENT: f64 = 0.5;
/// Bins of uneven times, in the shortest intervals.
const FINE: f64 = 0.25;
/// How near to a multiple, in parts.
const NEAR: f64 = 1e-3;

/// How the runs are sampled.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Sampling {
    /// Interval and duration (s) of each run that is sampled evenly, run by run.
    runs: Vec<Option<(f64, f64)>>,
    /// The interval (s) of which all are multiples, if there is one.
    interval: Option<f64>,
    /// From this frequency (Hz) on every wave is one below it.
    highest: f64,
    /// Half a period of waves below this frequency (Hz) is longer than what was recorded.
    lowest: f64,
    /// Waves of higher frequencies (Hz) have several periods between most readings.
    carried: f64,
}

impl Sampling {
    /// For waves with amplitudes of each run's own, or for those that go on through a campaign.
    pub(in crate::diagnose) fn of(problem: &Problem, are_of_runs: bool) -> Self {
        let mut shortest = f64::INFINITY;
        let runs: Vec<Option<(f64, f64)>> = problem
            .parts
            .iter()
            .flat_map(|part| &part.runs)
            .map(|run| {
                let mut times = Vec::with_capacity(run.record.len());
                run.record.walk(|stretch| {
                    let samples = stretch.samples;
                    let jumped = |at: usize| samples.jump_time.get(at).copied().unwrap_or(0.0);
                    times.extend(stretch.range().map(|at| samples.run_time[at] - jumped(at)));
                });
                let mut intervals = intervals(&times);
                shortest = shortest.min(short(&mut intervals).unwrap_or(f64::INFINITY));
                grid(&times, &mut intervals)
            })
            .collect();
        let all = || problem.parts.iter().flat_map(|part| &part.runs);
        let longest = if are_of_runs {
            let spans = all().filter_map(|run| run.record.ends(|samples| &samples.run_time));
            spans.map(|[first, last]| last - first).fold(0.0, f64::max)
        } else {
            let ends = all().filter_map(|run| run.record.ends(|samples| &samples.elapsed_time));
            let ends = ends
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [first, last]| {
                    [low.min(first), high.max(last)]
                });
            (ends[1] - ends[0]).max(0.0)
        };
        let carried = 0.5 * CARRIED / shortest;
        Self { lowest: HALF_PERIOD / longest, carried, ..Self::made(runs) }
    }

    /// Bins (s) for a spectrum, and the highest frequency (Hz) that it has; `None` where that is not known. On
    /// an even grid a bin is its interval. Times that are uneven carry no more than the shortest intervals do.
    pub(super) fn bins(&self) -> Option<(f64, f64)> {
        let shortest = 0.5 * CARRIED / self.carried;
        let known = match self.interval {
            Some(interval) => (interval, self.highest),
            None => (FINE * shortest, 0.5 / shortest),
        };
        (known.0 > 0.0 && known.0.is_finite()).then_some(known)
    }

    /// For waves that nobody describes: readings that are far apart at uneven times fit some of the many
    /// frequencies beyond what they carry by chance.
    pub(super) fn of_unknown(self) -> Self {
        Self { highest: self.highest.min(self.carried), ..self }
    }

    fn made(runs: Vec<Option<(f64, f64)>>) -> Self {
        let even: Option<Vec<(f64, f64)>> = runs.iter().copied().collect();
        let interval = even.and_then(|even| common(&even));
        let highest = interval.map_or(f64::INFINITY, |interval| 0.5 / interval);
        Self { runs, interval, highest, lowest: 0.0, carried: f64::INFINITY }
    }

    /// Whether a wave of this frequency (Hz) is less than a turn of phase in some run, or one of a
    /// lower frequency in all of them, or too slow for what was recorded.
    pub(super) fn is_blind(&self, frequency: f64) -> bool {
        let folded = |(interval, duration): &(f64, f64)| {
            from_multiple(frequency, *interval) * duration < 1.0
        };
        !(self.lowest..=self.highest).contains(&frequency) || self.runs.iter().flatten().any(folded)
    }

    /// Whether a wave of this frequency (Hz) in a run is the same as one of another frequency below
    /// some.
    pub(super) fn is_slow_in(&self, run: usize, frequency: f64, below: f64) -> bool {
        let even = self.runs.get(run).copied().flatten();
        even.is_some_and(|(interval, _)| from_multiple(frequency, interval) < below)
    }
}

/// The intervals between times.
fn intervals(times: &[f64]) -> Vec<f64> {
    times.windows(2).map(|two| two[1] - two[0]).collect()
}

/// The interval (s) than which one in ten is shorter; they change their order.
fn short(intervals: &mut [f64]) -> Option<f64> {
    let place = intervals.len() / SHORT;
    if intervals.is_empty() {
        return None;
    }
    Some(*intervals.select_nth_unstable_by(place, f64::total_cmp).1).filter(|one| *one > 0.0)
}

/// Interval and duration (s) of times on an even grid, some of which may be missing; `None` where they
/// are not. The intervals between them change their order.
fn grid(times: &[f64], intervals: &mut [f64]) -> Option<(f64, f64)> {
    let interval = upper_median(intervals).filter(|one| *one > 0.0)?;
    let (first, last) = (*times.first()?, *times.last()?);
    // The number of each on the grid, from the one before; then the grid by least squares.
    let (mut number, mut before) = (0.0, first);
    let next = |time: &f64| {
        number += ((time - std::mem::replace(&mut before, *time)) / interval).round();
        number
    };
    let numbers: Vec<f64> = times.iter().map(next).collect();
    let count = times.len() as f64;
    let (mean_number, mean) =
        (numbers.iter().sum::<f64>() / count, times.iter().sum::<f64>() / count);
    let (mut square, mut along) = (0.0, 0.0);
    for (number, time) in numbers.iter().zip(times) {
        square += (number - mean_number).powi(2);
        along += (number - mean_number) * (time - mean);
    }
    let interval = along / square;
    let far =
        |(number, time): (&f64, &f64)| (time - mean - interval * (number - mean_number)).powi(2);
    let squares: f64 = numbers.iter().zip(times).map(far).sum();
    let is_even = count > 2.0
        && interval > 0.0
        && squares < count * (EVEN * interval).powi(2)
        && count > PRESENT * number;
    is_even.then_some((interval, last - first))
}

/// How far (Hz) a frequency is from the nearest multiple of a sampling rate; infinite where that is 0.
fn from_multiple(frequency: f64, interval: f64) -> f64 {
    let turns = (frequency * interval).round();
    if turns >= 1.0 { (frequency - turns / interval).abs() } else { f64::INFINITY }
}

/// The longest interval of which all are multiples, if there is one.
fn common(even: &[(f64, f64)]) -> Option<f64> {
    let shortest = even.iter().map(|(interval, _)| *interval).fold(f64::INFINITY, f64::min);
    let is_multiple = |parts: f64| {
        even.iter().all(|(interval, _)| {
            let times = interval * parts / shortest;
            (times - times.round()).abs() < NEAR * parts
        })
    };
    let parts = (1..=PARTS).map(f64::from).find(|parts| is_multiple(*parts));
    parts.map(|parts| shortest / parts).filter(|interval| interval.is_finite())
}

/// Why no member of a family can be tested.
pub(in crate::diagnose) const ALL_BLIND: &str = "none of its frequencies is distinguishable from a constant at the rates and durations of these runs: sample faster, at uneven intervals, or for longer";

/// The members of a family that the runs distinguish from a constant; the first where it acts at jumps
/// of stamps, and there are none.
pub(in crate::diagnose) fn distinguishable<'a>(
    problem: &Problem,
    family: &'a [Candidate],
) -> Vec<&'a Candidate> {
    let Some(first) = family.first().filter(|_| family.len() > 1) else {
        return family.iter().collect();
    };
    let effect = &first.selected.effect;
    let mut runs = problem.parts.iter().flat_map(|part| &part.runs);
    if effect.acts_at_jumps() && runs.all(|run| run.record.head(1).jump_time.is_empty()) {
        return vec![first];
    }
    let shape = &effect.shape;
    let frequencies: Vec<&String> =
        shape.iter().filter(|(_, one)| is_frequency(&one.unit)).map(|(name, _)| name).collect();
    if frequencies.is_empty() {
        return family.iter().collect();
    }
    let sampling = Sampling::of(problem, first.is_of_runs());
    let is_blind = |one: &&Candidate| {
        let values = frequencies.iter().filter_map(|name| one.selected.member.get(*name));
        values.into_iter().any(|value| sampling.is_blind(*value))
    };
    family.iter().filter(|one| !is_blind(one)).collect()
}

/// Whether members of this unit are frequencies; rates of turns are none.
pub(super) fn is_frequency(unit: &Unit) -> bool {
    Unit::parse("Hz").is_ok_and(|hertz| unit.dimension == hertz.dimension && !unit.has_angle())
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    #[test]
    fn multiples_of_a_sampling_rate_are_blind() {
        let of = |even: &[(f64, f64)]| Sampling::made(even.iter().copied().map(Some).collect());
        // Every 0.365 s for 36.5 s, and every 0.1 s for 20 s.
        let runs = of(&[(0.365, 36.5), (0.1, 20.0)]);
        for blind in [2.7397, 5.47, 10.0, 10.04] {
            assert!(runs.is_blind(blind), "{blind}");
        }
        for seen in [0.5, 1.3, 2.70, 2.78, 7.0, 9.9, 15.1] {
            assert!(!runs.is_blind(seen), "{seen}");
        }
        // Multiples of a tenth of a second: what is beyond 5 Hz is below it.
        let alike = of(&[(0.1, 20.0), (0.3, 30.0)]);
        assert!(alike.is_blind(5.1) && !alike.is_blind(4.9));
        let alike = of(&[(0.2, 20.0), (0.3, 30.0)]);
        assert!(alike.is_blind(5.1) && !alike.is_blind(4.9));
        let uneven = Sampling::made(vec![None]);
        assert!(!uneven.is_blind(20.0) && !uneven.is_slow_in(0, 20.0, 0.5));
    }

    /// Rows that are missing make no other frequencies distinguishable.
    #[test]
    fn times_on_a_grid_are_even_with_rows_missing() {
        let all = (0..400).map(|row| 0.1 * f64::from(row) + 2e-3 * f64::from(row * row % 7));
        let some = |is_there: &dyn Fn(usize) -> bool| -> Vec<f64> {
            all.clone()
                .enumerate()
                .filter(|(row, _)| is_there(*row))
                .map(|(_, time)| time)
                .collect()
        };
        for times in [some(&|_| true), some(&|row| row % 19 != 3), some(&|row| row * row % 5 < 2)] {
            let (interval, duration) = grid(&times, &mut intervals(&times)).unwrap();
            assert!((interval - 0.1).abs() < 1e-5 && (duration - 39.9).abs() < 0.3, "{interval}");
            assert!(Sampling::made(vec![Some((interval, duration))]).is_blind(7.7));
        }
        let uneven: Vec<f64> = (0..400).map(|row| f64::from(row).powf(1.3)).collect();
        for times in [&uneven[..], &[1.0], &[]] {
            assert!(grid(times, &mut intervals(times)).is_none());
        }
        assert!((short(&mut [2.0, 1.9, 2.1]).unwrap() - 1.9).abs() < 1e-9);
        assert!(short(&mut []).is_none() && short(&mut [0.0]).is_none());
        let uneven = Sampling { carried: 0.8, ..Sampling::made(vec![None]) };
        assert!(!uneven.is_blind(9.97) && uneven.of_unknown().is_blind(9.97));
    }

    #[test]
    fn what_is_slower_than_the_recording_is_blind() {
        let slow = Sampling { lowest: HALF_PERIOD / 40.0, ..Sampling::made(vec![None]) };
        assert!(slow.is_blind(0.01) && !slow.is_blind(0.0126));
        let still = Sampling { lowest: HALF_PERIOD / 0.0, ..Sampling::made(vec![None]) };
        assert!(still.is_blind(1.0));
    }

    #[test]
    fn rates_of_turns_are_no_frequencies() {
        let is_one = |symbol| is_frequency(&Unit::parse(symbol).unwrap());
        assert!(["Hz", "kHz", "1/s"].into_iter().all(is_one));
        assert!(!["rad/s", "deg/s", "s"].into_iter().any(is_one));
    }

    #[test]
    fn what_is_slow_in_one_run_is_not_in_another() {
        let runs = Sampling::made(vec![Some((0.1, 20.0)), None, Some((0.15, 20.0))]);
        let slow = |frequency| [0, 1, 2].map(|run| runs.is_slow_in(run, frequency, 0.5));
        assert_eq!(slow(10.2), [true, false, false]);
        assert_eq!(slow(6.5), [false, false, true]);
        assert_eq!(slow(0.2), [false; 3]);
        assert_eq!(slow(20.1), [true, false, true]);
    }
}
