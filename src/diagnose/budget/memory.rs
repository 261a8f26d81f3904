//! Autocorrelated noise in what rows leave: the Gauss-Markov noise of largest likelihood.

use crate::engine::gauss_markov::{GaussMarkov, NoiseClock};

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
        if let Some((noise, own)) = likeliest(&runs).filter(|(_, own)| *own > SURE) {
            gained += own;
            found.push((part, row, noise));
        }
    }
    (gained, found)
}

/// The Gauss-Markov noise of largest likelihood, and its log likelihood ratio against white noise
/// less its price.
fn likeliest(runs: &Component) -> Option<(GaussMarkov, f64)> {
    let count: usize = runs.values().map(Vec::len).sum();
    let (mut duration, mut steps, mut longest) = (0.0, 0_usize, 0.0_f64);
    for values in runs.values() {
        let own = values.last()?.1 - values.first()?.1;
        duration += own;
        steps += values.len().saturating_sub(1);
        longest = longest.max(own);
    }
    let interval = duration / steps.max(1) as f64;
    if count < 50 || !interval.is_finite() || interval <= 0.0 {
        return None;
    }
    let square: f64 = runs.values().flatten().map(|one| one.2 * one.2).sum();
    let white = -0.5 * count as f64 * (square / count as f64).ln();
    let of = |share: f64, time: f64| {
        let noise = GaussMarkov { share, time, clock: NoiseClock::Stamps };
        (ln_likelihood(runs, noise, count), noise)
    };
    let most = LONGEST * longest.max(interval);
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

fn ln_likelihood(runs: &Component, noise: GaussMarkov, count: usize) -> f64 {
    let (mut squares, mut weights) = (0.0, 0.0);
    for values in runs.values() {
        let (mut filter, mut state) = (noise.filter(), 0.0);
        for (_, time, value) in values {
            let gains = filter.next(*time, true);
            state *= gains.decay;
            let left = value - state;
            squares += (left * gains.weight).powi(2);
            weights += gains.weight.ln();
            state += gains.gain * left;
        }
    }
    weights - 0.5 * count as f64 * (squares / count as f64).ln()
}
