//! What changed between runs or in the course of one, once and for all later runs of a setup, told
//! from a walk.
//!
//! Who knocks against a tripod displaces it once; an instrument that was switched off and on may
//! count from another zero. What is left of the readings then looks as if the instrument wandered,
//! and a walk that was found may be no walk: changes before a few runs, each with one value for all
//! later runs of its setup or, put right again, for one run, say the same with less; of a run in
//! whose course the rig was displaced nothing is known, and later ones have one value. Those of the
//! rig's place, and those of each block that has a value for each run and was found, are taken off
//! one after the other, the likeliest first, and paid for; where nothing of the walk is left beyond
//! three of them at most, before half of the runs at most, and where they are far likelier than the
//! walk, they are what happened, of kinds of change the likeliest. No effect of the library says
//! so: it is unknown structure with a place.

use crate::diagnose::evidence::Entry;
use crate::diagnose::evidence::score::likelihood_of_gain;
use crate::diagnose::evidence::thresholds::FURTHER;
use crate::diagnose::found::{Displaced, Location};
use crate::diagnose::library::place::Place;
use crate::engine::Problem;

use super::sequence::{Change, Span, in_order, places, spans};
use super::wandering::Wandering;

/// Displacements that are looked for: more are a walk.
const MOST: usize = 3;

/// A walk that may be displacements.
pub(super) struct Suspect<'a> {
    /// Its name.
    pub(super) name: &'a str,
    pub(super) wandering: &'a Wandering,
    /// What is known beside it.
    pub(super) known: &'a [Entry],
    /// Blocks with a value for each run that were found.
    pub(super) of_runs: &'a [(&'a Place, &'a Entry)],
    /// Logarithm of its likelihood ratio beyond that.
    pub(super) likelihood: f64,
}

/// A change, and what it does.
type Possible = (Change, Entry);

/// What may have changed: the place of the rig, or what a block says.
#[derive(Clone, Copy)]
enum Changed<'a> {
    Rig,
    Block(&'a Place, &'a Entry),
}

