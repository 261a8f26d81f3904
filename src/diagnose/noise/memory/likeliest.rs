//! The memory of largest likelihood.

use crate::diagnose::sequences::Sequence;
use crate::engine::gauss_markov::{GaussMarkov, NoiseClock};

/// Logarithm of the largest likelihood ratio of noise with memories against white noise of unit
/// variance.
pub(in crate::diagnose) fn likelihood_of_memory(all: &[Sequence]) -> f64 {
    all.iter().map(|one| likeliest(one).map_or(0.0, |(_, likelihood)| likelihood)).sum()
}

/// Logarithm of the likelihood ratio of some noise, with the scatter that is there, against white
/// noise of unit variance.
pub(super) fn likelihood(one: &Sequence, noise: GaussMarkov) -> f64 {
    let (variance, mut sum) = (one.variance(), 0.0);
    let white = variance.ln();
    // Weights mostly are the same from sample to sample.
    let mut weight = (1.0, 0.0);
    for (run, times) in one.runs.iter().zip(one.times(noise.clock)) {
        let (mut filter, mut state) = (noise.filter(), 0.0);
        for (value, time) in run.iter().zip(times) {
            let gains = filter.next(*time, !value.is_nan());
            state *= gains.decay;
            if !value.is_nan() {
                let left = value - state;
                let squares = value * value - (left * gains.weight).powi(2) / variance;
                if weight.0 != gains.weight {
                    weight = (gains.weight, gains.weight.ln());
                }
                sum += 0.5 * (squares - white) + weight.1;
                state += gains.gain * left;
            }
        }
    }
    sum
}

/// Shares and times (in intervals between samples) from which the likeliest are looked for.
const SHARES: [f64; 7] = [0.03, 0.08, 0.2, 0.4, 0.6, 0.8, 0.95];
const TIMES: usize = 9;
const FIRST_TIME: f64 = 0.7;
const TIME_RATIO: f64 = 2.2;
/// A memory that is shorter than this part of an interval is none.
const LEAST_TIME: f64 = 0.3;
/// Refinements of both.
const REFINED: usize = 24;

/// The Gauss-Markov noise of largest likelihood, with the logarithm of that.
pub(super) fn likeliest(one: &Sequence) -> Option<(GaussMarkov, f64)> {
    let by_stamps = likeliest_by(one, NoiseClock::Stamps);
    // Both clocks say the same where samples are evenly spaced.
    let interval = |clock| one.interval(clock);
    let (stamps, numbers) = (interval(NoiseClock::Stamps), interval(NoiseClock::Numbers)?);
    if stamps.is_some_and(|stamps| (stamps / numbers).ln().abs() < EVEN) {
        return by_stamps;
    }
    let by_numbers = likeliest_by(one, NoiseClock::Numbers);
    by_stamps.into_iter().chain(by_numbers).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Logarithm of the ratio of median to mean interval below which samples are evenly spaced.
const EVEN: f64 = 0.05;

/// The same by one clock.
fn likeliest_by(one: &Sequence, clock: NoiseClock) -> Option<(GaussMarkov, f64)> {
    let interval = one.interval(clock)?;
    if one.variance() == 0.0 {
        return None;
    }
    let at = |share: f64, time: f64| {
        let time = time.max(LEAST_TIME * interval);
        let noise = GaussMarkov { share: share.clamp(1e-4, 0.999), time, clock };
        (noise, likelihood(one, noise))
    };
    let times = (0..TIMES).map(|k| FIRST_TIME * interval * TIME_RATIO.powi(k as i32));
    let grid = times.flat_map(|time| SHARES.map(|share| at(share, time)));
    let mut best = grid.max_by(|a, b| a.1.total_cmp(&b.1))?;
    // Shares move on the scale on which 0 and 1 are far away.
    let (mut odds, mut ratio) = (2.0_f64, TIME_RATIO.sqrt());
    for _ in 0..REFINED {
        let GaussMarkov { share, time, .. } = best.0;
        let of_odds = |by: f64| by * share / (1.0 - share + by * share);
        let near = [
            at(of_odds(odds), time),
            at(of_odds(odds.recip()), time),
            at(share, time * ratio),
            at(share, time / ratio),
        ];
        let found = near.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        if found.1 > best.1 {
            best = found;
        } else {
            (odds, ratio) = (odds.sqrt(), ratio.sqrt());
        }
    }
    Some(best)
}
