//! The verdict: what the search found, as an answer.
//!
//! | file | answers |
//! |---|---|
//! | [`mod@silent`] | what shows in no reading, and why |
//! | [`mod@hidden`] | what could still hide |
//! | `moment` | what changes in the course of a run |
//! | `turning` | which oscillations go round with what turns |
//! | `ringing` | what oscillates in what is left, and is no steady wave |
//! | `alone` | the same without the readings of a few runs that are off there alone |

pub(super) mod alone;
pub mod hidden;
pub(super) mod moment;
pub(super) mod ringing;
pub mod silent;
mod turning;

use crate::estimate::contradicted::Contradicted;

use super::evidence::Entry;
use super::evidence::score::Score;
use super::evidence::thresholds::{LEAST_PROBABLE, NAMED};
use super::found::{Apart, Displaced, Location, Noise, Ranked};
use super::gross::wild::RUNS_APART;
use super::library::structure::Place;
use super::search::{Adopted, Search};
use super::stage::Stage;
use turning::goes_round;

/// Places shown at most.
const PLACES: usize = 5;
/// A block that explains less of the best is no place of its own.
const LEAST_SHARE: f64 = 0.2;

/// What is off in a few runs is what there is where it explains this part of what the best block does.
const RUNS_LEAD: f64 = 0.8;

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Nothing: the model fits.
    Adequate,
    /// Effects of the library explain everything that can be seen.
    Explained,
    /// Effects explain nearly everything, but their form does not fit.
    ShapeDiffers,
    /// Something is there, and nothing in the library explains it.
    Unknown,
    /// The nominal parameters are not determined.
    Unobservable,
}

impl Verdict {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::Explained => "explained",
            Self::ShapeDiffers => "shape_differs",
            Self::Unknown => "unknown",
            Self::Unobservable => "unobservable",
        }
    }
}

/// Why what is there has no name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Why {
    /// No effect passes its test, or what does leaves something.
    NoneFits,
    /// The model with an effect that passes its test cannot be fitted.
    NotFitted,
    /// Effects leave nothing, but hardly are the cause.
    Improbable,
    /// Effects leave nothing, but something simpler or likelier that nobody wrote down leaves no more.
    Imitated,
    /// Effects explain it where they are fitted, but not on readings that they are not fitted to.
    NotBorneOut,
    /// A reading is off in a few runs.
    RunsApart,
    /// The rig was displaced between runs, or a reading counts anew from some run on.
    Displaced,
    /// Something changed in the course of a run.
    Changed,
}

impl Why {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::NoneFits => "none_fits",
            Self::NotFitted => "not_fitted",
            Self::Improbable => "improbable",
            Self::Imitated => "imitated",
            Self::NotBorneOut => "not_borne_out",
            Self::RunsApart => "runs_apart",
            Self::Displaced => "displaced",
            Self::Changed => "changed",
        }
    }
}

/// A verdict with what belongs to it.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The verdict.
    pub verdict: Verdict,
    /// The effects that it names.
    pub effects: Vec<Adopted>,
    /// Where it is *unknown*, why, and which effects would have been named but for that.
    pub why: Option<(Why, Vec<String>)>,
}

impl Answer {
    fn known(verdict: Verdict, effects: Vec<Adopted>) -> Self {
        Self { verdict, effects, why: None }
    }

    fn unknown(why: Why, effects: Vec<String>) -> Self {
        Self { verdict: Verdict::Unknown, effects: Vec::new(), why: Some((why, effects)) }
    }
}

