//! Why a row does not stand.

use crate::diagnose::budget::labels::Label;

/// Why a row does not stand.
#[derive(Clone, Debug, PartialEq)]
pub enum Objection {
    /// It does not bring enough on held-out readings.
    HeldOut(f64),
    /// It is too small for a name beside what else there is.
    Small(f64),
    /// It gains more beside the blocks than without them.
    Borrowed,
    /// Its form lies within the remainder.
    WithinRemainder(f64),
    /// Beside the whole remainder its value is consistent with zero: chi squared.
    MayBeZero(f64),
    /// Its values differ between groups of readings.
    Apart(Label, f64),
    /// Blocks in its place do as well.
    Replaced(f64),
    /// The fit with it does not converge.
    NotConverged,
}

impl Objection {
    /// Its key.
    pub fn word(&self) -> &'static str {
        match self {
            Self::HeldOut(_) => "fails_on_held_out",
            Self::Small(_) => "too_small",
            Self::Borrowed => "corrects_the_remainder",
            Self::WithinRemainder(_) => "within_the_remainder",
            Self::MayBeZero(_) => "consistent_with_zero",
            Self::Apart(..) => "differs_between_groups",
            Self::Replaced(_) => "unmodelled_fits_as_well",
            Self::NotConverged => "fit_does_not_converge",
        }
    }
}
