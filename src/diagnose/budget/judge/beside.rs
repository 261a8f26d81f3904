//! What stands beside a row: blocks that change the same readings, and that have its form.

use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::terms::{Term, without};
use crate::diagnose::price::Gain;

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
        let own =
            |term: usize| self.terms[term].columns.iter().flatten().map(|(column, _)| *column);
        let acts = |term: usize, measurand: usize| {
            own(term).any(|column| self.sums.product_in(measurand, column, column) > 0.0)
        };
        (0..self.scale.len()).any(|one| acts(row, one) && acts(block, one))
    }

    /// How much of the squared length of a row's form the blocks of the model leave to it.
    pub(super) fn own_share(&self, model: &[usize], at: usize) -> f64 {
        let others = without(model, model[at]);
        let rows = self.rows_of(&others);
        let length = |beside: &[usize]| self.form_left(beside, model, model[at]);
        length(&others) / length(&rows).max(f64::MIN_POSITIVE)
    }
}
