//! A stage of the search: the campaigns with the effects adopted so far, fitted, and the evidence
//! of everything that is not in the model yet.

use std::collections::HashSet;
use std::sync::{Arc, OnceLock};

use nalgebra::DVector;

use crate::effect::{Family, Members};
use crate::engine::Problem;
use crate::engine::signatures::Signatures;
use crate::engine::stretches::Left;
use crate::estimate::batch::Fit;

use super::evidence::scan::{ALL_BLIND, Scanned, scan, told, with_member};
use super::evidence::score::{Score, of_gain, score};
use super::evidence::thresholds::{TIE, level};
use super::evidence::{Entry, Evidence};
use super::fitted::Fitted;
use super::found::{Apart, Noise};
use super::library::candidate::{Candidate, NotTestable};
use super::library::catalogue::{self, Made, sign};
use super::library::offer::Offer;
use super::library::place::{Of, Place};
use super::library::prior::Prior;
use super::library::wanted::Wanted;

/// Structures taken off at most before the noise is judged.
const MOST_STRUCTURES: usize = 8;

/// A fitted model with the evidence for all that is not in it.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The model.
    pub fitted: Fitted,
    /// Effects of the library, one member of each family, then blocks of unknown structure.
    pub candidates: Vec<Candidate>,
    /// Number of effects among the candidates.
    pub effects: usize,
    /// For each candidate the number of members of its family that were tried.
    pub members: Vec<usize>,
    /// Effects on the noise.
    pub noise: Vec<Candidate>,
    /// Effects that cannot be tested.
    pub not_testable: Vec<NotTestable>,
    /// How probable each cause is before the readings are looked at.
    pub prior: Prior,
    /// Evidence of each candidate.
    pub evidence: Evidence,
    /// Score of each candidate.
    pub scores: Vec<Score>,
    /// What is known of the noise.
    pub noise_found: Noise,
    /// For each candidate how much more its score scatters from stretch to stretch than the noise
    /// says.
    pub inflation: Vec<f64>,
    /// Number of stretches; 0 where they were not looked at.
    pub stretches: usize,
    /// Logarithm of the evidence of each candidate, where it was asked for.
    pub(super) logarithms: OnceLock<Vec<f64>>,
}

/// What stays the same while the noise of a stage is judged: the members that families were scanned
/// for, before anything was known of the noise (beside a square or a walk a scan would find what
/// these leave of themselves), and signatures.
#[derive(Debug, Default)]
pub struct Kept {
    scanned: Scanned,
    signed: Option<(Arc<Made>, String, Arc<Vec<Signatures>>)>,
}

impl Kept {
    fn signatures(
        &mut self,
        made: &Arc<Made>,
        problem: &Problem,
        candidates: &[&Candidate],
    ) -> Arc<Vec<Signatures>> {
        let key = catalogue::key(candidates);
        if let Some((known, of, signed)) = &self.signed
            && Arc::ptr_eq(known, made)
            && *of == key
        {
            return signed.clone();
        }
        let signed = sign(problem, candidates);
        self.signed = Some((made.clone(), key, Arc::clone(&signed)));
        signed
    }
}

impl Stage {
    /// Looks at everything that is not in a fitted model. `None` where its parameters are not
    /// determined.
    pub fn new(fitted: Fitted, wanted: &Wanted) -> Option<Self> {
        Self::again(fitted, wanted, &mut Kept::default())
    }

    /// The same; families that were scanned are not scanned again while the noise is judged, and
    /// signatures that are the same are not made again.
    pub fn again(fitted: Fitted, wanted: &Wanted, kept: &mut Kept) -> Option<Self> {
        let made = wanted.catalogue.of(&fitted.recipes);
        let Offer { effects, noise, mut not_testable } = wanted.of(made.offer.clone());
        let (mut candidates, mut members, blind) =
            best_members(&fitted, &made, effects, &mut kept.scanned)?;
        not_testable.extend(blind);
        let effects = candidates.len();
        let mut waves: Vec<(Candidate, usize)> = Vec::new();
        for block in &made.blocks {
            let place = block.place.as_ref();
            let wave = waves.iter().find(|(wave, _)| wave.is_beside(block));
            let found = if block.selected.effect.shape.is_empty() {
                Some((block.clone(), 1))
            } else if let Some((wave, tried)) = wave
                && place.is_some_and(Place::is_oscillation_of_one)
            {
                // Where all of them do most.
                let frequency = wave.selected.member.values().next();
                frequency.and_then(|one| Some((with_member(&fitted, block, *one)?, *tried)))
            } else {
                let found = scan(&fitted, block, &mut kept.scanned);
                if place.is_some_and(Place::is_oscillation) {
                    waves.extend(found.clone());
                }
                found
            };
            if let Some((found, tried)) = found {
                candidates.push(found);
                members.push(tried);
            }
        }
        let all: Vec<&Candidate> = candidates.iter().collect();
        let Fit { normal, point, .. } = &fitted.fit;
        let signatures = kept.signatures(&made, &fitted.problem, &all);
        let evidence = Evidence::with(&fitted.problem, normal, point, all.len(), signatures)?;
        let scores: Vec<Score> = evidence
            .entries
            .iter()
            .zip(&members)
            .map(|(entry, members)| score(entry, *members))
            .collect();
        Some(Self {
            fitted,
            candidates,
            effects,
            members,
            noise,
            not_testable,
            prior: wanted.prior.clone(),
            inflation: vec![1.0; scores.len()],
            evidence,
            scores,
            noise_found: Noise::default(),
            stretches: 0,
            logarithms: OnceLock::new(),
        })
    }

