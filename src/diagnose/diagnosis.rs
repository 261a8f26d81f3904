//! The answer as data, and how it is put together from what was found.
//!
//! It looks for nothing itself.

use crate::engine::open::Recipe;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, finish};
use crate::estimate::contradicted::{Contradicted, contradicted};

use super::fitted::Fitted;
use super::found::{Location, Lost, NoiseEffect, Ranked};
use super::gap::refuted::{degrees, is_refuted};
use super::gap::steps::Steps;
use super::gap::{Gap, floor, gap};
use super::gross::misstated::Misstated;
use super::gross::twice::Twice;
use super::library::candidate::NotTestable;
use super::library::place::Place;
use super::library::wanted::Wanted;
use super::search::absorbed::alike_by_square;
use super::search::probability::{beside_walks, is_unknown, of_causes};
use super::search::{Adopted, Search};
use super::stage::Stage;
use super::verdict::answer::{Answer, Verdict, Why};
use super::verdict::apart::displaced;
use super::verdict::by_sense::{BySense, by_sense};
use super::verdict::hidden::{Hidden, hidden};
use super::verdict::locations::{beside, led_by, likeliest, locations, of_stated};
use super::verdict::member::{MemberUncertainty, members};
use super::verdict::moment::Changed;
use super::verdict::ranked::ranked;
use super::verdict::ringing::ringing;
use super::verdict::silent::{Absorbed, silent};
use super::verdict::{leftover, verdict};

/// The answer.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The joint estimate with the nominal model.
    pub nominal: Calibration,
    /// The verdict.
    pub verdict: Verdict,
    /// The effects that it names, in order of adoption.
    pub effects: Vec<Adopted>,
    /// How well the members of families among them are known.
    pub members: Vec<MemberUncertainty>,
    /// Where it is *unknown*, why, and which effects would have been named but for that.
    pub why: Option<(Why, Vec<String>)>,
    /// The effects on the noise that it names.
    pub noise: Vec<NoiseEffect>,
    /// The joint estimate with those effects; `None` without any.
    pub explained: Option<Calibration>,
    /// All testable effects, best first.
    pub candidates: Vec<Ranked>,
    /// The probabilities of nothing, of one effect of the library and of unknown structure, if one
    /// of them is all that is there; `None` where that is no question.
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
    /// The delays of the nominal model with all readings and without those that are left out; empty
    /// if none are.
    pub delays: Vec<Twice>,
    /// Stated values that the readings contradict with the named effects in the model, farthest
    /// first.
    pub contradicted: Vec<Contradicted>,
    /// What rings in what the named effects leave.
    pub rings: Option<Location>,
    /// What changed in the course of a run, if that is all that is there; each of them does for it.
    pub changes: Vec<Location>,
    /// What goes otherwise there than back, where that was looked for and is there.
    pub(super) by_sense: Option<BySense>,
    /// The search, for those who want to know more; `None` where there was none.
    pub search: Option<Search>,
}

impl Diagnosis {
    /// Of a nominal model alone.
    pub(super) fn unobservable(nominal: Calibration, lost: Vec<Lost>) -> Self {
        Self {
            nominal,
            verdict: Verdict::Unobservable,
            effects: Vec::new(),
            members: Vec::new(),
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
            by_sense: None,
            search: None,
        }
    }

