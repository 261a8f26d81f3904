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

use crate::engine::open::{Opened, Recipe};
use crate::engine::{Part, Problem};
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::contradicted::{Contradicted, against};

use budget::answer::{FAR_BEYOND_STATED, Remainder, Verdict};
use budget::driver::{Found, search, search_with_jumps};
use fitted::Fitted;
use found::LeftOut;
use gap::holdout::{HoldoutError, holdout};
use library::place::Place;
use library::wanted::Wanted;
use outliers::compared_delays::compared_delays;
use outliers::records::Records;
use outliers::wrong_value::{WrongValue, wrong_value, wrong_value_beside};
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
    let with_free = |wrong: WrongValue| {
        let recipes = wrong.recipes(recipes.clone());
        let diagnosis = of_fit(&wrong.without, recipes, wanted, options)?;
        Ok::<_, FitError>(beside_wrong_value(diagnosis, &whole, wrong.contradicted))
    };
    if let Some(wrong) = wrong_value(&whole, &recipes, wanted, options)? {
        return with_free(wrong);
    }
    let stated = of_fit(&whole, recipes.clone(), wanted, options)?;
    let Some(wrong) = wrong_value_beside(&whole, &stated.contradicted, options)? else {
        return Ok(stated);
    };
    let free = with_free(wrong)?;
    let is_better = free.variance_factor() * FAR_LESS < stated.variance_factor();
    Ok(if is_better { free } else { stated })
}

/// How many times less the variance factor must be with a stated value free, beside what explains the
/// gap best with and without; and in a fit that begins anew.
const FAR_LESS: f64 = 2.0;

/// The diagnosis from a joint estimate on. Wrong readings may have led it to where no fit comes back
/// from without them: then it begins anew, without those that were left out.
fn of_fit(
    whole: &Calibration,
    recipes: Vec<Recipe>,
    wanted: &Wanted,
    options: &Options,
) -> Result<Diagnosis, FitError> {
    let none = LeftOut::default();
    let (diagnosis, records) = searched(whole, (whole, none), recipes.clone(), wanted, options)?;
    let is_lost =
        !diagnosis.left_out.is_empty() && diagnosis.variance_factor() > FAR_BEYOND_STATED.powi(2);
    let Some(records) = records.filter(|_| is_lost) else { return Ok(diagnosis) };
    let anew = records.fitted_anew(whole, options)?.filter(|anew| {
        let factor = anew.variance_factor().unwrap_or(f64::INFINITY);
        factor * FAR_LESS < diagnosis.variance_factor()
    });
    let Some(anew) = anew else { return Ok(diagnosis) };
    let known = (whole, diagnosis.left_out);
    Ok(searched(&anew, known, recipes, wanted, options)?.0)
}

/// The diagnosis from a joint estimate on, with the readings that it did not leave out; some of those
/// that are given may have been left out before.
fn searched(
    whole: &Calibration,
    known: (&Calibration, LeftOut),
    recipes: Vec<Recipe>,
    wanted: &Wanted,
    options: &Options,
) -> Result<(Diagnosis, Option<Records>), FitError> {
    let cleared = without_outliers(whole, None, options)?;
    searched_from(whole, cleared, known, recipes, wanted, options)
}