    /// Whether a block is not counted as structure, unless a few runs do for it: noise with a
    /// memory scatters from run to run, so what each run has for itself says nothing then; and
    /// beside a walk, or a memory that weights do not take account of, an oscillation says no more,
    /// for at a multiple of a run's sampling rate it is slow there.
    pub fn is_scatter(&self, candidate: usize) -> bool {
        let found = &self.noise_found;
        let own = |apart: &Apart| apart.block == self.candidates[candidate].name;
        if found.apart.iter().any(own) {
            return false;
        }
        let slow = found.memory > 0.0 || found.wanders(&self.noise);
        (found.runs_scatter && self.is_of_runs(candidate))
            || (slow && self.is_oscillation(candidate))
    }

    /// Whether a candidate is a wave in time that nobody wrote down.
    pub fn is_oscillation(&self, candidate: usize) -> bool {
        self.candidates[candidate].place.as_ref().is_some_and(Place::is_oscillation)
    }

    pub(super) fn is_of_runs(&self, candidate: usize) -> bool {
        self.candidates[candidate].place.as_ref().is_some_and(Place::is_of_runs)
    }

    /// All significant structure, of the library or unknown, taken together.
    pub fn structure(&self) -> Entry {
        self.together(&self.structures())
    }

    /// The same one by one, but for what each run has for itself and oscillations.
    pub fn structures_over_runs(&self) -> Vec<usize> {
        self.structures_among(|n| !self.is_of_runs(n) && !self.is_oscillation(n))
    }

    /// The same but for what each run has for itself.
    pub fn structures_over_samples(&self) -> Vec<usize> {
        self.structures_among(|n| !self.is_of_runs(n))
    }

    /// The same but for oscillations, which walks and noisier runs imitate.
    pub fn structures_beside_noise(&self) -> Vec<usize> {
        self.structures_among(|n| !self.is_oscillation(n))
    }

    /// The candidates, of the library or unknown, that are significant one after the other,
    /// greedily.
    pub fn structures(&self) -> Vec<usize> {
        self.structures_among(|_| true)
    }

    /// Blocks with a value for each run that are significant by themselves.
    pub fn blocks_over_runs(&self) -> Vec<usize> {
        let level = level(self.candidates.len());
        (self.effects..self.candidates.len())
            .filter(|n| self.is_of_runs(*n) && self.scores[*n].ln_p <= level)
            .collect()
    }

    /// Those of readings.
    pub fn readings_over_runs(&self) -> Vec<usize> {
        let is_of_reading = |n: &usize| {
            let place = self.candidates[*n].place.as_ref();
            place.is_some_and(|place| matches!(place.of, Of::Measurand(_)))
        };
        self.blocks_over_runs().into_iter().filter(is_of_reading).collect()
    }

    /// Several candidates as one.
    pub fn together(&self, candidates: &[usize]) -> Entry {
        let entries: Vec<&Entry> = candidates.iter().map(|n| self.entry(*n)).collect();
        self.evidence.together(&entries)
    }

