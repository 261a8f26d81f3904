//! What a model file declares.

use indexmap::IndexMap;

use crate::diagnostic::{Place, Source, Span};
use crate::formula::Formula;
use crate::graph::{Kind, MeasurandKind, Scope};
use crate::units::Unit;

/// A model file, read and checked for form (formulas parsed, names not yet resolved).
#[derive(Clone, Debug)]
pub struct Model {
    /// Its name.
    pub name: String,
    /// What it is, in words.
    pub title: String,
    /// Where its equations come from.
    pub reference: Option<String>,
    /// The file.
    pub source: Source,
    /// `[inputs]`.
    pub inputs: Vec<InputDeclaration>,
    /// `[parameters]`; delays are not in here.
    pub parameters: Vec<ParameterDeclaration>,
    /// `[quantities]` in the order written.
    pub quantities: IndexMap<String, Formula>,
    /// `[measurands]` in the order written.
    pub measurands: Vec<MeasurandDeclaration>,
    /// `[delays]`: shared delays.
    pub delays: Vec<DelayGroup>,
    /// Lines of `[parameters]` on delays (`"vertical.delay"`), which exist without a declaration.
    pub overrides: Vec<Override>,
    /// `[roles]`: what stands for a name of the library.
    pub roles: Roles,
    /// `[heads]`: the same for each of several heads.
    pub heads: IndexMap<String, Roles>,
    /// `[coordinates]`.
    pub coordinates: Option<Coordinates>,
}

/// What stands for a name of the library in a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Role {
    /// The name whose value it is.
    pub value: String,
    /// The name of the model that has its delay and its sigma.
    pub owner: String,
}

/// What stands for names of the library, by these.
pub type Roles = IndexMap<String, Role>;

/// One line of `[inputs]`.
#[derive(Clone, Debug)]
pub struct InputDeclaration {
    /// Name.
    pub name: String,
    /// Where the name stands.
    pub span: Span,
    /// Unit.
    pub unit: Unit,
    /// Whether it moves.
    pub signal: bool,
    /// Period by which a recorded value may jump (SI), to be unwrapped.
    pub period: Option<f64>,
    /// Standard uncertainty of one value (SI), shared by the readings of one sample.
    pub sigma: Option<f64>,
    /// Time constant of the smoothing of a logged stream (s).
    pub smooth: Option<f64>,
    /// In words.
    pub about: String,
}

/// How a random parameter is correlated from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Process {
    /// Independent draws.
    White,
    /// Random walk (its unit has a root of time in it).
    Walk,
    /// First-order autoregressive, with a memory time.
    Memory,
}

/// The distribution of a random parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Gaussian.
    Normal,
    /// Rectangular.
    Uniform,
}

/// One line of `[parameters]`, of a model or an effect.
#[derive(Clone, Debug)]
pub struct ParameterDeclaration {
    /// Name, local to the file.
    pub name: String,
    /// Where the name stands.
    pub span: Span,
    /// Scalar, vector, rotation.
    pub kind: Kind,
    /// Unit.
    pub unit: Unit,
    /// One for each measurand.
    pub per_measurand: bool,
    /// Correlation of a random parameter.
    pub process: Process,
    /// Distribution of a random parameter.
    pub shape: Shape,
    /// Memory time (s) of a random parameter with `process = "memory"`, unless a family says it.
    pub memory: Option<f64>,
    /// What else is said of it, to be overridden by a campaign.
    pub setting: Setting,
    /// In words.
    pub about: String,
}

/// What is known of a parameter before the data: SI, one number a component (a rotation's are the
/// three of its rotation vector).
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// One value for each of these.
    pub scope: Scope,
    /// Not estimated.
    pub fixed: bool,
    /// Contrasts: the values sum to zero over the scope.
    pub sum_zero: bool,
    /// Known value (a prior if `sigma` is given, else only a start or, when fixed, the value).
    pub value: Option<Vec<f64>>,
    /// Standard uncertainty of `value`.
    pub sigma: Option<Vec<f64>>,
    /// Lower bound.
    pub lower: Option<Vec<f64>>,
    /// Upper bound.
    pub upper: Option<Vec<f64>>,
    /// Where iteration starts.
    pub start: Option<Vec<f64>>,
    /// A standard uncertainty beyond this means unobservable.
    pub plausible: Option<f64>,
    /// How far from the value that was simulated the form of its effect, or of its model, holds.
    pub linear_range: Option<f64>,
    /// The value of a simulator's parameter at which streams were computed: that of an effect counts
    /// from it.
    pub simulated_at: Option<f64>,
    /// Magnitude such rigs show (effects).
    pub typical: Option<f64>,
    /// Degrees of freedom on which `sigma` rests; `None`: as if infinitely many.
    pub degrees_of_freedom: Option<f64>,
    /// What is said of single components of a vector, over all of this.
    pub components: Option<Box<[Component; 3]>>,
}

