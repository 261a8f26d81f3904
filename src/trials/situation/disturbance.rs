//! The kinds of disturbances. Sizes are in units of the stated noise.

use rand_chacha::ChaCha12Rng;
use serde::{Deserialize, Serialize};

use crate::engine::open::Recipe;
use crate::engine::{Point, Problem};

use super::channel::{Channel, move_readings};
use super::course::Course;
use super::misstated;
use super::replaced;

/// What disturbs a campaign. Which run, moment and measurand it meets is drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Disturbance {
    /// A reading, its time or a parameter moves.
    Moved {
        /// What moves.
        channel: Channel,
        /// When, and how far each time.
        course: Course,
        /// rms over the readings that it moves.
        size: f64,
    },
    /// A code stands in place of readings of one measurand.
    ErrorCodes {
        /// The code (SI).
        code: f64,
        /// Share of the readings.
        share: f64,
    },
    /// Samples of one run got lost: from a moment on its readings are those of later samples.
    LostSamples {
        /// How much later, in samples.
        periods: usize,
        /// For so many samples, at most to the end of the run.
        length: usize,
    },
    /// Consecutive readings of one measurand lie far out, all on one side.
    OutlierBursts {
        /// How many bursts.
        bursts: usize,
        /// Readings in each.
        length: usize,
        /// How far out.
        size: f64,
    },
    /// One run has one measurand in another unit: its readings are multiplied.
    WrongUnit {
        /// By this factor.
        factor: f64,
    },
    /// The readings of one measurand are rounded.
    Quantised {
        /// To multiples of this step.
        step: f64,
    },
    /// A stated parameter is not what is stated.
    Misstated {
        /// How far off, in stated standard uncertainties.
        by: f64,
        /// Whether the wrong value is stated as exact.
        fixed: bool,
    },
}

impl Disturbance {
    /// Disturbs the readings of campaigns at their true point.
    pub(super) fn disturb(&self, problem: &mut Problem, point: &Point, chance: &mut ChaCha12Rng) {
        match self {
            Self::Moved { channel, course, size } => {
                move_readings(problem, point, (channel, course), *size, chance);
            }
            Self::ErrorCodes { code, share } => {
                replaced::error_codes(problem, *code, *share, chance);
            }
            Self::LostSamples { periods, length } => {
                replaced::lost_samples(problem, *periods, *length, chance);
            }
            Self::OutlierBursts { bursts, length, size } => {
                (0..*bursts).for_each(|_| replaced::outlier_burst(problem, *length, *size, chance));
            }
            Self::WrongUnit { factor } => replaced::wrong_unit(problem, *factor, chance),
            Self::Quantised { step } => replaced::quantised(problem, *step, chance),
            Self::Misstated { .. } => {}
        }
    }

    /// Misstates a value of the campaigns that the diagnosis is given.
    pub(super) fn misstate(
        &self,
        problem: &mut Problem,
        recipes: &mut [Recipe],
        chance: &mut ChaCha12Rng,
    ) {
        if let Self::Misstated { by, fixed } = self {
            misstated::misstate(problem, recipes, (*by, *fixed), chance);
        }
    }
}
