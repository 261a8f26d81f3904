//! Residuals as sequences in time: of each component of each measurand, run after run.
//!
//! Those of a stage are whitened, in units of what is stated or found of the noise; those seen from
//! a point are as they are, in SI units. What they say is judged elsewhere.

use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};

use crate::campaign::Run;
use crate::campaign::record::Record;
use crate::engine::gauss_markov::NoiseClock;
use crate::engine::layout::qualified;
use crate::engine::stretches::Left;
use crate::engine::{Point, Problem};
use crate::estimate::median::upper_median;

use crate::statistics::ln_normal;

/// Standard deviation over median absolute deviation of a normal distribution.
pub(super) const NORMAL: f64 = 1.482_602_2;
/// Standard deviation of the logarithm of a median absolute deviation, times `√n`.
pub(super) const OF_A_MEDIAN: f64 = 1.17;

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
    /// The component.
    pub(super) row: usize,
    pub(super) runs: Vec<Arc<Vec<f64>>>,
    pub(super) times: Arc<Times>,
}

/// The times of the samples of runs, made when they are asked for.
pub(super) struct Times {
    records: Vec<Record>,
    by_stamps: OnceLock<Vec<Vec<f64>>>,
    by_numbers: OnceLock<Vec<Vec<f64>>>,
}

impl Times {
    fn of(runs: &[Run]) -> Self {
        let records = runs.iter().map(|run| run.record.clone()).collect();
        Self { records, by_stamps: OnceLock::new(), by_numbers: OnceLock::new() }
    }

    /// The times of all samples of each run (s).
    fn by(&self, clock: NoiseClock) -> &[Vec<f64>] {
        let made = match clock {
            NoiseClock::Stamps => &self.by_stamps,
            NoiseClock::Numbers => &self.by_numbers,
        };
        made.get_or_init(|| self.records.iter().map(|record| times(record, clock)).collect())
    }
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

    /// Their mean square.
    pub(super) fn variance(&self) -> f64 {
        let add = |(sum, count), value: f64| (sum + value * value, count + 1.0);
        let (sum, count) = self.present().fold((0.0, 0.0), add);
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// The only one of one campaign, whose samples have no times.
    #[cfg(test)]
    pub(super) fn of_runs(runs: Vec<Arc<Vec<f64>>>) -> Self {
        Self { measurand: 0, part: 0, row: 0, runs, times: Arc::new(Times::of(&[])) }
    }

    /// The times of all samples of each run (s).
    pub(super) fn times(&self, clock: NoiseClock) -> &[Vec<f64>] {
        self.times.by(clock)
    }

    /// The median time between samples (s).
    pub(super) fn interval(&self, clock: NoiseClock) -> Option<f64> {
        let pairs = self.times(clock).iter().flat_map(|times| times.windows(2));
        upper_median(&mut pairs.map(|pair| pair[1] - pair[0]).collect::<Vec<f64>>())
            .filter(|interval| *interval > 0.0)
    }
}

/// The residuals of each component of each measurand.
pub(super) fn sequences(problem: &Problem, left: &[Left]) -> Vec<Sequence> {
    let mut all = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        let times = Arc::new(Times::of(&part.runs));
        for row in 0..part.residual_count() {
            let runs = (0..part.runs.len())
                .map(|run| Arc::clone(&left[problem.run_index(p, run)].residuals[row]))
                .collect();
            let (measurand, times) = (part.measurand_of(row), Arc::clone(&times));
            all.push(Sequence { measurand, part: p, row, runs, times });
        }
    }
    all
}

/// The times of a run's samples (s).
fn times(record: &Record, clock: NoiseClock) -> Vec<f64> {
    let mut times = Vec::with_capacity(record.len());
    record.walk(|stretch| {
        times.extend_from_slice(&clock.of(stretch.samples)[stretch.range()]);
    });
    times
}

/// Sums over neighbours in a run.
pub(super) struct Neighbours {
    pub(super) products: f64,
    pub(super) squares: f64,
    pub(super) pairs: f64,
}

impl Neighbours {
    pub(super) fn of(run: &[f64]) -> Self {
        let mut sums = Self { products: 0.0, squares: 0.0, pairs: 0.0 };
        for pair in run.windows(2).filter(|pair| pair.iter().all(|value| !value.is_nan())) {
            sums.products += pair[0] * pair[1];
            sums.squares += 0.5 * (pair[0].powi(2) + pair[1].powi(2));
            sums.pairs += 1.0;
        }
        sums
    }

    /// Their correlation.
    pub(super) fn correlation(&self) -> f64 {
        if self.squares > 0.0 { self.products / self.squares } else { 0.0 }
    }

    /// Logarithm of its probability by chance.
    pub(super) fn ln_p(&self) -> f64 {
        ln_normal(self.correlation() * self.pairs.sqrt())
    }
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
