//! Rows that nominal parameters absorb to first order, tested beside the blocks of a model.
//!
//! Such an effect has a form only away from zero, and entered a fit without blocks. Beside blocks its
//! slope there is no measure of it: from a value that is wrong by all of its size one linear step leads
//! half the way to zero for an effect of the second order. So it stands by fits with the blocks, one
//! with it and one without.

use crate::diagnose::budget::in_fit::{columns_of, effect_of};
use crate::diagnose::budget::judge::Objection;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::ENTER;
use crate::estimate::batch::FitError;

use super::{Competed, Search};

impl Search<'_> {
    /// Takes those out of the fit that gain too little beside the blocks; whether there are such.
    pub(super) fn take_out_curved(&mut self, competed: &Competed) -> Result<bool, FitError> {
        let Competed { linear, judged, .. } = competed;
        let is_unseen = |name: &str| self.unseen.as_ref().is_some_and(|all| all.has(name));
        let is_curved = |row: &usize| {
            let own = &linear.terms[*row];
            own.is_effect() && is_unseen(&own.name) && judged.model.contains(row)
        };
        let rows: Vec<usize> = linear.rows().into_iter().filter(is_curved).collect();
        if rows.is_empty() {
            return Ok(false);
        }
        let selection = self.selection_of(competed);
        let blocks = judged.model.iter().map(|term| selection.whole(*term)).filter(|term| {
            let own = &linear.terms[*term];
            !own.is_effect() && own.change.is_none()
        });
        let blocks: Vec<_> =
            blocks.filter_map(|term| linear.candidates.get(linear.terms[term].candidate)).collect();
        if blocks.is_empty() {
            return Ok(false);
        }
        let mut beside = linear.fitted.clone();
        for block in blocks {
            let with = beside.with(&block.selected, &[], self.options)?;
            beside = with.filter(Fitted::is_sound).unwrap_or(beside);
        }
        // Chi squared in units of the noise that was found, over that in units of the stated noise.
        let scaled = selection.chi_squared(&judged.model) / beside.fit.cost;
        let mut leave = Vec::new();
        for row in rows {
            let own = &linear.terms[row];
            let Some(effect) = effect_of(&beside, &own.name) else { continue };
            let without = beside.without(&[effect], self.options)?;
            let gain = scaled * (without.fit.cost - beside.fit.cost);
            let degrees = columns_of(&beside, &own.name).len();
            if selection.ln_bayes_factor(row, Gain { gain, degrees }) < ENTER {
                let objection = Objection::Small(gain.max(0.0).sqrt());
                self.log.push(format!("{} does not stand: {objection:?}", own.name));
                self.refused.push((own.name.clone(), own.variant));
                self.objections.push((own.name.clone(), objection));
                leave.push(row);
            }
        }
        if leave.is_empty() {
            return Ok(false);
        }
        self.fitted = self.without_rows(&leave, linear, linear.fitted.clone())?;
        Ok(true)
    }
}
