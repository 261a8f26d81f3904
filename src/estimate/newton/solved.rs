//! What came of readings, column by column: one reading after another is made of it when it is asked
//! for, and none is stored.

use nalgebra::DVector;

use crate::engine::lanes::arithmetic::Arithmetic;
use crate::engine::lanes::dispatch::{Simd, Task};
use crate::engine::lanes::{Chunk, LANES, Lanes};
use crate::estimate::newton::quick::STEPS;
use crate::estimate::newton::{BLIND_RATIO, ReadingDelay, State};

/// A sample without a reading.
const ABSENT: u8 = 0;
/// A reading with its delay.
const SOLVED: u8 = 1;
/// One that is blind, as far as was known when it was solved.
const BLIND: u8 = 2;
/// One without a delay.
const FAILED: u8 = 3;

/// The readings of one measurand in a block of a run.
#[derive(Debug)]
pub struct Solved {
    pub(super) run: usize,
    pub(super) measurand: usize,
    /// The smallest uncertainty at reference of the run (s).
    pub(super) best: f64,
    /// From which delay on they were solved (s).
    pub(super) origin: f64,
    pub(super) lanes: SolvedLanes,
    /// `Σ w dt/dθ` of the solved ones over the columns the run touches, with the weights
    /// `w = random_at_reference⁻²`.
    pub weighted_sensitivity: DVector<f64>,
}

impl Solved {
    /// Every reading, in the order of samples.
    pub fn each(&self) -> impl Iterator<Item = ReadingDelay> {
        let present = |lane: &usize| self.lanes.state[*lane] != ABSENT;
        (0..self.lanes.len()).filter(present).map(|lane| self.lanes.reading(lane, self))
    }

    /// The samples of the block; `None` if there are none.
    pub(crate) fn samples(&self) -> Option<std::ops::Range<usize>> {
        let (first, len) = (self.lanes.first, self.lanes.len());
        (len > 0).then_some(first..first + len)
    }

    /// The delays (s) of those that have one, in the order of samples.
    pub fn delays(&self) -> impl Iterator<Item = f64> {
        let is_solved = |lane: &usize| {
            self.lanes.state[*lane] == SOLVED && !self.lanes.is_blind_beside(*lane, self.best)
        };
        let solved = (0..self.lanes.len()).filter(is_solved);
        solved.map(|lane| self.origin + self.lanes.delay[lane])
    }
}

/// What came of the samples of a block, column by column, chunk behind chunk; a sample without a
/// delay has numbers that mean nothing.
#[derive(Debug)]
pub(super) struct SolvedLanes {
    /// Number of the first sample in the run.
    first: usize,
    state: Vec<u8>,
    steps: Vec<u8>,
    time: Vec<f64>,
    /// Rows of the data file; empty where they are the numbers of the samples.
    rows: Vec<usize>,
    /// Delay since the origin (s).
    delay: Vec<f64>,
    slope: Vec<f64>,
    random: Vec<f64>,
    random_at_reference: Vec<f64>,
    common: Vec<f64>,
    /// For each chunk the largest random part of a solved reading, by either slope (s); NaN if one
    /// is.
    worst: Vec<f64>,
    /// For each chunk `Σ w dt/dθ` of its solved readings, along the program's directions.
    sums: Vec<f64>,
    directions: usize,
}

/// What came of one lane.
pub(super) struct Lane {
    pub(super) is_solved: bool,
    /// Whether the slope has the sign of that at the origin: beyond a turning point of the
    /// prediction it is another reading's delay.
    pub(super) is_here: bool,
    pub(super) delay: f64,
    pub(super) slope: f64,
    pub(super) random: f64,
    pub(super) common: f64,
    pub(super) steps: u32,
}

impl SolvedLanes {
    /// Room for so many samples from `first` on.
    pub(super) fn new(first: usize, len: usize, directions: usize) -> Self {
        let column = || Vec::with_capacity(len);
        let chunks = len.div_ceil(LANES);
        Self {
            first,
            state: Vec::with_capacity(len),
            steps: Vec::with_capacity(len),
            time: column(),
            rows: Vec::new(),
            delay: column(),
            slope: column(),
            random: column(),
            random_at_reference: column(),
            common: column(),
            worst: Vec::with_capacity(chunks),
            sums: Vec::with_capacity(chunks * directions),
            directions,
        }
    }