impl Suspect<'_> {
    /// The likeliest changes that do for the walk, if some do.
    pub(super) fn displaced(&self, problem: &Problem) -> Option<Displaced> {
        let spans = spans(problem);
        let blocks = self.of_runs.iter().map(|(place, entry)| Changed::Block(place, entry));
        std::iter::once(Changed::Rig)
            .chain(blocks)
            .filter_map(|changed| self.changes(problem, &spans, changed))
            .max_by(|a, b| a.likelihood.total_cmp(&b.likelihood))
    }

    /// The changes of one kind that do for the walk, if they do.
    fn changes(
        &self,
        problem: &Problem,
        spans: &[Span],
        changed: Changed<'_>,
    ) -> Option<Displaced> {
        let possible = self.possible(spans, changed);
        let before = possible.iter().filter(|one| matches!(one.0, Change::From(_))).count();
        let mut taken: Vec<&Possible> = Vec::new();
        loop {
            // As many as there are runs say anything.
            if taken.len() == MOST || 2 * (taken.len() + 1) > before {
                return None;
            }
            let whole = self.beside(&taken);
            let likelihood = |one| (one, self.beyond(&whole, one, possible.len()).0);
            taken.push(possible.iter().map(likelihood).max_by(|a, b| a.1.total_cmp(&b.1))?.0);
            if self.do_for_it(&taken) {
                break;
            }
        }
        // What the first found were may be clear only beside the others.
        for one in taken.clone() {
            let others = without(&taken, one);
            if !others.is_empty() && self.do_for_it(&others) {
                taken = others;
            }
        }
        let likelihood: f64 = (0..taken.len())
            .map(|n| self.beyond(&self.beside(&taken[..n]), taken[n], possible.len()).0)
            .sum();
        let gain = |one: &Possible| {
            self.beyond(&self.beside(&without(&taken, one)), one, possible.len()).1
        };
        let found: Vec<(Change, f64)> = taken.iter().map(|one| (one.0, gain(one))).collect();
        // Of which kind is chosen, too.
        let likelihood = likelihood - ((1 + self.of_runs.len()) as f64).ln();
        (likelihood > self.likelihood + FURTHER.ln()).then(|| Displaced {
            places: located(problem, changed, found),
            likelihood,
            walk: self.name.to_owned(),
            share: (self.likelihood / likelihood).max(0.0),
        })
    }

    /// Changes before each run but the first of its setup, in each but that and the last, and of
    /// the rig in the course of each.
    fn possible(&self, runs: &[Span], changed: Changed<'_>) -> Vec<Possible> {
        let places = places(&in_order(runs));
        let is_after =
            |run: usize, other: usize| runs[run].0 == runs[other].0 && places[run] > places[other];
        let acts = |wanted: &dyn Fn(usize) -> bool| match changed {
            Changed::Rig => self.wandering.displacement(wanted),
            Changed::Block(_, entry) => self.wandering.evidence.tied_over(entry, wanted),
        };
        let all = || 0..runs.len();
        let is_later = |run: &usize| all().any(|other| is_after(*run, other));
        let is_between = |run: &usize| is_later(run) && all().any(|other| is_after(other, *run));
        let before = |run| (Change::From(run), acts(&|other| other == run || is_after(other, run)));
        let within = |run| (Change::In(run), acts(&|other| other == run));
        let whole = |run| self.wandering.course_of(run);
        let during = |run: usize| {
            let later = acts(&|other| is_after(other, run));
            let both = [whole(run), later];
            (
                Change::During(run),
                self.wandering.evidence.together(&both.iter().collect::<Vec<_>>()),
            )
        };
        let moves = all().filter(|_| matches!(changed, Changed::Rig)).map(during);
        let before = all().filter(is_later).map(before);
        before.chain(all().filter(is_between).map(within)).chain(moves).collect()
    }

    /// What is known and some displacements as one.
    fn beside(&self, taken: &[&Possible]) -> Entry {
        let taken = taken.iter().map(|(_, entry)| entry);
        self.wandering.evidence.together(&self.known.iter().chain(taken).collect::<Vec<_>>())
    }

    /// Logarithm of the likelihood ratio of a displacement, one of so many, beyond something, and
    /// what it takes off the sum of squares.
    fn beyond(&self, whole: &Entry, (_, entry): &Possible, of: usize) -> (f64, f64) {
        let (gain, degrees) = self.wandering.evidence.beyond(whole, entry);
        (likelihood_of_gain(gain, degrees) - (of as f64).ln(), gain)
    }

    /// Whether nothing of the walk is left beyond some displacements.
    fn do_for_it(&self, taken: &[&Possible]) -> bool {
        self.wandering.is_gone(&self.beside(taken))
    }
}

fn without<'p>(taken: &[&'p Possible], one: &Possible) -> Vec<&'p Possible> {
    taken.iter().copied().filter(|other| other.0 != one.0).collect()
}

/// Changes, with what each explains, as places, the largest first.
fn located(
    problem: &Problem,
    changed: Changed<'_>,
    mut found: Vec<(Change, f64)>,
) -> Vec<Location> {
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    let most = found.first().map_or(1.0, |(_, gain)| *gain);
    let names = problem.run_names();
    let place = |change: Change| match (changed, change) {
        (Changed::Rig, Change::From(run)) => Place::before_run(&names[run]),
        (Changed::Rig, Change::In(run)) => Place::of_rig_in(&names[run]),
        (Changed::Rig, Change::During(run)) => Place::of_rig_during(&names[run]),
        (Changed::Block(place, _), change) => {
            place.in_runs(&change.words(&names), change.only_run(&names))
        }
    };
    let found = found.into_iter();
    found.map(|(one, gain)| Location { place: place(one), share: gain / most }).collect()
}
