//! The whitened column of a change, sample by sample, where noise may be autocorrelated: what acts from a
//! sample on is whitened from there on.

use crate::engine::gauss_markov::{Gains, States};

/// The column of a change in one residual component, sample after sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct Masked {
    whole: States,
    own: States,
}

impl Masked {
    /// The whitened value at the next reading, from that of the whole column.
    pub fn next(&mut self, gains: Option<&Gains>, whitened: f64, acts: bool) -> f64 {
        let Some(gains) = gains else { return if acts { whitened } else { 0.0 } };
        let value = gains.undo(&mut self.whole, whitened);
        gains.take(&mut self.own, if acts { value } else { 0.0 })
    }
}
