//! Where simulation and reality differ, which unmodelled effect causes it, and how far the gap
//! shrinks once that effect is added.
//!
//! From the ground up; each imports from those before it:
//!
//! | room | answers |
//! |---|---|
//! | [`fitted`] | campaigns with some effects, fitted |
//! | [`library`] | what may be added to a model |
//! | [`evidence`] | what each of that would explain, from one pass, and how unlikely that is by chance |
//! | [`found`] | what is found beside effects, as data |
//! | `sequences` | residuals in the order of time |
//! | [`stage`] | a fitted model with the evidence of all that is not in it |
//! | [`gross`] | what spoils a fit: it is left out and told |
//! | [`noise`] | the noise, before anything is tested against it |
//! | [`mod@search`] | which effects are adopted |
//! | [`verdict`] | the answer, what shows in no reading and what could still hide |
//! | [`mod@gap`] | how far the gap shrinks |
//! | [`diagnosis`] | the answer as data |
//! | [`power`] | what a design could see, before any data |

pub mod budget;
pub mod diagnosis;
pub mod evidence;
pub mod fitted;
pub mod found;
pub mod gap;
pub mod gross;
pub mod library;
pub mod noise;
pub mod power;
pub mod search;
mod sequences;
pub mod stage;
pub mod verdict;

use crate::engine::Problem;
use crate::engine::open::{Opened, Recipe};
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::calibrate;

pub use diagnosis::Diagnosis;
use fitted::Fitted;
use gap::floor;
use gap::holdout::{HoldoutError, holdout};
use gap::steps::Steps;
use gross::codes::without_codes;
use gross::misstated::misstated;
use gross::settle::{settled, without_lost, without_spoiling};
use gross::spikes::without_spikes;
use gross::twice::twice;
use library::wanted::Wanted;
use search::search;
use verdict::alone::without_alone;
use verdict::answer::Verdict;
use verdict::moment::changed;

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
    if let Some(misstated) = misstated(&whole, options)? {
        return Ok(Diagnosis::of_misstated(whole, misstated, recipes));
    }
    let (nominal, mut gross) = without_codes(whole.clone(), options)?;
    let (nominal, unsettling) = settled(nominal, options)?;
    gross.extend(unsettling);
    let (nominal, lost) = without_lost(nominal, options)?;
    let (nominal, spikes) = without_spikes(nominal, options)?;
    gross.extend(spikes);
    let (nominal, wrong) = without_spoiling(nominal, options)?;
    gross.extend(wrong);
    let mut diagnosis = Diagnosis::unobservable(nominal, lost);
    if !diagnosis.nominal.is_sound() {
        return Ok(diagnosis);
    }
    let (problem, fit) = (diagnosis.nominal.problem.clone(), diagnosis.nominal.fit.clone());
    let fitted = Fitted { recipes, problem, fit };
    if std::env::var_os("BUDGET").is_some() {
        if let Some(found) = budget::driver::search(fitted, wanted, options)? {
            for line in &found.log { println!("{line}"); }
            println!("scale {:?}", found.scale);
            for t in &found.judged.model { println!("MODEL {} {}", found.linear.terms[*t].name, found.judged.nameless.contains(t)); }
        }
        return Ok(diagnosis);
    }
    let aside = (&diagnosis.lost[..], &gross);
    let Some(mut search) = search(fitted.clone(), aside, wanted, options)? else {
        return Ok(diagnosis);
    };
    if let Some(changed) = changed(&search, &fitted, aside, wanted, options)? {
        search = diagnosis.name_no_effect(changed, search);
    } else {
        if let Some((nominal, found)) = without_alone(&search, &fitted, aside, wanted, options)? {
            (diagnosis.nominal, search) = (nominal, found);
        }
        diagnosis.decide(&search, options)?;
    }
    diagnosis.list(&search);
    diagnosis.look_again(&search, wanted);
    diagnosis.locate(&search);
    if let Some(first) = search.stages.first()
        && (!diagnosis.lost.is_empty() || !first.noise_found.left_out.is_empty())
    {
        diagnosis.delays = twice(&whole, first, options)?;
    }
    if diagnosis.verdict == Verdict::Unknown {
        diagnosis.name_nearest(&search);
        diagnosis.floor = search.stages.first().map(|stage| floor(&stage.fitted));
    } else {
        diagnosis.suspect(&search);
    }
    diagnosis.search = Some(search);
    Ok(diagnosis)
}

/// Judges how far the gap shrinks on a campaign that the fit never saw; without named effects
/// nothing changes.
///
/// # Errors
/// [`HoldoutError`] where the campaign cannot be fitted at all, or does not take an effect.
pub fn judge(
    diagnosis: &mut Diagnosis,
    held_out: &Opened,
    wanted: &Wanted,
    options: &Options,
) -> Result<(), HoldoutError> {
    let Some(search) = &diagnosis.search else { return Ok(()) };
    let Some(stage) = search.stages.get(diagnosis.effects.len()) else { return Ok(()) };
    if diagnosis.effects.is_empty() {
        return Ok(());
    }
    let models = Steps::of(&stage.fitted, &diagnosis.effects, options)?;
    let in_data = diagnosis.effects.iter().all(|one| one.evidence() == "data");
    diagnosis.gap = Some(holdout(held_out, &models, wanted, in_data, options)?);
    Ok(())
}
