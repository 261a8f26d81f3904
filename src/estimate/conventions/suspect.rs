//! What may have been mistaken: the meaning of logged numbers, or the turns of a formula.

use crate::engine::Problem;
use crate::estimate::conventions::Instead;
use crate::estimate::conventions::applied::Suspected;
use crate::estimate::conventions::turns::Reordered;
use crate::estimate::conventions::units::scale;
use crate::estimate::minima::thinned::Tried;
use crate::formula::Expression;

/// Something that may have been mistaken.
#[derive(Clone, Debug)]
pub(super) enum Suspect<'c> {
    /// A convention of the library, for some of the logged numbers.
    Columns(Suspected<'c>),
    /// A product of turns in the model's formulas.
    Turns(Reordered),
}

impl Suspect<'_> {
    /// Whether it is about some of the logged numbers that another one is about.
    pub(super) fn shares_numbers(&self, other: &Self) -> bool {
        let (Self::Columns(own), Self::Columns(other)) = (self, other) else { return false };
        own.channels.iter().any(|one| other.channels.contains(one))
    }

    /// Whether both multiply the same logged number.
    pub(super) fn scales_as(&self, other: &Self) -> bool {
        let scales = |one: &Self| match one {
            Self::Columns(one) => scale(one.convention).is_some_and(|scale| scale.abs() != 1.0),
            Self::Turns(_) => false,
        };
        self.shares_numbers(other) && scales(self) && scales(other)
    }

    /// Whether it multiplies numbers of which a file states the unit.
    pub(super) fn doubts_a_head(&self) -> bool {
        let Self::Columns(one) = self else { return false };
        scale(one.convention).is_some_and(|scale| scale.abs() != 1.0)
            && one.channels.iter().any(|channel| channel.is_headed)
    }

    /// The problem with it set right; `None` where that cannot be done.
    pub(super) fn applied(&self, problem: &Problem) -> Option<Problem> {
        match self {
            Self::Columns(one) => one.applied(problem),
            Self::Turns(one) => one.applied(problem),
        }
    }

    /// As of [`Suspected::stretched`].
    pub(super) fn stretched(&self, changed: &Problem, fit: &Tried) -> f64 {
        match self {
            Self::Columns(one) => one.stretched(changed, fit),
            Self::Turns(_) => 0.0,
        }
    }

    /// Which is taken of several that fit alike: the shortest. Of those of one length a change of the
    /// readings is taken before one of the inputs: the rig is the reference, and negating its
    /// stream would mirror the frame in which lever arms are sought.
    pub(super) fn order(&self) -> (usize, bool) {
        match self {
            Self::Columns(one) => (one.length(), !one.is_of_readings()),
            Self::Turns(one) => (one.length(), false),
        }
    }

    /// What each changed number is, over what was changed before.
    pub(super) fn formulas(&self, before: Vec<(String, Expression)>) -> Vec<(String, Expression)> {
        match self {
            Self::Columns(one) => one.formulas(&before),
            Self::Turns(_) => before,
        }
    }

    /// It in words.
    pub(super) fn named(&self) -> Instead {
        let opposite = Vec::new();
        match self {
            Self::Columns(one) => Instead {
                name: one.convention.name.clone(),
                title: one.convention.title.clone(),
                numbers: one.channels.iter().map(|one| one.name.clone()).collect(),
                opposite,
            },
            Self::Turns(one) => Instead {
                name: one.name.to_owned(),
                title: one.title(),
                numbers: one.places.clone(),
                opposite,
            },
        }
    }
}
