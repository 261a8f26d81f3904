//! Autocorrelated noise in what rows leave: the Gauss-Markov noise of largest likelihood.

use crate::engine::gauss_markov::GaussMarkov;

use super::linear::Linear;
use super::noise::{components, gauss_markov};
use super::selection::Selection;

/// Gauss-Markov noise of a campaign's residual component.
pub type OfComponent = (usize, usize, GaussMarkov);

/// Residuals of a component at least.
const LEAST: usize = 50;
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
        let count: usize = runs.values().map(Vec::len).sum();
        let Some((noise, own)) = gauss_markov(&runs).filter(|_| count >= LEAST) else { continue };
        let own = own - (count as f64).ln();
        if own > SURE {
            gained += own;
            found.push((part, row, noise));
        }
    }
    (gained, found)
}
