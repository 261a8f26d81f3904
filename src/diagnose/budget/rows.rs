//! The whitened rows of a linearised model one after the other: values of the columns of a model, of
//! some further columns, and the residual of the nominal model.
//!
//! It sums nothing.

use crate::diagnose::library::catalogue::sign;
use crate::engine::gauss_markov::Gains;

use super::linear::{Linear, by_candidate};
use super::masked::Masked;
use super::selection::Selection;
use super::terms::{Base, Change, Combination};

/// One whitened reading in a linearised model.
#[derive(Clone, Copy, Debug)]
pub struct Values<'a> {
    /// Index of the run among all.
    pub run: usize,
    /// Number of the sample in the run.
    pub sample: usize,
    /// Residual component.
    pub row: usize,
    /// The measurand, as the sums number them.
    pub measurand: usize,
    /// The sample's time (s), or its row where there are no times.
    pub time: f64,
    /// Of the model's columns.
    pub model: &'a [f64],
    /// Of the further columns.
    pub further: &'a [f64],
    /// The residual of the nominal model.
    pub residual: f64,
    /// Of the filter along time, where the noise is autocorrelated.
    pub gains: Option<&'a Gains>,
}

/// A column of a model among those of a run: its parts, and the change that it is.
type Cell<'a> = (Combination, Option<&'a Change>);

impl Linear {
    /// Shows every whitened reading with the values of the columns of a model and of some bases.
    pub fn visit(
        &self,
        selection: &Selection<'_>,
        model: &[usize],
        bases: &[Base],
        see: &mut dyn FnMut(Values<'_>),
    ) {
        let problem = &self.fitted.problem;
        let mut own: Vec<usize> = Vec::new();
        let mut number_of = |candidate: usize| {
            own.iter().position(|known| *known == candidate).unwrap_or_else(|| {
                own.push(candidate);
                own.len() - 1
            })
        };
        for base in bases {
            number_of(base.candidate);
        }
        for term in model {
            let term = &selection.terms[*term];
            if let Some(change) = term.appended() {
                number_of(change.base.candidate);
            } else if term.candidate != usize::MAX {
                number_of(term.candidate);
            }
        }
        let candidates: Vec<_> = own.iter().map(|n| &self.candidates[*n]).collect();
        let signed = sign(problem, &candidates);
        let nominal = selection.columns(&[]);
        let columns: Vec<(&Combination, Option<(&Change, Base)>)> = {
            let nominal = nominal.iter().map(|one| (one, None));
            let terms = model.iter().map(|term| &selection.terms[*term]);
            let of_terms = terms.flat_map(|term| {
                let change = term.appended();
                let bases = change.into_iter().flat_map(Change::bases).map(Some);
                let bases = bases.chain(std::iter::repeat(None));
                let columns = term.columns.iter().zip(bases);
                columns.map(move |(one, base)| (one, change.zip(base)))
            });
            nominal.chain(of_terms).chain([(selection.residual(), None)]).collect()
        };
        for (part, signatures) in signed.iter().enumerate() {
            // The signatures of each candidate in their order, here and in the sums.
            let of_candidates = by_candidate(signatures, own.len());
            let mut cells: Vec<Vec<Cell<'_>>> = Vec::new();
            let mut of_bases: Vec<Vec<Option<usize>>> = Vec::new();
            for run in 0..problem.parts[part].runs.len() {
                let run = problem.run_index(part, run);
                let touched = problem.layout.columns.touched_by(run);
                let mut here = vec![None; self.sums.residual() + 1];
                touched.iter().enumerate().for_each(|(at, column)| here[*column] = Some(at));
                for (number, mine) in own.iter().zip(&of_candidates) {
                    for (at, in_sums) in mine.iter().zip(&self.signatures[part][*number]) {
                        if let Some(column) = self.sums.column_at(run, touched.len() + in_sums) {
                            here[column] = Some(touched.len() + at);
                        }
                    }
                }
                here[self.sums.residual()] = Some(touched.len() + signatures.columns.len());
                let local = |base: &Base| -> Option<usize> {
                    let number = own.iter().position(|known| *known == base.candidate)?;
                    Some(touched.len() + of_candidates[number].get(base.signature)?)
                };
                let cell =
                    |(one, change): &(&Combination, Option<(&Change, Base)>)| -> Combination {
                        match change {
                            None => {
                                let place =
                                    |(column, by): &(usize, f64)| Some((here[*column]?, *by));
                                one.iter().filter_map(place).collect()
                            }
                            Some((_, base)) => {
                                local(base).map(|at| (at, 1.0)).into_iter().collect()
                            }
                        }
                    };
                let all = columns.iter();
                cells.push(all.map(|one| (cell(one), one.1.map(|of| of.0))).collect());
                of_bases.push(bases.iter().map(local).collect());
            }
            let first = self.sums.first_measurand[part];
            let (mut row, mut values, mut further) = (Vec::new(), Vec::new(), Vec::new());
            // Of each residual component the columns of changes.
            let mut masked: Vec<Vec<Masked>> = Vec::new();
            let data = &problem.parts[part];
            problem.visit_whitened(signatures, &self.fitted.fit.point, &mut |lanes| {
                let run = problem.run_index(part, lanes.run);
                masked.resize_with(masked.len().max(lanes.row + 1), Vec::new);
                masked[lanes.row].resize(columns.len(), Masked::default());
                for lane in 0..lanes.stretch.len {
                    if !lanes.is_present(lane) {
                        continue;
                    }
                    lanes.put(lane, &mut row);
                    let sample = lanes.stretch.first + lane;
                    let gains = lanes.gains_at(lane);
                    values.clear();
                    let own = cells[lanes.run].iter().zip(&mut masked[lanes.row]);
                    values.extend(own.map(|((parts, change), masked)| {
                        let value: f64 = parts.iter().map(|(at, by)| row[*at] * by).sum();
                        let acts = |change: &&Change| self.acts(change, (run, sample));
                        change.map_or(value, |change| masked.next(gains, value, acts(&change)))
                    }));
                    let residual = values.pop().unwrap_or(0.0);
                    further.clear();
                    let of = of_bases[lanes.run].iter();
                    further.extend(of.map(|at| at.map_or(0.0, |at| row[at])));
                    see(Values {
                        run,
                        sample,
                        row: lanes.row,
                        measurand: first + data.measurand_of(lanes.row),
                        time: lanes.stretch.samples.order_of(lanes.stretch.start + lane),
                        model: &values,
                        further: &further,
                        residual,
                        gains,
                    });
                }
            });
        }
    }

    /// Whether a change acts on a sample (run and number).
    pub fn acts(&self, change: &Change, (run, sample): (usize, usize)) -> bool {
        let (first, from) = change.at;
        let part_of = |run: usize| self.fitted.problem.run_at(run).0;
        match change.end {
            Some(end) => run == first && (from..end).contains(&sample),
            None if run == first => sample >= from,
            None => part_of(first) == part_of(run) && self.order[run] > self.order[first],
        }
    }
}
