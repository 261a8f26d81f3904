//! Stated values that are wrong, as terms: a column that acts in the equations of a parameter's prior
//! alone, so that the readings decide the value.
//!
//! What a campaign fixes although the model leaves it open has no equation: its term is another value of it
//! in all runs. What the model itself fixes is not tried. Nor is a value of which the
//! readings say something only because rows are in the fit. A derivative by it has a part that is the
//! product of the value of a row and a change of the form of that row. In the place of the row this part
//! would explain whatever the row does, at a value that is wrong by all of its size; without the
//! row there is no such part.

use nalgebra::DMatrix;

use super::in_fit::absent;
use super::linear::Linear;
use super::selection::Selection;
use super::sums::Appended;
use super::terms::{Base, Term};
use crate::diagnose::library::place::Place;
use crate::engine::gram::{LeastSquares, PriorRow};
use crate::estimate::arrow::normal_matrix;
use crate::estimate::inverse_factor::Factor;

/// Part of the redundancy of a stated value in the linearised fit that it must have where the rows
/// are zero.
const WITHOUT_ROWS: f64 = 0.5;

impl Linear {
    /// Adds for each parameter with stated values the term that they are wrong.
    pub(super) fn with_stated_values(&mut self) {
        let layout = &self.fitted.problem.layout;
        let mut of_priors: Vec<(usize, Vec<usize>)> = Vec::new();
        for (row, prior) in self.sums.priors.iter().enumerate() {
            let acts = |column: usize| prior.coefficients.iter().any(|(own, _)| *own == column);
            let own = (0..layout.instances.len()).find(|instance| {
                let mut columns = layout.own_columns(*instance);
                columns.any(|(_, column)| acts(column))
            });
            let Some(instance) = own else { continue };
            match of_priors.iter_mut().find(|(known, _)| *known == instance) {
                Some((_, rows)) => rows.push(row),
                None => of_priors.push((instance, vec![row])),
            }
        }
        let first = self.terms.len();
        let mut equations: Vec<Vec<PriorRow>> = Vec::new();
        for (instance, rows) in of_priors {
            equations.push(rows.iter().map(|row| self.sums.priors[*row].clone()).collect());
            let one = &self.fitted.problem.layout.instances[instance];
            let place = Place::of_stated(&one.name, one.whose());
            let (name, mut columns) = (place.words.clone(), Vec::new());
            for row in rows {
                let column = self.sums.append(&Appended::default());
                self.sums.priors[row].coefficients.push((column, 1.0));
                columns.push(vec![(column, 1.0)]);
            }
            self.terms.push(Term::new(name, Some(place), columns));
        }
        self.drop_those_of_rows(first, &equations);
        self.with_fixed_values();
    }

    /// Adds for each component of a parameter that a campaign fixes the term that its value is wrong:
    /// another value in each run of the campaign, all alike.
    fn with_fixed_values(&mut self) {
        let problem = &self.fitted.problem;
        let runs = problem.run_names();
        let mut terms = Vec::new();
        for candidate in 0..self.candidates.len() {
            let Some(name) = self.fixed(candidate) else { continue };
            for (number, part) in problem.parts.iter().enumerate() {
                let is_of_part = |column: &usize| {
                    let of = self.sums.owners[column - self.sums.nominal].of.as_ref();
                    let run = of.and_then(|of| runs.iter().position(|run| run == of));
                    run.is_some_and(|run| problem.run_at(run).0 == number)
                };
                let own = self.sums.of_candidate[candidate].iter().copied().filter(is_of_part);
                let all: Vec<(usize, f64)> = own.map(|column| (column, 1.0)).collect();
                if !all.is_empty() {
                    let label = part.label.as_deref().filter(|_| problem.parts.len() > 1);
                    let place = Place::of_stated(&name, label);
                    let term = Term::new(place.words.clone(), Some(place), vec![all]);
                    terms.push(Term { candidate, ..term });
                }
            }
        }
        self.terms.extend(terms);
    }

