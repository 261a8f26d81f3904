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
//! | `not_lost` | those of them that effects explain |
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
mod not_lost;
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
use self::lost::{Elsewhere, Jump};
use self::not_lost::LostSamples;
use self::saturated::without_saturated;
use self::settle::{settled, without_lost, without_spoiling};
use self::spikes::{Spikes, without_spikes};
use self::unresponsive::without_unresponsive;
use super::found::LeftOut;

/// A fit, with what is left out of it.
type Clean = (Calibration, LeftOut);
/// The fit without more; `None` where there is nothing to leave out.
type Cleaned = Result<Option<Clean>, FitError>;

/// A nominal fit without what spoils it.
#[derive(Clone, Debug)]
pub(super) struct Cleared {
    /// The fit.
    pub(super) nominal: Calibration,
    /// What is left out for good.
    pub(super) left_out: LeftOut,
    /// Samples that were lost, among that: effects may explain them.
    pub(super) lost: LostSamples,
    /// What is left out as it is seen from the nominal fit: effects may have hidden it, or made it up.
    pub(super) spikes: Spikes,
    /// Jumps of clocks, if there are any, with the fit that shows them and what is left out of it. No
    /// spikes are: what is far out beside a jump may be nothing else.
    pub(super) jumped: Option<(Clean, Vec<Jump>)>,
}

/// The nominal fit without what spoils it, and that; lost samples are looked for where they are not
/// known.
pub(super) fn without_outliers(
    whole: &Calibration,
    lost: Option<&Elsewhere>,
    options: &Options,
) -> Result<Cleared, FitError> {
    let steps: [fn(&Calibration, &Options) -> Cleaned; 5] =
        [without_codes, without_saturated, settled, without_frozen, without_unresponsive];
    let mut now = (whole.clone(), LeftOut::default());
    for step in steps {
        let found = step(&now.0, options)?;
        take(&mut now, found);
    }
    let (rest, found) = without_lost(&now.0, lost, options)?;
    now.1.lost.extend(found.lost.clone());
    let jumps = found.jumps.clone();
    let lost = LostSamples::new(found, &now.0.problem);
    now.0 = rest.unwrap_or(now.0);
    let jumped = (!jumps.is_empty()).then(|| (now.clone(), jumps));
    let mut spikes = Spikes::none(&now.0.problem);
    if let Some(found) = without_spikes(&now.0, options)? {
        (now.0, spikes.left_out) = found;
    }
    if let Some(found) = without_spoiling(&now.0, options)? {
        now.1.extend(spikes.left_out);
        take(&mut now, Some(found));
        spikes = Spikes::none(&now.0.problem);
    }
    let (nominal, left_out) = now;
    Ok(Cleared { nominal, left_out, lost, spikes, jumped })
}

/// Goes on with the fit without more.
fn take(now: &mut Clean, found: Option<Clean>) {
    if let Some((rest, more)) = found {
        now.0 = rest;
        now.1.extend(more);
    }
}
