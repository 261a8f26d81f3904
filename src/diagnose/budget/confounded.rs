//! Effects that the readings do not separate from a row: other rows whose values are correlated with
//! its own, and effects outside the fit whose form is nearly the row's.
//!
//! Only a combination of the two is well determined. Where the other effect is outside the fit, it
//! may be there all the same; the row's standard uncertainty allows for that, at the typical size of
//! the other one and with the posterior probability that it is there, too (model average). It does
//! not say which of the two is there: that is the posterior of the row.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};

use crate::diagnose::evidence::basis::basis;

use super::answer::{Confounded, Size};
use super::linear::Linear;
use super::selection::Selection;
use super::selection::normal::Beside;
use super::solved::Solved;
use super::terms::without;
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::{CONFOUNDED, IN_PART, NEAR_ALIAS};

/// Effects outside the fit that are compared with a row at most.
const MOST: usize = 4;
/// Share of its squared length below which an effect is absorbed by the other rows.
const ABSORBED: f64 = 0.01;
/// Correlation beyond which two effects have no separate values.
const ONE: f64 = 0.9999;

impl Solved {
    /// Rows whose values are correlated with those of a row.
    fn confounded_rows(
        &self,
        selection: &Selection<'_>,
        model: &[usize],
        at: usize,
    ) -> Vec<Confounded> {
        let own = |other: usize| &selection.terms[model[other]];
        let others = (0..model.len()).filter(|other| *other != at && own(*other).is_effect());
        others
            .map(|other| (other, self.correlation(at, other)))
            .filter(|(_, correlation)| correlation.abs() >= CONFOUNDED)
            .map(|(other, correlation)| Confounded {
                name: own(other).name.clone(),
                is_row: true,
                is_probable: true,
                correlation,
                factor: self.factor(at, other),
                joint: Vec::new(),
            })
            .collect()
    }

    /// The largest correlation of a value of one term with one of another.
    fn correlation(&self, one: usize, other: usize) -> f64 {
        let mut most = 0.0_f64;
        for i in self.terms[one].clone() {
            for j in self.terms[other].clone() {
                let root = (self.covariance[(i, i)] * self.covariance[(j, j)]).sqrt();
                let correlation = self.covariance[(i, j)] / root;
                if correlation.abs() > most.abs() {
                    most = correlation;
                }
            }
        }
        most
    }

    /// `k` where `row + k * other` is uncorrelated with the other one, of two effects with one value.
    fn factor(&self, row: usize, other: usize) -> Option<f64> {
        let (row, other) = (self.terms[row].clone(), self.terms[other].clone());
        let slope = |i: usize, j: usize| -self.covariance[(i, j)] / self.covariance[(j, j)];
        (row.len() == 1 && other.len() == 1).then(|| slope(row.start, other.start))
    }

    /// What all values vary with those of a term, `E(all | term) = K term`, and the inverse covariance
    /// of the term's.
    fn slope(&self, term: usize) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let own = self.terms[term].clone();
        let covariance = self.covariance.view((own.start, own.start), (own.len(), own.len()));
        let inverse = covariance.into_owned().cholesky()?.inverse();
        Some((self.covariance.columns(own.start, own.len()) * &inverse, inverse))
    }

    /// Adds what an effect outside the fit, near a row, may put into all values: `with` has the effect
    /// in it, last.
    fn widen(&mut self, at: usize, with: &Self, typical: &[Option<f64>], ln_bayes: f64) {
        let other = with.terms.len() - 1;
        let Some((slope, inverse)) = with.slope(other) else { return };
        let slope = slope.rows(0, self.values.len());
        let found = DVector::from_column_slice(with.of_term(other));
        // Without a typical size the other one is as large as the row.
        let of_row = slope.rows(self.terms[at].start, self.terms[at].len()).norm();
        let own = DVector::from_column_slice(self.of_term(at)).norm();
        let reach = own / of_row.max(f64::MIN_POSITIVE);
        let typical = typical.iter().map(|typical| typical.unwrap_or(reach).powi(-2));
        let prior = DMatrix::from_diagonal(&DVector::from_iterator(found.len(), typical));
        let Some(factor) = (&inverse + prior).cholesky() else { return };
        let covariance = factor.inverse();
        let mean = &covariance * &inverse * found;
        let probability = 1.0 / (1.0 + (-ln_bayes).exp());
        let spread = slope * (covariance + &mean * mean.transpose()) * slope.transpose();
        self.covariance += spread * probability;
    }
}

