//! What each trial is to be, from the seed and its number alone.
//!
//! A plan is a list of strata with weights. Trial `n` belongs to the stratum in which the
//! fractional part of `n φ` falls (`φ` the golden ratio): any beginning of a plan is spread over
//! its strata nearly as the whole, so an interrupted plan is a smaller one, and a longer one goes
//! on where a shorter one ended.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha12Rng;
use serde::{Deserialize, Serialize};

use super::situation::Situation;
use super::situation::standard::standard;

/// What is true in a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Nothing but the stated noise.
    None,
    /// One effect: of the library, or the same cause in another form.
    One,
    /// Two effects.
    Two,
    /// One effect that the library of the diagnosis lacks.
    Withheld,
    /// Noise that is not what is stated.
    Noise,
    /// A special situation: disturbed readings or statements, also beside an effect.
    Situation,
    /// Three to five effects at once, also beside a cause that the library lacks.
    Mixture,
}

impl Kind {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::One => "one",
            Self::Two => "two",
            Self::Withheld => "withheld",
            Self::Noise => "noise",
            Self::Situation => "situation",
            Self::Mixture => "mixture",
        }
    }
}

/// How large an effect is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Size {
    /// This `λ`.
    Fixed(f64),
    /// Logarithmically uniform between two.
    Between(f64, f64),
}

/// A kind of trial and its part of the plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stratum {
    /// What is true.
    pub kind: Kind,
    /// How large.
    pub size: Size,
    /// Its part, of the sum of all.
    pub weight: f64,
    /// Whether it is of the mix over which probabilities are judged.
    pub mixed: bool,
    /// The situation, where the kind is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub situation: Option<Situation>,
}

impl Stratum {
    /// A kind of trial at a size.
    pub fn new(kind: Kind, size: Size, weight: f64) -> Self {
        Self { kind, size, weight, mixed: false, situation: None }
    }
}

/// Which stratum a trial belongs to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Spread by the golden ratio, in proportion to the weights.
    #[default]
    Spread,
    /// One stratum after the other, whatever their weights.
    InTurn,
}

/// Range of `λ` where nothing else is asked for.
pub const SIZES: (f64, f64) = (2.0, 100.0);
/// Nothing, the library, withheld: the mix over which probabilities are judged.
const MIX: [(Kind, f64); 3] = [(Kind::None, 0.30), (Kind::One, 0.50), (Kind::Withheld, 0.20)];
/// Part of the mix in the whole plan.
const MIXED: f64 = 0.50;
/// The rest: kind, `λ`, part.
const REST: [(Kind, f64, f64); 8] = [
    (Kind::Noise, 0.0, 0.32),
    (Kind::One, 8.0, 0.03),
    (Kind::One, 12.0, 0.03),
    (Kind::One, 25.0, 0.03),
    (Kind::Two, 25.0, 0.03),
    (Kind::Withheld, 12.0, 0.01),
    (Kind::Withheld, 25.0, 0.025),
    (Kind::Withheld, 50.0, 0.025),
];

/// Size of the effect beside a situation.
const BESIDE: f64 = 30.0;
/// Range of `λ` of each effect of a mixture.
const MIXTURE: (f64, f64) = (15.0, 400.0);

/// A plan of trials.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// How many.
    pub trials: usize,
    /// Where all random numbers come from.
    pub seed: u64,
    /// How they take their strata.
    pub order: Order,
    /// What they are.
    pub strata: Vec<Stratum>,
}

/// One trial of a plan.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What is true.
    pub kind: Kind,
    /// How large its effects may be.
    pub size: Size,
    /// How large its effects are; 0 where each has a size of its own.
    pub lambda: f64,
    /// Whether it is of the mix over which probabilities are judged.
    pub mixed: bool,
    /// Whether `lambda` was drawn.
    pub spread: bool,
    /// Its random numbers.
    pub generator: ChaCha12Rng,
    /// The seed of its readings.
    pub seed: u64,
    /// The situation, where the kind is one.
    pub situation: Option<Situation>,
}

impl Plan {
    /// The mix, with what shows best at fixed sizes.
    pub fn standard(trials: usize, seed: u64) -> Self {
        let (from, to) = SIZES;
        let mix = MIX.map(|(kind, part)| Stratum {
            mixed: true,
            ..Stratum::new(kind, Size::Between(from, to), MIXED * part)
        });
        let rest =
            REST.map(|(kind, lambda, weight)| Stratum::new(kind, Size::Fixed(lambda), weight));
        Self::spread(trials, seed, mix.into_iter().chain(rest).collect())
    }