/// The verdict of a search.
pub fn verdict(search: &Search) -> Answer {
    let Some(last) = search.stages.last() else {
        return Answer::known(Verdict::Unobservable, Vec::new());
    };
    let left = last.blocks_found();
    let named = || if left.is_empty() && search.convinces() { search.names() } else { Vec::new() };
    if displaced(search).is_some() {
        return Answer::unknown(Why::Displaced, named());
    }
    if !apart(search).is_empty() {
        // Beside effects that do not fit, what they leave is soon off in some run.
        return if has_more_than_runs(last) {
            Answer::unknown(Why::NoneFits, Vec::new())
        } else {
            Answer::unknown(Why::RunsApart, named())
        };
    }
    if search.adopted.is_empty() {
        let noise = !last.noise_found.effects.is_empty();
        let unfitted = last.declared().first().map(|n| last.candidates[*n].name.clone());
        return match (left.is_empty(), noise) {
            (false, _) if unfitted.is_some() => {
                Answer::unknown(Why::NotFitted, unfitted.into_iter().collect())
            }
            (false, _) => Answer::unknown(Why::NoneFits, Vec::new()),
            (true, true) => Answer::known(Verdict::Explained, Vec::new()),
            (true, false) => Answer::known(Verdict::Adequate, Vec::new()),
        };
    }
    if left.is_empty() && search.convinces() {
        let mut adopted = search.adopted.clone();
        against_effects(adopted.split_last_mut().map_or(&mut [], |(_, before)| before));
        return Answer::known(Verdict::Explained, adopted);
    }
    if left.is_empty() && !search.is_probable() {
        return Answer::unknown(Why::Improbable, search.names());
    }
    // One effect that leaves nothing has no other form.
    if left.is_empty() && search.adopted.len() == 1 {
        return Answer::unknown(Why::Imitated, search.names());
    }
    // Effects may still be causes although something of another form is left.
    let second = &search.stages[1];
    let gain = search.adopted[0].gain;
    let share = gain / (gain + leftover(second));
    if share >= NAMED && search.adopted[0].among_effects >= LEAST_PROBABLE {
        let further = (1..search.adopted.len()).take_while(|number| is_a_cause(search, *number));
        let mut adopted = search.adopted[..=further.count()].to_vec();
        against_effects(&mut adopted);
        return Answer::known(Verdict::ShapeDiffers, adopted);
    }
    if left.is_empty() {
        return Answer::unknown(Why::Imitated, search.names());
    }
    Answer::unknown(Why::NoneFits, Vec::new())
}

/// In how many runs at most what is there may be off alone, of the nominal model and beside the effects that were
/// found: in none where an effect explains it by itself, or where something is known of runs already; where several
/// effects do, one run may do as much by itself.
pub fn runs_in_doubt(search: &Search) -> (usize, usize) {
    let answer = verdict(search);
    // Readings of which most are wild in a run may be so in a part of it.
    let noise = search.stages.last().map(|last| &last.noise_found);
    let is_known =
        displaced(search).is_some() || noise.is_some_and(|noise| !noise.apart.is_empty());
    match (answer.verdict, answer.effects.len()) {
        _ if is_known => (0, 0),
        (Verdict::Explained, 1) => (0, 0),
        (Verdict::Explained, 2..) => (1, 0),
        (Verdict::ShapeDiffers, _) => (0, RUNS_APART),
        _ => (RUNS_APART, RUNS_APART),
    }
}

/// Whether nothing is left but noise, beside effects if they are probable.
pub fn is_clear(search: &Search) -> bool {
    let clear = search.stages.last().is_some_and(|last| last.blocks_found().is_empty());
    let convinces = search.adopted.is_empty() || search.convinces();
    clear && convinces && displaced(search).is_none()
}

/// What displaced the rig: it is in the model as a walk, which soaks it up, but it is none.
pub fn displaced(search: &Search) -> Option<&Displaced> {
    search.stages.last()?.noise_found.displaced.as_ref()
}

/// What is off in a few runs, as the last stage sees it: first what is left out.
pub fn apart(search: &Search) -> Vec<&Place> {
    search.stages.last().map_or_else(Vec::new, |last| {
        let Noise { left_out, apart, .. } = &last.noise_found;
        let out = left_out.runs.iter().map(|one| &one.place);
        out.chain(apart.iter().map(|one| &one.place)).collect()
    })
}

/// Whether a few runs are off, but far from all of what there is.
fn has_more_than_runs(stage: &Stage) -> bool {
    let Noise { left_out, apart, .. } = &stage.noise_found;
    let most = leftover(stage);
    let is_less = |one: &Apart| share_of_runs(stage, one, most) < RUNS_LEAD;
    left_out.runs.is_empty() && !apart.is_empty() && apart.iter().all(is_less)
}

