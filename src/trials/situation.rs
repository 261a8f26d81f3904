//! Special situations: disturbed readings and misstated values, as data.
//!
//! A situation is a list of disturbances, and what a diagnosis should make of them. It is written
//! into the first line of a file of trials, so that trials can be made again.
//!
//! | file | answers |
//! |---|---|
//! | [`standard`] | the situations that are tried |
//! | [`disturbance`] | the kinds of disturbances |
//! | [`channel`] | what is moved: a reading, its time, a parameter |
//! | [`course`] | when it is moved, and how far each time |
//! | `replaced` | readings replaced by others |
//! | `misstated` | values that are stated wrong |

pub mod channel;
pub mod course;
pub mod disturbance;
mod misstated;
mod replaced;
pub mod standard;

use rand_chacha::ChaCha12Rng;
use serde::{Deserialize, Serialize};

use crate::engine::open::Recipe;
use crate::engine::{Point, Problem};

use disturbance::Disturbance;

/// A special situation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Situation {
    /// Its name.
    pub name: String,
    /// Number of effects of the library beside it, 0 to 1.
    #[serde(default)]
    pub effects: usize,
    /// What disturbs the campaign, in this order.
    pub disturbances: Vec<Disturbance>,
    /// Effects of the library that describe it: it is right to name them.
    #[serde(default)]
    pub names: Vec<String>,
    /// Whether a cause outside the library must be reported (`true`) or must not be (`false`);
    /// `None` where both are right.
    #[serde(default)]
    pub unmodelled: Option<bool>,
}

impl Situation {
    /// Disturbs the readings of campaigns at their true point.
    pub fn disturb(&self, problem: &mut Problem, point: &Point, chance: &mut ChaCha12Rng) {
        self.disturbances.iter().for_each(|one| one.disturb(problem, point, chance));
    }

    /// Misstates values of the campaigns that the diagnosis is given.
    pub fn misstate(
        &self,
        problem: &mut Problem,
        recipes: &mut [Recipe],
        chance: &mut ChaCha12Rng,
    ) {
        self.disturbances.iter().for_each(|one| one.misstate(problem, recipes, chance));
    }
}