    /// These kinds at these sizes, each as often as any other; no size stands for the whole range.
    pub fn of(trials: usize, seed: u64, kinds: &[Kind], lambdas: &[f64]) -> Self {
        let sizes: Vec<Size> = match lambdas {
            [] => vec![Size::Between(SIZES.0, SIZES.1)],
            lambdas => lambdas.iter().map(|lambda| Size::Fixed(*lambda)).collect(),
        };
        let stratum = |kind: Kind| move |size: &Size| Stratum::new(kind, *size, 1.0);
        let strata = kinds.iter().flat_map(|kind| sizes.iter().map(stratum(*kind))).collect();
        Self::spread(trials, seed, strata)
    }

    /// The standard situations in turn.
    pub fn situations(trials: usize, seed: u64) -> Self {
        let stratum = |situation: Situation| Stratum {
            situation: Some(situation),
            ..Stratum::new(Kind::Situation, Size::Fixed(BESIDE), 1.0)
        };
        let strata = standard().into_iter().map(stratum).collect();
        Self { order: Order::InTurn, ..Self::spread(trials, seed, strata) }
    }

    /// Mixtures of several effects.
    pub fn mixtures(trials: usize, seed: u64) -> Self {
        let size = Size::Between(MIXTURE.0, MIXTURE.1);
        Self::spread(trials, seed, vec![Stratum::new(Kind::Mixture, size, 1.0)])
    }

    fn spread(trials: usize, seed: u64, strata: Vec<Stratum>) -> Self {
        Self { trials, seed, order: Order::Spread, strata }
    }

    /// The index of a trial's stratum; `None` where the plan has no strata.
    pub fn stratum(&self, number: usize) -> Option<usize> {
        let last = self.strata.len().checked_sub(1)?;
        if self.order == Order::InTurn {
            return Some(number % self.strata.len());
        }
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let whole: f64 = self.strata.iter().map(|one| one.weight).sum();
        let mut at = ((number as f64 + 0.5) * golden).fract() * whole;
        let found = self.strata.iter().position(|one| {
            at -= one.weight;
            at < 0.0
        });
        Some(found.unwrap_or(last))
    }

    /// What a trial is to be.
    pub fn trial(&self, number: usize) -> Trial {
        let mut generator = ChaCha12Rng::seed_from_u64(self.seed);
        generator.set_stream(number as u64);
        let nothing = Stratum::new(Kind::None, Size::Fixed(0.0), 1.0);
        let stratum = self.stratum(number).map_or(nothing, |index| self.strata[index].clone());
        let seed = generator.random();
        let (lambda, spread) = match stratum.size {
            Size::Fixed(lambda) => (lambda, false),
            Size::Between(..) if stratum.kind == Kind::Mixture => (0.0, false),
            Size::Between(from, to) => (between(from, to, generator.random::<f64>()), true),
        };
        let Stratum { kind, size, mixed, situation, .. } = stratum;
        Trial { kind, size, lambda, mixed, spread, generator, seed, situation }
    }
}

/// A number from a logarithmically uniform distribution; `share` is uniform from 0 to 1.
pub(super) fn between(from: f64, to: f64, share: f64) -> f64 {
    from * (to / from).powf(share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_beginning_of_a_plan_is_spread_as_the_whole() {
        let plan = Plan::standard(2000, 5);
        for trials in [100, 500, 2000] {
            let of = |wanted: Kind| (0..trials).filter(|n| plan.trial(*n).kind == wanted).count();
            let none = of(Kind::None) as f64 / trials as f64;
            let noise = of(Kind::Noise) as f64 / trials as f64;
            assert!((none - 0.15).abs() < 0.02, "{trials}: {none}");
            assert!((noise - 0.32).abs() < 0.02, "{trials}: {noise}");
        }
    }

    #[test]
    fn sizes_are_spread_over_the_logarithm() {
        let plan = Plan::of(400, 3, &[Kind::One], &[]);
        let below = (0..400).filter(|n| plan.trial(*n).lambda < 200.0_f64.sqrt()).count();
        assert!((150..250).contains(&below), "{below}");
        assert!(!plan.trial(0).mixed);
        assert_eq!(Plan::of(1, 3, &[Kind::Two], &[25.0]).trial(0).lambda, 25.0);
    }
}
