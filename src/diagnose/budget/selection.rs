//! Terms in competition: what each would take off chi squared beside a model, and what each of the
//! model's terms contributes, under noise scale factors that follow from the model.
//!
//! With the nominal columns and those of the model's terms `M`, a term `j` has
//! `S = H_jj - H_jM H_MM⁻¹ H_Mj` and the score `g` likewise; it takes `gᵀ S⁺ g` off chi squared,
//! over the directions of which more than a share of 3e-4 of their length is left. Where none is left
//! the term is absorbed and never enters. It searches nothing.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};

use super::price::{Gain, ln_bayes_factor, price};
use super::sums::{Sums, Weighted};
use super::terms::{Combination, Term};
use crate::diagnose::evidence::basis::basis;
use crate::estimate::eigen;

/// Added to the diagonal of scaled normal equations: what the readings do not determine stays where
/// it is.
const RIDGE: f64 = 1e-10;
/// Share of the squared length of a row's form that a block leaves to it, below which it contains
/// the form.
const CONTAINED: f64 = 0.01;
/// Share of a direction of a block from which it is a row's form.
const WITHIN: f64 = 0.5;
/// Rounds in which noise scale factors and model settle.
const ROUNDS: usize = 3;

/// The terms and the sums that they are compared on.
#[derive(Clone, Debug)]
pub struct Selection<'a> {
    /// The sums.
    pub sums: &'a Sums,
    /// The terms.
    pub terms: Vec<Term>,
    /// Whether each may enter.
    pub live: Vec<bool>,
    /// Noise scale factor of each measurand: found over stated standard deviation.
    pub scale: Vec<f64>,
    /// Columns of the nominal parameters.
    nominal: Vec<Combination>,
    /// The residual of the nominal model.
    residual: Combination,
    weighted: Weighted<'a>,
    /// Product of each column with the residual.
    score: Vec<f64>,
    effects: usize,
    blocks: usize,
}

/// A model's normal equations, factored.
struct Factored {
    columns: Vec<Combination>,
    factor: Cholesky<f64, Dyn>,
    /// `L⁻¹`: one product with it is quicker than a triangular solution for many columns.
    inverse: DMatrix<f64>,
    length: DVector<f64>,
    /// `L⁻¹ b` of scaled columns.
    half: DVector<f64>,
}

impl<'a> Selection<'a> {
    /// Of terms; `active` rows that are in the fit with their values (column and value).
    pub fn new(sums: &'a Sums, terms: &[Term], active: &[(usize, f64)]) -> Self {
        let in_fit = |column: usize| active.iter().any(|(own, _)| *own == column);
        let nominal = (0..sums.nominal).filter(|column| !in_fit(*column));
        let mut residual = vec![(sums.residual(), 1.0)];
        residual.extend(active);
        let count = |effect: bool| terms.iter().filter(|one| one.is_effect() == effect).count();
        let scale = vec![1.0; sums.readings.len()];
        let weighted = sums.weighted(&vec![1.0; scale.len()]);
        let mut selection = Self {
            sums,
            terms: terms.to_vec(),
            live: terms.iter().map(|one| !one.columns.is_empty()).collect(),
            scale,
            nominal: nominal.map(|column| vec![(column, 1.0)]).collect(),
            residual,
            weighted,
            score: Vec::new(),
            effects: count(true),
            blocks: count(false).max(1),
        };
        selection.weigh();
        selection
    }

    /// Sums anew with the noise scale factors as they are.
    fn weigh(&mut self) {
        let weights: Vec<f64> = self.scale.iter().map(|scale| scale.powi(-2)).collect();
        self.weighted = self.sums.weighted(&weights);
        let product = |column| {
            self.residual.iter().map(|(other, by)| by * self.weighted.product(column, *other)).sum()
        };
        self.score = (0..self.sums.len()).map(product).collect();
    }

    /// The product of two combinations of columns.
    fn product(&self, a: &Combination, b: &Combination) -> f64 {
        let with = |(i, p): &(usize, f64)| {
            p * b.iter().map(|(j, q)| q * self.weighted.product(*i, *j)).sum::<f64>()
        };
        a.iter().map(with).sum()
    }

    fn score_of(&self, a: &Combination) -> f64 {
        a.iter().map(|(column, by)| by * self.score[*column]).sum()
    }

    /// The columns of a model: nominal ones, then those of its terms in order.
    pub fn columns(&self, model: &[usize]) -> Vec<Combination> {
        let own = model.iter().flat_map(|term| self.terms[*term].columns.iter().cloned());
        self.nominal.iter().cloned().chain(own).collect()
    }

