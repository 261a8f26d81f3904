//! The whitened rows of a linearised model one after the other: values of the columns of a model, of
//! some further columns, and the residual of the nominal model.
//!
//! It sums nothing.

use crate::diagnose::library::catalogue::sign;

use super::linear::Linear;
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
    /// The sample's time (s).
    pub time: f64,
    /// Of the model's columns.
    pub model: &'a [f64],
    /// Of the further columns.
    pub further: &'a [f64],
    /// The residual of the nominal model.
    pub residual: f64,
}

/// A column of a model among those of a run.
struct Cell {
    parts: Combination,
    change: Option<Change>,
}

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
            if let Some(change) = &term.change {
                number_of(change.base.candidate);
            } else if term.candidate != usize::MAX {
                number_of(term.candidate);
            }
        }
        let candidates: Vec<_> = own.iter().map(|n| &self.candidates[*n]).collect();
        let signed = sign(problem, &candidates);
        let columns: Vec<(Combination, Option<Change>)> = {
            let nominal = selection.columns(&[]).into_iter().map(|one| (one, None));
            let of_terms = model.iter().flat_map(|term| {
                let term = &selection.terms[*term];
                term.columns.iter().map(|one| (one.clone(), term.change.clone()))
            });
            nominal.chain(of_terms).collect()
        };
        for (part, signatures) in signed.iter().enumerate() {
            let mut cells: Vec<Vec<Cell>> = Vec::new();
            let mut of_bases: Vec<Vec<Option<usize>>> = Vec::new();
            for run in 0..problem.parts[part].runs.len() {
                let touched = problem.layout.columns.touched_by(problem.run_index(part, run));
                let mut here = vec![None; self.sums.len() + 1];
                touched.iter().enumerate().for_each(|(at, column)| here[*column] = Some(at));
                // Signatures of each candidate in their order.
                let mut of_candidate: Vec<Vec<usize>> = vec![Vec::new(); own.len()];
                for (index, signature) in signatures.columns.iter().enumerate() {
                    let Some(number) = signature.effect.parse::<usize>().ok() else { continue };
                    let at = touched.len() + index;
                    of_candidate[number].push(at);
                    let column = self.sums.column_in(problem, own[number], part, run, signature);
                    if let Some(column) = column {
                        here[column] = Some(at);
                    }
                }
                here[self.sums.residual()] = Some(touched.len() + signatures.columns.len());
                let local = |base: &Base| -> Option<usize> {
                    let number = own.iter().position(|known| *known == base.candidate)?;
                    of_candidate[number].get(base.signature).copied()
                };
                let place = |one: &Combination| -> Combination {
                    one.iter().filter_map(|(column, by)| Some((here[*column]?, *by))).collect()
                };
                let mut all: Vec<Cell> = columns
                    .iter()
                    .map(|(one, change)| match change {
                        None => Cell { parts: place(one), change: None },
                        Some(change) => Cell {
                            parts: local(&change.base).map(|at| (at, 1.0)).into_iter().collect(),
                            change: Some(change.clone()),
                        },
                    })
                    .collect();
                all.push(Cell { parts: place(selection.residual()), change: None });
                cells.push(all);
                of_bases.push(bases.iter().map(local).collect());
            }
            let first = self.sums.first_measurand[part];
            let (mut row, mut values, mut further) = (Vec::new(), Vec::new(), Vec::new());
            let data = &problem.parts[part];
            problem.visit_whitened(signatures, &self.fitted.fit.point, &mut |lanes| {
                let run = problem.run_index(part, lanes.run);
                let size = problem.layout.columns.touched_by(run).len() + signatures.columns.len();
                row.resize(size + 1, 0.0);
                for lane in 0..lanes.stretch.len {
                    if !lanes.is_present(lane) {
                        continue;
                    }
                    lanes.put(lane, &mut row);
                    row[size] = lanes.residual[lane];
                    let sample = lanes.stretch.first + lane;
                    values.clear();
                    values.extend(cells[lanes.run].iter().map(|cell| {
                        let acts = |change: &Change| self.acts(change, (run, sample));
                        if !cell.change.as_ref().is_none_or(acts) {
                            return 0.0;
                        }
                        cell.parts.iter().map(|(at, by)| row[*at] * by).sum::<f64>()
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
                        time: lanes.stretch.samples.time[lanes.stretch.start + lane],
                        model: &values,
                        further: &further,
                        residual,
                    });
                }
            });
        }
    }

    /// Whether a change acts on a sample (run and number).
    pub fn acts(&self, change: &Change, sample: (usize, usize)) -> bool {
        match change.end {
            None => self.is_after(change.at, sample),
            Some(end) => change.at.0 == sample.0 && (change.at.1..end).contains(&sample.1),
        }
    }

    /// Whether a sample (run and number) comes no earlier than a moment of the same campaign.
    pub fn is_after(&self, moment: (usize, usize), sample: (usize, usize)) -> bool {
        if moment.0 == sample.0 {
            return sample.1 >= moment.1;
        }
        self.part_of(moment.0).0 == self.part_of(sample.0).0
            && self.order[sample.0] > self.order[moment.0]
    }
}
