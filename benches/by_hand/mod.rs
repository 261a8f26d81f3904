//! The polar instrument that follows a rotating arm, written by hand: what the engine is measured
//! against.
//!
//! C. Depenthal 2009, eqs. (8)-(11), as in `models/polar_one_rotation.toml`, with the effects
//! `collimation`, `vertical_index` and `distance_offset`: scalar code as a good engineer writes it
//! for this one model. The rotation matrix is made once for a run, derivatives are analytic,
//! nothing is computed twice, columns that are zero do not exist.
//!
//! Every measurand is read at its own moment: arm angle `a = angle + rate · delay`. With the
//! columns R0, R1, R2 of the rotation matrix and `u = R0 cos a + R1 sin a`, `v = R1 cos a - R0 sin
//! a`:
//!
//! ```text
//! point       P = r u + p
//! derivatives ∂P/∂r = u,  ∂P/∂p = 1,  ∂P/∂delay = rate r v      (orientation turned by q turn(δ))
//!             ∂P/∂δ = r [sin a R2, -cos a R2, v]
//! horizontal  atan2(y, x) + c / sin(W),  W = vertical + i       (collimation sees the index error)
//! vertical    atan2(hypot(x, y), z) + i
//! distance    |P| + d
//! ```
//!
//! | file | answers |
//! |---|---|
//! | `jacobian` | residual and non-zero derivatives of the three readings of one sample |
//! | `normal` | their whitened products, summed over samples |
//! | `delay` | the delay of each reading with its standard uncertainty, analytic |
//! | `generic` | the same over any number type: derivatives by dual numbers |
//! | `data` | campaigns of any size in memory, for both sides |
//! | `engine` | the engine with every instruction set and sweep |
//! | `process` | the threads of a bench, and what it says |
//!
//! `timing.rs` beside them times both sides in turn; benches that do declare it themselves.
//!
//! It does not treat missing readings, correlated readings or singular points.

pub(crate) mod data;
pub(crate) mod delay;
pub(crate) mod engine;
pub(crate) mod generic;
pub(crate) mod jacobian;
pub(crate) mod normal;
pub(crate) mod process;

use homepoint::campaign::{Run, Track};
use homepoint::engine::{Point, Problem};
use homepoint::quaternion::Quaternion;

/// Number of unknowns of one sample.
pub(crate) const COLUMNS: usize = 13;

/// The unknowns in the order of the engine's columns; the residual comes after the last.
pub(crate) mod column {
    pub(crate) const RADIUS: usize = 0;
    pub(crate) const DELAY: [usize; 3] = [1, 2, 3];
    pub(crate) const COLLIMATION: usize = 4;
    pub(crate) const INDEX_ERROR: usize = 5;
    pub(crate) const DISTANCE_OFFSET: usize = 6;
    pub(crate) const ORIENTATION: [usize; 3] = [7, 8, 9];
    pub(crate) const POSITION: [usize; 3] = [10, 11, 12];
    pub(crate) const RESIDUAL: usize = 13;
}

/// Values of the unknowns; SI.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parameters {
    pub(crate) radius: f64,
    pub(crate) orientation: Quaternion<f64>,
    pub(crate) position: [f64; 3],
    /// Of horizontal, vertical, distance.
    pub(crate) delays: [f64; 3],
    pub(crate) collimation: f64,
    pub(crate) index_error: f64,
    pub(crate) distance_offset: f64,
}

impl Parameters {
    /// The values that an engine's point has in a run of its first campaign, found by their names.
    pub(crate) fn of(problem: &Problem, run: usize, point: &Point) -> Self {
        let named = |name: &str| {
            let names = &problem.parts[0].system.assembly.names.parameters;
            let found = names.iter().position(|parameter| parameter.name == name);
            found.map_or([0.0; 4], |at| point.values[problem.layout.instance_in(0, run, at)])
        };
        let [x, y, z, _] = named("position");
        Self {
            radius: named("radius")[0],
            orientation: Quaternion::from_components(named("orientation")),
            position: [x, y, z],
            delays: ["horizontal.delay", "vertical.delay", "distance.delay"]
                .map(|name| named(name)[0]),
            collimation: named("collimation.offset")[0],
            index_error: named("vertical_index.index_error")[0],
            distance_offset: named("distance_offset.offset")[0],
        }
    }
}

/// One run as plain columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Columns<'a> {
    /// Arm angle at the reference time (rad).
    pub(crate) angle: &'a [f64],
    /// Its rate (rad/s).
    pub(crate) rate: &'a [f64],
    /// Readings: horizontal (rad), vertical (rad), distance (m).
    pub(crate) readings: [&'a [f64]; 3],
}

impl<'a> Columns<'a> {
    /// The columns of a run; `None` where the arm's angle is not captured with its rate.
    pub(crate) fn of(run: &'a Run) -> Option<Self> {
        let samples = run.held();
        let Track::Captured { value, rate: Some(rate), .. } = samples.inputs.first()? else {
            return None;
        };
        let [horizontal, vertical, distance] = samples.readings.as_slice() else {
            return None;
        };
        Some(Self { angle: value, rate, readings: [horizontal, vertical, distance] })
    }

    /// The columns of every run of the first campaign that has them all.
    pub(crate) fn of_all(problem: &'a Problem) -> Vec<Self> {
        problem.parts[0].runs.iter().filter_map(Self::of).collect()
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.angle.len()
    }
}
