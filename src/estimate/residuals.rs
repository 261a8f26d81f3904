//! Residuals in the order of time: of each component of each measurand, run after run, as they are
//! seen from a point; and readings that are far out, left out. Which ones those are is judged
//! elsewhere.

use std::sync::Arc;

use crate::engine::{Point, Problem};
use crate::statistics::robust;

/// A measurand of a run of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct OfRun {
    pub(crate) part: usize,
    pub(crate) measurand: usize,
    pub(crate) run: usize,
}

impl OfRun {
    /// The campaign and the measurand in it.
    pub(crate) fn of(self) -> (usize, usize) {
        (self.part, self.measurand)
    }

    /// The names of the run and of the measurand.
    pub(crate) fn names(self, problem: &Problem) -> (String, String) {
        let part = &problem.parts[self.part];
        let measurands = &part.system.assembly.names.measurands;
        (part.run_name(self.run), measurands[self.measurand].name.clone())
    }
}

/// One residual component's residuals, run after run.
#[derive(Clone)]
pub(crate) struct Residuals {
    pub(crate) measurand: usize,
    pub(crate) part: usize,
    pub(crate) runs: Vec<Arc<Vec<f64>>>,
    /// The robust standard deviation of all; NaN of none.
    pub(crate) deviation: f64,
}

impl Residuals {
    /// The residuals of a measurand of a campaign.
    pub(crate) fn new((part, measurand): (usize, usize), runs: Vec<Arc<Vec<f64>>>) -> Self {
        let deviation = robust(runs.iter().flat_map(|run| run.iter())).unwrap_or(f64::NAN);
        Self { measurand, part, runs, deviation }
    }

    /// The campaign and the measurand in it.
    pub(crate) fn of(&self) -> (usize, usize) {
        (self.part, self.measurand)
    }

    pub(crate) fn present(&self) -> impl Iterator<Item = f64> + '_ {
        self.runs.iter().flat_map(|run| run.iter()).copied().filter(|value| !value.is_nan())
    }

    /// Its measurand in a run.
    pub(crate) fn in_run(&self, run: usize) -> OfRun {
        OfRun { part: self.part, measurand: self.measurand, run }
    }

    /// Those of a run that are there, with the numbers of their samples.
    pub(crate) fn readings(&self, run: usize) -> Vec<(usize, f64)> {
        let all = self.runs[run].iter().copied().enumerate();
        all.filter(|(_, value)| !value.is_nan()).collect()
    }

    /// Their robust standard deviation, at least the stated one.
    pub(crate) fn scatter(&self, problem: &Problem) -> f64 {
        self.deviation.max(problem.parts[self.part].sigma[self.measurand])
    }

    /// Those whose sizes are beyond a limit, which may differ from run to run, by run.
    pub(crate) fn beyond(&self, limit: impl Fn(usize) -> f64) -> Far {
        let of_run = |run: usize| {
            let limit = limit(run);
            let all = self.runs[run].iter().copied().enumerate();
            all.filter(|(_, value)| value.abs() > limit).collect()
        };
        (0..self.runs.len()).map(of_run).collect()
    }
}

/// Samples and residuals of some readings of a measurand, by run.
pub(crate) type Far = Vec<Vec<(usize, f64)>>;

/// Which samples readings are of, by run.
pub(crate) fn samples(far: &Far) -> Vec<Vec<usize>> {
    far.iter().map(|run| run.iter().map(|(sample, _)| *sample).collect()).collect()
}

/// Leaves readings of a measurand of a campaign out.
pub(crate) fn leave_out(problem: &mut Problem, (part, measurand): (usize, usize), far: &Far) {
    let part = &mut problem.parts[part];
    let columns = part.slots()[measurand].columns();
    for (run, far) in part.runs.iter_mut().zip(far) {
        let groups = far.chunk_by(|before, after| after.0 == before.0 + 1);
        let range = |group: &[(usize, f64)]| group[0].0..group[0].0 + group.len();
        run.record.leave_out(groups.map(|group| (range(group), columns.clone())));
    }
}

/// All residuals at a point, of the same standard uncertainty: what a formula states of single readings is
/// taken off each. A reading that is stated to be noisier is not farther out for that.
pub(crate) fn seen_from(problem: &Problem, point: &Point) -> Vec<Residuals> {
    let scaled = |one: Residuals| {
        let runs = one.runs.iter().enumerate().map(|(run, residuals)| {
            match problem.sigma_factors(point, (one.part, run), one.measurand) {
                Some(factors) => {
                    let own = residuals.iter().zip(factors).map(|(value, factor)| value / factor);
                    Arc::new(own.collect())
                }
                None => residuals.clone(),
            }
        });
        Residuals::new(one.of(), runs.collect())
    };
    residuals_from(problem, point).into_iter().map(scaled).collect()
}

/// All residuals at a point as they are.
pub(crate) fn residuals_from(problem: &Problem, point: &Point) -> Vec<Residuals> {
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
        let of = |(row, runs)| Residuals::new((p, part.measurand_of(row)), runs);
        all.extend(rows.into_iter().enumerate().map(of));
    }
    all
}
