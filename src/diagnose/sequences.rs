//! Residuals as sequences in time: of each component of each measurand, run after run, as they are
//! seen from a point, in SI units. What follows from them is judged elsewhere.

use std::sync::Arc;

use crate::engine::layout::qualified;
use crate::engine::{Point, Problem};
use crate::statistics::{NORMAL, upper_median};

/// The median of the sizes of numbers, NaN not counted; `None` of none.
pub(super) fn median_size<'a>(values: impl IntoIterator<Item = &'a f64>) -> Option<f64> {
    let sizes = values.into_iter().map(|value| value.abs()).filter(|size| !size.is_nan());
    upper_median(&mut sizes.collect::<Vec<f64>>())
}

/// The robust standard deviation of numbers about zero, NaN not counted; `None` of none.
pub(super) fn robust<'a>(values: impl IntoIterator<Item = &'a f64>) -> Option<f64> {
    median_size(values).map(|median| NORMAL * median)
}

/// A measurand of a run of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::diagnose) struct OfRun {
    pub(in crate::diagnose) part: usize,
    pub(in crate::diagnose) measurand: usize,
    pub(in crate::diagnose) run: usize,
}

impl OfRun {
    /// The campaign and the measurand in it.
    pub(super) fn of(self) -> (usize, usize) {
        (self.part, self.measurand)
    }

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
    /// The robust standard deviation of all; NaN of none.
    pub(super) deviation: f64,
}

impl Sequence {
    /// The residuals of a measurand of a campaign.
    pub(super) fn new((part, measurand): (usize, usize), runs: Vec<Arc<Vec<f64>>>) -> Self {
        let deviation = robust(runs.iter().flat_map(|run| run.iter())).unwrap_or(f64::NAN);
        Self { measurand, part, runs, deviation }
    }

    /// The campaign and the measurand in it.
    pub(super) fn of(&self) -> (usize, usize) {
        (self.part, self.measurand)
    }

    pub(super) fn present(&self) -> impl Iterator<Item = f64> + '_ {
        self.runs.iter().flat_map(|run| run.iter()).copied().filter(|value| !value.is_nan())
    }

    /// Its measurand in a run.
    pub(super) fn in_run(&self, run: usize) -> OfRun {
        OfRun { part: self.part, measurand: self.measurand, run }
    }

    /// Those of a run that are there, with the numbers of their samples.
    pub(super) fn readings(&self, run: usize) -> Vec<(usize, f64)> {
        let all = self.runs[run].iter().copied().enumerate();
        all.filter(|(_, value)| !value.is_nan()).collect()
    }

    /// Those whose sizes are beyond a limit, which may differ from run to run, by run.
    pub(super) fn beyond(&self, limit: impl Fn(usize) -> f64) -> Vec<Vec<(usize, f64)>> {
        let of_run = |run: usize| {
            let limit = limit(run);
            let all = self.runs[run].iter().copied().enumerate();
            all.filter(|(_, value)| value.abs() > limit).collect()
        };
        (0..self.runs.len()).map(of_run).collect()
    }
}

/// All residuals at a point.
pub(super) fn seen_from(problem: &Problem, point: &Point) -> Vec<Sequence> {
    let mut all = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        let mut rows = vec![Vec::new(); part.residual_count()];
        for r in 0..part.runs.len() {
            let mut residuals = vec![Vec::new(); rows.len()];
            problem.visit_residuals(p, r, point, &mut |_, values| {
                residuals.iter_mut().zip(values).for_each(|(all, value)| all.push(*value));
            });
            rows.iter_mut().zip(residuals).for_each(|(runs, own)| runs.push(Arc::new(own)));
        }
        let of = |(row, runs)| Sequence::new((p, part.measurand_of(row)), runs);
        all.extend(rows.into_iter().enumerate().map(of));
    }
    all
}
