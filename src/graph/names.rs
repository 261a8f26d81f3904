//! What a model and its effects declare, once names are settled: the input of [`super::resolve`].
//!
//! Built by the nouns (model, effect, campaign); plain data, no behaviour beyond look-up.

use std::collections::HashMap;

use indexmap::IndexMap;

use crate::formula::Formula;
use crate::units::{Dimension, Unit};

/// Where one value of a parameter holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scope {
    /// One for the reference rig.
    Rig,
    /// One for the instrument under test.
    Instrument,
    /// One a setup.
    Setup,
    /// One a run.
    Run,
    /// Random, one draw a sample.
    Sample,
}

/// The kind of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A number.
    Scalar,
    /// Three numbers.
    Vector,
    /// A rotation.
    Rotation,
}

impl Kind {
    /// Dimension of its tangent space: 1 for a number, 3 for a vector or a rotation.
    pub fn dimension(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vector | Self::Rotation => 3,
        }
    }
}

/// Something recorded beside the readings.
#[derive(Clone, Debug)]
pub struct Input {
    /// Its name.
    pub name: String,
    /// Unit it is declared in.
    pub unit: Unit,
    /// Whether it moves.
    pub signal: bool,
    /// Index of the random that stands for its error, if it has a `sigma`.
    pub error: Option<usize>,
}

/// A parameter of the model or of an effect.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Full name: `radius`, `horizontal.delay`, `collimation.offset`.
    pub name: String,
    /// Scalar, vector or rotation.
    pub kind: Kind,
    /// Unit it is declared in.
    pub unit: Unit,
}

/// A random quantity: an input's error or a sample-scope parameter of an effect.
#[derive(Clone, Debug)]
pub struct Random {
    /// `arm_angle.error`, `timestamp_jitter.jitter`.
    pub name: String,
    /// Its dimension.
    pub dimension: Dimension,
}

/// What kind of measurand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeasurandKind {
    /// A plain number.
    Plain,
    /// An angle that wraps by `period` (rad).
    Angle {
        /// Period in rad; 0 if it does not wrap.
        period: f64,
    },
    /// A rotation.
    Rotation,
}

/// A quantity that the instrument reads.
#[derive(Clone, Debug)]
pub struct Measurand {
    /// Its name.
    pub name: String,
    /// Its value in the model.
    pub formula: Formula,
    /// Plain, angle or rotation.
    pub kind: MeasurandKind,
    /// Unit it is declared in.
    pub unit: Unit,
    /// Standard uncertainty of a reading, where it is a formula.
    pub sigma: Option<Formula>,
    /// Index of the parameter that is its delay (shared delays: the same index).
    pub delay: usize,
}

/// What a patch acts on.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum PatchTarget {
    /// `t`: the delay of all measurands.
    AllTimes,
    /// `NAME.t`: the delay of one measurand (by index).
    Time(usize),
    /// `NAME.sigma`: the noise level of one measurand (by index).
    Sigma(usize),
    /// An input, a quantity, a parameter or a measurand, by its name in the model.
    Name(String),
}

/// One patch: on the right, the target's own name or `self` is the unpatched quantity.
#[derive(Clone, Debug)]
pub struct Patch {
    /// What it acts on.
    pub target: PatchTarget,
    /// What it becomes.
    pub formula: Formula,
}

/// What a local name of an effect stands for.
#[derive(Clone, Debug, PartialEq)]
pub enum Local {
    /// A parameter, by index.
    Parameter(usize),
    /// One parameter for each measurand, by index (`per = "measurand"`).
    PerMeasurand(Vec<usize>),
    /// A random, by index.
    Random(usize),
    /// One random for each measurand, by index.
    RandomPerMeasurand(Vec<usize>),
    /// A number (a member of a family, a fixed constant).
    Constant(f64, Dimension),
    /// Another name of the model (a head's `horizontal` for `horizontal_a`).
    Name(String),
}

/// All patches of one effect, with its own names.
#[derive(Clone, Debug)]
pub struct PatchLayer {
    /// The effect's name.
    pub effect: String,
    /// Its parameters, shape values and head aliases.
    pub locals: HashMap<String, Local>,
    /// What it changes.
    pub patches: Vec<Patch>,
}

/// `[coordinates]`: the target from one sample's readings.
#[derive(Clone, Debug)]
pub struct CoordinatesNames {
    /// The target in the rig's frame.
    pub from: Formula,
    /// The target in the instrument's frame from the readings: measurand names are the readings.
    pub measured: Formula,
    /// A length that readings without errors make zero, if the model says one.
    pub gap: Option<Formula>,
    /// Helper lines before `measured`, in order; each may name those before it.
    pub helpers: IndexMap<String, Formula>,
    /// Index of the rotation parameter from `from`'s frame to `measured`'s.
    pub rotation: usize,
    /// Index of the translation parameter.
    pub translation: usize,
}

/// The symbol table of one model with its effects, in order of application.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// Recorded inputs.
    pub inputs: Vec<Input>,
    /// Parameters: the model's, the delays, the effects'.
    pub parameters: Vec<Parameter>,
    /// Random quantities.
    pub randoms: Vec<Random>,
    /// Named quantities in order of declaration.
    pub quantities: IndexMap<String, Formula>,
    /// What the instrument reads.
    pub measurands: Vec<Measurand>,
    /// Effects in order of application.
    pub layers: Vec<PatchLayer>,
    /// `[coordinates]`, if the model has them.
    pub coordinates: Option<CoordinatesNames>,
}
