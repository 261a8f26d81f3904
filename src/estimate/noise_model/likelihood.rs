//! The level and the Gauss-Markov processes of largest likelihood of a sequence of residuals: none,
//! one, or two, each of which must raise the likelihood by itself. Noise of a receiver or a gyroscope
//! is correlated over several times: with one process what is correlated over a longer one would look
//! like a drift or a change.

use crate::campaign::Run;
use crate::engine::gauss_markov::{BEGIN, GaussMarkov, Process};
use crate::engine::part::Part;
use crate::engine::stretches::Left;

/// Residuals of one component that are looked at: they give a correlation to a percent.
const ENOUGH: usize = 1 << 16;
/// Logarithm of the likelihood ratio beyond which noise is correlated, and beyond which it has a second
/// process: five standard deviations.
const SURE: f64 = 12.5;
/// Shares, and times in intervals between samples, from which the likeliest are looked for.
const SHARES: [f64; 7] = [0.05, 0.15, 0.3, 0.5, 0.7, 0.9, 0.98];
const FIRST_TIME: f64 = 0.7;
const TIME_RATIO: f64 = 2.2;
/// The same from which a second process is refined.
const HOPEFUL: f64 = 1.0;
/// Variances of a second process, over that of the first, from which it is looked for.
const RATIOS: [f64; 3] = [0.03, 0.2, 1.0];
/// A process that is not there, and the largest variance of one over that of the white part.
const NONE: (f64, f64) = (0.0, 1.0);
const MOST_RATIO: f64 = 1e4;
/// A correlation time is shorter than this part of a run.
const LONGEST: f64 = 0.25;
/// Refinements of each process.
const REFINED: usize = 30;

/// One residual component, run after run: residuals in units of what is stated, with their times.
pub(crate) struct Sequence {
    runs: Vec<Vec<(f64, f64)>>,
    /// How many residuals.
    pub(crate) count: usize,
    /// Mean interval, and the longest run (s).
    interval: f64,
    duration: f64,
}

/// What the likelihood says of a sequence.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Likeliest {
    pub(crate) variance: f64,
    /// What is correlated.
    pub(crate) noise: Option<GaussMarkov>,
    /// By how much that raises the logarithm of the likelihood.
    pub(crate) gained: f64,
}

impl Sequence {
    /// Of residuals with their times (s), run after run.
    pub(crate) fn new(runs: Vec<Vec<(f64, f64)>>) -> Self {
        let (mut steps, mut total, mut duration) = (0, 0.0, 0.0_f64);
        for own in &runs {
            if let (Some(first), Some(last)) = (own.first(), own.last()) {
                steps += own.len() - 1;
                total += last.0 - first.0;
                duration = duration.max(last.0 - first.0);
            }
        }
        let count = runs.iter().map(Vec::len).sum();
        Self { runs, count, interval: total / f64::from(steps.max(1) as u32), duration }
    }

    pub(crate) fn of(part: &Part, left: &[Left], row: usize) -> Self {
        let all: usize = left.iter().map(|one| one.residuals[row].len()).sum();
        let share = (ENOUGH as f64 / all.max(1) as f64).min(1.0);
        let of_run = |(run, one): (&Run, &Left)| {
            let residuals = &one.residuals[row];
            // What stands together, so that neighbours remain.
            let most = (share * residuals.len() as f64).ceil() as usize;
            let head = run.record.head(most);
            let own = residuals.iter().take(head.len()).enumerate();
            let own = own.filter(|(_, value)| value.is_finite());
            own.map(|(at, value)| (head.order_of(at), *value)).collect()
        };
        Self::new(part.runs.iter().zip(left).map(of_run).collect())
    }

    /// By how much a correlated part raises the logarithm of the likelihood.
    pub(crate) fn gained_by(&self, noise: GaussMarkov) -> f64 {
        self.with(noise).1 - self.of_white().1
    }

    /// Variance, and logarithm of the likelihood, of white noise.
    fn of_white(&self) -> (f64, f64) {
        let squares = self.runs.iter().flatten().map(|(_, value)| value * value).sum::<f64>();
        let variance = squares / self.count.max(1) as f64;
        (variance, -0.5 * self.count as f64 * variance.ln())
    }

    /// The same with a correlated part.
    fn with(&self, noise: GaussMarkov) -> (f64, f64) {
        let (mut squares, mut weights) = (0.0, 0.0);
        // Weights mostly are the same from sample to sample.
        let mut known = (1.0, 0.0);
        for run in &self.runs {
            let (mut filter, mut states) = (noise.filter(), BEGIN);
            for (time, value) in run {
                let gains = filter.next(*time, true);
                squares += gains.take(&mut states, *value).powi(2);
                if known.0 != gains.weight {
                    known = (gains.weight, gains.weight.ln());
                }
                weights += known.1;
            }
        }
        let variance = squares / self.count.max(1) as f64;
        (variance, weights - 0.5 * self.count as f64 * variance.ln())
    }

