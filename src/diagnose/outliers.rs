//! What spoils a fit, before anything else is judged: it is left out and reported.
//!
//! | file | answers |
//! |---|---|
//! | `wrong_value` | a stated value that is wrong altogether |
//! | `settle` | the nominal fit, without what keeps it from settling |
//! | `codes` | numbers that stand in the place of readings |
//! | `saturated` | readings at the limit of what an instrument shows |
//! | `suspects` | both of them, confirmed by a fit without them |
//! | `frozen` | readings that repeat the last one while the instrument moves on |
//! | `unresponsive` | readings that stand still but for noise while the prediction moves |
//! | `bursts`, `places` | stretches of wrong readings, and whether they come back at a place |
//! | [`spikes`] | readings that bend a fit, and once more beside the effects that were found |
//! | [`records`] | the readings of a problem, to put them back |
//! | [`lost`], `shifted` | stretches of readings shifted by whole samples, and by other times |
//! | `limits` | readings and runs that are far out, and runs of which nothing is left |
//! | `left_out` | how what is left out is listed |
//! | [`mod@compared_delays`] | what that does to the delays |

mod bursts;
mod codes;
pub mod compared_delays;
mod frozen;
mod left_out;
mod limits;
pub mod lost;
mod places;
pub mod records;
mod saturated;
mod settle;
mod shifted;
pub mod spikes;
mod suspects;
mod unresponsive;
pub(super) mod wrong_value;

use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::Calibration;

use self::codes::without_codes;
use self::frozen::without_frozen;
use self::lost::Jump;
use self::saturated::without_saturated;
use self::settle::{settled, without_lost, without_spoiling};
use self::spikes::{Spikes, without_spikes};
use self::unresponsive::without_unresponsive;
use super::found::LeftOut;

/// The fit of the rest with what was left out; `None` where there is nothing to leave out.
type Rest = Option<(Calibration, LeftOut)>;
type Cleaned = Result<Rest, FitError>;

/// Jumps of clocks, with the fit that shows them, in which no spikes are left out: what is far out
/// beside a jump may be nothing else.
#[derive(Clone, Debug)]
pub(super) struct Jumped {
    /// The fit.
    pub(super) nominal: Calibration,
    /// What is left out of it.
    pub(super) left_out: LeftOut,
    /// The jumps.
    pub(super) jumps: Vec<Jump>,
}

/// A nominal fit without what spoils it.
#[derive(Clone, Debug)]
pub(super) struct Cleared {
    /// The fit.
    pub(super) nominal: Calibration,
    /// What is left out for good.
    pub(super) left_out: LeftOut,
    /// What is left out as it is seen from the nominal fit: effects may have hidden it, or made it up.
    pub(super) spikes: Spikes,
    /// Jumps of clocks, if there are any.
    pub(super) jumped: Option<Jumped>,
}

/// The nominal fit without what spoils it, and that.
pub(super) fn without_outliers(
    whole: &Calibration,
    options: &Options,
) -> Result<Cleared, FitError> {
    let steps: [fn(&Calibration, &Options) -> Cleaned; 5] =
        [without_codes, without_saturated, settled, without_frozen, without_unresponsive];
    let (mut nominal, mut left_out) = (whole.clone(), LeftOut::default());
    for step in steps {
        if let Some((rest, found)) = step(&nominal, options)? {
            nominal = rest;
            left_out.extend(found);
        }
    }
    let (lost, jumps) = without_lost(&nominal, options)?;
    if let Some((rest, found)) = lost {
        nominal = rest;
        left_out.extend(found);
    }
    let jumped = (!jumps.is_empty()).then(|| Jumped {
        nominal: nominal.clone(),
        left_out: left_out.clone(),
        jumps,
    });
    let mut spikes = Spikes::none(&nominal.problem);
    if let Some((rest, found)) = without_spikes(&nominal, options)? {
        nominal = rest;
        spikes.left_out = found;
    }
    if let Some((rest, found)) = without_spoiling(&nominal, options)? {
        nominal = rest;
        left_out.extend(std::mem::take(&mut spikes.left_out));
        left_out.extend(found);
        spikes = Spikes::none(&nominal.problem);
    }
    Ok(Cleared { nominal, left_out, spikes, jumped })
}
