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
use crate::estimate::newton::careful::{Roots, Stage};
use crate::estimate::newton::quick::{Evaluated, Quick, STEPS};
use crate::estimate::newton::uncertainty::{Quadratic, Seconds, Weighted, along};
use crate::estimate::newton::{Given, ReadingDelay, RunDelays, State};

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
    /// The readings so far.
    readings: Vec<ReadingDelay>,
    /// For each chunk the number of readings up to its end.
    ends: Vec<usize>,
    /// For each chunk `Σ w dt/dθ` of its solved readings, along the program's directions.
    sums: Vec<Vec<f64>>,
    waiting: Waiting,
}

/// Readings that wait to be solved carefully.
#[derive(Debug)]
struct Waiting {
    places: Vec<Place>,
    /// The columns that their program loads.
    columns: Vec<Lanes>,
    at_reference: Evaluated,
    reading: Lanes,
}

/// Where a reading belongs.
#[derive(Clone, Copy, Debug)]
struct Place {
    chunk: usize,
    /// Among the readings.
    index: usize,
}

/// What came of some lanes, as delays since the origin.
struct Solution<'s> {
    /// Slopes at the origin.
    from: &'s Lanes,
    delay: &'s Lanes,
    slope: &'s Lanes,
    is_solved: &'s [bool; LANES],
    steps: &'s [u32; LANES],
}

impl<'a> Solver<'a> {
    /// For at most `len` readings of `[campaign, run, measurand]`.
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
            readings: Vec::with_capacity(len),
            ends: Vec::new(),
            sums: Vec::new(),
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
    pub(super) fn finished(mut self) -> RunDelays {
        let [part, run, _] = self.place;
        let problem = self.given.problem;
        let touched = problem.layout.columns.touched_by(problem.run_index(part, run)).len();
        let movers = problem.movers(part, run);
        let mut weighted = DVector::zeros(touched);
        for (slot, direction) in self.program.directions.iter().enumerate() {
            let sum: f64 = self.sums.iter().map(|sums| sums[slot]).sum();
            for (column, by) in &movers[*direction] {
                weighted[*column] += by * sum;
            }
        }
        let best = self.best;
        let blind = |reading: &&mut ReadingDelay| reading.is_blind_beside(best);
        self.readings.iter_mut().filter(blind).for_each(ReadingDelay::blind);
        RunDelays { readings: self.readings, weighted_sensitivity: weighted }
    }

    /// The chunks with a reading that counts as solved and is blind, as others of the run show.
    pub(super) fn stale(&self) -> Vec<usize> {
        let is_stale = |reading: &ReadingDelay| {
            reading.state == State::Solved && reading.is_blind_beside(self.best)
        };
        let has_stale = |chunk: &usize| self.readings[self.range(*chunk)].iter().any(is_stale);
        (0..self.ends.len()).filter(has_stale).collect()
    }

    fn range(&self, chunk: usize) -> std::ops::Range<usize> {
        let start = chunk.checked_sub(1).map_or(0, |before| self.ends[before]);
        start..self.ends[chunk]
    }

    /// Evaluates the readings of a chunk at the reference time, to know the best of them.
    pub(super) fn look(&mut self, chunk: &Chunk<'_>) {
        let (_, random) = self.at_reference(chunk);
        let sigmas = self.readings_of(chunk).iter().zip(random);
        let seen = sigmas.filter(|(reading, _)| !reading.is_nan()).map(|(_, sigma)| sigma);
        self.best = seen.fold(self.best, f64::min);
    }

    /// Solves the readings of the next chunk, but for those that wait.
    pub(super) fn next(&mut self, chunk: &Chunk<'_>) {
        let [_, run, measurand] = self.place;
        let readings = chunk.stretch().each().zip(self.readings_of(chunk));
        let present = readings.filter(|(_, reading)| !reading.is_nan());
        let unsolved = |(sample, _)| ReadingDelay::without_delay(run, measurand, &sample);
        self.readings.extend(present.map(unsolved));
        self.ends.push(self.readings.len());
        self.sums.push(Vec::new());
        self.again(chunk, self.ends.len() - 1);
    }

