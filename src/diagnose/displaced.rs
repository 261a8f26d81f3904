//! Displacements of the rig between runs, told from a walk.
//!
//! Who knocks against a tripod displaces it once. What is left of the readings then looks as if the
//! instrument wandered, and a walk that was found may be no walk: displacements before a few runs, each
//! with one value for all later runs of its setup, say the same with less. They are taken off one after
//! the other, the least probable by chance first, and paid for; where nothing of the walk is left beyond
//! [`MOST`] of them at most, and where they are far less probable by chance than the walk is likely, they
//! are what happened. No effect of the library says so: it is unknown structure with a place.
//!
//! Runs of a setup count in the order in which the campaign lists them.

use nalgebra::DVector;

use crate::engine::Problem;
use crate::engine::layout::qualified;

use super::evidence::{Entry, Evidence, Owner, Projected};
use super::score::{Score, of_gain};
use super::structure::{Of, Place};
use super::verdict::{FURTHER, Location};
use super::wander::Walk;

/// Displacements that are looked for: more are a walk.
const MOST: usize = 3;

/// Displacements that do for a walk.
#[derive(Clone, Debug)]
pub struct Displaced {
    /// Where each sits, the largest first.
    pub places: Vec<Location>,
    /// The logarithm of the walk's likelihood ratio over theirs: how much of them a walk explains.
    pub share: f64,
}

/// A walk that was found, as it is told from displacements.
pub(super) struct Suspect<'a> {
    /// The pass over the readings.
    pub(super) evidence: &'a Evidence,
    /// What is known beside the walk.
    pub(super) known: &'a [&'a Entry],
    /// The columns of the walk beyond the nominal parameters.
    pub(super) own: &'a Projected,
    /// The share of each column in the walk.
    pub(super) weights: &'a DVector<f64>,
    /// Whether a column is where the walk has come to when a run begins.
    pub(super) begins: fn(&Owner) -> bool,
    /// Logarithm of its likelihood ratio.
    pub(super) likelihood: f64,
    /// Logarithm of the share of false alarms.
    pub(super) level: f64,
}

/// A displacement before a run: its number, and what it does.
type Possible = (usize, Entry);

impl Suspect<'_> {
    /// The displacements that do for the walk, if they do.
    pub(super) fn displaced(&self, problem: &Problem) -> Option<Displaced> {
        let possible = self.possible(&problem.layout.columns.runs);
        let mut taken: Vec<&Possible> = Vec::new();
        while !self.is_all(&taken) {
            if taken.len() == MOST {
                return None;
            }
            let whole = self.beside(&taken);
            let beyond = |one| (one, self.beyond(&whole, one, possible.len()));
            let all = possible.iter().map(beyond);
            taken.push(all.min_by(|a, b| a.1.ln_p.total_cmp(&b.1.ln_p))?.0);
        }
        // What the first found were may be clear only beside the others.
        for one in taken.clone() {
            let others = without(&taken, one);
            if !others.is_empty() && self.is_all(&others) {
                taken = others;
            }
        }
        let surprise: f64 = (0..taken.len())
            .map(|n| -self.beyond(&self.beside(&taken[..n]), taken[n], possible.len()).ln_p)
            .sum();
        let gain = |one: &Possible| {
            self.beyond(&self.beside(&without(&taken, one)), one, possible.len()).gain
        };
        let found: Vec<(usize, f64)> = taken.iter().map(|one| (one.0, gain(one))).collect();
        (surprise > self.likelihood + FURTHER.ln()).then(|| Displaced {
            places: located(problem, found),
            share: self.likelihood / surprise,
        })
    }

    /// Displacements before each run but the first of its setup; `runs` begin with their setups.
    fn possible(&self, runs: &[(usize, usize)]) -> Vec<Possible> {
        let setup = |run: usize| runs[run].0;
        let from = |run: usize| {
            let later = |owner: &Owner, other: usize| {
                (self.begins)(owner) && setup(other) == setup(run) && other >= run
            };
            (run, self.evidence.tied(self.own, later))
        };
        let is_later = |run: &usize| (0..*run).any(|other| setup(other) == setup(*run));
        (0..runs.len()).filter(is_later).map(from).collect()
    }

    /// What is known and some displacements as one.
    fn beside(&self, taken: &[&Possible]) -> Entry {
        let taken = taken.iter().map(|(_, entry)| entry);
        self.evidence.together(&self.known.iter().copied().chain(taken).collect::<Vec<_>>())
    }

    /// What a displacement, one of so many, explains beyond something.
    fn beyond(&self, whole: &Entry, (_, entry): &Possible, of: usize) -> Score {
        let (gain, degrees) = self.evidence.beyond(whole, entry);
        of_gain(gain, degrees, of)
    }

    /// Whether nothing of the walk is left beyond some displacements.
    fn is_all(&self, taken: &[&Possible]) -> bool {
        let rest = Walk::beyond(self.evidence, &self.beside(taken), self.own, self.weights);
        rest.is_none_or(|rest| rest.ln_p() > self.level)
    }
}

fn without<'p>(taken: &[&'p Possible], one: &Possible) -> Vec<&'p Possible> {
    taken.iter().copied().filter(|other| other.0 != one.0).collect()
}

/// Displacements before runs, with what each explains, as places, the largest first.
fn located(problem: &Problem, mut found: Vec<(usize, f64)>) -> Vec<Location> {
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    let most = found.first().map_or(1.0, |(_, gain)| *gain);
    let names: Vec<String> = problem
        .parts
        .iter()
        .flat_map(|part| part.runs.iter().map(|run| qualified(part.label.as_deref(), &run.name)))
        .collect();
    let place = |run: usize| Place {
        of: Of::Channel("rig".to_owned()),
        covariate: "run".to_owned(),
        words: format!("a displacement of the instrument or the rig before run `{}`", names[run]),
    };
    found.iter().map(|(run, gain)| Location { place: place(*run), share: gain / most }).collect()
}
