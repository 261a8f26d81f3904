//! Change points: something of one reading, of a clock or of a place that is different from one
//! moment on.
//!
//! For each block with a value for each run (its column `x`, which acts from the moment on) the
//! gain of every moment follows from running sums of `x a_j`, `x r` and `x x` over the samples in
//! the order of time: one pass for all moments. Moments are tried in bins, the best then sample by
//! sample. A change is a term with one value; the moments that were tried are its members.

use nalgebra::{DMatrix, DVector};

use super::linear::Linear;
use super::price::Gain;
use super::selection::Selection;
use super::sums::Appended;
use super::terms::{Base, Change, Kind, Term};
use super::thresholds::ENTER;

/// Moments tried at most in the first pass.
const MOST_BINS: usize = 1500;
/// Bases whose changes are located sample by sample at most.
const MOST_STRONG: usize = 4;
/// Samples of a stretch at least: fewer are outliers.
const LEAST_STRETCH: usize = 8;
/// Places in a run at which a stretch begins or ends at most.
const MOST_ENDS: usize = 40;
/// Share of a change's squared length below which the model takes it up.
const TAKEN_UP: f64 = 1e-6;

/// A moment from which on a value is different.
#[derive(Clone, Copy, Debug)]
struct Bin {
    run: usize,
    first: usize,
}

