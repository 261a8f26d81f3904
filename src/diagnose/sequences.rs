//! Residuals as sequences in time: of each component of each measurand, run after run.
//!
//! Those of a stage are whitened, in units of what is stated or found of the noise; those seen from
//! a point are as they are, in SI units. What they say is judged elsewhere.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::engine::layout::qualified;
use crate::engine::stretches::Left;
use crate::engine::{Point, Problem};
use crate::estimate::median::upper_median;

/// Standard deviation over median absolute deviation of a normal distribution.
pub(super) const NORMAL: f64 = 1.482_602_2;

/// A measurand of a run of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::diagnose) struct OfRun {
    pub(in crate::diagnose) part: usize,
    pub(in crate::diagnose) measurand: usize,
    pub(in crate::diagnose) run: usize,
}

impl OfRun {
    /// The names of the run and of the measurand.
    pub(super) fn names(self, problem: &Problem) -> (String, String) {
        let part = &problem.parts[self.part];
        let run = qualified(part.label.as_deref(), &part.runs[self.run].name);
        (run, part.system.assembly.names.measurands[self.measurand].name.clone())
    }
}

/// One residual component's residuals, run after run.
#[derive(Clone)]
pub(super) struct Sequence {
    pub(super) measurand: usize,
    pub(super) part: usize,
    pub(super) runs: Vec<Arc<Vec<f64>>>,
}

impl Sequence {
    pub(super) fn present(&self) -> impl Iterator<Item = f64> + '_ {
        self.runs.iter().flat_map(|run| run.iter()).copied().filter(|value| !value.is_nan())
    }

    /// The same of some runs, as if there were no others.
    pub(super) fn among(&self, wanted: impl Fn(usize) -> bool) -> Self {
        let runs = self
            .runs
            .iter()
            .enumerate()
            .map(|(run, all)| if wanted(run) { Arc::clone(all) } else { Arc::default() });
        Self { runs: runs.collect(), ..self.clone() }
    }

    /// Whether it is of one of some measurands and runs in a run.
    pub(super) fn is_among(&self, some: &BTreeSet<OfRun>, run: usize) -> bool {
        some.contains(&OfRun { part: self.part, measurand: self.measurand, run })
    }

    /// Those of a run that are there, with the numbers of their samples.
    pub(super) fn readings(&self, run: usize) -> Vec<(usize, f64)> {
        let all = self.runs[run].iter().copied().enumerate();
        all.filter(|(_, value)| !value.is_nan()).collect()
    }

    /// Their robust standard deviation: from the median of their sizes; `None` of none.
    pub(super) fn deviation(&self) -> Option<f64> {
        let mut sizes: Vec<f64> = self.present().map(f64::abs).collect();
        upper_median(&mut sizes).map(|median| NORMAL * median)
    }

    /// The only one of one campaign, whose samples have no times.
    #[cfg(test)]
    pub(super) fn of_runs(runs: Vec<Arc<Vec<f64>>>) -> Self {
        Self { measurand: 0, part: 0, runs }
    }
}

/// The residuals of each component of each measurand.
pub(super) fn sequences(problem: &Problem, left: &[Left]) -> Vec<Sequence> {
    let mut all = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        for row in 0..part.residual_count() {
            let runs = (0..part.runs.len())
                .map(|run| Arc::clone(&left[problem.run_index(p, run)].residuals[row]))
                .collect();
            all.push(Sequence { measurand: part.measurand_of(row), part: p, runs });
        }
    }
    all
}

/// All residuals at a point, as they are.
pub(super) fn seen_from(problem: &Problem, point: &Point) -> Vec<Sequence> {
    let mut left = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        for r in 0..part.runs.len() {
            let mut residuals = vec![Vec::new(); part.residual_count()];
            problem.visit_residuals(p, r, point, &mut |_, values| {
                residuals.iter_mut().zip(values).for_each(|(all, value)| all.push(*value));
            });
            let residuals = residuals.into_iter().map(Arc::new).collect();
            left.push(Left { residuals, scores: Vec::new() });
        }
    }
    sequences(problem, &left)
}
