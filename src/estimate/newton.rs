//! Each reading's own delay: safeguarded Newton from the reference time.
//!
//! A measurand is a function `m(t)` of its delay alone once the transformation is known (the seed,
//! section 3.2.1); `m(t) = reading` is solved for `t`, starting at the reference time, `t = 0`.
//! The delay is an implicit function of every parameter: `dt/dθ = -(∂m/∂θ) / m'`, so
//! `u² = (u_m² + J Σ Jᵀ) / m'²` with the full covariance Σ of the parameters (the seed, section 3.4,
//! has the reading's part alone). Where `m'` vanishes the reading is *blind*. The lanes compute 128
//! readings at a time.

use nalgebra::{DMatrix, DVector};

use crate::engine::lanes::dispatch::Simd;

use crate::campaign::run::Samples;
use crate::engine::lanes::arithmetic::Arithmetic;
use crate::engine::lanes::dispatch::Task;
use crate::engine::lanes::{Chunk, LANES, Lanes, Workspace};
use crate::engine::noise::active_randoms;
use crate::engine::point::Point;
use crate::engine::problem::{ParameterLeaves, Problem};
use crate::engine::programs::DelayProgram;

mod chunk;
mod long;

use chunk::{Roots, Stage};
pub use long::each_delay;

/// A reading whose uncertainty exceeds the smallest of its run and measurand by this factor is blind.
pub const BLIND_RATIO: f64 = 10.0;

/// Whether a reading gave its delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// Solved.
    Solved,
    /// The measurand hardly changes with time here.
    Blind,
    /// Newton's iteration found no delay that explains the reading.
    Failed,
}

impl State {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Blind => "blind",
            Self::Failed => "failed",
        }
    }
}

/// The delay of one reading.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadingDelay {
    /// Run of the campaign.
    pub run: usize,
    /// Sample of the run.
    pub sample: usize,
    /// Measurand.
    pub measurand: usize,
    /// Row of the data file (line number, from 1).
    pub row: usize,
    /// Reference time (s).
    pub time: f64,
    /// What came of it.
    pub state: State,
    /// Delay (s); NaN unless solved or blind.
    pub delay: f64,
    /// Derivative of the measurand with respect to its delay (unit/s).
    pub slope: f64,
    /// Random part of the standard uncertainty (s): the reading and what is random in its sample.
    pub random: f64,
    /// The same with the slope at the reference time, which the reading's own error does not touch:
    /// what decides on blindness and weights.
    pub random_at_reference: f64,
    /// Common part (s): the parameters' covariance.
    pub common: f64,
    /// Newton steps.
    pub steps: u32,
}

impl ReadingDelay {
    /// Combined standard uncertainty (s).
    pub fn standard_uncertainty(&self) -> f64 {
        self.random.hypot(self.common)
    }

    /// Expanded uncertainty (s), k = 2.
    pub fn expanded_uncertainty(&self) -> f64 {
        2.0 * self.standard_uncertainty()
    }
}

/// The delays of one measurand in one run.
#[derive(Clone, Debug)]
pub struct RunDelays {
    /// One for each reading.
    pub readings: Vec<ReadingDelay>,
    /// `Σ w dt/dθ` of the solved ones over the columns the run touches, with the weights
    /// `w = random_at_reference⁻²`.
    pub weighted_sensitivity: DVector<f64>,
}

/// What the delays of a run are computed from.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// The campaigns.
    pub problem: &'a Problem,
    /// Parameter values.
    pub point: &'a Point,
    /// Covariance of all columns at that point.
    pub covariance: &'a DMatrix<f64>,
    /// Farthest delay looked for (s).
    pub range: f64,
}

