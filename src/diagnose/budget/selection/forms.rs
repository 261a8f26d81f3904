//! Forms: what a term does beyond the nominal parameters, and how much of that others absorb.

use std::ops::Range;

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector};

use super::Selection;
use super::normal::{Beside, Factored};
use crate::diagnose::budget::terms::{Combination, Term, without};
use crate::diagnose::evidence::basis::basis;
use crate::diagnose::thresholds::OWN_SHARE;
use crate::estimate::eigen;

/// Added to the diagonal of a block's own sums, columns of unit length.
const RIDGE: f64 = 1e-10;
/// Share of the squared length of a row's form that a block leaves to it, below which it contains
/// the form.
const CONTAINED: f64 = 0.01;
/// Share of a direction of a block from which it is a row's form.
const WITHIN: f64 = 0.5;

impl Selection<'_> {
    /// For each nominal column its part, as a length, of what nominal parameters absorb of a
    /// term's first column.
    pub fn shares_of_nominal(&self, term: usize) -> Vec<(usize, f64)> {
        let model = self.factored(&[]);
        let own = self.terms[term].columns.iter();
        let Some(column) = own.into_iter().find(|column| self.square(column) > 0.0) else {
            return Vec::new();
        };
        let values = self.of_nominal(&model, column);
        let lengths = values.component_mul(&model.factor.length);
        let shares = model.columns.iter().zip(lengths.iter());
        shares.map(|(column, share)| (column[0].0, share.abs())).collect()
    }

    /// The values of nominal columns that make most of a form.
    fn of_nominal(&self, nominal: &Factored, form: &Combination) -> DVector<f64> {
        let products = nominal.columns.iter().map(|other| self.product(other, form));
        let products = DVector::from_iterator(nominal.columns.len(), products);
        nominal.factor.values(&nominal.factor.half(&products))
    }

    /// The block with which a model goes on when a block enters: the block itself, or, where rows of
    /// the model have forms that lie within it, the directions that are left beside these. A named
    /// form keeps what it explains; the block explains the rest.
    pub fn beside_rows(&mut self, model: &[usize], block: usize) -> usize {
        let with = [model, &[block]].concat();
        let within = self.rows_within(&with, block, &self.factored(&with).solved());
        self.reduced(model, block, &within)
    }

    /// The rows of a model whose forms lie within a block of it, from its values `v` and their covariance
    /// `C`. Without the block `b` they are `v - C_b C_bb⁻¹ v_b` and `C - C_b C_bb⁻¹ C_bᵀ`: the inverse of a
    /// matrix without a block.
    fn rows_within(
        &self,
        model: &[usize],
        block: usize,
        (values, covariance): &(DVector<f64>, DMatrix<f64>),
    ) -> Vec<usize> {
        let ranges = self.ranges(model);
        let mut places = model.iter().zip(&ranges);
        let Some((_, of_block)) = places.find(|(term, _)| **term == block) else {
            return Vec::new();
        };
        let part = |rows: &Range<usize>, columns: &Range<usize>| {
            let (from, shape) = ((rows.start, columns.start), (rows.len(), columns.len()));
            covariance.view(from, shape).into_owned()
        };
        let Some(own) = Cholesky::new(part(of_block, of_block)) else { return Vec::new() };
        let block_values = own.solve(&values.rows(of_block.start, of_block.len()));
        let is_within = |(term, range): &(&usize, &Range<usize>)| {
            let across = part(range, of_block);
            let form = values.rows(range.start, range.len()) - &across * &block_values;
            // The inverse of its covariance is what the others leave of a term.
            let left = |covariance| Some(form.dot(&Cholesky::new(covariance)?.solve(&form)));
            let after = part(range, range);
            let before = &after - &across * own.solve(&across.transpose());
            // The form of a cause that a user suspects lies within what would leave too little of it.
            let contained = if self.terms[**term].is_own { OWN_SHARE } else { CONTAINED };
            left(after).zip(left(before)).is_some_and(|(after, before)| after < contained * before)
        };
        let rows = model.iter().zip(&ranges).filter(|(term, _)| self.terms[**term].is_effect());
        rows.filter(is_within).map(|(term, _)| *term).collect()
    }

    /// A block without the forms of rows of a model that lie within it.
    fn reduced(&mut self, model: &[usize], block: usize, within: &[usize]) -> usize {
        if within.is_empty() {
            return block;
        }
        let rest: Vec<usize> = model.iter().copied().filter(|own| !within.contains(own)).collect();
        let factored = self.factored(&rest);
        let columns = self.terms[block].columns.clone();
        let rows = within.iter().flat_map(|term| self.terms[*term].columns.clone());
        let all: Vec<Combination> = columns.iter().cloned().chain(rows).collect();
        let Beside { left, raw, .. } = self.across(&factored, &all);
        let (k, r) = (columns.len(), all.len() - columns.len());
        // Coordinates of the rows' forms in the block: S_bb⁻¹ S_br, columns of unit length.
        let own = DMatrix::from_fn(k, k, |i, j| left[(i, j)] / (raw[i] * raw[j]));
        let across = DMatrix::from_fn(k, r, |i, j| left[(i, k + j)] / (raw[i] * raw[k + j]));
        let Some(factor) = Cholesky::new(own + DMatrix::identity(k, k) * RIDGE) else {
            return block;
        };
        // What is orthogonal, in the metric of S, to the rows' forms.
        let lower = factor.l();
        let Some(forms) = lower.solve_lower_triangular(&across) else { return block };
        // Forms of unit length, orthogonal to each other.
        let rows = DMatrix::from_fn(r, r, |i, j| left[(k + i, k + j)] / (raw[k + i] * raw[k + j]));
        let (orthonormal, _) = basis(&rows, &DVector::from_element(r, 1.0));
        let forms = forms * orthonormal;
        let Some(eigen) = eigen::symmetric(&forms * forms.transpose()) else { return block };
        let Some(back) = lower.transpose().solve_upper_triangular(&eigen.eigenvectors) else {
            return block;
        };
        let mut reduced = Vec::new();
        for (number, share) in eigen.eigenvalues.iter().enumerate() {
            if *share < WITHIN {
                let mut combination: Combination = Vec::new();
                for (i, column) in columns.iter().enumerate() {
                    let by = back[(i, number)] / raw[i];
                    combination.extend(column.iter().map(|(at, own)| (*at, own * by)));
                }
                reduced.push(combination);
            }
        }
        let reduced_from = self.terms[block].reduced_from.or(Some(block));
        let may_enter = !reduced.is_empty();
        let whole = self.terms[block].clone();
        let term = Term { columns: reduced, reduced_from, may_enter, ..whole };
        self.terms[block].may_enter = false;
        self.terms.push(term);
        self.terms.len() - 1
    }

    /// A model with the blocks beside its rows that came in the place of another term; without those
    /// of which rows leave nothing.
    pub fn all_beside_rows(&mut self, mut model: Vec<usize>) -> Vec<usize> {
        let mut solved = None;
        for at in 0..model.len() {
            let (block, own) = (model[at], &self.terms[model[at]]);
            if own.is_effect() || own.change.is_some() || own.reduced_from.is_some() {
                continue;
            }
            let known = solved.get_or_insert_with(|| self.factored(&model).solved());
            let within = self.rows_within(&model, block, known);
            if !within.is_empty() {
                model[at] = self.reduced(&without(&model, block), block, &within);
                solved = None;
            }
        }
        model.retain(|term| !self.terms[*term].columns.is_empty());
        model
    }

    /// A block before it was reduced beside rows; any other term itself.
    pub fn whole(&self, term: usize) -> usize {
        self.terms[term].reduced_from.unwrap_or(term)
    }

    /// A model with the blocks that were reduced beside rows reduced beside those that it has.
    pub fn reduced_anew(&mut self, model: &[usize]) -> Vec<usize> {
        let from = |selection: &Self, term: usize| selection.terms[term].reduced_from;
        let mut anew: Vec<usize> =
            model.iter().copied().filter(|term| from(self, *term).is_none()).collect();
        for term in model {
            if let Some(whole) = from(self, *term) {
                self.terms[whole].may_enter = true;
                let block = self.beside_rows(&anew, whole);
                anew.push(block);
            }
        }
        anew
    }

    /// A term's form with what nominal parameters absorb of it taken off, as one combination of
    /// columns.
    pub fn beyond_nominal(&self, term: usize, values: &[f64]) -> Combination {
        let mut form = self.form(term, values);
        let absorbed = self.absorbed_by_nominal(term, values);
        for (column, value) in self.columns(&[]).into_iter().zip(absorbed) {
            form.extend(column.iter().map(|(at, by)| (*at, -by * value)));
        }
        form
    }

    /// How much of each nominal column is in a term's form.
    pub fn absorbed_by_nominal(&self, term: usize, values: &[f64]) -> Vec<f64> {
        let nominal = self.factored(&[]);
        self.of_nominal(&nominal, &self.form(term, values)).iter().copied().collect()
    }

    /// A term's form as one combination of columns.
    fn form(&self, term: usize, values: &[f64]) -> Combination {
        let columns = self.terms[term].columns.iter().zip(values);
        columns.flat_map(|(all, value)| all.iter().map(move |(at, by)| (*at, by * value))).collect()
    }

    /// Squared length of what a model leaves of all that the terms of another one do together.
    pub fn whole_form_left(&self, beside: &[usize], model: &[usize]) -> f64 {
        let values = self.values(model);
        let of =
            |(term, range): (&usize, Range<usize>)| self.form(*term, &values.as_slice()[range]);
        let whole: Combination = model.iter().zip(self.ranges(model)).flat_map(of).collect();
        self.across(&self.factored(beside), &[whole]).left[(0, 0)]
    }

    /// Whether a row of a model is a cause that a user suspects, and a block has nearly its form: what the
    /// block does better, such as at a few readings where a formula is rounded off, is for what remains.
    pub fn is_nearly_own(&self, model: &[usize], row: usize, block: usize) -> bool {
        let left = |beside: &[usize]| self.form_left(beside, model, row);
        self.terms[row].is_own && left(&[block]) < OWN_SHARE * left(&[])
    }

    /// Whether an effect of the library is no wider than a row of the user's own and has nearly its form.
    pub fn is_copy(&self, model: &[usize], row: usize, effect: usize) -> bool {
        let [own, other] = [row, effect].map(|term| &self.terms[term]);
        other.is_effect()
            && !other.is_own
            && other.columns.len() <= own.columns.len()
            && self.is_nearly_own(model, row, effect)
    }

    /// Squared length of what a model leaves of the form that a term has in another one.
    pub fn form_left(&self, beside: &[usize], model: &[usize], term: usize) -> f64 {
        let values = self.values(model);
        let mut places = model.iter().zip(self.ranges(model));
        let place = places.find(|(own, _)| **own == term).map_or(0..0, |(_, place)| place);
        let form = values.rows(place.start, place.len()).into_owned();
        (form.transpose() * self.left(beside, term) * &form)[(0, 0)]
    }
}
