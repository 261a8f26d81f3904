//! How large a part of the remainder is in the readings of its measurand.

use crate::diagnose::budget::linear::Measurand;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::place::{Of, Place};
use crate::engine::gram::LeastSquares;

use super::Budget;

impl Budget<'_> {
    /// The rms of what a term does (SI): of an error of a measurand in that one, else in the one in
    /// which it is largest against the noise.
    pub(super) fn rms(&self, term: usize, values: &[f64]) -> Option<(f64, String)> {
        let Self { linear, selection, .. } = self;
        let own = match &linear.terms[term].place {
            Some(Place { of: Of::Measurand(name), .. }) => Some(name),
            _ => None,
        };
        let Fitted { problem, fit, .. } = &linear.fitted;
        let squares = if problem.has_autocorrelated_noise() {
            self.squares_of_readings(term, values)
        } else {
            self.squares_of_sums(term, values)
        };
        let mut best: Option<(f64, f64, &str)> = None;
        for Measurand { number, part, measurand, name } in linear.measurands() {
            // Of a rotation that of the whole turn, not of one component.
            let components = problem.parts[part].slots()[measurand].components;
            let readings = (linear.sums.readings[number] / components) as f64;
            if readings == 0.0 || own.is_some_and(|own| own != name) {
                continue;
            }
            let rms = (squares[number].max(0.0) / readings).sqrt();
            let against = rms / selection.scale[number];
            if best.is_none_or(|(known, ..)| against > known) {
                best = Some((against, rms * problem.rms_sigma(&fit.point, part, measurand), name));
            }
        }
        best.map(|(_, rms, name)| (rms, name.to_owned()))
    }

    /// The sum of squares of what a term does in each measurand.
    fn squares_of_sums(&self, term: usize, values: &[f64]) -> Vec<f64> {
        let Self { linear, selection, .. } = self;
        let form = selection.beyond_nominal(term, values);
        let square = |number: usize| {
            let of = |i: usize, p: f64| {
                let with = |(j, q): &(usize, f64)| q * linear.sums.product_in(number, i, *j);
                p * form.iter().map(with).sum::<f64>()
            };
            form.iter().map(|(i, p)| of(*i, *p)).sum()
        };
        (0..selection.scale.len()).map(square).collect()
    }

    /// The same of readings under autocorrelated noise, without its weights: these are those of
    /// differences of readings, in which what varies slowly is small.
    fn squares_of_readings(&self, term: usize, values: &[f64]) -> Vec<f64> {
        let Self { linear, selection, .. } = self;
        let mut plain = (*linear).clone();
        let Fitted { problem, fit, .. } = &mut plain.fitted;
        problem.parts.iter_mut().for_each(|part| part.gauss_markov.fill(None));
        problem.reweight(&fit.point);
        let absorbed = selection.absorbed_by_nominal(term, values).into_iter();
        let by: Vec<f64> = absorbed.map(|value| -value).chain(values.iter().copied()).collect();
        let mut squares = vec![0.0; selection.scale.len()];
        plain.visit(selection, &[term], &[], &mut |one| {
            let size: f64 = one.model.iter().zip(&by).map(|(column, by)| column * by).sum();
            squares[one.measurand] += size.powi(2);
        });
        squares
    }
}