/// The delay of every reading of one measurand in one run, all in memory, a rotation left out (it
/// has no single delay).
pub fn delays_of_run(given: &Given<'_>, part: usize, run: usize, measurand: usize) -> RunDelays {
    let problem = given.problem;
    let data = &problem.parts[part];
    let touched = problem.layout.columns.touched_by(problem.run_index(part, run)).len();
    let mut found =
        RunDelays { readings: Vec::new(), weighted_sensitivity: DVector::zeros(touched) };
    if data.slots()[measurand].components != 1 {
        return found;
    }
    let mut solver = Solver::new(given, part, run, measurand);
    let record = &data.runs[run].record;
    found.readings.reserve(record.len());
    let mut sums: Vec<Vec<f64>> = Vec::with_capacity(record.len().div_ceil(LANES));
    let mut ends = Vec::with_capacity(sums.capacity());
    record.walk(|stretch| {
        for chunk in Chunk::all(stretch, data.columns()) {
            sums.push(solver.chunk(&chunk, &mut found.readings));
            ends.push(found.readings.len());
        }
    });
    // Early chunks did not know yet how well the run sees its delays: some of their readings may be
    // blind after all.
    let best = solver.best;
    let start = |number: usize| if number == 0 { 0 } else { ends[number - 1] };
    let is_stale = |reading: &ReadingDelay| {
        reading.state != State::Blind && reading.worst() > BLIND_RATIO * best
    };
    let stale: Vec<bool> = (0..sums.len())
        .map(|number| found.readings[start(number)..ends[number]].iter().any(is_stale))
        .collect();
    let mut scratch = Samples::default();
    for (number, _) in stale.iter().enumerate().filter(|(_, stale)| **stale) {
        let stretch = record.stretch(number * LANES..(number + 1) * LANES, &mut scratch);
        for chunk in Chunk::all(stretch, data.columns()) {
            let mut again = Vec::with_capacity(LANES);
            sums[number] = solver.chunk(&chunk, &mut again);
            found.readings[start(number)..ends[number]].clone_from_slice(&again);
        }
    }
    let mut weighted = vec![0.0; solver.program.directions.len()];
    for sums in sums {
        weighted.iter_mut().zip(sums).for_each(|(all, sum)| *all += sum);
    }
    found.weighted_sensitivity = solver.by_columns(&weighted);
    found
}

/// Solves the readings of one measurand in one run, chunk by chunk.
struct Solver<'a> {
    given: &'a Given<'a>,
    program: &'a DelayProgram,
    workspace: Workspace,
    place: (usize, usize, usize),
    /// Stated standard uncertainty of a reading.
    sigma: f64,
    /// Standard deviation of each random quantity; 0 where it does not act.
    deviations: Vec<f64>,
    /// Covariance along the program's directions, row by row; the upper triangle counts double.
    covariance: Vec<f64>,
    /// `prediction - reading` and slope of the chunk's readings at the reference time; the readings.
    start: [Lanes; 3],
    /// The smallest uncertainty at reference of the chunks so far (s): it decides which readings are
    /// blind.
    best: f64,
}

impl<'a> Solver<'a> {
    fn new(given: &'a Given<'a>, part: usize, run: usize, measurand: usize) -> Self {
        let problem = given.problem;
        let data = &problem.parts[part];
        let program = problem.programs(part).delay(&data.system, measurand);
        let mut workspace = Workspace::new(&program.code, problem.instruction_set());
        let parameters = problem.parameters(part, run, given.point);
        workspace.hold_still(&program.code, &ParameterLeaves(&parameters));
        let active = active_randoms(data);
        let deviations = (0..data.random_sigma.len())
            .map(|k| if active.contains(&k) { data.random_sigma_in(run, k) } else { 0.0 })
            .collect();
        Self {
            given,
            program,
            workspace,
            place: (part, run, measurand),
            sigma: data.sigma[measurand],
            deviations,
            covariance: along(given, part, run, &program.directions),
            start: [[0.0; LANES]; 3],
            best: f64::INFINITY,
        }
    }