    fn len(&self) -> usize {
        self.state.len()
    }

    pub(super) fn chunks(&self) -> usize {
        self.worst.len()
    }

    /// Makes room for the next chunk.
    pub(super) fn push(&mut self, chunk: &Chunk<'_>) {
        if self.state.is_empty() {
            self.first = chunk.first;
        }
        let stretch = chunk.stretch();
        self.time.extend_from_slice(&stretch.samples.time[stretch.range()]);
        let rows = stretch.samples.rows.get(stretch.range());
        self.rows.extend_from_slice(rows.unwrap_or_default());
        let len = self.len() + chunk.len;
        self.state.resize(len, ABSENT);
        self.steps.resize(len, 0);
        let columns =
            [&mut self.delay, &mut self.slope, &mut self.random, &mut self.random_at_reference];
        columns.into_iter().chain([&mut self.common]).for_each(|column| column.resize(len, 0.0));
        self.worst.push(0.0);
        self.sums.resize(self.sums.len() + self.directions, 0.0);
    }

    /// `Σ w dt/dθ` of a chunk's solved readings.
    pub(super) fn sums_mut(&mut self, chunk: usize) -> &mut [f64] {
        &mut self.sums[chunk * self.directions..(chunk + 1) * self.directions]
    }

    /// `Σ w dt/dθ` of all solved readings along one direction.
    pub(super) fn sum(&self, direction: usize) -> f64 {
        self.sums.chunks_exact(self.directions).map(|sums| sums[direction]).sum()
    }

    /// Takes what the quick way found of a chunk.
    pub(super) fn put(&mut self, chunk: usize, found: &Found) {
        let start = chunk * LANES;
        let end = self.len().min(start + LANES);
        let len = end - start;
        self.state[start..end].copy_from_slice(&found.state[..len]);
        self.steps[start..end].copy_from_slice(&found.steps[..len]);
        self.delay[start..end].copy_from_slice(&found.delay[..len]);
        self.slope[start..end].copy_from_slice(&found.slope[..len]);
        self.random[start..end].copy_from_slice(&found.random[..len]);
        self.random_at_reference[start..end].copy_from_slice(&found.random_at_reference[..len]);
        self.common[start..end].copy_from_slice(&found.common[..len]);
        self.worst[chunk] = found.worst;
    }

    /// Whether a reading sees its delay far worse than the best of its run: by the slope at the
    /// reference time, or by that at the solution.
    fn is_blind_beside(&self, lane: usize, best: f64) -> bool {
        let is_within = |random: f64| random <= BLIND_RATIO * best;
        let is_solved = self.state[lane] == SOLVED;
        !(is_within(self.random_at_reference[lane]) && (!is_solved || is_within(self.random[lane])))
    }

    /// Whether a lane without a delay yet is a reading that may see one.
    pub(super) fn may_be_seen(&self, lane: usize, best: f64) -> bool {
        self.state[lane] != ABSENT && self.random_at_reference[lane] <= BLIND_RATIO * best
    }

    /// Whether a reading of a chunk counts as solved that is blind beside the best of its run.
    pub(super) fn is_stale(&self, chunk: usize, best: f64) -> bool {
        let is_within = self.worst[chunk] <= BLIND_RATIO * best;
        !is_within
    }

    /// Takes what came of a lane; the weight of a solved one, divided by `-m'`, else zero.
    pub(super) fn take(&mut self, lane: usize, found: &Lane, best: f64) -> f64 {
        self.steps[lane] = u8::try_from(found.steps).unwrap_or(u8::MAX);
        self.state[lane] = FAILED;
        if !found.is_solved || !found.is_here {
            return 0.0;
        }
        self.state[lane] = SOLVED;
        (self.delay[lane], self.slope[lane]) = (found.delay, found.slope);
        (self.random[lane], self.common[lane]) = (found.random, found.common);
        let at_reference = self.random_at_reference[lane];
        if self.is_blind_beside(lane, best) {
            self.state[lane] = BLIND;
            return 0.0;
        }
        let worst = &mut self.worst[lane / LANES];
        *worst = larger(larger(*worst, at_reference), found.random);
        -1.0 / (at_reference * at_reference) / found.slope
    }

