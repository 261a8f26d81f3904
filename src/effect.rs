//! An effect as its author declares it: one TOML file that patches named quantities,
//! `docs/formats.md` section 3.
//!
//! Answers: what the file says. What it means in a given model is settled by [`crate::system`].

pub mod read;

use indexmap::IndexMap;

use crate::diagnostic::{Source, Span};
use crate::formula::Formula;
use crate::model::ParameterDeclaration;
use crate::units::Unit;

/// The clock of formulas that steps where stamps jump.
const JUMP_TIME: &str = "jump_time";

/// What part of the system an effect acts on; effects apply in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Acts {
    /// When readings are taken.
    Timing,
    /// The rig's encoder.
    Encoder,
    /// The rotating arm.
    Arm,
    /// The target on it.
    Target,
    /// The platform under the instrument.
    Platform,
    /// Rig frame to instrument frame.
    Transformation,
    /// The instrument's tracking.
    Servo,
    /// The instrument's axes and circles.
    Instrument,
    /// Its distance meter.
    Distance,
    /// The air.
    Atmosphere,
    /// The noise.
    Noise,
}

/// An effect file, read and checked for form.
#[derive(Clone, Debug)]
pub struct Effect {
    /// Its canonical name.
    pub name: String,
    /// What it is, in words.
    pub title: String,
    /// Where it is from, if said.
    pub reference: Option<String>,
    /// The file.
    pub source: Source,
    /// What it acts on.
    pub acts: Acts,
    /// A built-in detector: no patch, diagnose looks for it in its own way.
    pub builtin: bool,
    /// Tested only where some run begins after another one has ended.
    pub runs_in_sequence: bool,
    /// `[parameters]`.
    pub parameters: Vec<ParameterDeclaration>,
    /// `[patch]`: left side as written, with its place and meaning, and the right side.
    pub patches: Vec<PatchLine>,
    /// `[shape]`: families.
    pub shape: IndexMap<String, Family>,
    /// What is known of it, in words (what it is absorbed by, what separates it).
    pub about: String,
}

impl Effect {
    /// Whether it acts where stamps jump.
    pub fn acts_at_jumps(&self) -> bool {
        let mut names = self.patches.iter().flat_map(|patch| patch.formula.root.names());
        names.any(|(name, _)| name == JUMP_TIME)
    }
}

/// One line of `[shape]`.
#[derive(Clone, Debug)]
pub struct Family {
    /// Unit of its members.
    pub unit: Unit,
    /// The members, or the range from which one is taken.
    pub members: Members,
    /// The meaning of each of a list, in its order, in words; empty where numbers say it.
    pub means: Vec<String>,
}

impl Family {
    /// The meaning of a member in words, where there are such.
    pub fn meaning(&self, member: f64) -> Option<&str> {
        let Members::List(list) = &self.members else { return None };
        let place = list.iter().position(|own| *own == member)?;
        self.means.get(place).map(String::as_str)
    }
}

/// The members of a family, in SI.
#[derive(Clone, Debug)]
pub enum Members {
    /// These.
    List(Vec<f64>),
    /// Any in `from..=to`.
    Range {
        /// Lowest.
        from: f64,
        /// Highest.
        to: f64,
    },
}

impl Members {
    /// The member that stands for the family where none is chosen: the first, or the middle of the
    /// range (geometric where both ends are positive).
    pub fn default_member(&self) -> f64 {
        match self {
            Self::List(list) => list.first().copied().unwrap_or(0.0),
            Self::Range { from, to } if *from > 0.0 => (from * to).sqrt(),
            Self::Range { from, to } => 0.5 * (from + to),
        }
    }

    /// All of a list; of a range so many (at least two) from end to end, in a geometric series where
    /// both ends are positive, else in an even one.
    pub fn series(&self, count: usize) -> Vec<f64> {
        match self {
            Self::List(list) => list.clone(),
            Self::Range { from, to } => (0..count)
                .map(|k| k as f64 / (count - 1) as f64)
                .map(|share| {
                    if *from > 0.0 {
                        from * (to / from).powf(share)
                    } else {
                        from + (to - from) * share
                    }
                })
                .collect(),
        }
    }
}

/// One line of `[patch]`.
#[derive(Clone, Debug)]
pub struct PatchLine {
    /// Left side as written.
    pub name: String,
    /// Where it stands.
    pub span: Span,
    /// What it names.
    pub target: Target,
    /// Right side.
    pub formula: Formula,
}

/// The left side of a patch, names not yet settled in a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// `t`: the delay of every measurand.
    AllTimes,
    /// `NAME.t`: the delay of one measurand.
    Time(String),
    /// `NAME.sigma`: the noise level of one measurand.
    Sigma(String),
    /// `each.angle`: every measurand that is an angle.
    EachAngle,
    /// `each.angle.sigma`: the noise level of every measurand that is an angle.
    EachAngleSigma,
    /// A name of the model.
    Name(String),
}