    /// Number of nominal columns.
    pub fn nominal(&self) -> usize {
        self.nominal.len()
    }

    /// The residual of the nominal model: the fit's, with what rows in the fit explain added back.
    pub fn residual(&self) -> &Combination {
        &self.residual
    }

    fn factored(&self, model: &[usize]) -> Factored {
        let columns = self.columns(model);
        let n = columns.len();
        let mut matrix = DMatrix::zeros(n, n);
        for i in 0..n {
            for j in 0..=i {
                let sum = self.product(&columns[i], &columns[j]);
                matrix[(i, j)] = sum;
                matrix[(j, i)] = sum;
            }
        }
        let score = DVector::from_fn(n, |i, _| self.score_of(&columns[i]));
        let (factor, length) = factored(&matrix);
        let inverse = inverse_lower(&factor);
        let half = &inverse * score.component_div(&length);
        Factored { columns, factor, inverse, length, half }
    }

    /// Squared length of a column.
    pub fn square(&self, column: &Combination) -> f64 {
        self.product(column, column)
    }

    /// For each nominal column its part, as a length, of what nominal parameters absorb of a
    /// term's first column.
    pub fn shares_of_nominal(&self, term: usize) -> Vec<(usize, f64)> {
        let model = self.factored(&[]);
        let own = self.terms[term].columns.iter();
        let Some(column) = own.into_iter().find(|column| self.square(column) > 0.0) else {
            return Vec::new();
        };
        let across = model.columns.iter().zip(model.length.iter());
        let across = across.map(|(other, length)| self.product(other, column) / length);
        let mut share = DVector::from_iterator(model.columns.len(), across);
        model.factor.solve_mut(&mut share);
        let shares = model.columns.iter().zip(share.iter());
        shares.map(|(column, share)| (column[0].0, share.abs())).collect()
    }

    /// Chi squared of a model.
    pub fn chi_squared(&self, model: &[usize]) -> f64 {
        self.product(&self.residual, &self.residual) - self.factored(model).half.norm_squared()
    }

    /// Values of the columns of a model, and their covariance.
    pub fn solved(&self, model: &[usize]) -> (DVector<f64>, DMatrix<f64>) {
        let Factored { factor, length, half, .. } = self.factored(model);
        let mut values = half;
        factor.l_dirty().tr_solve_lower_triangular_mut(&mut values);
        let values = values.component_div(&length);
        let mut inverse = factor.inverse();
        for i in 0..length.len() {
            for j in 0..length.len() {
                inverse[(i, j)] /= length[i] * length[j];
            }
        }
        (values, inverse)
    }

    /// The normal equations of a model, columns scaled to unit length, with `L` their Cholesky factor:
    /// `L⁻¹`, the lengths, and `L⁻¹` times the scores.
    pub fn normal_equations(&self, model: &[usize]) -> (DMatrix<f64>, DVector<f64>, DVector<f64>) {
        let Factored { inverse, length, half, .. } = self.factored(model);
        (inverse, length, half)
    }

    /// `S` and `g` of some columns beside a model, and their raw lengths.
    fn beside(
        &self,
        model: &Factored,
        columns: &[Combination],
    ) -> (DMatrix<f64>, DVector<f64>, DVector<f64>) {
        let (n, k) = (model.columns.len(), columns.len());
        let mut across = DMatrix::zeros(n, k);
        for (j, column) in columns.iter().enumerate() {
            for i in 0..n {
                across[(i, j)] = self.product(&model.columns[i], column) / model.length[i];
            }
        }
        let across = &model.inverse * across;
        let own = DMatrix::from_fn(k, k, |i, j| self.product(&columns[i], &columns[j]));
        let raw = own.diagonal().map(|square| square.max(0.0).sqrt());
        let score = DVector::from_fn(k, |j, _| self.score_of(&columns[j]));
        let left = own - across.tr_mul(&across);
        let score = score - across.tr_mul(&model.half);
        (left, score, raw)
    }

    /// What a term takes off chi squared beside a model.
    pub fn gain(&self, model: &[usize], term: usize) -> Gain {
        let model = self.factored(model);
        self.gain_beside(&model, term)
    }

    fn gain_beside(&self, model: &Factored, term: usize) -> Gain {
        let (left, score, raw) = self.beside(model, &self.terms[term].columns);
        gain_of(&left, &score, &raw)
    }

    /// The Schur complement of a term's columns beside a model.
    pub fn left(&self, model: &[usize], term: usize) -> DMatrix<f64> {
        self.beside(&self.factored(model), &self.terms[term].columns).0
    }

