//! Causes that a user suspects enter before effects of the library that have nearly their form: what such an
//! effect does better, where a formula is rounded off, is no evidence for another cause.

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::{Ranked, Selection};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::thresholds::ENTER;
use crate::estimate::batch::FitError;

use super::Search;
use super::forward::Refitted;

impl Search<'_> {
    /// The first effect of the user's own of which the one that would enter is a copy, if there is one.
    pub(super) fn suspected(
        &self,
        linear: &Linear,
        selection: &Selection<'_>,
        ranked: &[Ranked],
        next: &Refitted,
    ) -> Result<Option<Refitted>, FitError> {
        let model = linear.rows();
        for one in ranked.iter().filter(|one| one.ln_bayes >= ENTER) {
            let with = [model.as_slice(), &[one.term]].concat();
            if !selection.copies_of_own(&with, one.term).contains(&next.term) {
                continue;
            }
            let start = linear.start(selection, &model, one.term);
            let selected = &linear.candidates[one.term].selected;
            let fitted = self.fitted.with(selected, &start, self.options)?;
            if let Some(fitted) = fitted.filter(Fitted::is_sound)
                && linear.is_plausible(&fitted, one.term)
            {
                let Ranked { term, ln_bayes, .. } = *one;
                let form = linear.terms[term].variant;
                return Ok(Some(Refitted { cost: fitted.fit.cost, ln_bayes, term, form, fitted }));
            }
        }
        Ok(None)
    }
}
