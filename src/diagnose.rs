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
use gap::refuted::{degrees, is_refuted};
use gap::steps::Steps;
use gap::{Gap, floor, gap};
use gross::codes::without_codes;
use gross::misstated::{Misstated, misstated};
use gross::settle::{settled, without_lost, without_spoiling};
use gross::spikes::without_spikes;
use gross::twice::{Twice, twice};
use library::candidates::{NotTestable, Wanted};
use library::structure::Place;
use search::absorbed::alike_by_square;
use search::probability::{beside_walks, of_causes};
use search::{Adopted, Search, search};
use stage::Stage;
use verdict::alone::without_alone;
use verdict::hidden::{Hidden, hidden};
use verdict::moment::{Changed, changed};
use verdict::ringing::ringing;
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
    /// The probabilities of nothing, of one effect of the library and of unknown structure, if one of them is all that is
    /// there; `None` where that is no question.
    pub causes: Option<[f64; 3]>,
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
    /// What rings in what the named effects leave.
    pub rings: Option<Location>,
    /// What changed in the course of a run, if that is all that is there; each of them does for it.
    pub changes: Vec<Location>,
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

impl Diagnosis {
    /// Of a nominal model alone.
    fn unobservable(nominal: Calibration, lost: Vec<Lost>) -> Self {
        Self {
            nominal,
            verdict: Verdict::Unobservable,
            effects: Vec::new(),
            why: None,
            noise: Vec::new(),
            explained: None,
            candidates: Vec::new(),
            causes: None,
            absorbed: Vec::new(),
            not_testable: Vec::new(),
            locations: Vec::new(),
            nearest: None,
            suspected: Vec::new(),
            gap: None,
            floor: None,
            hidden: Vec::new(),
            lost,
            delays: Vec::new(),
            contradicted: Vec::new(),
            rings: None,
            changes: Vec::new(),
            search: None,
        }
    }

    /// Of a value that is stated wrong altogether: beside it nothing else can be judged.
    fn of_misstated(whole: Calibration, misstated: Misstated, recipes: Vec<Recipe>) -> Self {
        let Misstated { contradicted, without } = misstated;
        let Calibration { problem, fit, .. } = without;
        let place = Place::of_stated(&contradicted.parameter, contradicted.estimate.of.as_deref());
        Self {
            verdict: Verdict::Unknown,
            why: Some((Why::NoneFits, Vec::new())),
            locations: vec![Location { place, share: 1.0 }],
            floor: Some(floor(&Fitted { recipes, problem, fit })),
            contradicted: vec![contradicted],
            ..Self::unobservable(whole, Vec::new())
        }
    }

    /// The verdict where something changed in the course of a run, and the search that belongs to it: what was found
    /// without it, in the noise above all, is no more than that.
    fn name_no_effect(&mut self, changed: Changed, search: Search) -> Search {
        let Changed { places, effects, stage, nominal } = changed;
        let is_alone = effects.is_empty();
        self.verdict = Verdict::Unknown;
        self.why = Some((Why::Changed, effects));
        self.changes = places;
        if let Some(nominal) = nominal {
            self.nominal = nominal;
        }
        if is_alone { Search { stages: vec![stage], adopted: Vec::new() } } else { search }
    }

    /// The verdict with what it names, which must stand on readings that it was not fitted to, and beside what is
    /// stated.
    fn decide(&mut self, search: &Search, options: &Options) -> Result<(), FitError> {
        let Answer { verdict, effects, why } = verdict::verdict(search);
        (self.verdict, self.effects, self.why) = (verdict, effects, why);
        if let Some(stage) = search.stages.get(self.effects.len())
            && matches!(self.verdict, Verdict::Explained | Verdict::ShapeDiffers)
        {
            self.noise.clone_from(&stage.noise_found.effects);
            if !self.effects.is_empty() {
                let models = Steps::of(&stage.fitted, &self.effects, options)?;
                let in_data = self.effects.iter().all(|one| one.evidence() == "data");
                let (memory, left) = (stage.noise_found.memory, verdict::leftover(stage));
                let degrees = degrees(&self.effects);
                self.gap = Some(gap(&models, degrees, left, memory, in_data));
            }
            let Fitted { problem, fit, .. } = stage.fitted.clone();
            self.explained = Some(finish(problem, fit, Vec::new(), Vec::new())?);
            if self.gap.as_ref().is_some_and(|gap| is_refuted(gap, &self.effects)) {
                let effects = self.effects.drain(..).map(|one| one.candidate.name);
                self.why = Some((Why::NotBorneOut, effects.collect()));
                self.verdict = Verdict::Unknown;
                self.noise.clear();
                (self.explained, self.gap) = (None, None);
            }
        }
        if let Some(stage) = search.stages.get(self.effects.len()) {
            self.tell_absorbed_aliases(search, stage, options)?;
            self.contradicted = beside_readings(stage, &self.nominal)?;
            if self.verdict == Verdict::Adequate && !self.contradicted.is_empty() {
                self.verdict = Verdict::Unknown;
                self.why = Some((Why::NoneFits, Vec::new()));
            }
            self.listen(stage);
        }
        Ok(())
    }

