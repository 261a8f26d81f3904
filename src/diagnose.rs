//! Where simulation and reality differ, which unmodelled effect causes it, and how far the gap
//! shrinks once that effect is added.
//!
//! | file | answers |
//! |---|---|
//! | [`candidates`] | what may be added to the model |
//! | [`structure`] | what an effect that nobody wrote down could look like |
//! | [`evidence`] | what each of them would explain, from one pass |
//! | [`score`], [`tail`] | how unlikely that is by chance |
//! | [`stage`] | a fitted model with all of that |
//! | [`whiten`], [`jitter`] | the noise, before anything is tested against it |
//! | [`search`] | which effects are adopted |
//! | [`verdict`] | the answer |

pub mod candidates;
pub mod evidence;
pub mod jitter;
pub mod score;
pub mod search;
pub mod stage;
pub mod structure;
pub mod tail;
pub mod verdict;
pub mod whiten;

use crate::engine::Problem;
use crate::engine::open::Recipe;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate, finish};

use candidates::{NotTestable, Wanted};
use search::{Adopted, Search, search};
use stage::Fitted;
use verdict::{Absorbed, Location, Ranked, Verdict};
use whiten::NoiseEffect;

/// The answer.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The joint estimate with the nominal model.
    pub nominal: Calibration,
    /// The verdict.
    pub verdict: Verdict,
    /// The effects that it names, in order of adoption.
    pub effects: Vec<Adopted>,
    /// The effects on the noise that it names.
    pub noise: Vec<NoiseEffect>,
    /// The joint estimate with those effects; `None` without any.
    pub explained: Option<Calibration>,
    /// All testable effects, best first.
    pub candidates: Vec<Ranked>,
    /// Effects that nominal parameters take up.
    pub absorbed: Vec<Absorbed>,
    /// Effects that cannot be tested here.
    pub not_testable: Vec<NotTestable>,
    /// Where the gap lies, best first.
    pub locations: Vec<Location>,
    /// The search, for those who want to know more; `None` where there was none.
    pub search: Option<Search>,
}

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
    let nominal = calibrate(problem, options)?;
    let mut diagnosis = Diagnosis {
        verdict: Verdict::Unobservable,
        effects: Vec::new(),
        noise: Vec::new(),
        explained: None,
        candidates: Vec::new(),
        absorbed: Vec::new(),
        not_testable: Vec::new(),
        locations: Vec::new(),
        search: None,
        nominal,
    };
    if !diagnosis.nominal.is_sound() {
        return Ok(diagnosis);
    }
    let (problem, fit) = (diagnosis.nominal.problem.clone(), diagnosis.nominal.fit.clone());
    let Some(search) = search(Fitted { recipes, problem, fit }, wanted, options)? else {
        return Ok(diagnosis);
    };
    (diagnosis.verdict, diagnosis.effects) = verdict::verdict(&search);
    if let Some(stage) = search.stages.get(diagnosis.effects.len())
        && matches!(diagnosis.verdict, Verdict::Explained | Verdict::ShapeDiffers)
    {
        diagnosis.noise.clone_from(&stage.noise_found.effects);
        let Fitted { problem, fit, .. } = stage.fitted.clone();
        diagnosis.explained = Some(finish(problem, fit, Vec::new(), Vec::new())?);
    }
    if let Some(first) = search.stages.first() {
        diagnosis.candidates = verdict::ranked(first);
        (diagnosis.absorbed, diagnosis.not_testable) = verdict::silent(first);
        diagnosis.locations = verdict::locations(first);
    }
    diagnosis.search = Some(search);
    Ok(diagnosis)
}
