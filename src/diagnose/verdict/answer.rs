//! The answer in a word, why what is there has no name, and the effects that belong to both.

use crate::diagnose::search::Adopted;

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Nothing: the model fits.
    Adequate,
    /// Effects of the library explain everything that can be seen.
    Explained,
    /// Effects explain nearly everything, but their form does not fit.
    ShapeDiffers,
    /// Something is there, and nothing in the library explains it.
    Unknown,
    /// The nominal parameters are not determined.
    Unobservable,
}

impl Verdict {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::Explained => "explained",
            Self::ShapeDiffers => "shape_differs",
            Self::Unknown => "unknown",
            Self::Unobservable => "unobservable",
        }
    }
}

/// Why what is there has no name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Why {
    /// No effect passes its test, or what does leaves something.
    NoneFits,
    /// The model with an effect that passes its test cannot be fitted.
    NotFitted,
    /// Effects leave nothing, but hardly are the cause.
    Improbable,
    /// Effects leave nothing, but something simpler or likelier that nobody wrote down leaves no
    /// more.
    Imitated,
    /// Effects explain it where they are fitted, but not on readings that they are not fitted to.
    NotBorneOut,
    /// A reading is off in a few runs.
    RunsApart,
    /// The rig was displaced between runs, or a reading counts anew from some run on.
    Displaced,
    /// Something changed in the course of a run.
    Changed,
    /// No place of it is beyond chance by itself, but that nothing is there, or an effect of the
    /// library, is far less likely.
    Likelier,
}

impl Why {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::NoneFits => "none_fits",
            Self::NotFitted => "not_fitted",
            Self::Improbable => "improbable",
            Self::Imitated => "imitated",
            Self::NotBorneOut => "not_borne_out",
            Self::RunsApart => "runs_apart",
            Self::Displaced => "displaced",
            Self::Changed => "changed",
            Self::Likelier => "likelier",
        }
    }
}

/// A verdict with what belongs to it.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The verdict.
    pub verdict: Verdict,
    /// The effects that it names.
    pub effects: Vec<Adopted>,
    /// Where it is *unknown*, why, and which effects would have been named but for that.
    pub why: Option<(Why, Vec<String>)>,
}

impl Answer {
    pub(super) fn known(verdict: Verdict, effects: Vec<Adopted>) -> Self {
        Self { verdict, effects, why: None }
    }

    pub(super) fn unknown(why: Why, effects: Vec<String>) -> Self {
        Self { verdict: Verdict::Unknown, effects: Vec::new(), why: Some((why, effects)) }
    }
}