    /// Sums over the program's directions as sums over the columns that the run touches.
    fn by_columns(&self, weighted: &[f64]) -> DVector<f64> {
        let (part, run, _) = self.place;
        let problem = self.given.problem;
        let touched = problem.layout.columns.touched_by(problem.run_index(part, run)).len();
        let mut sums = DVector::zeros(touched);
        let movers = problem.movers(part, run);
        for (direction, sum) in self.program.directions.iter().zip(weighted) {
            for (column, by) in &movers[*direction] {
                sums[*column] += by * sum;
            }
        }
        sums
    }

    /// Evaluates at the reference time: which readings are there, and the random part of the standard
    /// uncertainty of each (s) with the slope there.
    fn at_reference(&mut self, chunk: &Chunk<'_>) -> ([bool; LANES], Lanes) {
        let (part, _, measurand) = self.place;
        let column = self.given.problem.parts[part].slots()[measurand].column;
        let mut present = [false; LANES];
        for (there, reading) in present.iter_mut().zip(chunk.readings(column)) {
            *there = !reading.is_nan();
        }
        let code = &self.program.code;
        self.workspace.load(code, chunk, &[[0.0; LANES]]);
        self.workspace.compute(code, 0, chunk);
        let outputs = self.workspace.outputs(code, 0);
        self.start = [*outputs[0], *outputs[1], [0.0; LANES]];
        let readings = chunk.readings(column);
        self.start[2][..readings.len()].copy_from_slice(readings);
        self.workspace.compute(code, 1, chunk);
        let mut sigma = self.reading_sigma();
        for (sigma, slope) in sigma.iter_mut().zip(&self.start[1]) {
            *sigma = if slope.is_finite() && *slope != 0.0 {
                *sigma / slope.abs()
            } else {
                f64::INFINITY
            };
        }
        (present, sigma)
    }

    /// Keeps the smallest uncertainty at reference.
    fn see(&mut self, present: &[bool; LANES], at_reference: &Lanes) {
        for (there, sigma) in present.iter().zip(at_reference) {
            self.best = if *there && *sigma < self.best { *sigma } else { self.best };
        }
    }

    /// Standard deviation of the readings from the second group: their own noise and the sample's
    /// random quantities.
    fn reading_sigma(&self) -> Lanes {
        let outputs = self.workspace.outputs(&self.program.code, 1);
        let mut variance = match self.program.factor {
            Some(factor) => outputs[factor].map(|factor| (self.sigma * factor).powi(2)),
            None => [self.sigma * self.sigma; LANES],
        };
        for (random, output) in &self.program.sensitivities {
            let deviation = self.deviations[*random];
            if deviation > 0.0 {
                for (variance, slope) in variance.iter_mut().zip(outputs[*output]) {
                    *variance += (deviation * slope).powi(2);
                }
            }
        }
        variance.map(f64::sqrt)
    }

