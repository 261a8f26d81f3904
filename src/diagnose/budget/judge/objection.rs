//! Why a row does not stand.

use crate::diagnose::budget::labels::Label;
use crate::diagnose::price::Gain;

/// Why a row does not stand.
#[derive(Clone, Debug, PartialEq)]
pub enum Objection {
    /// It does not bring enough on held-out readings.
    HeldOut(f64),
    /// It is too small for a name beside what else there is.
    Small(f64),
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
    /// Whether an effect with this objection is a candidate for the remainder, by its gain beside the final model:
    /// one that failed by its size, and explains nothing more there than chance does, is none.
    pub(in crate::diagnose::budget) fn leaves_candidate(&self, gain: Gain) -> bool {
        let is_by_size = matches!(self, Self::Small(_) | Self::HeldOut(_));
        gain.degrees > 0 && (!is_by_size || gain.excess() > 0.0)
    }

    /// Its key.
    pub fn word(&self) -> &'static str {
        match self {
            Self::HeldOut(_) => "fails_on_held_out",
            Self::Small(_) => "too_small",
            Self::MayBeZero(_) => "consistent_with_zero",
            Self::Apart(..) => "differs_between_groups",
            Self::Replaced(_) => "unmodelled_fits_as_well",
            Self::NotConverged => "fit_does_not_converge",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beside blocks that have its form an effect has no size of its own, and the objection reports that.
    #[test]
    fn an_effect_that_explains_nothing_is_no_candidate() {
        let of = |gain| Gain { gain, degrees: 1 };
        assert!(!Objection::Small(3.0).leaves_candidate(of(0.01)));
        assert!(!Objection::HeldOut(-2.0).leaves_candidate(of(0.9)));
        assert!(Objection::Small(3.0).leaves_candidate(of(30.0)));
        assert!(Objection::MayBeZero(2.0).leaves_candidate(of(0.01)));
    }
}
