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
//! | [`power`] | what a design could see, before any data |

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
use crate::estimate::calibrate::{Calibration, calibrate, finish};
use crate::estimate::contradicted::{Contradicted, contradicted};

use fitted::Fitted;
use found::{Location, Lost, NoiseEffect, Ranked};
use gap::holdout::{HoldoutError, holdout};
use gap::steps::Steps;
use gap::{Gap, floor, gap};
use gross::codes::without_codes;
use gross::settle::{settled, without_lost, without_spoiling};
use gross::spikes::without_spikes;
use library::candidates::{NotTestable, Wanted};
use library::off;
use search::{Adopted, Search, search};
use stage::Stage;
use verdict::alone::without_alone;
use verdict::hidden::{Hidden, hidden};
use verdict::silent::{Absorbed, silent};
use verdict::{Answer, Verdict, Why};

/// The answer.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The joint estimate with the nominal model.
    pub nominal: Calibration,
    /// The verdict.
    pub verdict: Verdict,
    /// The effects that it names, in order of adoption.
    pub effects: Vec<Adopted>,
    /// Where it is *unknown*, why, and which effects would have been named but for that.
    pub why: Option<(Why, Vec<String>)>,
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
    /// The effect nearest to what is there, where nothing in the library explains it.
    pub nearest: Option<Ranked>,
    /// Effects that are beyond chance in what is left, but too small to be declared.
    pub suspected: Vec<String>,
    /// How far the gap shrinks with the named effects.
    pub gap: Option<Gap>,
    /// rms that the noise alone gives, by measurand, where nothing in the library explains the gap.
    pub floor: Option<Vec<(String, f64)>>,
    /// What could still hide, largest first.
    pub hidden: Vec<Hidden>,
    /// Stretches of lost samples; they are left out of everything but the first fit.
    pub lost: Vec<Lost>,
    /// The delays of the nominal model with all readings and without those that are left out; empty if
    /// none are.
    pub delays: Vec<Twice>,
    /// Stated values that the readings contradict with the named effects in the model, farthest first.
    pub contradicted: Vec<Contradicted>,
    /// The search, for those who want to know more; `None` where there was none.
    pub search: Option<Search>,
}

/// A delay with all readings and without those that are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Twice {
    /// Its name.
    pub name: String,
    /// The setup or run.
    pub of: Option<String>,
    /// With all readings (s).
    pub with: f64,
    /// Without those left out (s).
    pub without: f64,
    /// Standard uncertainty without them (s).
    pub sigma: Option<f64>,
}

/// The delays with and without what is left out, with the same noise.
fn twice(whole: &Calibration, stage: &Stage, options: &Options) -> Result<Vec<Twice>, FitError> {
    let Fitted { problem, fit, recipes } = stage.fitted.clone();
    let mut parts = problem.parts.clone();
    for (part, given) in parts.iter_mut().zip(&whole.problem.parts) {
        part.runs.clone_from(&given.runs);
    }
    let with = Fitted { recipes, problem: Problem::new(parts), fit: fit.clone() }.again(options)?;
    // Gross readings may keep the fit of all from settling: then it has no delays.
    if !with.is_sound() {
        return Ok(Vec::new());
    }
    let without = finish(problem, fit, Vec::new(), Vec::new())?.estimates();
    let with = finish(with.problem, with.fit, Vec::new(), Vec::new())?.estimates();
    let delays = without.into_iter().filter(|one| one.name.ends_with(".delay") && !one.fixed);
    let pairs = delays.filter_map(|one| {
        let same = with.iter().find(|other| other.name == one.name && other.of == one.of)?;
        let (with, without) = (same.value?, one.value?);
        Some(Twice { name: one.name, of: one.of, with, without, sigma: one.sigma })
    });
    Ok(pairs.collect())
}

/// The stated values that readings contradict, as a stage has them: those of the nominal model.
fn beside_readings(stage: &Stage, nominal: &Calibration) -> Result<Vec<Contradicted>, FitError> {
    let Fitted { problem, fit, .. } = stage.fitted.clone();
    let mut found = contradicted(&finish(problem, fit, Vec::new(), Vec::new())?);
    let own = &nominal.problem.layout.instances;
    found.retain(|one| own.iter().any(|instance| instance.name == one.parameter));
    Ok(found)
}

