//! Change points: something of one reading, of a clock or of a place that is different from one
//! moment on.
//!
//! For each block with a value for each run (its column `x`, which acts from the moment on) the
//! gain of every moment follows from running sums of `x a_j`, `x r` and `x x` over the samples in
//! the order of time: one pass for all moments. Moments are tried in bins, the best then sample by
//! sample. A change is a term with one value; the moments that were tried are its members.

use self::moments::Bin;
use super::linear::Linear;
use super::selection::Selection;
use super::sums::Appended;
use super::terms::{Base, Change, Kind, Term};
use crate::diagnose::thresholds::ENTER;

mod moments;

/// Moments tried at most in the first pass.
const MOST_BINS: usize = 1500;
/// Bases whose changes are located sample by sample at most.
const MOST_STRONG: usize = 4;
/// Share of a row's log Bayes factor that a change in its place has at least: it may stand for this
/// row and another one.
const IN_PLACE: f64 = 0.5;

impl Linear {
    /// For each value of a run that a block has the moment at which a change explains most beside a
    /// model, and beside the model without each of its rows.
    pub fn changes(&self, selection: &Selection<'_>, model: &[usize]) -> Vec<Change> {
        let bases = self.bases();
        let mut runs: Vec<usize> = (0..self.order.len()).collect();
        runs.sort_by_key(|run| self.order[*run]);
        let samples: usize = runs.iter().map(|run| self.samples_in(*run)).sum();
        let step = samples.div_ceil(MOST_BINS).max(1);
        let mut bins: Vec<Bin> = Vec::new();
        for run in &runs {
            let firsts = (0..self.samples_in(*run)).step_by(step);
            bins.extend(firsts.map(|first| Bin { run: *run, first }));
        }
        let rows = model.iter().filter(|term| selection.terms[**term].is_effect());
        let without = |out: &usize| model.iter().copied().filter(|own| own != out).collect();
        let models: Vec<Vec<usize>> =
            std::iter::once(model.to_vec()).chain(rows.map(without)).collect();
        let own: Vec<f64> = model
            .iter()
            .zip(selection.contributions(model))
            .filter(|(term, _)| selection.terms[**term].is_effect())
            .map(|(term, gain)| IN_PLACE * selection.ln_bayes_factor(*term, gain))
            .collect();
        let least: Vec<f64> = std::iter::once(ENTER).chain(own).collect();
        let coarse = self.best_moments(selection, (model, &models, &least), &bases, &bins);
        let weak = 2.0 * (ENTER + (samples.max(1) as f64).ln());
        let mut strong: Vec<Change> =
            coarse.into_iter().filter(|one| one.gain.gain > weak).collect();
        strong.sort_by(|a, b| b.gain.gain.total_cmp(&a.gain.gain));
        let mut known: Vec<(Base, bool)> = Vec::new();
        strong.retain(|one| {
            let kind = (one.base, one.end.is_some());
            let is_new = !known.contains(&kind);
            known.push(kind);
            is_new
        });
        strong.truncate(MOST_STRONG);
        let mut found = Vec::new();
        for one in strong {
            let at = bins.iter().position(|bin| (bin.run, bin.first) == one.at).unwrap_or(0);
            // Sample by sample between the neighbouring bins, coarse elsewhere.
            let (low, high) = (at.saturating_sub(1), (at + 1).min(bins.len() - 1));
            let mut around: Vec<Bin> = bins[..low].to_vec();
            for bin in &bins[low..=high] {
                let end = self.samples_in(bin.run).min(bin.first + step);
                around.extend((bin.first..end).map(|first| Bin { run: bin.run, first }));
            }
            around.extend(&bins[high + 1..]);
            let fine = self.best_moments(selection, (model, &models, &least), &[one.base], &around);
            found.extend(
                fine.into_iter().map(|one| Change { members: one.members.max(samples), ..one }),
            );
        }
        found
    }

    /// The values of a run that blocks have.
    fn bases(&self) -> Vec<Base> {
        let mut bases = Vec::new();
        for (candidate, one) in self.candidates.iter().enumerate() {
            let place = one.place.as_ref();
            if place.is_some_and(|place| place.is_of_runs()) {
                let count = one.selected.effect.parameters.len();
                bases.extend((0..count).map(|signature| Base { candidate, signature }));
            }
        }
        bases
    }