/// The same from a nominal fit without outliers on. Samples of which the search says that they were not
/// lost come back, and it begins again with them: they get fewer each time.
fn searched_from(
    whole: &Calibration,
    cleared: Cleared,
    (given, known): (&Calibration, LeftOut),
    recipes: Vec<Recipe>,
    wanted: &Wanted,
    options: &Options,
) -> Result<(Diagnosis, Option<Records>), FitError> {
    let Cleared { nominal, left_out: more, lost, spikes, jumped } = cleared;
    let beside = |more: LeftOut| {
        let mut left_out = known.clone();
        left_out.extend(more);
        left_out
    };
    let mut left_out = beside(more);
    let fitted = |of: &Calibration| {
        let (problem, fit) = (of.problem.clone(), of.fit.clone());
        Fitted { recipes: recipes.clone(), problem, fit }
    };
    let mut diagnosis = Diagnosis::without_search(nominal, Verdict::Unobservable);
    diagnosis.left_out = left_out.clone();
    diagnosis.left_out.extend(spikes.left_out.clone());
    if !diagnosis.nominal.fit.outcome.is_result() {
        diagnosis.verdict = Verdict::NotConverged;
    }
    if !diagnosis.nominal.is_sound() {
        return Ok((diagnosis, None));
    }
    let Some(mut found) = search(fitted(&diagnosis.nominal), spikes, wanted, options)? else {
        return Ok((diagnosis, None));
    };
    // Beside a jump that is not in the fit whatever is found is poor.
    if let Some(((nominal, less), jumps)) = jumped
        && is_poor(&found)
        && let Some(with) = search_with_jumps(fitted(&nominal), &jumps, wanted, options)?
        && !is_poor(&with)
    {
        (found, diagnosis.nominal, left_out) = (with, nominal, beside(less));
    }
    diagnosis.left_out = left_out;
    let last = found.competed.linear.fitted.clone();
    if let Some(rest) = lost.unexplained_by(&last) {
        let cleared = without_outliers(whole, Some(&rest), options)?;
        let known = (given, known.clone());
        let again = searched_from(whole, cleared, known, recipes.clone(), wanted, options)?;
        if again.1.is_some() {
            return Ok(again);
        }
    }
    let records = Records::of(&last.problem);
    let mut diagnosis = diagnosis.of(found, &wanted.prior, options)?;
    if !diagnosis.left_out.is_empty() {
        diagnosis.delays = compared_delays(given, &last, options)?;
    }
    Ok((diagnosis, Some(records)))
}

/// Whether what a search found leaves far more than is stated, or autocorrelated noise.
fn is_poor(found: &Found) -> bool {
    let fitted = &found.competed.linear.fitted;
    fitted.problem.has_autocorrelated_noise()
        || fitted.variance_factor() > FAR_BEYOND_STATED.powi(2)
}

/// The same where a stated value is wrong altogether, which was set free: it is a part of the
/// remainder. Its share is that of the gap with what is stated; the other shares are of the rest.
fn beside_wrong_value(
    mut diagnosis: Diagnosis,
    stated: &Calibration,
    mut wrong: Contradicted,
) -> Diagnosis {
    // What the readings say of it is estimated beside the rows.
    let explained = diagnosis.explained.as_ref().filter(|_| !diagnosis.rows.is_empty());
    if let Some(beside) = explained.and_then(|one| against(stated, one, &wrong.parameter)) {
        wrong = Contradicted { gain: wrong.gain, components: wrong.components, ..beside };
    }
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
        let mut held_out = held_out.clone();
        for part in &mut held_out.problem.parts {
            with_found_noise(part, diagnosis);
        }
        diagnosis.gap = Some(holdout(&held_out, steps, options)?);
    }
    Ok(())
}

/// Gives the measurands of a held-out campaign the noise that was found, where it states the same of them
/// as the campaigns that were fitted, and these agree.
fn with_found_noise(part: &mut Part, diagnosis: &Diagnosis) {
    let names = part.system.assembly.names.measurands.clone();
    for (stated, one) in part.sigma.iter_mut().zip(names.iter()) {
        let fitted = diagnosis.nominal.problem.parts.iter().filter(|fitted| {
            let known = &fitted.system.assembly.names.measurands;
            let same = known.iter().position(|own| own.name == one.name);
            same.is_some_and(|same| fitted.sigma[same] == *stated)
        });
        let factors = fitted.map(|fitted| {
            let level = diagnosis.levels.iter().find(|level| {
                let is_of = level.of.is_none() || level.of == fitted.label;
                level.run.is_none() && level.measurand == one.name && is_of
            });
            level.map_or(1.0, |level| level.factor)
        });
        let factors: Vec<f64> = factors.collect();
        let [least, most] =
            [f64::min, f64::max].map(|of| factors.iter().copied().reduce(of).unwrap_or(1.0));
        if most < SAME_NOISE * least {
            *stated *= (least * most).sqrt();
        }
    }
}

/// Factor within which campaigns have the same noise.
const SAME_NOISE: f64 = 1.2;
