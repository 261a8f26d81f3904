//! What stands beside a row: blocks that change the same readings, and that have its form.

use std::collections::BTreeMap;

use nalgebra::DVector;

use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::solved::Solved;
use crate::diagnose::budget::terms::{Term, without};
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::{ENTER, TIE, ZERO, ZERO_OF_OWN};
use crate::statistics::ln_chi_squared;

/// Share of the squared length of a row's form that a block leaves, below which it has this form.
pub(super) const SAME_FORM: f64 = 0.01;

impl Selection<'_> {
    /// What the blocks of some kind gain that change the readings that a row changes, beyond what chance
    /// gives.
    pub(super) fn excess_beside(
        &self,
        model: &[usize],
        gains: &[Gain],
        at: usize,
        is_one: impl Fn(&Term) -> bool,
    ) -> f64 {
        let is_block = |term: &Term| !term.is_effect() && is_one(term);
        let blocks = (0..model.len()).filter(|block| is_block(&self.terms[model[*block]]));
        let near = blocks.filter(|block| self.is_beside(model[at], model[*block]));
        near.map(|block| gains[block].excess()).sum()
    }

    /// Whether a block and a row change a common measurand.
    pub(super) fn is_beside(&self, row: usize, block: usize) -> bool {
        let of_row = self.measurands_of(row);
        self.measurands_of(block).iter().any(|one| of_row.contains(one))
    }

    /// Whether a block that is no wider than a row has its form, but for a share of its squared length.
    pub(super) fn has_its_form(
        &self,
        model: &[usize],
        row: usize,
        blocks: &[usize],
        share: f64,
    ) -> bool {
        let width = self.terms[row].columns.len();
        let whole = self.form_left(&[], model, row);
        blocks.iter().any(|block| {
            let own = &self.terms[*block].columns;
            !own.is_empty()
                && own.len() <= width
                && self.form_left(&[*block], model, row) < share * whole
        })
    }

    /// Whether a row is a cause that a user suspects, and what stands in its place is a block that has its
    /// form and explains no more: then it is not the form of other blocks that it mends.
    pub(super) fn needs_its_form(
        &self,
        model: &[usize],
        at: usize,
        gain: Gain,
        blocks: &[usize],
    ) -> bool {
        let row = model[at];
        if !self.terms[row].is_own {
            return false;
        }
        let rest: Vec<usize> = without(model, row).into_iter().map(|one| self.whole(one)).collect();
        let ranked = self.ranked(&rest, blocks);
        ranked.first().is_some_and(|best| {
            let own = self.ln_bayes_factor(row, gain);
            let left = self.form_left(&[best.term], model, row);
            best.ln_bayes >= ENTER
                && best.ln_bayes <= own + TIE
                && left < SAME_FORM * self.form_left(&[], model, row)
        })
    }

    /// Rows whose values beside the whole blocks of the model are consistent with zero, by their place,
    /// with the chi squared of these values.
    pub(super) fn lost_in_remainder(
        &self,
        model: &[usize],
        gains: &[Gain],
    ) -> BTreeMap<usize, f64> {
        let is_row = |at: &usize| self.terms[model[*at]].is_effect();
        let (rows, rest): (Vec<usize>, Vec<usize>) = (0..model.len()).partition(is_row);
        if rest.iter().all(|at| self.terms[model[*at]].reduced_from.is_none()) {
            return BTreeMap::new();
        }
        let whole: Vec<usize> = model.iter().map(|term| self.whole(*term)).collect();
        let solved = Solved::of(self, &whole, &rest, gains);
        // Values that the readings do not determine have no covariance.
        let chi_squared = |at: usize| {
            let range = &solved.terms[at];
            let own = (range.start, range.start);
            let covariance = solved.covariance.view(own, (range.len(), range.len())).into_owned();
            let values = DVector::from_column_slice(solved.of_term(at));
            Some(values.dot(&covariance.cholesky()?.solve(&values)))
        };
        let all = rows.into_iter().filter_map(|at| Some((at, chi_squared(at)?)));
        let may_be_zero = |at: &usize, chi_squared: &f64| {
            let zero = if self.terms[model[*at]].is_own { ZERO_OF_OWN } else { ZERO };
            ln_chi_squared(*chi_squared, solved.terms[*at].len()) > ln_chi_squared(zero, 1)
        };
        all.filter(|(at, chi_squared)| may_be_zero(at, chi_squared)).collect()
    }
}
