//! Autocorrelated noise in the residuals of a component: whether there is such, the Gauss-Markov noise of
//! largest likelihood, and another one in the place of that which whitened them. Whether blocks explain
//! more is for [`super::noise_or_blocks`] to say.

use std::collections::BTreeMap;

use crate::diagnose::thresholds::{ENTER, NOISE};
use crate::engine::gauss_markov::{BEGIN, GaussMarkov};
use crate::estimate::noise_model::likelihood::{Sequence, likeliest};

/// Residuals of one component by run: sample, time (s), whitened residual.
pub(super) type Component = BTreeMap<usize, Vec<(usize, f64, f64)>>;

/// The Gauss-Markov part of a component's residuals, where they are correlated.
pub(super) fn autocorrelation(runs: &Component) -> Option<GaussMarkov> {
    let values: Vec<Vec<f64>> =
        runs.values().map(|own| own.iter().map(|one| one.2).collect()).collect();
    let longest = values.iter().map(Vec::len).max().unwrap_or(0);
    let squares: f64 = values.iter().flatten().map(|value| value * value).sum();
    let count: usize = values.iter().map(Vec::len).sum();
    let pairs = values.iter().flat_map(|own| own.windows(2));
    let neighbours: f64 = pairs.map(|pair| pair[0] * pair[1]).sum();
    // Products of different residuals of stretches of so many: of white noise their sum has the
    // standard deviation of one product times the root of their number. A first look: for few
    // stretches this is no normal distribution, and the likelihood decides.
    let score = |length: usize| {
        let of_stretch = |own: &[f64]| {
            let sum = own.iter().sum::<f64>().powi(2) - own.iter().map(|x| x * x).sum::<f64>();
            [0.5 * sum, 0.5 * (own.len() * (own.len() - 1)) as f64]
        };
        let stretches = values.iter().flat_map(|own| own.chunks(length));
        let sums = stretches.map(of_stretch).fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        sums[0] * count as f64 / (squares * sums[1].sqrt())
    };
    let lengths = std::iter::successors(Some(4), |length| Some(2 * length));
    let is_alike = neighbours * (count as f64).sqrt() > NOISE * squares
        || lengths.take_while(|length| *length <= longest).any(|one| score(one) > NOISE);
    if is_alike { gauss_markov(runs).map(|(noise, _)| noise) } else { None }
}

/// Another Gauss-Markov noise in the place of that which whitened a component, where it is far likelier.
pub(super) fn again(runs: &Component, known: GaussMarkov) -> Option<GaussMarkov> {
    gauss_markov_again(runs, known).filter(|one| one.1 > ENTER).map(|one| one.0)
}

/// The Gauss-Markov noise of largest likelihood of a component, and its log likelihood ratio against
/// white noise; `None` where it is white.
pub(super) fn gauss_markov(runs: &Component) -> Option<(GaussMarkov, f64)> {
    let run = |own: &Vec<(usize, f64, f64)>| own.iter().map(|one| (one.1, one.2)).collect();
    let found = likeliest(&Sequence::new(runs.values().map(run).collect()));
    Some((found.noise?, found.gained))
}

/// What the values of such noise cost in a component of so many residuals.
pub(super) fn price(noise: GaussMarkov, count: usize) -> f64 {
    noise.processes().count() as f64 * (count as f64).ln()
}

/// The same of a component that is whitened by such noise, and its log likelihood ratio against that, less
/// what it costs more.
pub(super) fn gauss_markov_again(
    runs: &Component,
    known: GaussMarkov,
) -> Option<(GaussMarkov, f64)> {
    let run = |own: &Vec<(usize, f64, f64)>| {
        let (mut filter, mut states) = (known.filter(), BEGIN);
        let raw = own.iter().map(|(_, time, whitened)| {
            (*time, filter.next(*time, true).undo(&mut states, *whitened))
        });
        raw.collect()
    };
    let sequence = Sequence::new(runs.values().map(run).collect());
    let found = likeliest(&sequence);
    let (noise, count) = (found.noise?, sequence.count);
    let more = price(noise, count) - price(known, count);
    Some((noise, found.gained - sequence.gained_by(known) - more))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    /// A process of a time, whitened by one of another time.
    fn whitened(time: f64, by: GaussMarkov) -> Component {
        let mut state = 1_u64;
        let mut normal = || {
            let mut uniform = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..12).map(|_| uniform()).sum::<f64>() - 6.0
        };
        let decay = (-1.0 / time).exp();
        let mut run = || {
            let (mut filter, mut states) = (by.filter(), BEGIN);
            let mut process = normal();
            let sample = |at: usize| {
                process = decay * process + (1.0 - decay * decay).sqrt() * normal();
                let gains = filter.next(at as f64, true);
                (at, at as f64, gains.take(&mut states, process + 0.5 * normal()))
            };
            (0..200).map(sample).collect::<Vec<_>>()
        };
        (0..20).map(|number| (number, run())).collect()
    }

    #[test]
    fn noise_that_whitened_too_little_is_found_anew() {
        let (due, short) = (GaussMarkov::one(0.8, 20.0), GaussMarkov::one(0.7, 8.0));
        let (found, gained) = gauss_markov_again(&whitened(20.0, short), short).unwrap();
        let one = found.processes().next().unwrap();
        assert!((one.share - 0.8).abs() < 0.06, "{found:?}");
        assert!((one.time / 20.0).ln().abs() < 0.3, "{found:?}");
        assert!(gained > 20.0, "{gained}");
        let (_, more) = gauss_markov_again(&whitened(20.0, due), due).unwrap();
        assert!(more.abs() < 5.0, "{more}");
    }
}
