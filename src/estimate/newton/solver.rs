//! The readings of one measurand in a block of one run, chunk by chunk: the quick way for all, then
//! the careful one for those that wait.
//!
//! Readings that wait are put together over chunk borders, so that a few of them cost no chunk of
//! their own.

use nalgebra::DVector;

use crate::campaign::Track;
use crate::engine::lanes::{Chunk, LANES, Lanes, Workspace};
use crate::engine::noise::active_randoms;
use crate::engine::part::ParameterLeaves;
use crate::engine::programs::DelayProgram;
use crate::estimate::minima::starts::shortest_time;
use crate::estimate::newton::Given;
use crate::estimate::newton::careful::{Roots, Stage};
use crate::estimate::newton::quick::{Evaluated, Quick};
use crate::estimate::newton::solved::{Found, Judge, Lane, Smallest, Solved, SolvedLanes};
use crate::estimate::newton::uncertainty::{Quadratic, Seconds, Weighted, along};

/// A delay within this part of the time in which streams change is near the reference time.
const NEAR: f64 = 0.05;

/// See the module.
pub(super) struct Solver<'a> {
    given: &'a Given<'a>,
    program: &'a DelayProgram,
    workspace: Workspace,
    inputs: &'a [Track],
    /// Campaign, run, measurand.
    place: [usize; 3],
    /// Stated standard uncertainty of a reading.
    sigma: f64,
    /// Standard deviation of each random quantity; 0 where it does not act.
    deviations: Vec<f64>,
    /// Covariance along the program's directions.
    covariance: Vec<f64>,
    /// From which delay on each reading is solved (s), see [`origin`].
    origin: f64,
    /// The smallest uncertainty at reference that is known of the run (s): it decides which
    /// readings are blind.
    pub(super) best: f64,
    /// What came of the chunks so far.
    solved: SolvedLanes,
    waiting: Waiting,
}

/// Readings that wait to be solved carefully.
#[derive(Debug)]
struct Waiting {
    /// Where they belong among the samples of the block.
    places: Vec<usize>,
    /// The columns that their program loads.
    columns: Vec<Lanes>,
    at_reference: Evaluated,
    reading: Lanes,
}

impl<'a> Solver<'a> {
    /// For at most `len` samples of `[campaign, run, measurand]`.
    pub(super) fn new(given: &'a Given<'a>, place: [usize; 3], len: usize) -> Self {
        let [part, run, measurand] = place;
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
        let columns = workspace.loaded(&program.code).copied().collect();
        let nothing = [0.0; LANES];
        Self {
            given,
            program,
            workspace,
            inputs: data.runs[run].record.inputs(),
            place,
            sigma: data.sigma[measurand],
            deviations,
            covariance: along(given, part, run, &program.directions),
            origin: origin(given, place),
            best: f64::INFINITY,
            solved: SolvedLanes::new(0, len, program.directions.len()),
            waiting: Waiting {
                places: Vec::with_capacity(LANES),
                columns,
                at_reference: Evaluated { value: nothing, slope: nothing },
                reading: nothing,
            },
        }
    }

    /// What came of the block, with the sums over the columns that the run touches. What is blind
    /// has no delay, whether one was found or not.
    pub(super) fn finished(self) -> Solved {
        let [part, run, measurand] = self.place;
        let problem = self.given.problem;
        let touched = problem.layout.columns.touched_by(problem.run_index(part, run)).len();
        let movers = problem.movers(part, run);
        let mut weighted = DVector::zeros(touched);
        for (slot, direction) in self.program.directions.iter().enumerate() {
            let sum = self.solved.sum(slot);
            for (column, by) in &movers[*direction] {
                weighted[*column] += by * sum;
            }
        }
        Solved {
            run,
            measurand,
            best: self.best,
            origin: self.origin,
            lanes: self.solved,
            weighted_sensitivity: weighted,
        }
    }

    /// The chunks with a reading that counts as solved and is blind, as others of the run show.
    pub(super) fn stale(&self) -> Vec<usize> {
        (0..self.solved.chunks()).filter(|at| self.solved.is_stale(*at, self.best)).collect()
    }