    fn structures_among(&self, wanted: impl Fn(usize) -> bool) -> Vec<usize> {
        let level = level(self.candidates.len());
        let strong: Vec<usize> = (0..self.candidates.len())
            .filter(|n| self.scores[*n].ln_p <= level && wanted(*n))
            .collect();
        let mut taken: Vec<usize> = Vec::new();
        for _ in 0..MOST_STRUCTURES {
            let whole = self.together(&taken);
            let beyond = |n: &usize| {
                let (gain, degrees) = self.evidence.beyond(&whole, self.entry(*n));
                (of_gain(gain, degrees, self.members[*n]).ln_p, *n)
            };
            let all: Vec<(f64, usize)> = strong.iter().map(beyond).collect();
            let best = |some: &dyn Fn(usize) -> bool| {
                let some = all.iter().filter(|(_, number)| some(*number)).copied();
                some.min_by(|a, b| a.0.total_cmp(&b.0))
            };
            let Some((ln_p, number)) = best(&|_| true).filter(|(ln_p, _)| *ln_p <= level) else {
                break;
            };
            // What has a name goes before what nobody wrote down and does as much.
            let named = best(&|number| number < self.effects).filter(|one| one.0 <= ln_p + TIE);
            taken.push(named.map_or(number, |(_, named)| named));
        }
        taken
    }

    /// Compares how scores scatter from stretch to stretch with what the noise says; `left` is what
    /// is left of each run's readings without significant structure.
    pub fn judge_scatter(&mut self, left: &[Left]) {
        self.stretches = left.iter().map(|run| run.scores.len()).sum();
        self.inflation =
            self.evidence.entries.iter().map(|one| self.evidence.inflation(one, left)).collect();
    }

    /// The number of an effect of the library.
    pub(super) fn effect_named(&self, name: &str) -> Option<usize> {
        self.candidates[..self.effects].iter().position(|one| one.name == name)
    }

    /// The entry of a candidate.
    pub fn entry(&self, candidate: usize) -> &Entry {
        &self.evidence.entries[candidate]
    }

    /// Part of a candidate's gain that lies in values that are stated.
    pub fn prior_share(&self, candidate: usize) -> f64 {
        let noise: Vec<String> = self
            .noise_found
            .selected()
            .into_iter()
            .map(|one| format!("{}.", one.effect.name))
            .collect();
        let layout = &self.fitted.problem.layout;
        let is_noise = |index: &usize| {
            noise.iter().any(|prefix| layout.instances[*index].name.starts_with(prefix.as_str()))
        };
        let columns: HashSet<usize> = (0..layout.instances.len())
            .filter(is_noise)
            .flat_map(|index| (0..layout.instances[index].dimension()).map(move |k| (index, k)))
            .flat_map(|(index, k)| layout.columns_of(index, k))
            .map(|(column, _)| column)
            .collect();
        self.evidence.prior_share(self.entry(candidate), |column| columns.contains(&column))
    }

    /// The values of a candidate's parameters that the linearised problem finds best.
    pub fn start(&self, candidate: usize) -> Vec<(String, usize, Option<String>, f64)> {
        let entry = self.entry(candidate);
        let values: DVector<f64> = entry.values();
        entry
            .owners
            .iter()
            .zip(values.iter())
            .map(|(owner, value)| {
                (owner.parameter.clone(), owner.component, owner.of.clone(), *value)
            })
            .collect()
    }
}

/// Of each family the member that explains most, with the number of members tried, and families of
/// which no member can be tested.
fn best_members(
    fitted: &Fitted,
    made: &Made,
    offered: Vec<Candidate>,
    scanned: &mut Scanned,
) -> Option<(Vec<Candidate>, Vec<usize>, Vec<NotTestable>)> {
    let (mut best, mut tried, mut blind) = (Vec::new(), Vec::new(), Vec::new());
    let is_range = |family: &Family| matches!(family.members, Members::Range { .. });
    for family in offered.chunk_by(|a, b| a.name == b.name) {
        let first = &family[0];
        if family.len() > 1
            && first.selected.effect.shape.values().all(is_range)
            && let Some((found, members)) = scan(fitted, first, scanned)
        {
            best.push(found);
            tried.push(members);
            continue;
        }
        let members = told(&fitted.problem, family);
        let count = members.len();
        if count == 0 {
            blind.push(NotTestable::here(&first.name, ALL_BLIND));
            continue;
        }
        let mut winner = 0;
        if count > 1 {
            let fit = &fitted.fit;
            let signatures = made.signatures(&fitted.problem, &members);
            let evidence =
                Evidence::with(&fitted.problem, &fit.normal, &fit.point, count, signatures)?;
            let gain = |k: &usize| score(&evidence.entries[*k], 1).ln_p;
            winner = (0..count).min_by(|a, b| gain(a).total_cmp(&gain(b))).unwrap_or(0);
        }
        best.push(members[winner].clone());
        tried.push(count);
    }
    Some((best, tried, blind))
}
