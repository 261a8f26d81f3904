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
//! | `bursts`, `places` | stretches of wrong readings, and whether they come back at a place |
//! | `spikes` | readings that bend a fit |
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
mod saturated;
mod settle;
mod shifted;
mod spikes;
mod suspects;
pub(super) mod wrong_value;

use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::Calibration;

use self::codes::without_codes;
use self::frozen::without_frozen;
use self::saturated::without_saturated;
use self::settle::{settled, without_lost, without_spoiling};
use self::spikes::without_spikes;
use super::found::LeftOut;

/// The fit of the rest with what was left out; `None` where there is nothing to leave out.
type Cleaned = Result<Option<(Calibration, LeftOut)>, FitError>;

/// The nominal fit without what spoils it, and that.
pub(super) fn without_outliers(
    whole: &Calibration,
    options: &Options,
) -> Result<(Calibration, LeftOut), FitError> {
    let steps: [fn(&Calibration, &Options) -> Cleaned; 7] = [
        without_codes,
        without_saturated,
        settled,
        without_frozen,
        without_lost,
        without_spikes,
        without_spoiling,
    ];
    let (mut nominal, mut out) = (whole.clone(), LeftOut::default());
    for step in steps {
        if let Some((rest, found)) = step(&nominal, options)? {
            nominal = rest;
            out.extend(found);
        }
    }
    Ok((nominal, out))
}