    /// Adds absorbed effects that do by their squares what a named effect of one value does to its aliases.
    fn tell_absorbed_aliases(
        &mut self,
        search: &Search,
        stage: &Stage,
        options: &Options,
    ) -> Result<(), FitError> {
        let Some(first) = search.stages.first() else { return Ok(()) };
        for one in self.effects.iter_mut().filter(|one| one.score.degrees == 1) {
            let without = stage.fitted.without(&[&one.candidate.selected], options)?;
            let gain = without.cost() - stage.fitted.cost();
            let alike = alike_by_square(first, &without, gain, options)?;
            one.aliases.extend(alike.into_iter().map(|(name, _)| name));
        }
        Ok(())
    }

    /// Takes back that what is left looks like noise where something rings in it.
    fn listen(&mut self, stage: &Stage) {
        let is_noise = matches!(self.verdict, Verdict::Adequate | Verdict::Explained);
        let Some(ringing) = is_noise.then(|| ringing(stage)).flatten() else { return };
        if let Some(gap) = &mut self.gap {
            gap.leftover = ringing.gain;
            self.verdict = Verdict::ShapeDiffers;
        } else {
            self.verdict = Verdict::Unknown;
            self.why = Some((Why::NoneFits, Vec::new()));
            self.noise.clear();
            self.explained = None;
        }
        self.rings = Some(Location { place: ringing.place, share: 1.0 });
    }

    /// What could be tested against the nominal model, best first, and what could not.
    fn list(&mut self, search: &Search) {
        let Some(first) = search.stages.first() else { return };
        let probability = beside_walks(first);
        self.candidates = verdict::ranked(first, &probability);
        self.causes = Some(of_causes(first, &probability));
        (self.absorbed, self.not_testable) = silent(first);
    }

    /// Where the gap lies.
    fn locate(&mut self, search: &Search) {
        // Which runs are apart is judged anew with each effect.
        let stage = if self.is_apart() { search.stages.last() } else { search.stages.first() };
        let Some(stage) = stage else { return };
        self.locations = verdict::locations(stage);
        if self.verdict == Verdict::Unknown {
            let stated = verdict::of_stated(stage, &self.contradicted);
            self.locations = verdict::beside(stated, std::mem::take(&mut self.locations));
        }
        if let Some(displaced) = verdict::displaced(search) {
            self.locations.clone_from(&displaced.places);
        }
        if self.verdict == Verdict::Unknown {
            self.locations.splice(..0, self.rings.clone());
        }
        if !self.changes.is_empty() {
            self.locations.clone_from(&self.changes);
        }
    }

    /// Whether something is off in a few runs.
    fn is_apart(&self) -> bool {
        matches!(&self.why, Some((Why::RunsApart, _)))
    }

    /// The effect that is nearest to what has no name.
    fn name_nearest(&mut self, search: &Search) {
        let by_share = |a: &&Ranked, b: &&Ranked| a.share.total_cmp(&b.share);
        // Of what has no place shares are of no account.
        self.nearest = if self.locations.is_empty() {
            self.candidates.first().cloned()
        } else {
            self.candidates.iter().max_by(by_share).cloned()
        };
        let is_clear =
            |stage: Option<&Stage>| stage.is_some_and(|one| one.blocks_found().is_empty());
        let mut has_shares = true;
        if let Some(displaced) = verdict::displaced(search) {
            self.nearest = Some(displaced.nearest());
            // The walk that stands for them leaves nothing to be explained, and is no single cause.
            has_shares = false;
        }
        if self.is_apart() && is_clear(search.stages.last()) {
            // Those runs are left out: nothing is there to be near to, or even to have a share of.
            self.nearest = None;
            has_shares &= !is_clear(search.stages.first());
        }
        let is_beside = !self.changes.is_empty() && is_clear(search.stages.first());
        if self.rings.is_some() || is_beside {
            self.nearest = None;
            has_shares = false;
        }
        for one in &mut self.candidates {
            if !has_shares {
                one.share = 0.0;
            }
            if !has_shares || !self.changes.is_empty() {
                one.probability = 0.0;
            }
        }
        if !has_shares || !self.changes.is_empty() {
            self.causes = None;
        }
    }

    /// What could still be there beside the answer.
    fn suspect(&mut self, search: &Search) {
        let Some(stage) = search.stages.get(self.effects.len()) else { return };
        self.hidden = hidden(stage);
        let name = |number: usize| stage.candidates[number].name.clone();
        let named = |name: &String| self.effects.iter().any(|one| one.aliases.contains(name));
        // What passes its test, but cannot be fitted, is no less suspect.
        let unfitted = if search.adopted.is_empty() { stage.declared() } else { Vec::new() };
        let suspected = unfitted.into_iter().chain(stage.suspected()).map(name);
        self.suspected = suspected.filter(|name| !named(name)).collect();
    }
}

/// The stated values that readings contradict, as a stage has them: those of the nominal model.
fn beside_readings(stage: &Stage, nominal: &Calibration) -> Result<Vec<Contradicted>, FitError> {
    let Fitted { problem, fit, .. } = stage.fitted.clone();
    let mut found = contradicted(&finish(problem, fit, Vec::new(), Vec::new())?);
    let own = &nominal.problem.layout.instances;
    found.retain(|one| own.iter().any(|instance| instance.name == one.parameter));
    Ok(found)
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
