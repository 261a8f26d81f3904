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
use outliers::wrong_value::wrong_value;
use outliers::{Cleared, without_outliers};

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
    match wrong_value(&whole, &recipes, wanted, options)? {
        None => of_fit(whole, recipes, wanted, options),
        Some(wrong) => {
            let recipes = wrong.recipes(recipes);
            let diagnosis = of_fit(wrong.without, recipes, wanted, options)?;
            Ok(beside_wrong_value(diagnosis, wrong.contradicted))
        }
    }
}

/// The diagnosis from a joint estimate on.
fn of_fit(
    whole: Calibration,
    recipes: Vec<Recipe>,
    wanted: &Wanted,
    options: &Options,
) -> Result<Diagnosis, FitError> {
    let Cleared { nominal, left_out, spikes } = without_outliers(&whole, options)?;
    let fitted = Fitted { recipes, problem: nominal.problem.clone(), fit: nominal.fit.clone() };
    let is_sound = nominal.is_sound();
    let mut diagnosis = Diagnosis::without_search(nominal, Verdict::Unobservable);
    diagnosis.left_out = left_out.clone();
    diagnosis.left_out.extend(spikes.left_out.clone());
    if diagnosis.nominal.fit.outcome != Outcome::Converged {
        diagnosis.verdict = Verdict::NotConverged;
    }
    if !is_sound {
        return Ok(diagnosis);
    }
    let Some(found) = search(fitted, spikes, wanted, options)? else { return Ok(diagnosis) };
    diagnosis.left_out = left_out;
    let last = found.competed.linear.fitted.clone();
    let mut diagnosis = diagnosis.of(found, &wanted.prior, options)?;
    if !diagnosis.left_out.is_empty() {
        diagnosis.delays = compared_delays(&whole, &last, options)?;
    }
    Ok(diagnosis)
}

/// The same where a stated value is wrong altogether, which was set free: it is a part of the
/// remainder. Its share is that of the gap with what is stated; the other shares are of the rest.
fn beside_wrong_value(mut diagnosis: Diagnosis, wrong: Contradicted) -> Diagnosis {
    let place = Place::of_stated(&wrong.parameter, wrong.estimate.of.as_deref());
    let nominal = &diagnosis.nominal;
    let rest = (nominal.fit.cost - nominal.degrees_of_freedom() as f64).max(0.0);
    let share = wrong.gain / (wrong.gain + rest);
    diagnosis.verdict = match diagnosis.verdict {
        Verdict::Adequate => Verdict::Unknown,
        Verdict::Explained if diagnosis.rows.is_empty() => Verdict::Unknown,
        Verdict::Explained => Verdict::PartlyExplained,
        other => other,
    };
    diagnosis.set_free = Some(wrong.parameter.clone());
    diagnosis.remainder.insert(0, Remainder { share, ..Remainder::at(place) });
    diagnosis.contradicted.insert(0, wrong);
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