/// Whether named effects fail on the readings that they were not fitted to: what they take off there is
/// below a quarter of what they take off where they were fitted, by more than chance does. A value that
/// is learnt from half of a run costs twice there what it costs with all readings.
fn is_refuted(gap: &Gap, effects: &[Adopted]) -> bool {
    gap.closed.is_some() && gap.held_out_drop < least_drop(gap.lambda.powi(2), degrees(effects))
}

/// The degrees of freedom of some effects together.
fn degrees(effects: &[Adopted]) -> usize {
    effects.iter().map(|one| one.score.degrees).sum()
}

/// The least drop on held-out readings of effects with so many values that take so much off where they
/// were fitted.
fn least_drop(learnt: f64, degrees: usize) -> f64 {
    0.25 * learnt - 2.0 * degrees as f64 - REFUTED * 2.0 * learnt.sqrt()
}

/// Standard deviations by which a held-out drop must be too small.
const REFUTED: f64 = 3.0;

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
    let (nominal, mut gross) = without_codes(whole.clone(), options)?;
    let (nominal, unsettling) = settled(nominal, options)?;
    gross.extend(unsettling);
    let (nominal, lost) = without_lost(nominal, options)?;
    let (nominal, spikes) = without_spikes(nominal, options)?;
    gross.extend(spikes);
    let (nominal, wrong) = without_spoiling(nominal, options)?;
    gross.extend(wrong);
    let mut diagnosis = Diagnosis {
        verdict: Verdict::Unobservable,
        effects: Vec::new(),
        why: None,
        noise: Vec::new(),
        explained: None,
        candidates: Vec::new(),
        absorbed: Vec::new(),
        not_testable: Vec::new(),
        locations: Vec::new(),
        nearest: None,
        suspected: Vec::new(),
        gap: None,
        floor: None,
        hidden: Vec::new(),
        contradicted: Vec::new(),
        search: None,
        lost,
        delays: Vec::new(),
        nominal,
    };
    if !diagnosis.nominal.is_sound() {
        return Ok(diagnosis);
    }
    let (problem, fit) = (diagnosis.nominal.problem.clone(), diagnosis.nominal.fit.clone());
    let fitted = Fitted { recipes, problem, fit };
    let never_off = off::never_off(&fitted, wanted);
    let mut wanted = wanted.clone();
    wanted.without.extend(never_off.iter().map(|one| one.name.clone()));
    let aside = (&diagnosis.lost[..], &gross);
    let Some(mut search) = search(fitted.clone(), aside, &wanted, options)? else {
        return Ok(diagnosis);
    };
    if let Some((nominal, found)) = without_alone(&search, &fitted, aside, &wanted, options)? {
        (diagnosis.nominal, search) = (nominal, found);
    }
    let Answer { verdict, effects, why } = verdict::verdict(&search);
    (diagnosis.verdict, diagnosis.effects, diagnosis.why) = (verdict, effects, why);
    if let Some(stage) = search.stages.get(diagnosis.effects.len())
        && matches!(diagnosis.verdict, Verdict::Explained | Verdict::ShapeDiffers)
    {
        diagnosis.noise.clone_from(&stage.noise_found.effects);
        if !diagnosis.effects.is_empty() {
            let models = Steps::of(&stage.fitted, &diagnosis.effects, options)?;
            let in_data = diagnosis.effects.iter().all(|one| one.evidence() == "data");
            let (memory, left) = (stage.noise_found.memory, verdict::leftover(stage));
            let degrees = degrees(&diagnosis.effects);
            diagnosis.gap = Some(gap(&models, degrees, left, memory, in_data));
        }
        let Fitted { problem, fit, .. } = stage.fitted.clone();
        diagnosis.explained = Some(finish(problem, fit, Vec::new(), Vec::new())?);
        if diagnosis.gap.as_ref().is_some_and(|gap| is_refuted(gap, &diagnosis.effects)) {
            let effects = diagnosis.effects.drain(..).map(|one| one.candidate.name);
            diagnosis.why = Some((Why::NotBorneOut, effects.collect()));
            diagnosis.verdict = Verdict::Unknown;
            diagnosis.noise.clear();
            (diagnosis.explained, diagnosis.gap) = (None, None);
        }
    }
    if let Some(stage) = search.stages.get(diagnosis.effects.len()) {
        diagnosis.contradicted = beside_readings(stage, &diagnosis.nominal)?;
        if diagnosis.verdict == Verdict::Adequate && !diagnosis.contradicted.is_empty() {
            diagnosis.verdict = Verdict::Unknown;
            diagnosis.why = Some((Why::NoneFits, Vec::new()));
        }
    }
    let is_apart = matches!(&diagnosis.why, Some((Why::RunsApart, _)));
    if let Some(first) = search.stages.first() {
        diagnosis.candidates = verdict::ranked(first);
        (diagnosis.absorbed, diagnosis.not_testable) = silent(first);
        diagnosis.not_testable.extend(never_off);
        diagnosis.not_testable.sort_by(|a, b| a.name.cmp(&b.name));
        // Which runs are apart is judged anew with each effect.
        let stage = search.stages.last().filter(|_| is_apart).unwrap_or(first);
        diagnosis.locations = verdict::locations(stage);
        if diagnosis.verdict == Verdict::Unknown {
            let stated = verdict::of_stated(stage, &diagnosis.contradicted);
            diagnosis.locations = verdict::beside(stated, diagnosis.locations);
        }
    }
    if let Some(first) = search.stages.first()
        && (!diagnosis.lost.is_empty() || !first.noise_found.left_out.is_empty())
    {
        diagnosis.delays = twice(&whole, first, options)?;
    }
    if diagnosis.verdict == Verdict::Unknown {
        let by_share = |a: &&Ranked, b: &&Ranked| a.share.total_cmp(&b.share);
        // Of what has no place shares are of no account.
        diagnosis.nearest = if diagnosis.locations.is_empty() {
            diagnosis.candidates.first().cloned()
        } else {
            diagnosis.candidates.iter().max_by(by_share).cloned()
        };
        if let Some(displaced) = verdict::displaced(&search) {
            diagnosis.locations.clone_from(&displaced.places);
            diagnosis.nearest = Some(displaced.nearest());
            // The walk that stands for them leaves nothing to be explained, and is no single cause.
            for one in &mut diagnosis.candidates {
                (one.share, one.probability) = (0.0, 0.0);
            }
        }
        let is_clear =
            |stage: Option<&Stage>| stage.is_some_and(|one| one.blocks_found().is_empty());
        if is_apart && is_clear(search.stages.last()) {
            // Those runs are left out: nothing is there to be near to, or even to have a share of.
            diagnosis.nearest = None;
            if is_clear(search.stages.first()) {
                for one in &mut diagnosis.candidates {
                    (one.share, one.probability) = (0.0, 0.0);
                }
            }
        }
        diagnosis.floor = search.stages.first().map(|stage| floor(&stage.fitted));
    } else if let Some(stage) = search.stages.get(diagnosis.effects.len()) {
        diagnosis.hidden = hidden(stage);
        let name = |number: usize| stage.candidates[number].name.clone();
        let named = |name: &String| diagnosis.effects.iter().any(|one| one.aliases.contains(name));
        // What passes its test, but cannot be fitted, is no less suspect.
        let unfitted = if search.adopted.is_empty() { stage.declared() } else { Vec::new() };
        let suspected = unfitted.into_iter().chain(stage.suspected()).map(name);
        diagnosis.suspected = suspected.filter(|name| !named(name)).collect();
    }
    diagnosis.search = Some(search);
    Ok(diagnosis)
}

/// Judges how far the gap shrinks on a campaign that the fit never saw; without named effects nothing
/// changes.
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

#[cfg(test)]
mod tests {
    use super::least_drop;

    #[test]
    fn only_a_clear_failure_on_held_out_readings_refutes() {
        // Large effects of one value must show there; small ones, and those with a value for each of forty
        // runs, may even do harm.
        assert!(least_drop(2500.0, 1) > 300.0);
        assert!(least_drop(64.0, 1) < 0.0 && least_drop(144.0, 40) < -100.0);
        assert!(least_drop(144.0, 12) > -172.0, "a slip that a clock's rate does not explain");
    }
}