    /// The name of the component of a parameter of which a block is another value, if the campaign fixes it.
    pub(super) fn fixed(&self, candidate: usize) -> Option<String> {
        let (name, component) = self.candidates[candidate].place.as_ref()?.component()?;
        let layout = &self.fitted.problem.layout;
        let mut own = (0..layout.instances.len()).filter(|at| layout.instances[*at].name == name);
        let is_fixed = |at: usize| layout.columns_of(at, component.unwrap_or(0)).is_empty();
        let first = own.next().filter(|at| is_fixed(*at))?;
        let all_are = own.all(is_fixed);
        let axis = component.map_or("", |axis| [".x", ".y", ".z"][axis]);
        (all_are && component.is_none_or(|one| one < layout.instances[first].dimension()))
            .then(|| format!("{name}{axis}"))
    }

    /// Whether a change of a parameter is in all readings on which that value of it acts. It is no
    /// change: the fit estimates the value, and where one is stated that is wrong.
    pub(super) fn is_whole_value(
        &self,
        base: Base,
        at: (usize, usize),
        end: Option<usize>,
    ) -> bool {
        let problem = &self.fitted.problem;
        if at.1 > 0 || end.is_some_and(|end| end != problem.samples_in(at.0)) {
            return false;
        }
        let place = self.candidates[base.candidate].place.as_ref();
        let Some(name) = place.and_then(Place::parameter) else { return false };
        let value_in = |run: usize| {
            let (part, run) = problem.run_at(run);
            let mut names = problem.parts[part].system.assembly.names.parameters.iter();
            let parameter = names.position(|one| one.name == name)?;
            Some(problem.layout.instance_in(part, run, parameter))
        };
        let part = |run: usize| problem.run_at(run).0;
        let is_changed = |run: usize| match end {
            Some(_) => run == at.0,
            None => part(run) == part(at.0) && self.order[run] >= self.order[at.0],
        };
        let own = value_in(at.0);
        (0..self.order.len()).all(|run| (value_in(run) == own) == is_changed(run))
    }

    /// Takes out the values, of the terms from a first one on with these equations, whose redundancy
    /// is of the rows.
    fn drop_those_of_rows(&mut self, first: usize, equations: &[Vec<PriorRow>]) {
        if self.active.is_empty() || equations.is_empty() {
            return;
        }
        let Some((columns, factor)) = self.where_rows_are_zero() else { return };
        let selection = Selection::new(&self.sums, &self.terms, &self.active);
        let kept: Vec<Vec<bool>> = equations
            .iter()
            .zip(first..)
            .map(|(equations, term)| {
                let redundancy = selection.left(&[], term);
                let is_kept = |(at, equation): (usize, &PriorRow)| {
                    let of = |column: &usize| {
                        let own = equation.coefficients.iter().filter(|(own, _)| own == column);
                        own.map(|(_, by)| by).sum::<f64>()
                    };
                    let row = DMatrix::from_iterator(columns.len(), 1, columns.iter().map(of));
                    let without = 1.0 - factor.across(&row).norm_squared();
                    // Where a number cannot be computed nothing is known against the value.
                    let is_of_rows = without < WITHOUT_ROWS * redundancy[(at, at)];
                    !is_of_rows
                };
                equations.iter().enumerate().map(is_kept).collect()
            })
            .collect();
        for (term, kept) in self.terms[first..].iter_mut().zip(kept) {
            let mut kept = kept.into_iter();
            term.columns.retain(|_| kept.next().unwrap_or(true));
        }
    }

    /// The nominal columns, and their normal equations where every row is zero; `None` where these
    /// are no numbers.
    fn where_rows_are_zero(&self) -> Option<(Vec<usize>, Factor)> {
        let Self { fitted, active, .. } = self;
        let names = self.rows().into_iter().map(|row| &self.terms[row].name);
        let point = names.fold(fitted.fit.point.clone(), |at, row| absent(fitted, row, at));
        let (hessian, _) = normal_matrix(&fitted.problem.normal(&point)).ok()?;
        let is_nominal = |column: &usize| active.iter().all(|(own, _)| own != column);
        let columns: Vec<usize> = (0..hessian.nrows()).filter(is_nominal).collect();
        let own = hessian.select_rows(&columns).select_columns(&columns);
        own.iter().all(|value| value.is_finite()).then(|| (columns, Factor::of(&own)))
    }
}
