//! The verdict: what the search found, as an answer.
//!
//! | file | answers |
//! |---|---|
//! | [`answer`] | the answer in a word, and why what is there has no name |
//! | [`mod@apart`] | what is off in a few runs alone |
//! | [`mod@locations`] | where the gap lies |
//! | [`mod@ranked`] | every effect that can be tested, best first |
//! | [`member`] | how well the member of a family is known |
//! | [`mod@silent`] | what shows in no reading, and why |
//! | [`mod@hidden`] | what could still hide |
//! | `moment` | what changes in the course of a run |
//! | `turning` | which oscillations go round with what turns |
//! | `ringing` | what oscillates in what is left, and is no steady wave |
//! | `by_sense` | what goes otherwise there than back |
//! | `alone` | the same without the readings of a few runs that are off there alone |

pub(super) mod alone;
pub mod answer;
pub mod apart;
pub(super) mod by_sense;
pub mod hidden;
pub mod locations;
pub mod member;
pub(super) mod moment;
pub mod ranked;
pub(super) mod ringing;
pub mod silent;
mod turning;

use super::evidence::thresholds::{LEAST_PROBABLE, NAMED};
use super::gross::wild::RUNS_APART;
use super::search::{Adopted, Search};
use super::stage::Stage;
use answer::{Answer, Verdict, Why};
use apart::{apart, displaced, has_more_than_runs};

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

/// In how many runs at most what is there may be off alone, of the nominal model and beside the
/// effects that were found: in none where an effect explains it by itself, or where something is
/// known of runs already; where several effects do, one run may do as much by itself.
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

/// Of effects beside which something else was found: that they are not all is known.
fn against_effects(adopted: &mut [Adopted]) {
    for one in adopted {
        one.probability = one.among_effects;
    }
}

/// Whether an effect that was adopted after others, and leaves something, is more than an imitation
/// of what they leave: it explains as much as any block does, and more than is left then.
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