    /// Of a value that is stated wrong altogether: beside it nothing else can be judged.
    pub(super) fn of_misstated(
        whole: Calibration,
        misstated: Misstated,
        recipes: Vec<Recipe>,
    ) -> Self {
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

    /// The verdict where something changed in the course of a run, and the search that belongs to
    /// it: what was found without it, in the noise above all, is no more than that.
    pub(super) fn name_no_effect(&mut self, changed: Changed, search: Search) -> Search {
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

    /// The verdict with what it names, which must stand on readings that it was not fitted to, and
    /// beside what is stated.
    pub(super) fn decide(&mut self, search: &Search, options: &Options) -> Result<(), FitError> {
        let Answer { verdict, effects, why } = verdict(search);
        (self.verdict, self.effects, self.why) = (verdict, effects, why);
        if let Some(stage) = search.stages.get(self.effects.len())
            && matches!(self.verdict, Verdict::Explained | Verdict::ShapeDiffers)
        {
            self.noise.clone_from(&stage.noise_found.effects);
            if !self.effects.is_empty() {
                let models = Steps::of(&stage.fitted, &self.effects, options)?;
                let in_data = self.effects.iter().all(|one| one.evidence() == "data");
                let (memory, left) = (stage.noise_found.memory, leftover(stage));
                let degrees = degrees(&self.effects);
                self.gap = Some(gap(&models, degrees, left, memory, in_data));
            }
            let Fitted { problem, fit, .. } = stage.fitted.clone();
            self.explained = Some(finish(problem, fit, Vec::new(), Vec::new())?);
            if self.gap.as_ref().is_some_and(|gap| is_refuted(gap, &self.effects)) {
                self.name_none(Why::NotBorneOut);
            }
        }
        if let Some(stage) = search.stages.get(self.effects.len()) {
            self.members = members(stage, &self.effects, options)?;
            self.tell_absorbed_aliases(search, stage, options)?;
            self.contradicted = beside_readings(stage, &self.nominal)?;
            if self.rests_on_stated_values() {
                // The effects take up what the stated value does, and nothing is left of it.
                let beside = std::mem::take(&mut self.contradicted);
                let is_new = |one: &Contradicted| !beside.iter().any(|own| own.is_same(one));
                let hidden = contradicted(&self.nominal).into_iter().filter(is_new);
                self.contradicted = hidden.collect();
                self.contradicted.extend(beside);
            }
            if self.verdict == Verdict::Adequate && !self.contradicted.is_empty() {
                self.verdict = Verdict::Unknown;
                self.why = Some((Why::NoneFits, Vec::new()));
            }
            self.listen(stage);
        }
        Ok(())
    }

    /// Whether the evidence of a named effect lies in stated values, which may be wrong instead.
    pub fn rests_on_stated_values(&self) -> bool {
        self.effects.iter().any(|one| one.evidence() == "prior")
    }

    /// Adds absorbed effects that do by their squares what a named effect of one value does to its
    /// aliases.
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
    pub(super) fn list(&mut self, search: &Search) {
        let Some(first) = search.stages.first() else { return };
        let probability = beside_walks(first);
        self.candidates = ranked(first, &probability);
        self.causes = Some(of_causes(first, &probability));
        (self.absorbed, self.not_testable) = silent(first);
    }

    /// Looks again where nothing was found, and where nothing has a name: for what goes otherwise
    /// there than back, and for what is likely although no block of it is beyond chance.
    pub(super) fn look_again(&mut self, search: &Search, wanted: &Wanted) {
        let Some(stage) = search.stages.first() else { return };
        let look = || by_sense(stage, wanted);
        match self.verdict {
            Verdict::Adequate => {
                self.by_sense = look().filter(|one| one.is_seen);
                let is_likely = || self.causes.is_some_and(|causes| is_unknown(stage, causes));
                let why = match self.by_sense {
                    Some(_) => Why::NoneFits,
                    None if is_likely() => Why::Likelier,
                    None => return,
                };
                (self.verdict, self.why) = (Verdict::Unknown, Some((why, Vec::new())));
            }
            Verdict::Unknown if self.may_lie_elsewhere() => {
                let is_beside = !stage.blocks_found().is_empty();
                self.by_sense = look().filter(|one| one.is_seen || is_beside);
                // Runs one way against those the other way may ring.
                if self.by_sense.as_ref().is_some_and(|one| one.is_seen) {
                    self.rings = None;
                }
            }
            _ => {}
        }
    }

    /// Whether what has no name may lie at a place that was not asked for.
    fn may_lie_elsewhere(&self) -> bool {
        !matches!(
            self.why,
            Some((Why::Displaced | Why::RunsApart | Why::Changed | Why::NotFitted, _))
        )
    }

    /// Takes back the names of effects.
    fn name_none(&mut self, why: Why) {
        let effects = self.effects.drain(..).map(|one| one.candidate.name);
        self.why = Some((why, effects.collect()));
        self.verdict = Verdict::Unknown;
        self.noise.clear();
        (self.explained, self.gap) = (None, None);
    }

    /// Where the gap lies.
    pub(super) fn locate(&mut self, search: &Search) {
        // Which runs are apart is judged anew with each effect.
        let stage = if self.is_apart() { search.stages.last() } else { search.stages.first() };
        let Some(stage) = stage else { return };
        self.locations = if self.is_likelier() {
            likeliest(stage, &beside_walks(stage))
        } else {
            locations(stage)
        };
        if let Some(found) = &self.by_sense {
            self.locations = led_by(stage, found, std::mem::take(&mut self.locations));
        }
        if self.verdict == Verdict::Unknown || self.rests_on_stated_values() {
            let stated = of_stated(stage, &self.contradicted);
            self.locations = beside(stated, std::mem::take(&mut self.locations));
        }
        if let Some(displaced) = displaced(search) {
            self.locations.clone_from(&displaced.places);
        }
        if self.verdict == Verdict::Unknown {
            self.locations.splice(..0, self.rings.clone());
        }
        if !self.changes.is_empty() {
            self.locations.clone_from(&self.changes);
        }
    }

    /// Whether unknown structure is likely, and no more.
    fn is_likelier(&self) -> bool {
        matches!(&self.why, Some((Why::Likelier, _)))
    }

    /// Whether something is off in a few runs.
    fn is_apart(&self) -> bool {
        matches!(&self.why, Some((Why::RunsApart, _)))
    }

    /// The effect that is nearest to what has no name.
    pub(super) fn name_nearest(&mut self, search: &Search) {
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
        if let Some(displaced) = displaced(search) {
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
        // What only the second look found is no part of any share; what it found by sense of none
        // of the probabilities.
        let is_second = is_clear(search.stages.first());
        let is_second = is_second && (self.by_sense.is_some() || self.is_likelier());
        if is_second {
            self.nearest = None;
        }
        let has_probability = has_shares && !(is_second && self.by_sense.is_some());
        let has_probability = has_probability && self.changes.is_empty();
        for one in &mut self.candidates {
            if !has_shares || is_second {
                one.share = 0.0;
            }
            if !has_probability {
                one.probability = 0.0;
            }
        }
        if !has_probability {
            self.causes = None;
        }
    }

    /// What could still be there beside the answer.
    pub(super) fn suspect(&mut self, search: &Search) {
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
