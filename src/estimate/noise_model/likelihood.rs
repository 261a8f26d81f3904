//! The level and the Gauss-Markov part of largest likelihood of a sequence of residuals.

use crate::campaign::Run;
use crate::engine::gauss_markov::{GaussMarkov, NoiseClock};
use crate::engine::part::Part;
use crate::engine::stretches::Left;
use crate::estimate::noise::Memory;

/// Residuals of one component that are looked at: they give a correlation to a percent.
const ENOUGH: usize = 1 << 16;
/// Logarithm of the likelihood ratio beyond which noise is correlated: five standard deviations.
const SURE: f64 = 12.5;
/// Shares, and times in intervals between samples, from which the likeliest are looked for.
const SHARES: [f64; 7] = [0.05, 0.15, 0.3, 0.5, 0.7, 0.9, 0.98];
const FIRST_TIME: f64 = 0.7;
const TIME_RATIO: f64 = 2.2;
/// A memory is shorter than this part of a run.
const LONGEST: f64 = 0.25;
/// Refinements of both.
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
    /// A correlated part.
    pub(crate) memory: Option<Memory>,
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
            let own = run.record.head(most).time.into_iter().zip(residuals.iter().copied());
            own.filter(|(_, value)| value.is_finite()).collect()
        };
        Self::new(part.runs.iter().zip(left).map(of_run).collect())
    }

    /// Variance, and logarithm of the likelihood, with a correlated part.
    fn with(&self, share: f64, time: f64) -> (f64, f64) {
        let noise = GaussMarkov { share, time, clock: NoiseClock::Stamps };
        let (mut squares, mut weights) = (0.0, 0.0);
        // Weights mostly are the same from sample to sample.
        let mut known = (1.0, 0.0);
        for run in &self.runs {
            let (mut filter, mut state) = (noise.filter(), 0.0);
            for (time, value) in run {
                let gains = filter.next(*time, true);
                state *= gains.decay;
                let left = value - state;
                squares += (left * gains.weight).powi(2);
                if known.0 != gains.weight {
                    known = (gains.weight, gains.weight.ln());
                }
                weights += known.1;
                state += gains.gain * left;
            }
        }
        let variance = squares / self.count.max(1) as f64;
        (variance, weights - 0.5 * self.count as f64 * variance.ln())
    }
}

/// The level and the correlated part of largest likelihood.
pub(crate) fn likeliest(sequence: &Sequence) -> Likeliest {
    let squares = sequence.runs.iter().flatten().map(|(_, value)| value * value).sum::<f64>();
    let variance = squares / sequence.count.max(1) as f64;
    let white = Likeliest { variance, memory: None, gained: 0.0 };
    let longest = LONGEST * sequence.duration;
    let is_timed = sequence.interval > 0.0 && longest > sequence.interval;
    if !is_timed || variance <= 0.0 || !variance.is_finite() {
        return white;
    }
    let at = |share: f64, time: f64| {
        let (share, time) = (share.clamp(1e-3, 0.9999), time.min(longest));
        let (variance, likelihood) = sequence.with(share, time);
        (likelihood, variance, share, time)
    };
    let mut time = FIRST_TIME * sequence.interval;
    let mut best = at(SHARES[0], time);
    while time <= longest {
        for found in SHARES.map(|share| at(share, time)) {
            if found.0 > best.0 {
                best = found;
            }
        }
        time *= TIME_RATIO;
    }
    let (mut odds, mut ratio) = (2.0_f64, TIME_RATIO.sqrt());
    for _ in 0..REFINED {
        let (_, _, share, time) = best;
        // Shares move on the scale on which 0 and 1 are far away.
        let of_odds = |by: f64| by * share / (1.0 - share + by * share);
        let near = [
            at(of_odds(odds), time),
            at(of_odds(odds.recip()), time),
            at(share, time * ratio),
            at(share, time / ratio),
        ];
        let found = near.into_iter().fold(best, |a, b| if b.0 > a.0 { b } else { a });
        if found.0 > best.0 {
            best = found;
        } else {
            (odds, ratio) = (odds.sqrt(), ratio.sqrt());
        }
    }
    let (likelihood, correlated, share, time) = best;
    let of_white = -0.5 * sequence.count as f64 * variance.ln();
    let gained = likelihood - of_white;
    if gained > SURE {
        Likeliest { variance: correlated, memory: Some(Memory { share, time }), gained }
    } else {
        white
    }
}