    /// Number of samples of a run.
    pub fn samples_in(&self, run: usize) -> usize {
        let (part, run) = self.part_of(run);
        self.fitted.problem.parts[part].runs[run].record.len()
    }

    /// The campaign of a run, and its index there.
    pub fn part_of(&self, run: usize) -> (usize, usize) {
        let first = &self.fitted.problem.layout.first_run;
        let part = first.partition_point(|first| *first <= run) - 1;
        (part, run - first[part])
    }

    /// Adds changes as terms, with their sums.
    pub fn with_changes(&mut self, changes: &[Change]) {
        for change in changes {
            if self.terms.iter().any(|term| term.change.as_ref() == Some(change)) {
                continue;
            }
            let column = self.append(change);
            let block = &self.candidates[change.base.candidate];
            let (part, run) = self.part_of(change.at.0);
            let run = &self.fitted.problem.parts[part].runs[run];
            let row = run.record.row(change.at.1);
            let last = change.end.map(|end| run.record.row(end.saturating_sub(1)));
            let place = block.place.as_ref().map(|place| place.from(&run.name, (row, last)));
            let (name, columns) = (format!("change of {}", block.name), vec![vec![(column, 1.0)]]);
            self.terms.push(Term {
                members: change.members,
                place,
                change: Some(change.clone()),
                ..Term::new(name, Kind::Block, columns)
            });
        }
    }

    /// The column of a change, appended to the sums.
    fn append(&mut self, change: &Change) -> usize {
        let mut added = Appended::default();
        self.visit_change(change, &mut |(run, _), measurand, x, row| {
            added.add((run, measurand), x, row);
        });
        let known: Vec<(usize, Change)> = self
            .terms
            .iter()
            .filter_map(|term| Some((term.columns.first()?.first()?.0, term.change.clone()?)))
            .collect();
        for (column, other) in known {
            let places: Vec<Option<usize>> =
                (0..self.order.len()).map(|run| self.place_of(run, other.base)).collect();
            self.visit_change(change, &mut |(run, sample), measurand, x, row| {
                if let Some(theirs) = places[run].filter(|_| self.acts(&other, (run, sample))) {
                    added.add_to(measurand, column, x * row[theirs]);
                }
            });
        }
        self.sums.append(&added)
    }

    /// Where a base stands among the columns of a run.
    fn place_of(&self, run: usize, base: Base) -> Option<usize> {
        let (part, own) = (self.part_of(run).0, base.candidate.to_string());
        let mine = self.signed[part].columns.iter().enumerate();
        let (index, _) = mine.filter(|(_, one)| one.effect == own).nth(base.signature)?;
        Some(self.fitted.problem.layout.columns.touched_by(run).len() + index)
    }

    /// Shows every reading on which a change acts: run and sample, measurand, value of the change's
    /// column, the row with the residual last.
    fn visit_change(&self, change: &Change, see: &mut ChangeVisitor<'_>) {
        let problem = &self.fitted.problem;
        for (part, signatures) in self.signed.iter().enumerate() {
            let first = self.sums.first_measurand[part];
            let data = &problem.parts[part];
            let runs = 0..data.runs.len();
            let places: Vec<Option<usize>> =
                runs.map(|run| self.place_of(problem.run_index(part, run), change.base)).collect();
            let mut row = Vec::new();
            problem.visit_whitened(signatures, &self.fitted.fit.point, &mut |lanes| {
                let run = problem.run_index(part, lanes.run);
                let Some(place) = places[lanes.run] else { return };
                let touched = problem.layout.columns.touched_by(run).len();
                let size = touched + signatures.columns.len() + 1;
                row.resize(size, 0.0);
                for lane in 0..lanes.stretch.len {
                    let sample = lanes.stretch.first + lane;
                    if !lanes.is_present(lane) || !self.acts(change, (run, sample)) {
                        continue;
                    }
                    lanes.put(lane, &mut row);
                    row[size - 1] = lanes.residual[lane];
                    if row[place] != 0.0 {
                        let measurand = first + data.measurand_of(lanes.row);
                        see((run, sample), measurand, row[place], &row);
                    }
                }
            });
        }
    }
}

/// What sees the readings on which a change acts.
type ChangeVisitor<'a> = dyn FnMut((usize, usize), usize, f64, &[f64]) + 'a;
