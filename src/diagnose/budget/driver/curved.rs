//! Effects that nominal parameters absorb to first order, such as a low-pass filter, which begins as
//! a delay. Their second-order part appears at large values only, so it takes a refit to find them.
//! They are tried where another effect enters, which has the form of that part.

use crate::diagnose::budget::absorbed::{is_unseen, squared_length};
use crate::diagnose::budget::in_fit::columns_of;
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::variant::Variant;
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::{ENTER, RELAXED};
use crate::engine::layout::Instance;
use crate::estimate::batch::FitError;
use crate::system::Selected;

use super::Search;
use super::forward::Refitted;

impl Search<'_> {
    /// The best of them in the fit, if it is better than what would enter otherwise by what a term
    /// must be worth: an effect that the sums can see is simpler. Those that take nothing off chi
    /// squared are tried once.
    pub(super) fn better_curved(
        &mut self,
        linear: &Linear,
        selection: &Selection<'_>,
        model: &[usize],
        otherwise: &Refitted,
    ) -> Result<Option<Refitted>, FitError> {
        // Chi squared in units of the noise that was found, over that in units of the stated noise.
        let scaled = selection.chi_squared(model) / self.fitted.fit.cost;
        let mut best: Option<Refitted> = None;
        for (term, own) in linear.terms.iter().enumerate() {
            if !selection.live[term] || !is_unseen(own, selection, term) {
                continue;
            }
            // What would enter may have a value for each angle: then it may, too.
            let is_wider = linear.terms[otherwise.term].columns.len() > own.columns.len();
            let was_tried = |known: &(String, bool)| known.0 == own.name && (known.1 || !is_wider);
            if self.absorbed.iter().any(was_tried) {
                continue;
            }
            let square = squared_length(own, selection);
            if !square.is_finite() || square <= 0.0 {
                continue;
            }
            let plain = &linear.candidates[own.candidate].selected;
            let wider = own.variants.iter().copied().filter(|form| {
                is_wider && own.variant.is_none() && !self.is_refused(&own.name, *form)
            });
            let mut is_worth = false;
            for form in std::iter::once(own.variant).chain(wider.map(Some)) {
                let Some(with) = self.fit_from_usual_values(plain, form)? else { continue };
                let degrees = columns_of(&with, &own.name).len();
                // What a campaign states of scopes may undo the form.
                if form != own.variant && degrees <= own.columns.len() {
                    continue;
                }
                let drop = self.fitted.fit.cost - with.fit.cost;
                let gain = Gain { gain: scaled * drop, degrees };
                let of_form = if form == own.variant { 0.0 } else { RELAXED };
                let ln_bayes = selection.ln_bayes_factor(term, gain) - of_form;
                if ln_bayes < ENTER {
                    continue;
                }
                is_worth = true;
                let size = linear.ln_size_prior(&with, term);
                // As what would enter otherwise is priced; what is better by so much is so in units of
                // the noise that was found.
                let price = gain.gain - 2.0 * ln_bayes;
                let cost = with.fit.cost + price - 2.0 * size;
                let least = otherwise.cost - 2.0 * ENTER / scaled;
                let least = best.as_ref().map_or(least, |best| best.cost);
                if cost < least && linear.is_plausible(&with, term) {
                    best = Some(Refitted { cost, term, form, ln_bayes, fitted: with });
                }
            }
            if !is_worth {
                self.absorbed.push((own.name.clone(), is_wider));
            }
        }
        Ok(best)
    }

    /// The fit with an effect in some form, from its usual values: where its parameters are zero there
    /// is no slope to follow.
    fn fit_from_usual_values(
        &self,
        plain: &Selected,
        form: Option<Variant>,
    ) -> Result<Option<Fitted>, FitError> {
        let relaxed = form.and_then(|form| form.selected(plain));
        let selected = relaxed.unwrap_or_else(|| plain.clone());
        let prefix = format!("{}.", selected.name());
        let usual =
            |one: &Instance, _| one.name.starts_with(&prefix).then_some(one.setting.typical)?;
        let with = self.fitted.with_starts(&selected, usual, self.options)?;
        Ok(with.filter(Fitted::is_sound))
    }
}
