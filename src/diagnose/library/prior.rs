//! How probable each cause is before the readings are looked at.
//!
//! Nothing, some effect of the library, unknown structure: three probabilities, and how many times as
//! probable as the others each effect is. How large effects may be is a matter of their typical sizes.

use std::collections::BTreeMap;

/// Probability of nothing, of the library, of unknown structure, unless said otherwise.
const USUAL: [f64; 3] = [0.30, 0.50, 0.20];
/// What is left for others where only some probabilities are stated.
const LEAST: f64 = 1e-9;

/// One of the three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The model fits.
    Nothing,
    /// One effect of the library.
    Library,
    /// An unmodelled cause that the library lacks.
    Unknown,
}

/// Prior probabilities of causes.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    causes: [f64; 3],
    times: BTreeMap<String, f64>,
}

impl Default for Prior {
    fn default() -> Self {
        Self { causes: USUAL, times: BTreeMap::new() }
    }
}

impl Prior {
    /// With probabilities of some causes; the others share the rest as they usually do. `None`
    /// unless all three are above zero and add up to one.
    pub fn stated(stated: &[(Cause, f64)]) -> Option<Self> {
        let mut known = [None; 3];
        stated.iter().for_each(|(cause, probability)| known[*cause as usize] = Some(*probability));
        let rest = 1.0 - known.iter().flatten().sum::<f64>();
        let usual = USUAL.iter().zip(known).filter(|(_, known)| known.is_none());
        let by = rest / usual.map(|(usual, _)| usual).sum::<f64>();
        let causes = [0, 1, 2].map(|n| known[n].unwrap_or(USUAL[n] * by));
        let is_sound = causes.iter().all(|one| *one >= LEAST)
            && (causes.iter().sum::<f64>() - 1.0).abs() < LEAST;
        is_sound.then_some(Self { causes, times: BTreeMap::new() })
    }

    /// The same with an effect so many times as probable as others; `None` unless that is a number
    /// above zero.
    pub fn with(mut self, effect: &str, times: f64) -> Option<Self> {
        let is_sound = times.is_finite() && times >= LEAST;
        self.times.insert(effect.to_owned(), times);
        is_sound.then_some(self)
    }

    /// The probability of a cause.
    pub fn of(&self, cause: Cause) -> f64 {
        self.causes[cause as usize]
    }

    /// How many times as probable as others an effect is.
    pub fn times(&self, effect: &str) -> f64 {
        self.times.get(effect).copied().unwrap_or(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{Cause, LEAST, Prior};

    #[test]
    fn what_is_not_stated_shares_the_rest() {
        let of = |stated: &[(Cause, f64)]| {
            Prior::stated(stated)
                .map(|one| [Cause::Nothing, Cause::Library, Cause::Unknown].map(|c| one.of(c)))
        };
        assert_eq!(of(&[]), Some([0.3, 0.5, 0.2]));
        let rest = of(&[(Cause::Unknown, 0.6)]).unwrap_or_default();
        assert!((rest[0] - 0.15).abs() < LEAST && (rest[1] - 0.25).abs() < LEAST);
        let all = [(Cause::Nothing, 0.5), (Cause::Library, 0.25), (Cause::Unknown, 0.25)];
        assert_eq!(of(&all), Some([0.5, 0.25, 0.25]));
        assert_eq!(of(&all[..2]), of(&all));
        for wrong in [0.0, 1.0, 1.5, -0.1, f64::NAN] {
            assert_eq!(of(&[(Cause::Library, wrong)]), None, "{wrong}");
        }
        assert_eq!(of(&[all[0], all[1], (Cause::Unknown, 0.3)]), None);
    }

    #[test]
    fn an_effect_is_more_or_less_probable_than_others() {
        let prior = Prior::default().with("collimation", 3.0).unwrap_or_default();
        assert_eq!((prior.times("collimation"), prior.times("arm_radius")), (3.0, 1.0));
        for wrong in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            assert_eq!(Prior::default().with("collimation", wrong), None);
        }
    }
}
