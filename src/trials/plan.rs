//! What each trial is to be, from the seed and its number alone.
//!
//! A plan is a list of strata with weights. Trial `n` belongs to the stratum in which the
//! fractional part of `n φ` falls (`φ` the golden ratio): any beginning of a plan is spread over
//! its strata nearly as the whole, so an interrupted plan is a smaller one, and a longer one goes
//! on where a shorter one ended.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha12Rng;

/// What is true in a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
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
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::None, Self::One, Self::Two, Self::Withheld, Self::Noise];

    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::One => "one",
            Self::Two => "two",
            Self::Withheld => "withheld",
            Self::Noise => "noise",
        }
    }
}

/// How large an effect is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// This `λ`.
    Fixed(f64),
    /// Logarithmically uniform between two.
    Between(f64, f64),
}

/// A kind of trial and its part of the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stratum {
    /// What is true.
    pub kind: Kind,
    /// How large.
    pub size: Size,
    /// Its part, of the sum of all.
    pub weight: f64,
    /// Whether it is of the mix over which probabilities are judged.
    pub mixed: bool,
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

/// A plan of trials.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// How many.
    pub trials: usize,
    /// Where all random numbers come from.
    pub seed: u64,
    /// What they are.
    pub strata: Vec<Stratum>,
}

/// One trial of a plan.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What is true.
    pub kind: Kind,
    /// How large its effects are.
    pub lambda: f64,
    /// Whether it is of the mix over which probabilities are judged.
    pub mixed: bool,
    /// Whether `lambda` was drawn.
    pub spread: bool,
    /// Its random numbers.
    pub generator: ChaCha12Rng,
    /// The seed of its readings.
    pub seed: u64,
}

impl Plan {
    /// The mix, with what shows best at fixed sizes.
    pub fn standard(trials: usize, seed: u64) -> Self {
        let (from, to) = SIZES;
        let mix = MIX.map(|(kind, part)| Stratum {
            kind,
            size: Size::Between(from, to),
            weight: MIXED * part,
            mixed: true,
        });
        let rest = REST.map(|(kind, lambda, weight)| Stratum {
            kind,
            size: Size::Fixed(lambda),
            weight,
            mixed: false,
        });
        Self { trials, seed, strata: mix.into_iter().chain(rest).collect() }
    }

    /// These kinds at these sizes, each as often as any other; no size stands for the whole range.
    pub fn of(trials: usize, seed: u64, kinds: &[Kind], lambdas: &[f64]) -> Self {
        let sizes: Vec<Size> = match lambdas {
            [] => vec![Size::Between(SIZES.0, SIZES.1)],
            lambdas => lambdas.iter().map(|lambda| Size::Fixed(*lambda)).collect(),
        };
        let stratum = |kind: Kind| {
            move |size: &Size| Stratum { kind, size: *size, weight: 1.0, mixed: false }
        };
        let strata = kinds.iter().flat_map(|kind| sizes.iter().map(stratum(*kind))).collect();
        Self { trials, seed, strata }
    }

    /// What a trial is to be.
    pub fn trial(&self, number: usize) -> Trial {
        let mut generator = ChaCha12Rng::seed_from_u64(self.seed);
        generator.set_stream(number as u64);
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let whole: f64 = self.strata.iter().map(|one| one.weight).sum();
        let mut at = ((number as f64 + 0.5) * golden).fract() * whole;
        let found = self.strata.iter().find(|one| {
            at -= one.weight;
            at < 0.0
        });
        let nothing =
            Stratum { kind: Kind::None, size: Size::Fixed(0.0), weight: 1.0, mixed: false };
        let stratum = *found.or(self.strata.last()).unwrap_or(&nothing);
        let seed = generator.random();
        let (lambda, spread) = match stratum.size {
            Size::Fixed(lambda) => (lambda, false),
            Size::Between(from, to) => (from * (to / from).powf(generator.random::<f64>()), true),
        };
        let Stratum { kind, mixed, .. } = stratum;
        Trial { kind, lambda, mixed, spread, generator, seed }
    }
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