    /// The log Bayes factor of a gain of a term.
    pub fn ln_bayes_factor(&self, term: usize, gain: Gain) -> f64 {
        let own = &self.terms[term];
        ln_bayes_factor(gain, own.members, self.candidates(term)) + own.ln_prior
    }

    /// Number of candidates of a term's kind.
    fn candidates(&self, term: usize) -> usize {
        if self.terms[term].is_effect() { self.effects } else { self.blocks }
    }

    /// The block with which a model goes on when a block enters: the block itself, or, where rows of
    /// the model have forms that lie within it, the directions that are left beside these. A named
    /// form keeps what it explains; the block explains the rest.
    pub fn beside_rows(&mut self, model: &[usize], block: usize) -> usize {
        let with = [model, &[block]].concat();
        let within: Vec<usize> = model
            .iter()
            .copied()
            .filter(|term| self.terms[*term].is_effect())
            .filter(|term| {
                let rest: Vec<usize> = with.iter().copied().filter(|own| own != term).collect();
                let before: Vec<usize> = model.iter().copied().filter(|own| own != term).collect();
                self.form_left(&rest, model, *term)
                    < CONTAINED * self.form_left(&before, model, *term)
            })
            .collect();
        if within.is_empty() {
            return block;
        }
        let rest: Vec<usize> = model.iter().copied().filter(|own| !within.contains(own)).collect();
        let factored = self.factored(&rest);
        let columns = self.terms[block].columns.clone();
        let rows = within.iter().flat_map(|term| self.terms[*term].columns.clone());
        let all: Vec<Combination> = columns.iter().cloned().chain(rows).collect();
        let (left, _, raw) = self.beside(&factored, &all);
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
        let term = Term { columns: reduced, reduced_from, ..self.terms[block].clone() };
        self.live.push(!term.columns.is_empty());
        self.live[block] = false;
        self.terms.push(term);
        self.terms.len() - 1
    }

    /// A term's form with what nominal parameters absorb of it taken off, as one combination of
    /// columns.
    pub fn beyond_nominal(&self, term: usize, values: &[f64]) -> Combination {
        let mut form: Combination = Vec::new();
        for (column, value) in self.terms[term].columns.iter().zip(values) {
            form.extend(column.iter().map(|(at, by)| (*at, by * value)));
        }
        let nominal = self.factored(&[]);
        let across = nominal.columns.iter().zip(nominal.length.iter());
        let across = across.map(|(other, length)| self.product(other, &form) / length);
        let mut share = DVector::from_iterator(nominal.columns.len(), across);
        nominal.factor.solve_mut(&mut share);
        for ((column, length), share) in
            nominal.columns.iter().zip(nominal.length.iter()).zip(share.iter())
        {
            form.extend(column.iter().map(|(at, by)| (*at, -by * share / length)));
        }
        form
    }

    /// Squared length of what a model leaves of the form that a term has in another one.
    pub fn form_left(&self, beside: &[usize], model: &[usize], term: usize) -> f64 {
        let (values, _) = self.solved(model);
        let mut first = self.nominal();
        for own in model.iter().take_while(|own| **own != term) {
            first += self.terms[*own].columns.len();
        }
        let form = values.rows(first, self.terms[term].columns.len()).into_owned();
        (form.transpose() * self.left(beside, term) * &form)[(0, 0)]
    }

    /// Terms of a pool beside a model, best first: log Bayes factor, term, gain. Those that gain
    /// less than `least` are not among them.
    pub fn ranked(&self, model: &[usize], pool: &[usize], least: f64) -> Vec<Ranked> {
        let factored = self.factored(model);
        let mut ranked: Vec<Ranked> = pool
            .iter()
            .filter(|term| self.live[**term] && !model.contains(term))
            .map(|term| {
                let gain = self.gain_beside(&factored, *term);
                Ranked { term: *term, gain, ln_bayes: self.ln_bayes_factor(*term, gain) }
            })
            .filter(|one| one.gain.gain >= least)
            .collect();
        ranked.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
        ranked
    }

    /// What each term of a model contributes beyond the others.
    pub fn contributions(&self, model: &[usize]) -> Vec<Gain> {
        let without = |term: usize| -> Vec<usize> {
            model.iter().copied().filter(|other| *other != term).collect()
        };
        model.iter().map(|term| self.gain(&without(*term), *term)).collect()
    }

    /// Log evidence of a model but for a constant: comparable between models under the same noise.
    pub fn ln_evidence(&self, model: &[usize]) -> f64 {
        let prices = model.iter().zip(self.contributions(model)).map(|(term, gain)| {
            price(gain, self.terms[*term].members, self.candidates(*term))
                - self.terms[*term].ln_prior
        });
        -0.5 * self.chi_squared(model) - prices.sum::<f64>()
    }