/// For each row (by its place in the model) the rows whose values are correlated with its own, and the
/// effects outside the fit whose form is nearly its own. What these may put into the values, of
/// whichever row, is added to the covariance: once for each.
pub fn confounded(
    linear: &Linear,
    selection: &Selection<'_>,
    solved: &mut Solved,
    (model, rest, gains): (&[usize], &[usize], &[Gain]),
    rows: &[usize],
) -> Vec<Vec<Confounded>> {
    // Before anything is added.
    let others = |at: &usize| solved.confounded_rows(selection, model, *at);
    let mut all: Vec<Vec<Confounded>> = rows.iter().map(others).collect();
    let mut known = BTreeSet::new();
    for (at, found) in rows.iter().zip(&mut all) {
        let near = selection.near(model, *at, solved.of_term(*at));
        for (term, cosine) in near.into_iter().take(MOST) {
            let with = [model, &[term]].concat();
            let both = Solved::of(selection, &with, rest, gains);
            let typical = selection.typical(term);
            let ln_odds = selection.ln_odds_at(model, term, &typical);
            if known.insert(&linear.terms[term].name) {
                solved.widen(*at, &both, &typical, ln_odds);
            }
            // Of several values each pair has another correlation: that of the forms is reported.
            let factor = both.factor(*at, model.len());
            let of_forms = -cosine.sqrt();
            let correlation = factor.map_or(of_forms, |_| both.correlation(*at, model.len()));
            let joint = if correlation.abs() < ONE {
                let own = both.measured(linear, selection, model[*at], *at);
                let others = both.measured(linear, selection, term, model.len());
                own.into_iter().chain(others).collect()
            } else {
                Vec::new()
            };
            found.push(Confounded {
                name: linear.terms[term].name.clone(),
                is_row: false,
                is_probable: ln_odds > 0.0,
                correlation,
                factor,
                joint,
            });
        }
    }
    all
}

impl Solved {
    /// The values of a term with their standard uncertainties.
    fn measured(
        &self,
        linear: &Linear,
        selection: &Selection<'_>,
        term: usize,
        at: usize,
    ) -> Vec<(Size, f64)> {
        let columns = selection.terms[term].columns.iter().zip(self.terms[at].clone());
        columns
            .filter_map(|(column, place)| {
                let size = linear.size(column.first()?.0, self.values[place])?;
                Some((size, self.covariance[(place, place)].max(0.0).sqrt()))
            })
            .collect()
    }
}

impl Selection<'_> {
    /// The typical sizes of a term's values.
    fn typical(&self, term: usize) -> Vec<Option<f64>> {
        let columns = self.terms[term].columns.iter();
        columns.map(|column| self.sums.typical_of(column.first()?.0)).collect()
    }

    /// Effects outside a model whose form is nearly that of one of its terms (by its place) with
    /// given values, or has part of it and is there more probably than not: with the squared cosine,
    /// largest first.
    fn near(&self, model: &[usize], at: usize, values: &[f64]) -> Vec<(usize, f64)> {
        let term = model[at];
        let rest = without(model, term);
        let (factored, nominal) = (self.factored(&rest), self.factored(&[]));
        let own = &self.terms[term].columns;
        let values = DVector::from_column_slice(values);
        let mut found: Vec<(usize, f64)> = (0..self.terms.len())
            .filter(|other| {
                self.terms[*other].may_enter
                    && self.terms[*other].is_effect()
                    && !model.contains(other)
            })
            .filter_map(|other| {
                let both: Vec<_> = own.iter().chain(&self.terms[other].columns).cloned().collect();
                let Beside { left, raw, .. } = self.across(&factored, &both);
                let (k, n) = (own.len(), both.len());
                let form = left.view((0, 0), (k, k)) * &values;
                let square = values.dot(&form);
                let across = left.view((k, 0), (n - k, k)) * &values;
                let others = left.view((k, k), (n - k, n - k)).into_owned();
                // What another row absorbs is reported there.
                let alone = self.across(&nominal, &self.terms[other].columns).left;
                if others.trace() < ABSORBED * alone.trace() {
                    return None;
                }
                let raw = raw.rows(k, n - k).into_owned();
                let (basis, _) = basis(&others, &raw);
                let cosine = basis.tr_mul(&across).norm_squared() / square;
                let is_probable = || self.ln_odds_at(model, other, &self.typical(other)) > 0.0;
                let is_near = cosine >= NEAR_ALIAS || cosine >= IN_PART && is_probable();
                (square > 0.0 && is_near).then_some((other, cosine.min(1.0)))
            })
            .collect();
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        // An effect in two forms is one alias.
        let mut names = BTreeSet::new();
        found.retain(|(other, _)| names.insert(&self.terms[*other].name));
        found
    }
}