/// What changes in a few runs explain by themselves, over the `most` that a block does; all where there is none.
fn share_of_runs(stage: &Stage, apart: &Apart, most: f64) -> f64 {
    let block = stage.candidates.iter().position(|one| one.name == apart.block);
    let Some(block) = block.filter(|_| most > 0.0) else { return 1.0 };
    let own = stage.entry(block);
    let change = |runs: &Vec<usize>| stage.evidence.tied_over(own, |run| runs.contains(&run));
    let changes: Vec<Entry> = apart.runs.iter().map(change).collect();
    let all = stage.evidence.together(&changes.iter().collect::<Vec<_>>());
    ((all.gain() - all.degrees() as f64).max(0.0) / most).min(1.0)
}

/// Of effects beside which something else was found: that they are not all is known.
fn against_effects(adopted: &mut [Adopted]) {
    for one in adopted {
        one.probability = one.among_effects;
    }
}

/// Whether an effect that was adopted after others, and leaves something, is more than an imitation of
/// what they leave: it explains as much as any block does, and more than is left then.
fn is_a_cause(search: &Search, number: usize) -> bool {
    let (Some(before), Some(after)) = (search.stages.get(number), search.stages.get(number + 1))
    else {
        return false;
    };
    // Each in units of the noise of its stage.
    let one = &search.adopted[number];
    let blocks = before.blocks_found();
    let best = blocks.iter().map(|block| before.scores[*block].gain).fold(0.0, f64::max);
    one.score.gain >= NAMED * best && one.gain > leftover(after)
}

/// What the best block still explains.
pub fn leftover(stage: &Stage) -> f64 {
    stage.blocks_found().into_iter().map(|block| squared(stage, block)).fold(0.0, f64::max)
}

/// The squared length of what a block explains.
fn squared(stage: &Stage, block: usize) -> f64 {
    stage.scores[block].lambda().powi(2)
}

/// The blocks that are told: of oscillations none that goes round with the arm, where anything else says something.
fn told(stage: &Stage) -> Vec<usize> {
    let found = with_one_oscillation(stage, stage.blocks_found());
    let goes_round = |block: &usize| stage.is_oscillation(*block) && goes_round(stage, *block);
    let (round, others): (Vec<usize>, Vec<usize>) = found.iter().partition(|one| goes_round(one));
    let is_told = |block: &usize| squared(stage, *block) >= LEAST_SHARE * leftover(stage);
    if !round.is_empty() && others.iter().any(is_told) { others } else { found }
}

/// The squared length of what the best block explains that is told.
pub fn most_told(stage: &Stage) -> f64 {
    told(stage).into_iter().map(|block| squared(stage, block)).fold(0.0, f64::max)
}

/// Where the gap lies, best first; a few runs before all else where they are what there is.
pub fn locations(stage: &Stage) -> Vec<Location> {
    let runs_lead = !has_more_than_runs(stage);
    let mut found = told(stage);
    let square = |block: &usize| squared(stage, *block);
    let most = found.iter().map(square).fold(0.0, f64::max);
    let share = |block: &usize| square(block) / most;
    let apart = &stage.noise_found.apart;
    let few = |block: &usize| {
        let name = &stage.candidates[*block].name;
        apart.iter().find(|one| runs_lead && one.block == *name)
    };
    found.sort_by(|a, b| share(b).total_cmp(&share(a)));
    // What a few runs do for comes first: other blocks say the same of all runs.
    found.sort_by_key(|block| few(block).is_none());
    found.retain(|block| few(block).is_some() || share(block) >= LEAST_SHARE);
    let blocks: Vec<&str> = found.iter().map(|one| stage.candidates[*one].name.as_str()).collect();
    let found = found.iter().filter_map(|block| {
        let own = || stage.candidates[*block].place.clone();
        let place = few(block).map(|one| one.place.clone()).or_else(own)?;
        Some(Location { place, share: share(block) })
    });
    // What is left out has no block, and what is weighed down by a level of its run may pass no test.
    let others = apart.iter().filter(|one| !runs_lead || !blocks.contains(&one.block.as_str()));
    let others = others.map(|one| Location {
        place: one.place.clone(),
        share: if runs_lead { 1.0 } else { share_of_runs(stage, one, most) },
    });
    let out = stage.noise_found.left_out.runs.iter();
    let out = out.map(|one| Location { place: one.place.clone(), share: 1.0 });
    let mut all: Vec<Location> = out.chain(others).chain(found).collect();
    if !runs_lead {
        all.retain(|one| one.share >= LEAST_SHARE);
        all.sort_by(|a, b| b.share.total_cmp(&a.share));
    }
    let mut said: Vec<String> = Vec::new();
    all.retain(|one| {
        let is_new = !said.contains(&one.place.words);
        said.push(one.place.words.clone());
        is_new
    });
    all.truncate(PLACES);
    all
}