    /// What the terms of a model cost together.
    pub fn ln_price_of(&self, model: &[usize]) -> f64 {
        let prices = model
            .iter()
            .zip(self.contributions(model))
            .map(|(term, gain)| price(gain, self.terms[*term].members, self.candidates(*term)));
        prices.sum()
    }

    /// Lets the noise scale factors follow from a model: the residual sum of squares of each
    /// measurand over its readings less the model's degrees of freedom.
    pub fn set_scale(&mut self, model: &[usize]) {
        for _ in 0..ROUNDS {
            let (values, covariance) = self.solved(model);
            let columns = self.columns(model);
            let mut vector = self.residual.clone();
            for (column, value) in columns.iter().zip(values.iter()) {
                vector.extend(column.iter().map(|(own, by)| (*own, -by * value)));
            }
            let mut next = self.scale.clone();
            for (measurand, next) in next.iter_mut().enumerate() {
                let readings = self.sums.readings[measurand] as f64;
                if readings == 0.0 {
                    continue;
                }
                let product = |a: &Combination, b: &Combination| -> f64 {
                    let with = |(i, p): &(usize, f64)| {
                        let sum =
                            |(j, q): &(usize, f64)| q * self.sums.product_in(measurand, *i, *j);
                        p * b.iter().map(sum).sum::<f64>()
                    };
                    a.iter().map(with).sum()
                };
                let square = product(&vector, &vector);
                let mut freedom = 0.0;
                for (i, a) in columns.iter().enumerate() {
                    for (j, b) in columns.iter().enumerate().take(i + 1) {
                        let times = if i == j { 1.0 } else { 2.0 };
                        freedom += times * covariance[(i, j)] * product(a, b);
                    }
                }
                freedom /= self.scale[measurand].powi(2);
                *next = (square.max(0.0) / (readings - freedom).max(1.0)).sqrt().max(1e-12);
            }
            let change = next.iter().zip(&self.scale).map(|(new, old)| (new / old - 1.0).abs());
            let is_settled = change.fold(0.0, f64::max) < 1e-4;
            self.scale = next;
            self.weigh();
            if is_settled {
                break;
            }
        }
    }

    /// The same noise scale factors as another selection.
    pub fn adopt_scale(&mut self, scale: &[f64]) {
        self.scale = scale.to_vec();
        self.weigh();
    }
}

/// A term beside a model.
#[derive(Clone, Copy, Debug)]
pub struct Ranked {
    /// The term.
    pub term: usize,
    /// What it takes off chi squared.
    pub gain: Gain,
    /// Its log Bayes factor.
    pub ln_bayes: f64,
}

/// The gain of a score `g` with Schur complement `S`.
pub fn gain_of(left: &DMatrix<f64>, score: &DVector<f64>, raw: &DVector<f64>) -> Gain {
    if !left.iter().chain(score.iter()).all(|value| value.is_finite()) || left.nrows() == 0 {
        return Gain::default();
    }
    let (basis, _) = basis(left, raw);
    let score = basis.tr_mul(score);
    Gain { gain: score.norm_squared(), degrees: score.len() }
}

/// `L⁻¹` of a factor.
fn inverse_lower(factor: &Cholesky<f64, Dyn>) -> DMatrix<f64> {
    let n = factor.l_dirty().nrows();
    let mut inverse = DMatrix::identity(n, n);
    factor.l_dirty().solve_lower_triangular_mut(&mut inverse);
    inverse
}

/// The factor of normal equations whose columns are scaled to unit length, and the lengths.
pub fn factored(matrix: &DMatrix<f64>) -> (Cholesky<f64, Dyn>, DVector<f64>) {
    let n = matrix.nrows();
    let length = matrix.diagonal().map(|square| if square > 0.0 { square.sqrt() } else { 1.0 });
    let scaled = |ridge: f64| {
        DMatrix::from_fn(n, n, |i, j| {
            matrix[(i, j)] / (length[i] * length[j]) + f64::from(i == j) * ridge
        })
    };
    let mut ridge = RIDGE;
    loop {
        if let Some(factor) = Cholesky::new(scaled(ridge)) {
            return (factor, length);
        }
        if ridge > 1.0 {
            let unit = DMatrix::identity(n, n);
            // Sums that are no numbers: nothing is taken off anything.
            return (Cholesky::pack_dirty(unit), length);
        }
        ridge *= 10.0;
    }
}
