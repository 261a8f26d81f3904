//! Change points: something of one reading, of a clock or of a place that is different from one
//! moment on.
//!
//! For each block with a value for each run (its column `x`, which acts from the moment on) the
//! gain of every moment follows from running sums of `x a_j`, `x r` and `x x` over the samples in
//! the order of time: one pass for all moments. Moments are tried in bins, the best then sample by
//! sample. A change is a term with one value; the moments that were tried are its members.

use rayon::prelude::*;

use self::models::Models;
use self::moments::Bin;
use super::linear::Linear;
use super::masked::Masked;
use super::selection::Selection;
use super::sums::Appended;
use super::terms::{Base, Change, Term};
use crate::diagnose::library::place::{Extent, Place};
use crate::diagnose::thresholds::ENTER;

mod absorbed;
mod forms;
mod models;
mod moments;
mod onsets;
mod runs;
mod together;

/// Moments tried at most in the first pass.
const MOST_BINS: usize = 1500;
/// Bases whose changes are located sample by sample at most.
const MOST_STRONG: usize = 4;
/// Change points that enter the competition in a round at most.
const MOST_CHANGES: usize = 4;

/// A column of a change: its number, and what it is.
type OfChange = (usize, Change, Base);

impl Linear {
    /// Change points beside a model, and beside the model without each of its rows and blocks, that are
    /// worth their price: the best of each kind.
    pub fn changes(&self, selection: &Selection<'_>, model: &[usize]) -> Vec<Change> {
        let bases = self.bases();
        let mut runs: Vec<usize> = (0..self.order.len()).collect();
        runs.sort_by_key(|run| self.order[*run]);
        let samples: usize = runs.iter().map(|run| self.fitted.problem.samples_in(*run)).sum();
        let step = samples.div_ceil(MOST_BINS).max(1);
        let mut bins: Vec<Bin> = Vec::new();
        for run in &runs {
            let firsts = (0..self.fitted.problem.samples_in(*run)).step_by(step);
            bins.extend(firsts.map(|first| (*run, first)));
        }
        let models = Models::of(selection, model);
        let coarse = self.best_moments(selection, &models, &bases, &bins);
        let weak = 2.0 * (ENTER + (samples.max(1) as f64).ln());
        // Those in the place of a term are larger than those beside it, and must not hide these.
        let strong_of = |is_in_place: bool| {
            let own = coarse.iter().filter(|(in_place, _)| *in_place == is_in_place);
            let own = own.map(|(_, one)| one).filter(|one| one.gain.gain > weak);
            let mut strong: Vec<Change> = own.cloned().collect();
            strong.sort_by(|a, b| b.gain.gain.total_cmp(&a.gain.gain));
            Change::keep_one_of_a_kind(&mut strong, MOST_STRONG);
            strong
        };
        let mut strong = strong_of(false);
        for one in strong_of(true) {
            if !strong.contains(&one) {
                strong.push(one);
            }
        }
        let fine = |one: &Change| {
            // Sample by sample in the neighbouring bins of its moment, and of its end; coarse elsewhere.
            let at = bins.iter().position(|bin| *bin == one.at).unwrap_or(0);
            let before =
                |end: usize| bins.iter().rposition(|bin| bin.0 == one.at.0 && bin.1 <= end);
            let end = one.end.and_then(before);
            let is_near = |bin: usize| {
                let near = |place: usize| bin + 1 >= place && bin <= place + 1;
                near(at) || end.is_some_and(near)
            };
            let mut around: Vec<Bin> = Vec::new();
            for (number, (run, first)) in bins.iter().enumerate() {
                let end = self.fitted.problem.samples_in(*run).min(first + step);
                let end = if is_near(number) { end } else { first + 1 };
                around.extend((*first..end).map(|first| (*run, first)));
            }
            self.best_moments(selection, &models, &[one.base], &around)
        };
        let found: Vec<_> = strong.par_iter().map(fine).collect();
        let paid = |(_, one): (bool, Change)| Change { members: one.members.max(samples), ..one };
        let mut found: Vec<Change> = found.into_iter().flatten().map(paid).collect();
        let ln_bayes = |one: &Change| selection.ln_bayes_factor_of_change(one);
        let known = || model.iter().filter_map(|term| selection.terms[*term].change.as_ref());
        found.retain(|one| ln_bayes(one) >= ENTER && !known().any(|known| one.is_near(known)));
        found.sort_by(|a, b| ln_bayes(b).total_cmp(&ln_bayes(a)));
        Change::keep_one_of_a_kind(&mut found, MOST_CHANGES);
        let siblings: Vec<Change> = found.iter().flat_map(|one| self.siblings(one)).collect();
        let together: Vec<Change> = found.iter().flat_map(|one| self.together(one)).collect();
        found.extend(siblings);
        found.extend(together);
        found.extend(self.runs_in_place(selection, model));
        found.extend(self.forms_in_runs(selection, model));
        found
    }

    /// The values of a run that blocks have.
    fn bases(&self) -> Vec<Base> {
        let mut bases = Vec::new();
        for (candidate, one) in self.candidates.iter().enumerate() {
            let place = one.place.as_ref();
            if place.is_some_and(Place::is_of_runs) && !self.is_of_several(candidate) {
                let count = one.selected.effect.parameters.len();
                bases.extend((0..count).map(|signature| Base { candidate, signature }));
            }
        }
        bases
    }