    /// Evaluates the readings of a chunk at the reference time, to know the best of them.
    pub(super) fn look(&mut self, chunk: &Chunk<'_>) {
        self.at_reference(chunk, &self.reading_of(chunk));
    }

    /// Solves the readings of the next chunk, but for those that wait.
    pub(super) fn next(&mut self, chunk: &Chunk<'_>) {
        self.solved.push(chunk);
        self.again(chunk, self.solved.chunks() - 1);
    }

    /// The readings of a chunk; NaN where there is none.
    fn reading_of(&self, chunk: &Chunk<'_>) -> Lanes {
        let mut reading = [f64::NAN; LANES];
        reading[..chunk.len].copy_from_slice(self.readings_of(chunk));
        reading
    }

    fn readings_of<'c>(&self, chunk: &Chunk<'c>) -> &'c [f64] {
        let [part, _, measurand] = self.place;
        chunk.readings(self.given.problem.parts[part].slots()[measurand].column)
    }

    /// Value and slope of each reading of a chunk at the origin, and the random part of its delay's
    /// standard uncertainty (s) with that slope; infinite where there is no slope. The best is known
    /// then.
    fn at_reference(&mut self, chunk: &Chunk<'_>, reading: &Lanes) -> (Evaluated, Lanes) {
        self.workspace.load(&self.program.code, chunk, &[[self.origin; LANES]], false);
        let at_reference = self.evaluate();
        let mut random = self.random_part(&at_reference.slope);
        let set = self.given.problem.instruction_set();
        self.best = self.best.min(set.run(Smallest { reading, random: &mut random }));
        (at_reference, random)
    }

    /// Solves the readings of a chunk, the number of which is known already.
    pub(super) fn again(&mut self, chunk: &Chunk<'_>, number: usize) {
        let reading = self.reading_of(chunk);
        let (at_reference, random_at_reference) = self.at_reference(chunk, &reading);
        let range = self.given.range;
        let set = self.given.problem.instruction_set();
        let quick = Quick::find(set, &at_reference, &reading, range, |delay| self.at(delay));
        let (random, common) = (self.random_part(&quick.slope), self.common_part(&quick.slope));
        let mut found = Found {
            delay: &quick.delay,
            slope: &quick.slope,
            random: &random,
            random_at_reference: &random_at_reference,
            common: &common,
            state: [0; LANES],
            steps: [0; LANES],
            worst: 0.0,
            weights: [0.0; LANES],
        };
        set.run(Judge {
            reading: &reading,
            from: &at_reference.slope,
            is_solved: &quick.is_solved,
            best: self.best,
            found: &mut found,
        });
        self.solved.put(number, &found);
        let sums = self.solved.sums_mut(number);
        sums.fill(0.0);
        let columns = self.workspace.outputs(&self.program.code, 2);
        set.run(Weighted { columns: &columns, weights: &found.weights, sums });
        if quick.is_solved[..chunk.len].contains(&false) {
            for lane in (0..chunk.len).filter(|lane| !quick.is_solved[*lane]) {
                // What is blind for certain is not worth the steps.
                let place = number * LANES + lane;
                if self.solved.may_be_seen(place, self.best) {
                    self.wait(lane, place, &at_reference, &reading);
                }
            }
        }
    }

    /// Lets the reading of a lane wait.
    fn wait(&mut self, lane: usize, place: usize, at_reference: &Evaluated, reading: &Lanes) {
        let waiting = &mut self.waiting;
        let to = waiting.places.len();
        waiting.places.push(place);
        let loaded = self.workspace.loaded(&self.program.code);
        for (column, values) in waiting.columns.iter_mut().zip(loaded) {
            column[to] = values[lane];
        }
        waiting.at_reference.value[to] = at_reference.value[lane];
        waiting.at_reference.slope[to] = at_reference.slope[lane];
        waiting.reading[to] = reading[lane];
        if waiting.places.len() == LANES {
            let kept: Vec<Lanes> = self.workspace.loaded(&self.program.code).copied().collect();
            self.careful();
            self.workspace.reload(&kept);
        }
    }

    /// Solves the readings that wait.
    pub(super) fn careful(&mut self) {
        let places = std::mem::take(&mut self.waiting.places);
        if places.is_empty() {
            return;
        }
        // Lanes that nobody waits in compute what the last one does.
        let last = places.len() - 1;
        self.waiting.columns.iter_mut().for_each(|column| {
            let value = column[last];
            column[last..].fill(value);
        });
        self.workspace.reload(&self.waiting.columns);
        let Evaluated { value, slope } = self.waiting.at_reference;
        let start = [value, slope, self.waiting.reading];
        let roots = Roots::find(places.len(), start, self.given.range, |delay| {
            let Evaluated { value, slope } = self.at(delay);
            [value, slope]
        });
        let from = slope;
        let slope = self.at(&roots.delay).slope;
        let (random, common) = (self.random_part(&slope), self.common_part(&slope));
        let columns = self.workspace.outputs(&self.program.code, 2);
        for (at, place) in places.iter().enumerate() {
            let found = Lane {
                is_solved: roots.stage[at] == Stage::Solved,
                is_here: slope[at].is_sign_positive() == from[at].is_sign_positive(),
                delay: roots.delay[at],
                slope: slope[at],
                random: random[at],
                common: common[at],
                steps: roots.steps[at],
            };
            let weight = self.solved.take(*place, &found, self.best);
            if weight != 0.0 {
                let sums = self.solved.sums_mut(place / LANES);
                for (sum, column) in sums.iter_mut().zip(&columns) {
                    *sum += weight * column[at];
                }
            }
        }
    }

    /// Value and slope of the prediction at some delays since the origin.
    fn at(&mut self, delay: &Lanes) -> Evaluated {
        let delay = delay.map(|delay| self.origin + delay);
        self.workspace.give(&self.program.code, 0, &delay);
        self.evaluate()
    }

    fn evaluate(&mut self) -> Evaluated {
        self.workspace.compute(&self.program.code, 0, self.inputs);
        let outputs = self.workspace.outputs(&self.program.code, 0);
        Evaluated { value: *outputs[0], slope: *outputs[1] }
    }

    /// The random part of the delays' standard uncertainty (s) with some slopes, from the second
    /// group: the readings' own noise and the sample's random quantities.
    fn random_part(&mut self, slope: &Lanes) -> Lanes {
        self.workspace.compute(&self.program.code, 1, self.inputs);
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
        self.seconds(&variance, slope)
    }

    /// The common part (s) with some slopes, from the third group: the parameters' covariance.
    fn common_part(&mut self, slope: &Lanes) -> Lanes {
        let code = &self.program.code;
        self.workspace.compute(code, 2, self.inputs);
        let mut variance = [0.0; LANES];
        self.given.problem.instruction_set().run(Quadratic {
            columns: &self.workspace.outputs(code, 2),
            covariance: &self.covariance,
            sum: &mut variance,
        });
        self.seconds(&variance, slope)
    }

    fn seconds(&self, variance: &Lanes, slope: &Lanes) -> Lanes {
        let mut seconds = [0.0; LANES];
        self.given.problem.instruction_set().run(Seconds {
            variance,
            slope,
            seconds: &mut seconds,
        });
        seconds
    }
}

/// From which delay on the readings of `[campaign, run, measurand]` are solved: the reference time
/// itself (Depenthal 2009, section 3.2.1), or the delay at the given point where that is beyond what
/// is plausible of a delay, or a part of the time in which streams change: from far away the
/// iteration may end at another one.
fn origin(given: &Given<'_>, [part, run, measurand]: [usize; 3]) -> f64 {
    let layout = &given.problem.layout;
    let names = &given.problem.parts[part].system.assembly.names;
    let instance = layout.instance_in(part, run, names.measurands[measurand].delay);
    let known = given.point.values[instance][0];
    let plausible = layout.instances[instance].setting.plausible.unwrap_or(0.0);
    let inputs = given.problem.parts[part].runs[run].record.inputs();
    let near = shortest_time(inputs.iter()).map_or(f64::INFINITY, |time| NEAR * time);
    if known.abs() > plausible.min(near) { known } else { 0.0 }
}
