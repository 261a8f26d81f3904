//! Rows of the fit whose values differ between setups or angles get values of their own,
//! where that explains more than one more effect.

use crate::diagnose::budget::in_fit::{Row, columns_of, effect_of};
use crate::diagnose::budget::labels::{Label, labels};
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::pieces::Pieces;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::variant::Variant;
use crate::diagnose::thresholds::{APART_SHARE, ENTER, RELAXED, ROW};
use crate::engine::layout::Instance;
use crate::estimate::batch::FitError;

use super::Search;

impl Search<'_> {
    /// Gives the row whose relaxed form has the largest log Bayes factor, beyond `least`, values of
    /// its own; whether there is one.
    pub(super) fn relax(
        &mut self,
        linear: &Linear,
        selection: &Selection<'_>,
        model: &[usize],
        least: f64,
    ) -> Result<bool, FitError> {
        let best = best(linear, selection, model).filter(|best| best.0 >= least.max(ENTER));
        let Some((_, row, form)) = best else { return Ok(false) };
        let name = &self.rows[row].name;
        let Some(plain) = effect_of(&self.fitted, name).cloned() else { return Ok(false) };
        let Some(selected) = form.selected(&plain) else { return Ok(false) };
        let without = self.fitted.without(&[&plain], self.options)?;
        // Each value begins at the one that it had in common with the others: at zero some effects have
        // no slope.
        let (layout, point) = (&self.fitted.problem.layout, &self.fitted.fit.point);
        let prefix = format!("{name}.");
        let start = |one: &Instance, component: usize| {
            let is_of = |index: &usize| {
                let known = &layout.instances[*index].name;
                let rest = one.name.strip_prefix(known.as_str());
                known.starts_with(&prefix)
                    && rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
            };
            let all = || (0..layout.instances.len()).filter(is_of);
            let same = all().find(|index| layout.instances[*index].whose() == one.whose());
            let common = same.or_else(|| all().next())?;
            point.components(layout, common).get(component).copied()
        };
        let with = without.with_starts(&selected, start, self.options)?;
        // What a campaign states of scopes may undo the form.
        let columns = |fitted: &Fitted| columns_of(fitted, name).len();
        let is_wider = |with: &Fitted| columns(with) > columns(&self.fitted);
        let with = with.filter(Fitted::is_sound).filter(is_wider);
        let Some(with) = with else { return Ok(false) };
        self.take_form(row, form);
        self.fitted = with;
        Ok(true)
    }

    /// A row of the fit has a relaxed form.
    pub(super) fn take_form(&mut self, row: usize, form: Variant) {
        let Row { name, variant: own, ln_prior, .. } = &mut self.rows[row];
        self.log.push(format!("{name} with {}", form.words()));
        self.wanted.variants.insert(name.clone(), form);
        *own = Some(form);
        *ln_prior -= RELAXED;
    }
}

/// The best relaxed form of a row in the fit: its log Bayes factor, the row, the form.
fn best(
    linear: &Linear,
    selection: &Selection<'_>,
    model: &[usize],
) -> Option<(f64, usize, Variant)> {
    // No pass over the readings where they have no groups that a row may differ between.
    let forms = labels(&linear.fitted.problem);
    let forms: Vec<Variant> = forms.iter().filter_map(|one| one.label.variant()).collect();
    let may_differ =
        |term: &usize| selection.terms[*term].variants.iter().any(|form| forms.contains(form));
    if !model.iter().any(may_differ) {
        return None;
    }
    let pieces = Pieces::new(linear, selection, model);
    let gains = selection.contributions(model);
    let forms = model.iter().enumerate().filter_map(|(row, term)| {
        let forms = &selection.terms[*term].variants;
        let wanted = |label: &Label| label.variant().is_some_and(|form| forms.contains(&form));
        let (label, ln_bayes, gain) = selection.separate_values(model, row, &pieces, wanted)?;
        let is_more = gain > ROW.max(APART_SHARE * gains[row].gain);
        is_more.then_some((ln_bayes - RELAXED, row, label.variant()?))
    });
    forms.max_by(|a, b| a.0.total_cmp(&b.0))
}
