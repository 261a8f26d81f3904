//! The score of mixtures: effects that are named, names that are right, and whether causes outside
//! the library are seen.

use crate::trials::bound::Count;
use crate::trials::outcome::Outcome;
use crate::trials::outcome::mixed::Mixed;

/// Effects from this length on must be named.
pub const LARGE: f64 = 25.0;
/// Causes outside the library from this length on must be seen.
pub const SEEN: f64 = 30.0;

/// The score of mixtures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mixtures {
    /// Effects of the library that are named, of all.
    pub effects: Count,
    /// The same of those of length [`LARGE`] and more.
    pub large: Count,
    /// Names that are right, of all names.
    pub names: Count,
    /// A remainder is reported, of mixtures with a cause outside the library of length [`SEEN`] and
    /// more.
    pub remainder: Count,
    /// A remainder is reported, of mixtures without a cause outside the library.
    pub false_remainder: Count,
}

/// Scores the mixtures among some trials; `None` without any.
pub fn score(outcomes: &[Outcome]) -> Option<Mixtures> {
    let mut mixtures = outcomes.iter().filter_map(|one| one.mixture.as_ref()).peekable();
    mixtures.peek()?;
    let mut score = Mixtures::default();
    mixtures.for_each(|one| score.add(one));
    Some(score)
}

impl Mixtures {
    fn add(&mut self, one: &Mixed) {
        for (is_named, lambda) in one.identified.iter().zip(&one.lambda) {
            self.effects.add(*is_named);
            if *lambda >= LARGE {
                self.large.add(*is_named);
            }
        }
        one.right.iter().for_each(|is_right| self.names.add(*is_right));
        if one.outside == 0 {
            self.false_remainder.add(one.remainder);
        } else if one.lambda.last().is_some_and(|lambda| *lambda >= SEEN) {
            self.remainder.add(one.remainder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_names_and_remainders_are_counted() {
        let outside = Mixed {
            lambda: vec![20.0, 100.0, 40.0],
            outside: 1,
            noise: 1.0,
            identified: vec![false, true],
            right: vec![true, false],
            remainder: true,
        };
        let mut inside = Mixed { outside: 0, remainder: false, ..outside.clone() };
        inside.identified.push(true);
        let mut score = Mixtures::default();
        [outside, inside].iter().for_each(|one| score.add(one));
        let pair = |count: Count| (count.hits, count.trials);
        assert_eq!(pair(score.effects), (3, 5));
        assert_eq!(pair(score.large), (3, 3));
        assert_eq!(pair(score.names), (2, 4));
        assert_eq!(pair(score.remainder), (1, 1));
        assert_eq!(pair(score.false_remainder), (0, 1));
    }
}