    fn readings_of<'c>(&self, chunk: &Chunk<'c>) -> &'c [f64] {
        let [part, _, measurand] = self.place;
        chunk.readings(self.given.problem.parts[part].slots()[measurand].column)
    }

    /// Value and slope of each reading of a chunk at the origin, and the random part of its delay's
    /// standard uncertainty (s) with that slope; infinite where there is no slope.
    fn at_reference(&mut self, chunk: &Chunk<'_>) -> (Evaluated, Lanes) {
        self.workspace.load(&self.program.code, chunk, &[[self.origin; LANES]], false);
        let at_reference = self.evaluate();
        let random = self.random_part(&at_reference.slope);
        (at_reference, random.map(|sigma| if sigma.is_nan() { f64::INFINITY } else { sigma }))
    }

    /// Solves the readings of a chunk, the number of which is known already.
    pub(super) fn again(&mut self, chunk: &Chunk<'_>, number: usize) {
        let start = self.range(number).start;
        let mut reading = [f64::NAN; LANES];
        reading[..chunk.len].copy_from_slice(self.readings_of(chunk));
        let (at_reference, random) = self.at_reference(chunk);
        let lanes = (0..LANES).filter(|lane| !reading[*lane].is_nan());
        let places: Vec<(usize, Place)> = lanes
            .zip(start..)
            .map(|(lane, index)| (lane, Place { chunk: number, index }))
            .collect();
        for (lane, place) in &places {
            self.readings[place.index].random_at_reference = random[*lane];
            self.best = self.best.min(random[*lane]);
        }
        let range = self.given.range;
        let set = self.given.problem.instruction_set();
        let quick = Quick::find(set, &at_reference, &reading, range, |delay| self.at(delay));
        let solution = Solution {
            from: &at_reference.slope,
            delay: &quick.delay,
            slope: &quick.slope,
            is_solved: &quick.is_solved,
            steps: &[STEPS; LANES],
        };
        let solved = |(lane, _): &&(usize, Place)| quick.is_solved[*lane];
        let weights = self.finish(&solution, places.iter().filter(solved));
        let mut sums = vec![0.0; self.program.directions.len()];
        let columns = self.workspace.outputs(&self.program.code, 2);
        set.run(Weighted { columns: &columns, weights: &weights, sums: &mut sums });
        self.sums[number] = sums;
        for (lane, place) in places.iter().filter(|(lane, _)| !quick.is_solved[*lane]) {
            // What is blind for certain is not worth the steps.
            if !self.readings[place.index].is_blind_beside(self.best) {
                self.wait(*lane, *place, &at_reference, &reading);
            }
        }
    }

    /// Lets the reading of a lane wait.
    fn wait(&mut self, lane: usize, place: Place, at_reference: &Evaluated, reading: &Lanes) {
        let waiting = &mut self.waiting;
        let to = waiting.places.len();
        waiting.places.push(place);
        let loaded = self.workspace.loaded(&self.program.code);
        for (column, values) in waiting.columns.iter_mut().zip(loaded) {
            column[to..].fill(values[lane]);
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
        self.workspace.reload(&self.waiting.columns);
        let Evaluated { value, slope } = self.waiting.at_reference;
        let start = [value, slope, self.waiting.reading];
        let roots = Roots::find(places.len(), start, self.given.range, |delay| {
            let Evaluated { value, slope } = self.at(delay);
            [value, slope]
        });
        let start_slope = slope;
        let slope = self.at(&roots.delay).slope;
        let is_solved = roots.stage.map(|stage| stage == Stage::Solved);
        let solution = Solution {
            from: &start_slope,
            delay: &roots.delay,
            slope: &slope,
            is_solved: &is_solved,
            steps: &roots.steps,
        };
        let lanes: Vec<(usize, Place)> = places.iter().copied().enumerate().collect();
        let weights = self.finish(&solution, lanes.iter());
        let columns = self.workspace.outputs(&self.program.code, 2);
        for (lane, place) in lanes.iter().filter(|(lane, _)| weights[*lane] != 0.0) {
            for (sum, column) in self.sums[place.chunk].iter_mut().zip(&columns) {
                *sum += weights[*lane] * column[*lane];
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

    /// Fills the readings of some lanes, evaluated last at their solution; the weights of those
    /// that are solved and not blind, divided by `-m'`.
    fn finish<'s>(
        &mut self,
        solution: &Solution<'_>,
        lanes: impl Iterator<Item = &'s (usize, Place)>,
    ) -> Lanes {
        let random = self.random_part(solution.slope);
        let common = self.common_part(solution.slope);
        let mut weights = [0.0; LANES];
        for (lane, place) in lanes {
            let reading = &mut self.readings[place.index];
            reading.steps = solution.steps[*lane];
            reading.state = State::Failed;
            let slope = solution.slope[*lane];
            // Beyond a turning point of the prediction it is another reading's delay.
            let is_here = slope.is_sign_positive() == solution.from[*lane].is_sign_positive();
            if solution.is_solved[*lane] && is_here {
                reading.state = State::Solved;
                reading.delay = self.origin + solution.delay[*lane];
                reading.slope = slope;
                reading.random = random[*lane];
                reading.common = common[*lane];
            }
            if reading.is_blind_beside(self.best) {
                reading.state = State::Blind;
            }
            if reading.state == State::Solved {
                weights[*lane] = -reading.random_at_reference.powi(-2) / reading.slope;
            }
        }
        weights
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
