//! Errors of a reading that depend on an input in one run alone: of a run that scatters more than the
//! others each block over a covariate is tried with values in that run. Whether such a form or noise of
//! the run explains more is for [`crate::diagnose::budget::noise_or_blocks`] to say.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::noise::components;
use crate::diagnose::budget::noise_of_runs::{OfRun, noise_of_runs};
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::selection::normal::{Factored, gain_of};
use crate::diagnose::budget::terms::{Base, Change, Term};
use crate::diagnose::library::place::{Of, Place};
use crate::diagnose::thresholds::{ENTER, TIE};

/// A block with values in one run: products with the columns of a model, with itself, and with the
/// residual.
struct Form {
    block: usize,
    across: DMatrix<f64>,
    square: DMatrix<f64>,
    score: DVector<f64>,
}

/// A measurand in a run in which it scatters more than in the others.
struct Noisy {
    run: usize,
    measurand: usize,
    count: f64,
    chi_squared: f64,
}

impl Linear {
    /// For each run that scatters more than the others the form over a covariate that explains most
    /// there, where it is worth its price beside the noise that the run would have with it.
    pub(super) fn forms_in_runs(&self, selection: &Selection<'_>, model: &[usize]) -> Vec<Change> {
        // A run alone scatters like itself.
        let noisy = match self.order.len() {
            0 | 1 => Vec::new(),
            _ => self.noisy_runs(selection, model),
        };
        if noisy.is_empty() {
            return Vec::new();
        }
        let blocks: Vec<&Term> = selection.terms.iter().filter(|term| is_form(term)).collect();
        let width = |term: &Term| self.candidates[term.candidate].selected.effect.parameters.len();
        let bases_of = |term: &&Term| {
            let candidate = term.candidate;
            (0..width(term)).map(move |signature| Base { candidate, signature })
        };
        let bases: Vec<Base> = blocks.iter().flat_map(bases_of).collect();
        let Factored { factor, half, columns, .. } = selection.factored(model);
        let form = |(block, term): (usize, &&Term)| Form {
            block,
            across: DMatrix::zeros(columns.len(), width(term)),
            square: DMatrix::zeros(width(term), width(term)),
            score: DVector::zeros(width(term)),
        };
        let forms = |_: &Noisy| blocks.iter().enumerate().map(form).collect();
        let mut all: Vec<Vec<Form>> = noisy.iter().map(forms).collect();
        self.visit(selection, model, &bases, &mut |values| {
            let is_of = |one: &Noisy| (one.run, one.measurand) == (values.run, values.measurand);
            let Some(number) = noisy.iter().position(is_of) else { return };
            let weight = selection.scale[values.measurand].powi(-2);
            let mut rest = values.further;
            for form in &mut all[number] {
                let (own, others) = rest.split_at(form.score.len());
                rest = others;
                for (j, x) in own.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                    let x = weight * x;
                    let across = form.across.column_mut(j).into_iter();
                    across.zip(values.model).for_each(|(sum, a)| *sum += x * a);
                    let square = form.square.column_mut(j).into_iter();
                    square.zip(own).for_each(|(sum, y)| *sum += x * y);
                    form.score[j] += x * values.residual;
                }
            }
        });
        let best = |(noisy, forms): (&Noisy, &Vec<Form>)| {
            let of_form = |form: &Form| {
                let across = factor.across(&form.across);
                let left = &form.square - across.tr_mul(&across);
                let score = &form.score - across.tr_mul(&half);
                let gain = gain_of(&left, &score, &form.square.diagonal().map(f64::sqrt));
                let term = blocks[form.block];
                let change = Change {
                    base: Base { candidate: term.candidate, signature: 0 },
                    width: form.score.len(),
                    at: (noisy.run, 0),
                    end: Some(self.fitted.problem.samples_in(noisy.run)),
                    gain,
                    members: self.order.len() * term.members,
                };
                let own = selection.ln_bayes_factor_within(&change, noisy.count, noisy.chi_squared);
                // An input does as much as the reading that follows it.
                let less =
                    if term.place.as_ref().is_some_and(Place::is_over_itself) { TIE } else { 0.0 };
                (own - less, change)
            };
            let best = forms.iter().map(of_form).max_by(|a, b| a.0.total_cmp(&b.0));
            best.filter(|one| one.0 >= ENTER).map(|one| one.1)
        };
        noisy.par_iter().zip(&all).filter_map(best).collect()
    }

    /// Measurands in runs in which they scatter more than in the others.
    fn noisy_runs(&self, selection: &Selection<'_>, model: &[usize]) -> Vec<Noisy> {
        let residuals = components(self, selection, model, &mut |_, _| {});
        let noisy = noise_of_runs(self, &residuals).1.into_iter().filter(|one| one.3 > 1.0);
        let of_run = |(part, run, measurand, _): OfRun| {
            let run = self.fitted.problem.run_index(part, run);
            let measurand = self.sums.first_measurand[part] + measurand;
            let own = residuals.iter().filter(|one| (one.0.0, one.0.1) == (part, measurand));
            let own = own.filter_map(|one| one.1.get(&run)).flatten();
            let (count, sum) = own.fold((0.0, 0.0), |(n, sum), one| (n + 1.0, sum + one.2 * one.2));
            Noisy { run, measurand, count, chi_squared: sum / selection.scale[measurand].powi(2) }
        };
        noisy.map(of_run).collect()
    }
}

/// Whether a term is an error of a reading over a covariate.
fn is_form(term: &Term) -> bool {
    let is_of_reading = |place: &Place| {
        matches!(place.of, Of::Measurand(_)) && !place.is_of_runs() && !place.is_oscillation()
    };
    term.may_enter
        && term.change.is_none()
        && term.candidate != usize::MAX
        && term.place.as_ref().is_some_and(is_of_reading)
}
