//! Whether neighbours in time are alike, and for how long.

use crate::diagnose::sequences::{Neighbours, Sequence};
use crate::statistics::ln_normal;

/// Noise with a memory: neighbours in time are alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) struct Memory {
    /// Part of the variance that has it.
    pub(super) share: f64,
    /// Number of pairs of neighbours.
    pub(super) pairs: f64,
    /// Logarithm of the probability of the neighbours' correlation by chance.
    pub(super) ln_p: f64,
}

/// Lags at which a memory is fitted.
const LAGS: usize = 24;

/// The memory of a measurand, if it has one: `share · exp(-lag / samples)` through its
/// correlations, by least squares over a grid of times.
pub(in crate::diagnose) fn remembered(one: &Sequence, level: f64) -> Option<Memory> {
    let correlation = |lag: usize| {
        let (mut products, mut count) = (0.0, 0.0);
        for run in &one.runs {
            for (a, b) in run.iter().zip(run.iter().skip(lag)) {
                if !a.is_nan() && !b.is_nan() {
                    products += a * b;
                    count += 1.0;
                }
            }
        }
        (products, count)
    };
    let (squares, all) = correlation(0);
    let (neighbours, pairs) = correlation(1);
    if all == 0.0 || pairs == 0.0 || squares <= 0.0 {
        return None;
    }
    let variance = squares / all;
    let ln_p = ln_normal(neighbours / pairs / variance * f64::sqrt(pairs));
    if ln_p > level {
        return None;
    }
    let lags: Vec<(f64, f64)> = (1..=LAGS)
        .map(|lag| (lag as f64, correlation(lag)))
        .filter(|(_, (_, count))| *count > 0.0)
        .map(|(lag, (products, count))| (lag, products / count / variance))
        .collect();
    let fitted = |samples: f64| {
        let decay = |lag: f64| (-lag / samples).exp();
        let own: f64 = lags.iter().map(|(lag, _)| decay(*lag).powi(2)).sum();
        let both: f64 = lags.iter().map(|(lag, value)| decay(*lag) * value).sum();
        let share = (both / own).clamp(0.0, 1.0);
        let misfit = |(lag, value): &(f64, f64)| (value - share * decay(*lag)).powi(2);
        (lags.iter().map(misfit).sum::<f64>(), share)
    };
    let times = (0..80).map(|k| 0.3 * 1.12_f64.powi(k));
    let best = times.map(fitted).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Memory { share: best.1, pairs, ln_p })
}

/// The largest correlation of neighbours that is more than chance; 0 where there is none.
pub(in crate::diagnose::noise) fn memory(all: &[Sequence], level: f64) -> f64 {
    all.iter()
        .map(|one| {
            let mut all = Neighbours::of(&[]);
            for run in &one.runs {
                let own = Neighbours::of(run);
                all.products += own.products;
                all.squares += own.squares;
                all.pairs += own.pairs;
            }
            if all.ln_p() <= level { all.correlation().min(0.99) } else { 0.0 }
        })
        .fold(0.0, f64::max)
}