/// The columns of a model that is a part of another, among those of that.
fn columns_within(selection: &Selection<'_>, whole: &[usize], part: &[usize]) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..selection.nominal()).collect();
    let mut first = selection.nominal();
    for term in whole {
        let count = selection.terms[*term].columns.len();
        if part.contains(term) {
            kept.extend(first..first + count);
        }
        first += count;
    }
    kept
}

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
        let coarse = self.best_moments(selection, (model, &models), &bases, &bins);
        let least = 2.0 * (ENTER + (samples.max(1) as f64).ln());
        let mut strong: Vec<Change> =
            coarse.into_iter().filter(|one| one.gain.gain > least).collect();
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
            let fine = self.best_moments(selection, (model, &models), &[one.base], &around);
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

    /// For each base and each of some models, all of them parts of one, the bin from which on a
    /// change explains most.
    fn best_moments(
        &self,
        selection: &Selection<'_>,
        (whole, models): (&[usize], &[Vec<usize>]),
        bases: &[Base],
        bins: &[Bin],
    ) -> Vec<Change> {
        let n = selection.columns(whole).len();
        let mut sums: Vec<DMatrix<f64>> =
            bases.iter().map(|_| DMatrix::zeros(n + 2, bins.len())).collect();
        let mut of_run: Vec<(usize, usize)> = vec![(0, 0); self.order.len()];
        for (number, bin) in bins.iter().enumerate() {
            let own = &mut of_run[bin.run];
            *own = if own.1 == 0 { (number, number + 1) } else { (own.0, number + 1) };
        }
        self.visit(selection, whole, bases, &mut |values| {
            let (first, end) = of_run[values.run];
            let own = &bins[first..end];
            let at = own.partition_point(|bin| bin.first <= values.sample);
            let bin = first + at.saturating_sub(1);
            let weight = selection.scale[values.measurand].powi(-2);
            for (sum, x) in sums.iter_mut().zip(values.further) {
                if *x == 0.0 {
                    continue;
                }
                let mut column = sum.column_mut(bin);
                let column = column.as_mut_slice();
                let x = x * weight;
                for (sum, a) in column.iter_mut().zip(values.model) {
                    *sum += x * a;
                }
                column[n] += x * values.residual;
                column[n + 1] += x * x / weight;
            }
        });
        // From each bin on to the end of its campaign.
        let part = |bin: usize| self.part_of(bins[bin].run).0;
        let totals: Vec<f64> = sums.iter().map(|sum| sum.row(n + 1).iter().sum()).collect();
        for sum in &mut sums {
            for bin in (0..bins.len().saturating_sub(1)).rev() {
                if part(bin) == part(bin + 1) {
                    let later = sum.column(bin + 1).into_owned();
                    let mut own = sum.column_mut(bin);
                    own += later;
                }
            }
        }
        let mut found = Vec::new();
        for model in models {
            let kept = columns_within(selection, whole, model);
            let (inverse, length, half) = selection.normal_equations(model);
            for ((base, sum), total) in bases.iter().zip(&sums).zip(&totals) {
                let scaled = DMatrix::from_fn(kept.len(), bins.len(), |i, bin| {
                    sum[(kept[i], bin)] / length[i]
                });
                let across = &inverse * scaled;
                let mut best: Option<(f64, usize)> = None;
                for bin in 1..bins.len() {
                    let square = sum[(n + 1, bin)];
                    if square <= 0.0 || square >= *total {
                        continue;
                    }
                    let across = across.column(bin);
                    let left = square - across.norm_squared();
                    if left < TAKEN_UP * square {
                        continue;
                    }
                    let gain = (sum[(n, bin)] - across.dot(&half)).powi(2) / left;
                    if best.is_none_or(|(known, _)| gain > known) {
                        best = Some((gain, bin));
                    }
                }
                found.extend(best.map(|(gain, bin)| Change {
                    base: *base,
                    at: (bins[bin].run, bins[bin].first),
                    end: None,
                    gain: Gain { gain, degrees: 1 },
                    members: bins.len(),
                }));
                let across_of = (&across, &half);
                found.extend(self.best_stretch(sum, across_of, bins).map(|mut one| {
                    one.base = *base;
                    one
                }));
            }
        }
        found
    }

    /// The stretch of a run in which a change explains most, of all that begin and end with bins;
    /// running sums of a base as `best_moments` has them.
    fn best_stretch(
        &self,
        sum: &DMatrix<f64>,
        (across, half): (&DMatrix<f64>, &DVector<f64>),
        bins: &[Bin],
    ) -> Option<Change> {
        let n = sum.nrows() - 2;
        let mut best: Option<(f64, usize, usize)> = None;
        let mut tried = 0;
        let mut first = 0;
        while first < bins.len() {
            let run = bins[first].run;
            let count = bins[first..].iter().take_while(|bin| bin.run == run).count();
            let next = first + count;
            let is_last =
                next >= bins.len() || self.part_of(bins[next].run).0 != self.part_of(run).0;
            let step = count.div_ceil(MOST_ENDS).max(1);
            for from in (first..next).step_by(step) {
                for to in (from + step..=next).step_by(step) {
                    let whole = to == next && is_last;
                    let end = bins.get(to).filter(|bin| bin.run == run);
                    let end = end.map_or_else(|| self.samples_in(run), |bin| bin.first);
                    if end - bins[from].first < LEAST_STRETCH {
                        continue;
                    }
                    tried += 1;
                    let beyond = |row: usize| if whole { 0.0 } else { sum[(row, to)] };
                    let square = sum[(n + 1, from)] - beyond(n + 1);
                    if square <= 0.0 {
                        continue;
                    }
                    let (mut taken, mut along) = (0.0, 0.0);
                    for i in 0..half.len() {
                        let own = across[(i, from)] - if whole { 0.0 } else { across[(i, to)] };
                        taken += own * own;
                        along += own * half[i];
                    }
                    let left = square - taken;
                    if left < TAKEN_UP * square {
                        continue;
                    }
                    let score = sum[(n, from)] - beyond(n) - along;
                    let gain = score * score / left;
                    if best.is_none_or(|(known, ..)| gain > known) {
                        best = Some((gain, from, to));
                    }
                }
            }
            first = next;
        }
        best.map(|(gain, from, to)| {
            let run = bins[from].run;
            let same = bins.get(to).filter(|bin| bin.run == run);
            let end = same.map_or_else(|| self.samples_in(run), |bin| bin.first);
            Change {
                base: Base { candidate: 0, signature: 0 },
                at: (run, bins[from].first),
                end: Some(end),
                gain: Gain { gain, degrees: 1 },
                members: tried,
            }
        })
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
            self.terms.push(Term {
                candidate: usize::MAX,
                name: format!("change of {}", block.name),
                kind: Kind::Block,
                columns: vec![vec![(column, 1.0)]],
                members: change.members,
                ln_prior: 0.0,
                is_of_runs: false,
                place,
                change: Some(change.clone()),
                reduced_from: None,
                may_enter: true,
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
