//! Where the gap lies: the blocks of unknown structure that are told, what is off in a few runs,
//! and stated values that the readings contradict.

use crate::diagnose::evidence::thresholds::TIE;
use crate::diagnose::found::Location;
use crate::diagnose::library::place::Place;
use crate::diagnose::stage::Stage;
use crate::estimate::contradicted::Contradicted;

use super::apart::{has_more_than_runs, share_of_runs};
use super::by_sense::BySense;
use super::turning::goes_round;
use super::{leftover, squared};

/// Places shown at most.
const PLACES: usize = 5;
/// A block that explains less of the best is no place of its own.
const LEAST_SHARE: f64 = 0.2;

/// The blocks that are told: of oscillations none that goes round with the arm, where anything else
/// says something.
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
    // What is left out has no block, and what is weighed down by a level of its run may pass no
    // test.
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
    shown(all)
}

/// Places with what goes otherwise there than back before them, where that is far less likely by
/// chance than any block that is told.
pub(in crate::diagnose) fn led_by(
    stage: &Stage,
    found: &BySense,
    places: Vec<Location>,
) -> Vec<Location> {
    let told = told(stage);
    let least = told.iter().map(|block| stage.scores[*block].ln_p).fold(0.0, f64::min);
    if found.score.ln_p > least - TIE {
        return places;
    }
    let most = told.iter().map(|block| squared(stage, *block)).fold(0.0, f64::max);
    let own = found.score.lambda().powi(2);
    let share = if most > 0.0 { (own / most).max(1.0) } else { 1.0 };
    beside(vec![Location { place: found.place.clone(), share }], places)
}

/// The places of unknown structure that is likeliest, where no block is beyond chance by itself,
/// with what each explains over the likeliest; `probability` is that of each candidate.
pub fn likeliest(stage: &Stage, probability: &[f64]) -> Vec<Location> {
    let mut blocks: Vec<usize> = (stage.effects..stage.candidates.len()).collect();
    blocks.sort_by(|a, b| probability[*b].total_cmp(&probability[*a]));
    let best = blocks.first().map_or(0.0, |block| probability[*block]);
    blocks.retain(|block| probability[*block] > 0.0 && probability[*block] >= LEAST_SHARE * best);
    let most = blocks.first().map_or(0.0, |block| squared(stage, *block));
    let place = |block: usize| {
        let place = stage.candidates[block].place.clone()?;
        let own = squared(stage, block);
        Some(Location { place, share: if own < most { own / most } else { 1.0 } })
    };
    shown(blocks.into_iter().filter_map(place).collect())
}

/// Each place once, and not too many.
fn shown(mut all: Vec<Location>) -> Vec<Location> {
    let mut said: Vec<String> = Vec::new();
    all.retain(|one| {
        let is_new = !said.contains(&one.place.words);
        said.push(one.place.words.clone());
        is_new
    });
    all.truncate(PLACES);
    all
}

/// Stated values that the readings contradict, as places: what the sum of squares loses without
/// them, over what it loses with the best block of a stage that is told.
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

/// Blocks of which an oscillation of all readings stays only where it is less probable by chance
/// than that of any one, which goes then.
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
