//! What stands beside a row: blocks that change the same readings, and that have its form.

use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::terms::{Term, without};
use crate::diagnose::price::Gain;

/// Share of the squared length of a row's form that a block leaves, below which it has this form.
const SAME_FORM: f64 = 0.01;

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

    /// Whether a block that is no wider than a row has its form.
    pub(super) fn has_its_form(&self, model: &[usize], row: usize, blocks: &[usize]) -> bool {
        let width = self.terms[row].columns.len();
        let whole = self.form_left(&[], model, row);
        blocks.iter().any(|block| {
            let own = &self.terms[*block].columns;
            !own.is_empty()
                && own.len() <= width
                && self.form_left(&[*block], model, row) < SAME_FORM * whole
        })
    }

    /// How much of the squared length of a row's form the blocks of the model leave to it.
    pub(super) fn own_share(&self, model: &[usize], at: usize) -> f64 {
        let others = without(model, model[at]);
        let rows = self.rows_of(&others);
        let length = |beside: &[usize]| self.form_left(beside, model, model[at]);
        length(&others) / length(&rows).max(f64::MIN_POSITIVE)
    }
}
