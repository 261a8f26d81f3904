//! Where simulation and reality differ, which unmodelled effects cause it, and how far the gap
//! shrinks once they are added.
//!
//! From the ground up; each imports from those before it:
//!
//! | room | answers |
//! |---|---|
//! | [`price`], [`thresholds`] | from a drop of chi squared to a log Bayes factor; every threshold with its meaning |
//! | [`fitted`] | campaigns with some effects, fitted |
//! | [`library`] | what may be added to a model |
//! | [`evidence`] | one pass over the readings; which member of a family explains most |
//! | [`found`] | what is found beside effects, as data |
//! | [`outliers`] | readings that spoil a fit: they are left out and reported |
//! | [`mod@gap`] | how far the gap shrinks |
//! | [`budget`] | which terms explain the gap, what remains, and the answer as data |
//! | [`power`] | what a design could see, before any data |

pub mod budget;
pub mod evidence;
pub mod fitted;
pub mod found;
pub mod gap;
pub mod library;
pub mod outliers;
pub mod power;
pub mod price;
pub mod thresholds;

use crate::engine::Problem;
use crate::engine::open::{Opened, Recipe};
use crate::estimate::batch::{FitError, Options, Outcome};
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::contradicted::Contradicted;

use budget::answer::{Remainder, Verdict};
use budget::driver::search;
use fitted::Fitted;
use gap::holdout::{HoldoutError, holdout};
use library::place::Place;
use library::wanted::Wanted;
use outliers::compared_delays::compared_delays;
use outliers::without_outliers;
use outliers::wrong_value::wrong_value;

pub use budget::answer::Diagnosis;

/// Diagnoses campaigns.
///
/// # Errors
/// [`FitError`] where a problem cannot be fitted at all.
pub fn diagnose(
    problem: Problem,
    recipes: Vec<Recipe>,
    wanted: &Wanted,
    options: &Options,
) -> Result<Diagnosis, FitError> {
    let whole = calibrate(problem, options)?;
    if let Some(contradicted) = wrong_value(&whole, options)? {
        return Ok(of_wrong_value(whole, contradicted));
    }
    let (nominal, left_out) = without_outliers(&whole, options)?;
    let fitted = Fitted { recipes, problem: nominal.problem.clone(), fit: nominal.fit.clone() };
    let is_sound = nominal.is_sound();
    let mut diagnosis = Diagnosis::without_search(nominal, Verdict::Unobservable);
    diagnosis.left_out = left_out;
    if diagnosis.nominal.fit.outcome != Outcome::Converged {
        diagnosis.verdict = Verdict::NotConverged;
    }
    if !is_sound {
        return Ok(diagnosis);
    }
    let Some(found) = search(fitted, wanted, options)? else { return Ok(diagnosis) };
    let last = found.competed.linear.fitted.clone();
    let mut diagnosis = diagnosis.of(found, &wanted.prior, options)?;
    if !diagnosis.left_out.is_empty() {
        diagnosis.delays = compared_delays(&whole, &last, options)?;
    }
    Ok(diagnosis)
}

/// The answer where a stated value is wrong altogether: beside it nothing else can be judged.
fn of_wrong_value(whole: Calibration, contradicted: Contradicted) -> Diagnosis {
    let place = Place::of_stated(&contradicted.parameter, contradicted.estimate.of.as_deref());
    let mut diagnosis = Diagnosis::without_search(whole, Verdict::Unknown);
    diagnosis.remainder = vec![Remainder { share: 1.0, ..Remainder::at(place) }];
    diagnosis.contradicted = vec![contradicted];
    diagnosis
}

/// Judges how far the gap shrinks on a campaign that the fit never saw; without rows nothing
/// changes.
///
/// # Errors
/// [`HoldoutError`] where the campaign cannot be fitted at all, or does not take an effect.
pub fn judge(
    diagnosis: &mut Diagnosis,
    held_out: &Opened,
    options: &Options,
) -> Result<(), HoldoutError> {
    if let Some(steps) = &diagnosis.steps {
        diagnosis.gap = Some(holdout(held_out, steps, options)?);
    }
    Ok(())
}
