//! Noise in competition with basis blocks: which of them explains more of what rows leave.
//!
//! A random walk, a slow noise or a noisier run is fitted by many blocks one after the other, each of
//! which looks significant under white noise that is the same everywhere; and an unmodelled effect
//! makes residuals that are correlated in time and larger in some runs. The log likelihoods decide,
//! each with its price: that of the rows with such noise against that of the rows with the blocks
//! and white noise.

use super::linear::Linear;
use super::memory::{OfComponent, SURE, autocorrelated};
use super::noise_of_runs::{OfRun, noise_of_runs};
use super::selection::Selection;
use super::terms::Term;

/// Noise that explains more than blocks do.
#[derive(Clone, Debug)]
pub enum Instead {
    /// It is autocorrelated.
    Autocorrelated(Vec<OfComponent>),
    /// It differs from run to run.
    OfRuns(Vec<OfRun>),
}

/// The noise that explains more than the blocks of a model do, if there is one. What changes at a
/// moment is no noise: it stays beside it, as rows do, unless the noise explains it, too.
pub fn instead_of_blocks(
    linear: &Linear,
    selection: &Selection<'_>,
    model: &[usize],
) -> Option<Instead> {
    let problem = &linear.fitted.problem;
    let those = |stays: &dyn Fn(&Term) -> bool| -> Vec<usize> {
        model.iter().copied().filter(|term| stays(&selection.terms[*term])).collect()
    };
    let with_changes = those(&|term| term.is_effect() || term.change.is_some());
    let rows = those(&Term::is_effect);
    // Without blocks autocorrelation is looked for in what is left in the end.
    let has_blocks = model.len() > with_changes.len() && !problem.has_memory();
    let has_own_levels = problem.parts.iter().any(|part| !part.run_levels.is_empty());
    let mut best: Option<(f64, Instead)> = None;
    let mut take = |beyond: f64, gained: f64, found: Instead| {
        if gained > SURE && beyond > best.as_ref().map_or(0.0, |(known, _)| *known) {
            best = Some((beyond, found));
        }
    };
    for kept in [&with_changes, &rows] {
        let mut of_rows = selection.clone();
        of_rows.set_scale(kept);
        let mut by_blocks = selection.ln_price_of(kept) - selection.ln_price_of(model);
        for (number, readings) in linear.sums.readings.iter().enumerate() {
            if *readings > 0 {
                let ratio = of_rows.scale[number] / selection.scale[number];
                by_blocks += *readings as f64 * ratio.ln();
            }
        }
        if has_blocks {
            let (gained, found) = autocorrelated(linear, &of_rows, kept);
            if !found.is_empty() {
                take(gained - by_blocks, gained, Instead::Autocorrelated(found));
            }
        }
        if kept.len() == with_changes.len() && !has_own_levels {
            let (gained, found) = noise_of_runs(linear, &of_rows, kept);
            if !found.is_empty() {
                take(gained - by_blocks, gained, Instead::OfRuns(found));
            }
        }
        if !has_blocks || rows == with_changes {
            break;
        }
    }
    best.map(|(_, found)| found)
}
