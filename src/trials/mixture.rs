//! Mixtures: three to five effects at once, in half of them beside a cause that the library of the
//! diagnosis lacks, in a third with noise twice what is stated.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;

use super::design::{Cause, Design, Dose};
use super::doses::{dose, pick};
use super::plan::{Size, between};

/// How many effects of the library.
const EFFECTS: std::ops::RangeInclusive<usize> = 3..=5;
/// Part with a cause outside the library.
const WITH_OUTSIDE: f64 = 0.5;
/// Part of these causes that have no name; the others are effects that are withheld.
const NAMELESS: f64 = 0.5;
/// Part with too much noise, and how many times as much.
const NOISY: (f64, f64) = (1.0 / 3.0, 2.0);
/// Two causes share no more of the squared length of their signatures than this.
const APART: f64 = 0.5;
/// Tries for each cause.
const TRIES: usize = 100;

/// What is true in a mixture.
#[derive(Clone, Debug)]
pub(super) struct Mixture {
    /// The effects of the library, then the cause outside it.
    pub(super) doses: Vec<Dose>,
    /// How many of them are outside the library: 0 or 1.
    pub(super) outside: usize,
    /// The noise, in units of what is stated.
    pub(super) noise: f64,
}

/// Draws a mixture; each cause has a size of its own.
pub(super) fn mixture(design: &Design, size: Size, chance: &mut ChaCha12Rng) -> Mixture {
    let count = chance.random_range(EFFECTS);
    let with_outside = chance.random::<f64>() < WITH_OUTSIDE;
    let is_nameless = chance.random::<f64>() < NAMELESS;
    let noise = if chance.random::<f64>() < NOISY.0 { NOISY.1 } else { 1.0 };
    let of = |nameless: bool| -> Vec<&Cause> {
        let fits = |one: &&Cause| if nameless { one.names.is_empty() } else { one.in_library };
        design.causes.iter().filter(fits).collect()
    };
    let mut doses = Vec::new();
    for _ in 0..count {
        let found = another(design, &of(false), size, &doses, chance, |_| true);
        doses.extend(found);
    }
    let mut outside = None;
    if with_outside {
        let names = |dose: &Dose| dose.cause.name.clone();
        let present: Vec<String> = doses.iter().map(names).collect();
        // Withholding it must not withhold another effect of the mixture.
        let alone = |dose: &Dose| {
            !present.iter().any(|name| design.is_named(dose, name))
                && design.like(dose).iter().all(|name| !present.iter().any(|own| is_of(own, name)))
        };
        outside = another(design, &of(is_nameless), size, &doses, chance, alone);
    }
    let count = usize::from(outside.is_some());
    doses.extend(outside);
    Mixture { doses, outside: count, noise }
}

/// Whether a cause is of this effect, at any head.
fn is_of(cause: &str, effect: &str) -> bool {
    cause.split('.').next() == Some(effect)
}

/// One more cause that is like none of the others.
fn another(
    design: &Design,
    causes: &[&Cause],
    size: Size,
    others: &[Dose],
    chance: &mut ChaCha12Rng,
    fits: impl Fn(&Dose) -> bool,
) -> Option<Dose> {
    let (from, to) = match size {
        Size::Fixed(lambda) => (lambda, lambda),
        Size::Between(from, to) => (from, to),
    };
    for _ in 0..TRIES {
        let cause = pick(causes, chance)?;
        let lambda = between(from, to, chance.random::<f64>());
        let drawn = dose(design, cause, lambda, chance);
        let is_apart = |other: &Dose| {
            other.cause.name != drawn.cause.name
                && !design.is_named(other, &drawn.cause.name)
                && design.alike_parts(other, &drawn) < APART
        };
        if others.iter().all(is_apart) && fits(&drawn) {
            return Some(drawn);
        }
    }
    None
}