    fn reading(&self, lane: usize, of: &Solved) -> ReadingDelay {
        let number = self.first + lane;
        let state = match self.state[lane] {
            BLIND => State::Blind,
            _ if self.is_blind_beside(lane, of.best) => State::Blind,
            SOLVED => State::Solved,
            _ => State::Failed,
        };
        let given = |value: f64| if state == State::Solved { value } else { f64::NAN };
        ReadingDelay {
            run: of.run,
            sample: number,
            measurand: of.measurand,
            row: self.rows.get(lane).copied().unwrap_or(number + 1),
            time: self.time[lane],
            state,
            delay: given(of.origin + self.delay[lane]),
            slope: given(self.slope[lane]),
            random: given(self.random[lane]),
            random_at_reference: self.random_at_reference[lane],
            common: given(self.common[lane]),
            steps: if state == State::Blind { 0 } else { u32::from(self.steps[lane]) },
        }
    }
}

/// The larger of two; NaN if one is.
fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

/// What the quick way found of a chunk.
pub(super) struct Found<'a> {
    pub(super) delay: &'a Lanes,
    pub(super) slope: &'a Lanes,
    pub(super) random: &'a Lanes,
    pub(super) random_at_reference: &'a Lanes,
    pub(super) common: &'a Lanes,
    pub(super) state: [u8; LANES],
    pub(super) steps: [u8; LANES],
    /// See [`SolvedLanes`].
    pub(super) worst: f64,
    /// Weights of the solved readings, divided by `-m'`; zero for others.
    pub(super) weights: Lanes,
}

/// Judges what the quick way found of a chunk: states, steps and weights.
pub(super) struct Judge<'f, 'a> {
    pub(super) reading: &'a Lanes,
    /// Slopes at the origin.
    pub(super) from: &'a Lanes,
    pub(super) is_solved: &'a [bool; LANES],
    pub(super) best: f64,
    pub(super) found: &'f mut Found<'a>,
}

impl Task for Judge<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        let most = BLIND_RATIO * self.best;
        let found = self.found;
        let mut worst = [0.0_f64; ABREAST];
        for lane in 0..LANES {
            let (slope, random) = (found.slope[lane], found.random[lane]);
            let at_reference = found.random_at_reference[lane];
            let is_here = slope.is_sign_positive() == self.from[lane].is_sign_positive();
            let is_seen = (at_reference <= most) & (random <= most);
            let is_present = !self.reading[lane].is_nan();
            let is_found = is_present & self.is_solved[lane] & is_here;
            let state = if is_seen { SOLVED } else { BLIND };
            let state = if is_found { state } else { FAILED };
            found.state[lane] = if is_present { state } else { ABSENT };
            found.steps[lane] = if self.is_solved[lane] { STEPS as u8 } else { 0 };
            let counts = is_found & is_seen;
            let weight = -1.0 / (at_reference * at_reference) / slope;
            found.weights[lane] = if counts { weight } else { 0.0 };
            // What is seen is within `most`: no NaN among it.
            let larger = if at_reference > random { at_reference } else { random };
            let larger = if counts { larger } else { 0.0 };
            let worst = &mut worst[lane % ABREAST];
            *worst = if larger > *worst { larger } else { *worst };
        }
        found.worst = worst.into_iter().fold(0.0, f64::max);
    }
}

/// Numbers that are compared side by side.
const ABREAST: usize = 16;

/// The random parts of a chunk at the reference time, infinite where there is no slope, and the
/// smallest of its readings.
pub(super) struct Smallest<'a> {
    pub(super) reading: &'a Lanes,
    pub(super) random: &'a mut Lanes,
}

impl Task for Smallest<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) -> f64 {
        let mut least = [f64::INFINITY; ABREAST];
        for lane in 0..LANES {
            let random = &mut self.random[lane];
            *random = if random.is_nan() { f64::INFINITY } else { *random };
            let seen = if self.reading[lane].is_nan() { f64::INFINITY } else { *random };
            let least = &mut least[lane % ABREAST];
            *least = if seen < *least { seen } else { *least };
        }
        least.into_iter().fold(f64::INFINITY, f64::min)
    }
}
