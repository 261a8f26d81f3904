//! Causes drawn at random, with values of a wanted size.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

use super::design::{Cause, Design, Dose};

/// One of some causes.
pub(super) fn pick<'c>(causes: &[&'c Cause], chance: &mut ChaCha12Rng) -> Option<&'c Cause> {
    (!causes.is_empty()).then(|| causes[chance.random_range(0..causes.len())])
}

pub(super) fn dose(design: &Design, cause: &Cause, lambda: f64, chance: &mut ChaCha12Rng) -> Dose {
    let member = chance.random::<f64>();
    design.dose(cause, lambda, member, &mut || StandardNormal.sample(&mut *chance))
}
