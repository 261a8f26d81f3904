//! What is true of each effect of a mixture, and which were identified.

use serde::{Deserialize, Serialize};

use crate::trials::design::{Design, Dose};
use crate::trials::draw::Drawn;

/// A mixture of effects.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mixed {
    /// Length of each effect's signature, in units of the stated noise.
    pub lambda: Vec<f64>,
    /// How many of the effects, the last ones, the library of the diagnosis lacks.
    pub outside: usize,
    /// Standard deviation of the noise, in units of what is stated.
    pub noise: f64,
    /// Of each effect that the library has: whether it, or an alias, is named.
    pub identified: Vec<bool>,
    /// Of each name in the answer: whether it is that of an effect, or an alias.
    pub right: Vec<bool>,
    /// Whether the answer says that something is there beside the named effects.
    pub remainder: bool,
}

impl Mixed {
    pub(super) fn truth(drawn: &Drawn) -> Self {
        Self {
            lambda: drawn.doses.iter().map(|dose| dose.lambda).collect(),
            outside: drawn.outside,
            noise: drawn.noise_factor,
            identified: vec![false; drawn.doses.len() - drawn.outside],
            ..Self::default()
        }
    }

    pub(super) fn judge(
        &mut self,
        design: &Design,
        known: &[Dose],
        named: &[String],
        remainder: bool,
    ) {
        let is_of = |dose: &Dose, name: &String| design.is_named(dose, name);
        self.identified =
            known.iter().map(|dose| named.iter().any(|name| is_of(dose, name))).collect();
        self.right = named.iter().map(|name| known.iter().any(|dose| is_of(dose, name))).collect();
        self.remainder = remainder;
    }
}