    /// Adds changes as terms, with their sums.
    pub fn with_changes(&mut self, changes: &[Change]) {
        let mut known: Vec<OfChange> = Vec::new();
        for term in &self.terms {
            let Some(change) = term.appended() else { continue };
            let columns = term.columns.iter().filter_map(|one| Some(one.first()?.0));
            known.extend(columns.zip(change.bases()).map(|(at, base)| (at, change.clone(), base)));
        }
        let old = known.len();
        let (mut new, mut next): (Vec<(&Change, usize)>, _) = (Vec::new(), self.sums.residual());
        for change in changes {
            let is_known = known.iter().any(|(_, one, _)| one == change);
            if !is_known {
                known.extend(
                    (next..).zip(change.bases()).map(|(at, base)| (at, change.clone(), base)),
                );
                new.push((change, next));
                next += change.width;
            }
        }
        for added in self.products(&known, old) {
            self.sums.append(&added);
        }
        for (change, first) in new {
            let block = &self.candidates[change.base.candidate];
            let (part, run) = self.fitted.problem.run_at(change.at.0);
            let name = self.fitted.problem.parts[part].run_name(run);
            let appended = self.terms.iter_mut().filter(|term| term.appended().is_some());
            for term in appended {
                term.may_enter &= !term.change.as_ref().is_some_and(|one| one.is_near(change));
            }
            let extent = self.extent(change);
            let place = block.place.as_ref().map(|place| place.within(&name, extent));
            let columns = (first..first + change.width).map(|column| vec![(column, 1.0)]).collect();
            self.terms.push(Term {
                members: change.members,
                change: Some(change.clone()),
                ..Term::new(format!("change of {}", block.name), place, columns)
            });
        }
    }

    /// How much of the campaign a change is in.
    pub(super) fn extent(&self, change: &Change) -> Extent {
        let is_last = self.order.iter().max() == self.order.get(change.at.0);
        let (part, run) = self.fitted.problem.run_at(change.at.0);
        let record = &self.fitted.problem.parts[part].runs[run].record;
        let row = record.row(change.at.1);
        match (change.at.1, change.end) {
            (0, None) if !is_last => Extent::FromRun,
            (0, None) => Extent::Run,
            (0, Some(end)) if end == record.len() => Extent::Run,
            (_, None) => Extent::From(row),
            (_, Some(end)) => {
                let last = record.row(end.saturating_sub(1));
                match end == record.len() {
                    true => Extent::ToItsEnd(row, last),
                    false => Extent::Rows(row, last),
                }
            }
        }
    }

    /// The changes of a model, each with the name of its block.
    pub fn changes_in(&self, model: &[usize]) -> Vec<(String, Change)> {
        let changes = model.iter().filter_map(|term| self.terms[*term].appended().cloned());
        changes.map(|one| (self.candidates[one.base.candidate].name.clone(), one)).collect()
    }

    /// Changes of another linearisation in this one, by the names of their blocks.
    pub fn known_changes(&self, named: &[(String, Change)]) -> Vec<Change> {
        let here = |(name, change): &(String, Change)| {
            let candidate = self.candidates.iter().position(|one| one.name == *name)?;
            let count = self.candidates[candidate].selected.effect.parameters.len();
            if count < change.base.signature + change.width {
                return None;
            }
            let base = Base { candidate, ..change.base };
            Some(Change { base, ..change.clone() })
        };
        named.iter().filter_map(here).collect()
    }

    /// The products of the columns of changes, from `new` on, with all columns and with those of the
    /// changes before them.
    fn products(&self, changes: &[OfChange], new: usize) -> Vec<Appended> {
        let mut added: Vec<Appended> = vec![Appended::default(); changes.len() - new];
        if added.is_empty() {
            return added;
        }
        let problem = &self.fitted.problem;
        for (part, signatures) in self.signed.iter().enumerate() {
            let first = self.sums.first_measurand[part];
            let data = &problem.parts[part];
            let places_in = |run: usize| -> Vec<Option<usize>> {
                let run = problem.run_index(part, run);
                changes.iter().map(|(.., base)| self.place_of(run, *base)).collect()
            };
            let places: Vec<Vec<Option<usize>>> = (0..data.runs.len()).map(places_in).collect();
            let (mut row, mut values) = (Vec::new(), vec![0.0; changes.len()]);
            // Of each residual component.
            let mut masked: Vec<Vec<Masked>> = Vec::new();
            problem.visit_whitened(signatures, &self.fitted.fit.point, &mut |lanes| {
                let run = problem.run_index(part, lanes.run);
                let measurand = first + data.measurand_of(lanes.row);
                masked.resize_with(masked.len().max(lanes.row + 1), Vec::new);
                masked[lanes.row].resize(changes.len(), Masked::default());
                for lane in (0..lanes.stretch.len).filter(|lane| lanes.is_present(*lane)) {
                    let at = (run, lanes.stretch.first + lane);
                    let gains = lanes.gains_at(lane);
                    let acts = |own: usize| self.acts(&changes[own].1, at);
                    if gains.is_none() && !(new..changes.len()).any(acts) {
                        continue;
                    }
                    lanes.put(lane, &mut row);
                    for (own, masked) in masked[lanes.row].iter_mut().enumerate() {
                        let whole = places[lanes.run][own].map_or(0.0, |place| row[place]);
                        values[own] = masked.next(gains, whole, acts(own));
                    }
                    for (own, x) in values.iter().enumerate().skip(new) {
                        if *x != 0.0 {
                            let sums = &mut added[own - new];
                            sums.add((run, measurand), *x, &row);
                            for (other, y) in values.iter().enumerate().take(own) {
                                sums.add_to(measurand, changes[other].0, x * y);
                            }
                        }
                    }
                }
            });
        }
        added
    }

    /// Where a base stands among the columns of a run.
    fn place_of(&self, run: usize, base: Base) -> Option<usize> {
        let place = self.signatures[self.fitted.problem.run_at(run).0][base.candidate]
            .get(base.signature)?;
        Some(self.fitted.problem.layout.columns.touched_by(run).len() + place)
    }
}
