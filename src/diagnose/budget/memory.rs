//! Autocorrelated noise in what rows leave: the Gauss-Markov noise of largest likelihood.

use crate::engine::gauss_markov::{GaussMarkov, NoiseClock};
use crate::estimate::noise_model::likelihood::Sequence;

use super::linear::Linear;
use super::noise::{Component, components};
use super::selection::Selection;

/// Gauss-Markov noise of a campaign's residual component.
pub type OfComponent = (usize, usize, GaussMarkov);

/// Shares and times (in intervals) that are tried.
const SHARES: [f64; 6] = [0.3, 0.6, 0.85, 0.95, 0.99, 0.999];
const TIMES: [f64; 7] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];
/// A correlation time is at most this part of the longest run.
const LONGEST: f64 = 0.25;
/// Refinements of both.
const REFINED: usize = 24;
/// Log likelihood beyond which noise is autocorrelated at all: five standard deviations, and the
/// price of two values.
pub const SURE: f64 = 20.0;

/// Gauss-Markov noise by campaign and residual component, in what rows leave, and by how much it
/// raises the log likelihood, less its price.
pub fn autocorrelated(
    linear: &Linear,
    selection: &Selection<'_>,
    rows: &[usize],
) -> (f64, Vec<OfComponent>) {
    let (mut gained, mut found) = (0.0, Vec::new());
    for ((part, _, row), runs) in components(linear, selection, rows, &mut |_, _| {}) {
        if let Some((noise, own)) = likeliest(runs).filter(|(_, own)| *own > SURE) {
            gained += own;
            found.push((part, row, noise));
        }
    }
    (gained, found)
}

/// The Gauss-Markov noise of largest likelihood, and its log likelihood ratio against white noise
/// less its price.
fn likeliest(runs: Component) -> Option<(GaussMarkov, f64)> {
    let timed = |(_, time, residual)| (time, residual);
    let of_run = |own: Vec<(usize, f64, f64)>| own.into_iter().map(timed).collect();
    let sequence = Sequence::from_runs(runs.into_values().map(of_run).collect());
    let (count, interval) = (sequence.count, sequence.interval);
    if count < 50 || !interval.is_finite() || interval <= 0.0 {
        return None;
    }
    let white = -0.5 * count as f64 * sequence.variance().ln();
    let of = |share: f64, time: f64| {
        let noise = GaussMarkov { share, time, clock: NoiseClock::Stamps };
        (sequence.with(share, time).1, noise)
    };
    let most = LONGEST * sequence.duration.max(interval);
    let mut best: Option<(f64, GaussMarkov)> = None;
    for share in SHARES {
        for time in TIMES.iter().map(|time| time * interval).filter(|time| *time <= most) {
            let own = of(share, time);
            if best.is_none_or(|(known, _)| own.0 > known) {
                best = Some(own);
            }
        }
    }
    let mut best = best?;
    // Steps in ln time and in the logit of the share, each halved where none helps.
    let mut step = 0.7;
    for _ in 0..REFINED {
        let logit = (best.1.share / (1.0 - best.1.share)).ln();
        let tries = [(step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step)].map(|(s, t)| {
            let share = 1.0 / (1.0 + (-(logit + s)).exp());
            of(share.clamp(0.01, 0.9999), (best.1.time.ln() + t).exp().min(most))
        });
        let better = tries.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        match better.filter(|one| one.0 > best.0 + 1e-3) {
            Some(better) => best = better,
            None => step *= 0.5,
        }
    }
    Some((best.1, best.0 - white - (count as f64).ln()))
}
