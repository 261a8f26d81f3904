//! Do the lines of sight of one sample meet? (Depenthal 2009, section 3.3)
//!
//! Where a sample has more readings than its point needs, as two stations with two angles each, a
//! model's `[coordinates]` may state the `gap`, a length that readings without errors make zero:
//! for two skew lines that of their common perpendicular. It needs neither arm nor transformation,
//! so it checks the base and the readings by themselves.
//!
//! Angles that are read at unlike moments see the target at unlike places: with delays that differ
//! by Δτ and a target at speed v the gap is up to v Δτ. So it is given twice, as read and with the
//! delays taken out, `reading - (m(τ) - m(0))`, beside what the readings' own uncertainties let
//! expect.

use crate::campaign::{Sample, Samples};
use crate::engine::part::{Part, SampleLeaves, wrapped};
use crate::engine::pointwise::Program;
use crate::engine::problem::Problem;
use crate::engine::{Point, part::Slot};
use crate::estimate::deviations::{Spread, spread};
use crate::graph::MeasurandKind;

/// The gaps of one run (m).
#[derive(Clone, Debug)]
pub struct Intersection {
    /// Of each sample, as read; NaN where a reading is missing.
    pub as_read: Vec<f64>,
    /// The same with the delays taken out.
    pub without_delays: Vec<f64>,
    /// What they do over the run.
    pub spreads: [Spread; 2],
    /// Standard deviation that the readings' stated uncertainties let expect (m).
    pub expected: f64,
}

/// The gaps of a run at a point; `None` for a model that states none, or without whole samples.
pub fn intersection(
    problem: &Problem,
    part: usize,
    run: usize,
    point: &Point,
) -> Option<Intersection> {
    let data = &problem.parts[part];
    let gap = Gap::new(problem, part, run, point)?;
    let samples = data.runs[run].record.whole();
    let mut moved = samples.clone();
    gap.take_delays_out(samples, &mut moved);
    let as_read = gap.of_all(samples);
    let without_delays = gap.of_all(&moved);
    let mut variance = vec![0.0; samples.len()];
    for (slot, sigma) in data.slots().iter().zip(&data.sigma) {
        let mut shifted = samples.clone();
        shifted.readings[slot.column].iter_mut().for_each(|reading| *reading += sigma);
        for ((variance, there), here) in variance.iter_mut().zip(gap.of_all(&shifted)).zip(&as_read)
        {
            *variance += (there - here).powi(2);
        }
    }
    let known = |values: &[f64]| -> Vec<f64> {
        values.iter().copied().filter(|value| value.is_finite()).collect()
    };
    let variances = known(&variance);
    if variances.is_empty() {
        return None;
    }
    let of = |values: &[f64]| spread(known(values).iter().copied());
    Some(Intersection {
        spreads: [of(&as_read), of(&without_delays)],
        as_read,
        without_delays,
        expected: (variances.iter().sum::<f64>() / variances.len() as f64).sqrt(),
    })
}

/// A run's gap as a function of its readings.
struct Gap<'a> {
    data: &'a Part,
    program: Program,
    /// With the delays as found, and without any.
    parameters: [Vec<[f64; 4]>; 2],
    randoms: Vec<f64>,
}

impl<'a> Gap<'a> {
    fn new(problem: &'a Problem, part: usize, run: usize, point: &Point) -> Option<Self> {
        let data = &problem.parts[part];
        let assembly = &data.system.assembly;
        let node = assembly.coordinates.as_ref()?.gap?;
        let found = problem.parameters::<f64>(part, run, point);
        let mut none = found.clone();
        for measurand in &assembly.names.measurands {
            none[measurand.delay] = [0.0; 4];
        }
        Some(Self {
            data,
            program: Program::new(&assembly.graph, &[node]),
            parameters: [found, none],
            randoms: vec![0.0; data.random_sigma.len()],
        })
    }

    fn leaves<'s>(&'s self, sample: Sample<'s>, delayed: bool) -> SampleLeaves<'s, f64> {
        let parameters = &self.parameters[usize::from(!delayed)];
        SampleLeaves { parameters, randoms: &self.randoms, columns: self.data.columns(), sample }
    }

    fn of_all(&self, samples: &Samples) -> Vec<f64> {
        let mut workspace = Vec::new();
        let mut of = |at| {
            let sample = Sample { samples, at, number: at };
            self.program.evaluate(&self.leaves(sample, true), &mut workspace)[0]
        };
        (0..samples.len()).map(&mut of).collect()
    }

    /// Moves readings to the reference time: `reading - (m(τ) - m(0))`.
    fn take_delays_out(&self, samples: &Samples, moved: &mut Samples) {
        let mut workspace = Vec::new();
        for at in 0..samples.len() {
            let sample = Sample { samples, at, number: at };
            let mut predicted = |delayed| -> Vec<f64> {
                self.data.evaluate(&self.leaves(sample, delayed), &mut workspace).to_vec()
            };
            let (late, now) = (predicted(true), predicted(false));
            for Slot { kind, output, column, .. } in self.data.slots() {
                let change = late[*output] - now[*output];
                moved.readings[*column][at] -= match kind {
                    MeasurandKind::Angle { period } => wrapped(change, *period),
                    MeasurandKind::Plain => change,
                    MeasurandKind::Rotation => 0.0,
                };
            }
        }
    }
}
