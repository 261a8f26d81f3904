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

/// Noise that explains more than blocks do.
#[derive(Clone, Debug)]
pub enum Instead {
    /// It is autocorrelated.
    Autocorrelated(Vec<OfComponent>),
    /// It differs from run to run.
    OfRuns(Vec<OfRun>),
}

/// The noise that explains more than the blocks of a model do, if there is one. What changes at a
/// moment is no noise: it stays beside it, as rows do.
pub fn instead_of_blocks(
    linear: &Linear,
    selection: &Selection<'_>,
    model: &[usize],
) -> Option<Instead> {
    let problem = &linear.fitted.problem;
    let stays = |term: &usize| {
        let term = &selection.terms[*term];
        term.is_effect() || term.change.is_some()
    };
    let rows: Vec<usize> = model.iter().copied().filter(stays).collect();
    let rows = rows.as_slice();
    let mut of_rows = selection.clone();
    of_rows.set_scale(rows);
    let mut by_blocks = selection.ln_price_of(rows) - selection.ln_price_of(model);
    for (number, readings) in linear.sums.readings.iter().enumerate() {
        if *readings > 0 {
            by_blocks += *readings as f64 * (of_rows.scale[number] / selection.scale[number]).ln();
        }
    }
    let mut best: Option<(f64, Instead)> = None;
    // Without blocks autocorrelation is looked for in what is left in the end.
    if model.len() > rows.len() && !problem.has_memory() {
        let (gained, found) = autocorrelated(linear, &of_rows, rows);
        best = (!found.is_empty()).then_some((gained, Instead::Autocorrelated(found)));
    }
    if problem.parts.iter().all(|part| part.run_levels.is_empty()) {
        let (gained, found) = noise_of_runs(linear, &of_rows, rows);
        let is_more = best.as_ref().is_none_or(|(known, _)| gained > *known);
        if !found.is_empty() && is_more {
            best = Some((gained, Instead::OfRuns(found)));
        }
    }
    best.filter(|(gained, _)| *gained > by_blocks.max(SURE)).map(|(_, found)| found)
}