    /// Times (s) from which processes are looked for.
    fn times(&self) -> impl Iterator<Item = f64> {
        let longest = LONGEST * self.duration;
        let first = FIRST_TIME * self.interval;
        let times = std::iter::successors(Some(first), |time| Some(time * TIME_RATIO));
        times.take_while(move |time| *time <= longest)
    }
}

/// Processes beside white noise: of each the variance over that of the white part, and the time (s).
#[derive(Clone, Copy, Debug)]
struct Tried {
    processes: [(f64, f64); 2],
    likelihood: f64,
    variance: f64,
}

impl Tried {
    /// The noise of a sequence.
    fn at(sequence: &Sequence, processes: [(f64, f64); 2]) -> Self {
        let longest = LONGEST * sequence.duration;
        let processes = processes.map(|(ratio, time)| (ratio.min(MOST_RATIO), time.min(longest)));
        let (variance, likelihood) = sequence.with(noise_of(processes));
        Self { processes, likelihood, variance }
    }

    /// With other values of its processes, as long as the likelihood rises.
    fn refined(mut self, sequence: &Sequence) -> Self {
        let of_two = self.processes[1].0 > 0.0;
        let (mut ratio_by, mut time_by) = (2.0_f64, TIME_RATIO.sqrt());
        for _ in 0..if of_two { 2 * REFINED } else { REFINED } {
            let mut best = self;
            for index in 0..=usize::from(of_two) {
                let steps =
                    [(ratio_by, 1.0), (1.0 / ratio_by, 1.0), (1.0, time_by), (1.0, 1.0 / time_by)];
                for (ratio, time) in steps {
                    let mut processes = self.processes;
                    let own = &mut processes[index];
                    *own = (own.0 * ratio, own.1 * time);
                    let found = Self::at(sequence, processes);
                    if found.likelihood > best.likelihood {
                        best = found;
                    }
                }
            }
            if best.likelihood > self.likelihood {
                self = best;
            } else {
                (ratio_by, time_by) = (ratio_by.sqrt(), time_by.sqrt());
            }
        }
        self
    }
}

/// The noise of processes by their variances over that of the white part, and times (s).
fn noise_of(processes: [(f64, f64); 2]) -> GaussMarkov {
    let whole = 1.0 + processes[0].0 + processes[1].0;
    let [first, second] = processes.map(|(ratio, time)| Process { share: ratio / whole, time });
    GaussMarkov::two(first, second)
}

/// The level and the correlated part of largest likelihood.
pub(crate) fn likeliest(sequence: &Sequence) -> Likeliest {
    let (variance, of_white) = sequence.of_white();
    let white = Likeliest { variance, noise: None, gained: 0.0 };
    let longest = LONGEST * sequence.duration;
    let is_timed = sequence.interval > 0.0 && longest > sequence.interval;
    if !is_timed || variance <= 0.0 || !variance.is_finite() {
        return white;
    }
    let best_of = |tried: &mut dyn Iterator<Item = [(f64, f64); 2]>| {
        let tried = tried.map(|processes| Tried::at(sequence, processes));
        tried.reduce(|best, one| if one.likelihood > best.likelihood { one } else { best })
    };
    let alone = |time| SHARES.map(|share| [(share / (1.0 - share), time), NONE]);
    let Some(one) = best_of(&mut sequence.times().flat_map(alone)) else { return white };
    let one = one.refined(sequence);
    if one.likelihood - of_white <= SURE {
        return white;
    }
    let first = one.processes[0];
    let beside = |time| RATIOS.map(|ratio| [first, (ratio * first.0, time)]);
    let two = best_of(&mut sequence.times().flat_map(beside));
    // One that raises nothing from any start is not refined.
    let two = two.filter(|two| two.likelihood > one.likelihood + HOPEFUL);
    let two = two.map(|two| two.refined(sequence));
    let best = two.filter(|two| two.likelihood - one.likelihood > SURE).unwrap_or(one);
    let mut processes = best.processes;
    // The slower process, which may not be there, is the second.
    processes.sort_by(|a, b| (a.0 == 0.0).cmp(&(b.0 == 0.0)).then(a.1.total_cmp(&b.1)));
    let noise = Some(noise_of(processes));
    Likeliest { variance: best.variance, noise, gained: best.likelihood - of_white }
}