    /// Solves the readings of a chunk; `Σ w dm/dθ / -m'` of the solved ones comes back, for each of the
    /// program's directions.
    fn chunk(&mut self, chunk: &Chunk<'_>, readings: &mut Vec<ReadingDelay>) -> Vec<f64> {
        let (_, run, measurand) = self.place;
        let (present, at_reference) = self.at_reference(chunk);
        self.see(&present, &at_reference);
        let best = self.best;
        let program = self.program;
        let code = &program.code;
        let roots = Roots::find(
            program,
            &mut self.workspace,
            chunk,
            &present,
            &at_reference.map(|sigma| sigma <= BLIND_RATIO * best),
            self.start,
            self.given.range,
        );
        self.workspace.give(code, 0, &roots.delay);
        self.workspace.compute(code, 0, chunk);
        let slopes = *self.workspace.outputs(code, 0)[1];
        self.workspace.compute(code, 1, chunk);
        let sigma = self.reading_sigma();
        self.workspace.compute(code, 2, chunk);
        let derivatives = self.workspace.outputs(code, 2);
        let mut common = [0.0; LANES];
        self.given.problem.instruction_set().run(Quadratic {
            columns: &derivatives,
            covariance: &self.covariance,
            sum: &mut common,
        });
        let mut weights = [0.0; LANES];
        for (lane, sample) in chunk.stretch().each().enumerate() {
            if !present[lane] {
                continue;
            }
            let slope = slopes[lane].abs();
            let mut reading = ReadingDelay {
                run,
                sample: sample.number,
                measurand,
                row: sample.row(),
                time: sample.time(),
                state: State::Failed,
                delay: f64::NAN,
                slope: f64::NAN,
                random: f64::NAN,
                random_at_reference: at_reference[lane],
                common: f64::NAN,
                steps: roots.steps[lane],
            };
            if roots.stage[lane] == Stage::Solved {
                reading.state = State::Solved;
                reading.delay = roots.delay[lane];
                reading.slope = slopes[lane];
                reading.random = sigma[lane] / slope;
                reading.common = common[lane].max(0.0).sqrt() / slope;
            }
            reading.mark_blind(best);
            if reading.state == State::Solved {
                weights[lane] = -reading.random_at_reference.powi(-2) / reading.slope;
            }
            readings.push(reading);
        }
        derivatives.iter().map(|column| dot(&weights, column)).collect()
    }
}

/// `Σ a b` over lanes, in eight sums; where `a` is zero, nothing.
fn dot(a: &Lanes, b: &Lanes) -> f64 {
    let mut parts = [0.0; 8];
    for (a, b) in a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0) {
        for ((part, a), b) in parts.iter_mut().zip(a).zip(b) {
            *part += if *a == 0.0 { 0.0 } else { a * b };
        }
    }
    parts.iter().sum()
}

impl ReadingDelay {
    /// Its random uncertainty (s), at the reference time or at the solution: the larger.
    fn worst(&self) -> f64 {
        let solved = self.state == State::Solved;
        let here = if solved { self.random } else { self.random_at_reference };
        self.random_at_reference.max(here)
    }

    /// Marks a reading that sees its delay far worse than the best of its run: by the slope at the
    /// reference time, and by that at the solution.
    fn mark_blind(&mut self, best: f64) {
        let worst = self.worst();
        if !worst.is_finite() || worst > BLIND_RATIO * best {
            self.state = State::Blind;
        }
    }
}

/// The covariance of a run along some directions, for [`Quadratic`].
fn along(given: &Given<'_>, part: usize, run: usize, directions: &[usize]) -> Vec<f64> {
    let problem = given.problem;
    let touched = problem.layout.columns.touched_by(problem.run_index(part, run));
    let movers = problem.movers(part, run);
    let count = directions.len();
    let mut along = vec![0.0; count * count];
    for i in 0..count {
        for j in i..count {
            let mut sum = 0.0;
            for (a, p) in &movers[directions[i]] {
                for (b, q) in &movers[directions[j]] {
                    sum += p * q * given.covariance[(touched[*a], touched[*b])];
                }
            }
            along[i * count + j] = if i == j { sum } else { 2.0 * sum };
        }
    }
    along
}

/// `sum = Σ_i column_i Σ_{j >= i} covariance_ij column_j`, lane by lane.
struct Quadratic<'a> {
    columns: &'a [&'a Lanes],
    covariance: &'a [f64],
    sum: &'a mut Lanes,
}

impl Task for Quadratic<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        let count = self.columns.len();
        for (i, left) in self.columns.iter().enumerate() {
            let mut inner = [0.0; LANES];
            for (j, right) in self.columns.iter().enumerate().skip(i) {
                let entry = self.covariance[i * count + j];
                for lane in 0..LANES {
                    inner[lane] = A::mul_add(entry, right[lane], inner[lane]);
                }
            }
            for lane in 0..LANES {
                self.sum[lane] = A::mul_add(left[lane], inner[lane], self.sum[lane]);
            }
        }
    }
}