/// What is said of one component alone (SI).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Component {
    /// Known value.
    pub value: Option<f64>,
    /// Standard uncertainty of it.
    pub sigma: Option<f64>,
    /// Lower bound.
    pub lower: Option<f64>,
    /// Upper bound.
    pub upper: Option<f64>,
    /// Where iteration starts.
    pub start: Option<f64>,
    /// Whether it is not estimated; `None`: as the vector.
    pub fixed: Option<bool>,
}

impl Setting {
    /// Nothing known, one value over `scope`.
    pub fn new(scope: Scope) -> Self {
        Self {
            scope,
            fixed: false,
            sum_zero: false,
            value: None,
            sigma: None,
            lower: None,
            upper: None,
            start: None,
            plausible: None,
            linear_range: None,
            simulated_at: None,
            typical: None,
            degrees_of_freedom: None,
            components: None,
        }
    }

    /// What holds for a delay unless something else is said: one an instrument, known to 10 ms.
    pub fn of_delay() -> Self {
        Self { plausible: Some(0.01), ..Self::new(Scope::Instrument) }
    }
}

/// One line of `[measurands]`.
#[derive(Clone, Debug)]
pub struct MeasurandDeclaration {
    /// Name.
    pub name: String,
    /// Where the name stands.
    pub span: Span,
    /// `value`.
    pub formula: Formula,
    /// Plain, angle, rotation.
    pub kind: MeasurandKind,
    /// Unit.
    pub unit: Unit,
    /// Standard uncertainty of one reading (SI), if stated; k = 1.
    pub sigma: Option<f64>,
    /// The same as a formula, in its place.
    pub sigma_formula: Option<Formula>,
    /// In words.
    pub about: String,
}

/// One line of `[delays]`: one delay shared by several measurands.
#[derive(Clone, Debug)]
pub struct DelayGroup {
    /// The parameter is called `NAME.delay`.
    pub name: String,
    /// Where the name stands.
    pub span: Span,
    /// The measurands that share it.
    pub of: Vec<String>,
    /// What else is said of it.
    pub setting: Setting,
}

/// `[coordinates]`.
#[derive(Clone, Debug)]
pub struct Coordinates {
    /// The target in the rig's frame.
    pub from: Formula,
    /// Name of the rotation parameter.
    pub rotation: String,
    /// Name of the translation parameter.
    pub translation: String,
    /// The target in the instrument's frame from the readings.
    pub measured: Formula,
    /// A length that readings without errors make zero, if they are more than the point needs.
    pub gap: Option<Formula>,
    /// Helper lines before it, in order.
    pub helpers: IndexMap<String, Formula>,
}

/// What a campaign or the command line says of one parameter, over what its declaration says.
///
/// Units are kept so that the dimension can be checked once the parameter is known.
#[derive(Clone, Debug, Default)]
pub struct Override {
    /// Full name of the parameter or random: `radius`, `horizontal.delay`, `collimation.offset`.
    pub name: String,
    /// Where it stands, if it stands in a file.
    pub place: Option<Place>,
    /// The setup in which it holds; `None`: everywhere.
    pub setup: Option<String>,
    /// Known value (SI), one a component.
    pub value: Option<Vec<(f64, Unit)>>,
    /// Standard uncertainty of it.
    pub sigma: Option<Vec<(f64, Unit)>>,
    /// Lower bound.
    pub lower: Option<Vec<(f64, Unit)>>,
    /// Upper bound.
    pub upper: Option<Vec<(f64, Unit)>>,
    /// Where iteration starts.
    pub start: Option<Vec<(f64, Unit)>>,
    /// A standard uncertainty beyond this means unobservable.
    pub plausible: Option<(f64, Unit)>,
    /// Largest value for which the form of its effect holds.
    pub linear_range: Option<(f64, Unit)>,
    /// The value of a simulator's parameter from which this one counts.
    pub simulated_at: Option<(f64, Unit)>,
    /// Not estimated.
    pub fixed: Option<bool>,
    /// Whether what was stated before is dropped: value, uncertainty, and that it is fixed.
    pub free: bool,
    /// Another scope.
    pub scope: Option<Scope>,
    /// Contrasts: the values sum to zero over the scope.
    pub sum_zero: Option<bool>,
    /// Degrees of freedom on which `sigma` rests.
    pub degrees_of_freedom: Option<f64>,
}
