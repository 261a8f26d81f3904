//! A problem without some of its runs.

use crate::engine::problem::Problem;

impl Problem {
    /// The problem without some runs (campaign and run); a campaign that would lose all of them keeps
    /// all. `None` where none goes.
    pub fn without_runs(&self, goes: impl Fn(usize, usize) -> bool) -> Option<Self> {
        let mut parts = self.parts.clone();
        let mut is_less = false;
        for (number, part) in parts.iter_mut().enumerate() {
            let stays: Vec<bool> = (0..part.runs.len()).map(|run| !goes(number, run)).collect();
            if stays.iter().all(|stays| *stays) || !stays.contains(&true) {
                continue;
            }
            is_less = true;
            part.runs = kept(&part.runs, &stays);
            part.run_levels = kept(&part.run_levels, &stays);
            part.smoothing_sigma = kept(&part.smoothing_sigma, &stays);
        }
        is_less.then(|| self.with_parts(parts))
    }
}

/// Those of some elements that stay.
fn kept<T: Clone>(all: &[T], stays: &[bool]) -> Vec<T> {
    all.iter().zip(stays).filter(|(_, stays)| **stays).map(|(one, _)| one.clone()).collect()
}
