//! Causes that a user suspects enter before effects of the library that have nearly their form: what such an
//! effect explains better may be where a formula is rounded off. Where it leaves nothing, and the user's own
//! effect does, it is the cause.

use crate::diagnose::budget::families::Families;
use crate::diagnose::budget::in_fit::{Row, effect_of};
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::search::Pools;
use crate::diagnose::budget::selection::{Ranked, Selection};
use crate::diagnose::evidence::members::with_best_member;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::thresholds::{ENTER, OWN_EFFECT, TIE};
use crate::estimate::batch::FitError;

use super::forward::Refitted;
use super::{Competed, Search};

/// An effect of the user's own that entered in the place of one of the library with nearly its form.
#[derive(Debug)]
pub(super) struct Displaced {
    pub(super) own: String,
    pub(super) copy: String,
    /// Whether the copy was tried in its place.
    is_tried: bool,
}

impl Search<'_> {
    /// The first effect of the user's own of which the one that would enter is a copy, if there is one.
    pub(super) fn suspected(
        &mut self,
        linear: &Linear,
        selection: &Selection<'_>,
        ranked: &[Ranked],
        next: &Refitted,
    ) -> Result<Option<Refitted>, FitError> {
        let model = linear.rows();
        for one in ranked.iter().filter(|one| one.ln_bayes >= ENTER) {
            let with = [model.as_slice(), &[one.term]].concat();
            if !selection.is_copy(&with, one.term, next.term) {
                continue;
            }
            let start = linear.start(selection, &model, one.term);
            let selected = &linear.candidates[one.term].selected;
            let fitted = self.fitted.with(selected, &start, self.options)?;
            if let Some(fitted) = fitted.filter(Fitted::is_sound)
                && linear.is_plausible(&fitted, one.term)
            {
                let [own, copy] = [one.term, next.term].map(|term| linear.terms[term].name.clone());
                self.displaced.push(Displaced { own, copy, is_tried: false });
                let Ranked { term, ln_bayes, .. } = *one;
                let form = linear.terms[term].variant;
                return Ok(Some(Refitted { cost: fitted.fit.cost, ln_bayes, term, form, fitted }));
            }
        }
        Ok(None)
    }

    /// Exchanges an effect of the user's own for one of the library with nearly its form, where structure
    /// remains beside the one and none beside the other; whether there is such a one.
    pub(super) fn take_copy(&mut self, competed: &Competed) -> Result<bool, FitError> {
        let Competed { linear, judged, .. } = competed;
        let rows = linear.rows();
        let has_blocks = judged.model.iter().any(|term| !linear.terms[*term].is_effect());
        if !has_blocks && !linear.fitted.problem.has_autocorrelated_noise() {
            return Ok(false);
        }
        // Chi squared in units of the noise that was found, over that in units of the stated noise.
        let scaled = self.selection_of(competed).chi_squared(&rows) / linear.fitted.fit.cost;
        for at in 0..self.displaced.len() {
            let Displaced { own, copy, is_tried } = &mut self.displaced[at];
            let is_in_fit = |name: &String| rows.iter().any(|row| linear.terms[*row].name == *name);
            if *is_tried || !is_in_fit(own) || is_in_fit(copy) {
                continue;
            }
            *is_tried = true;
            let (own, copy) = (own.clone(), copy.clone());
            let Some((fitted, rows)) = self.with_copy(&own, &copy)? else { continue };
            if scaled * self.gain_of_copy(&fitted)? < 2.0 * (TIE + OWN_EFFECT.ln()) {
                continue;
            }
            let mut scanned = Families::default();
            let other = Linear::new(fitted.clone(), &rows, &self.wanted, true, &mut scanned);
            let Some(other) = other else { continue };
            let mut beside = self.selection(&other);
            beside.set_scale(&other.rows());
            let pools = Pools::of(&beside);
            if beside.best_block(&other.rows(), &pools).is_none() {
                self.log.push(format!("{copy} for {own}"));
                self.refused.push((own, None));
                self.changes.clear();
                (self.rows, self.fitted) = (rows, fitted);
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// What a fit with a copy in the place of a row takes off chi squared, under the noise of the present one.
    fn gain_of_copy(&self, with: &Fitted) -> Result<f64, FitError> {
        let mut alike = with.clone();
        for (part, present) in alike.problem.parts.iter_mut().zip(&self.fitted.problem.parts) {
            part.gauss_markov.clone_from(&present.gauss_markov);
        }
        Ok(self.fitted.fit.cost - alike.again(self.options)?.fit.cost)
    }

    /// The fit, and its rows, with a copy in the place of a row, under the noise of the nominal model; of a
    /// family the member that is best there.
    fn with_copy(&self, name: &str, copy: &str) -> Result<Option<(Fitted, Vec<Row>)>, FitError> {
        let Some(own) = effect_of(&self.fitted, name) else { return Ok(None) };
        let mut without = self.fitted.without(&[own], self.options)?;
        for (part, nominal) in without.problem.parts.iter_mut().zip(&self.nominal.problem.parts) {
            part.gauss_markov.clone_from(&nominal.gauss_markov);
        }
        let mut rows: Vec<Row> = self.rows.iter().filter(|one| one.name != name).cloned().collect();
        let mut scanned = Families::default();
        let beside = Linear::new(without.clone(), &rows, &self.wanted, false, &mut scanned);
        let Some(beside) = beside else { return Ok(None) };
        let Some(term) = beside.terms.iter().position(|own| own.name == copy) else {
            return Ok(None);
        };
        let mut selection = self.selection(&beside);
        selection.set_scale(&beside.rows());
        let start = beside.start(&selection, &beside.rows(), term);
        let selected = &beside.candidates[beside.terms[term].candidate].selected;
        let with = without.with(selected, &start, self.options)?;
        let with = with.filter(Fitted::is_sound).filter(|with| beside.is_plausible(with, term));
        let Some(with) = with else { return Ok(None) };
        let better = with_best_member(&with, copy, self.options)?;
        rows.push(beside.row(term));
        Ok(Some((better.map_or(with, |(better, _)| better), rows)))
    }
}