/// Stated values that the readings contradict, as places: what the sum of squares loses without them, over
/// what it loses with the best block of a stage that is told.
pub fn of_stated(stage: &Stage, contradicted: &[Contradicted]) -> Vec<Location> {
    let most = if contradicted.is_empty() { 0.0 } else { most_told(stage) };
    let share = |one: &Contradicted| if most > 0.0 { one.gain / most } else { 1.0 };
    let place = |one: &Contradicted| Place::of_stated(&one.parameter, one.estimate.of.as_deref());
    contradicted.iter().map(|one| Location { place: place(one), share: share(one) }).collect()
}

/// Places with others, best first, the best of them with a share of 1.
pub fn beside(mut places: Vec<Location>, others: Vec<Location>) -> Vec<Location> {
    if places.is_empty() {
        return others;
    }
    places.extend(others);
    places.sort_by(|a, b| b.share.total_cmp(&a.share));
    let most = places[0].share.max(1.0);
    places.iter_mut().for_each(|one| one.share /= most);
    places.retain(|one| one.share >= LEAST_SHARE);
    places.truncate(PLACES);
    places
}

/// Blocks of which an oscillation of all readings stays only where it is less probable by chance than that of
/// any one, which goes then.
fn with_one_oscillation(stage: &Stage, mut found: Vec<usize>) -> Vec<usize> {
    let place = |block: &usize| stage.candidates[*block].place.as_ref();
    let is_of_one = |block: &usize| place(block).is_some_and(Place::is_oscillation_of_one);
    let waves: Vec<usize> =
        found.iter().copied().filter(|block| stage.is_oscillation(*block)).collect();
    let ln_p = |block: &&usize| stage.scores[**block].ln_p;
    let best = waves.iter().min_by(|a, b| ln_p(a).total_cmp(&ln_p(b)));
    let of_one = best.is_some_and(is_of_one);
    found.retain(|block| !waves.contains(block) || is_of_one(block) == of_one);
    found
}

/// All testable effects, best first; one that may be there instead of a walk as it is without that.
/// `probability` is that of each candidate.
pub fn ranked(stage: &Stage, probability: &[f64]) -> Vec<Ranked> {
    let blocks = stage.blocks_found();
    let share = |number: usize, score: &Score| {
        let own = score.lambda().powi(2);
        let entry = stage.entry(number);
        let left = blocks.iter().map(|block| {
            let (gain, degrees) = stage.evidence.beyond(entry, stage.entry(*block));
            gain - degrees as f64
        });
        let left = left.fold(0.0, f64::max);
        if own > 0.0 { own / (own + left) } else { 0.0 }
    };
    let mut all: Vec<(usize, Ranked)> = (0..stage.effects)
        .filter(|n| stage.entry(*n).degrees() > 0)
        .map(|n| {
            let name = stage.candidates[n].name.clone();
            let instead = stage.noise_found.instead().find(|one| one.effect == name);
            let score = instead.map_or(stage.scores[n], |one| one.score);
            let member = stage.candidates[n].selected.member.clone();
            let (share, probability) = (share(n, &score), probability[n]);
            (n, Ranked { name, member, score, share, probability })
        })
        .collect();
    all.sort_by(|a, b| a.1.score.ln_p.total_cmp(&b.1.score.ln_p).then(a.0.cmp(&b.0)));
    all.into_iter().map(|(_, one)| one).collect()
}
