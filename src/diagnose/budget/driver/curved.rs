//! Effects that nominal parameters absorb to first order, such as a low-pass filter, which begins as
//! a delay: what is left of them shows at large values alone, so it takes a refit to find them.

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::ENTER;
use crate::engine::point::NamedValue;

use super::Search;
use super::forward::Refitted;

impl Search<'_> {
    /// The best of them in the fit, if it is better than what would enter otherwise by what a term
    /// must be worth: an effect that the sums can see is simpler. Those that nominal parameters
    /// absorb altogether are tried once.
    pub(super) fn better_curved(
        &mut self,
        linear: &Linear,
        selection: &Selection<'_>,
        otherwise: &Refitted,
    ) -> Option<Refitted> {
        let mut best: Option<Refitted> = None;
        for (term, own) in linear.terms.iter().enumerate() {
            let is_new = own.is_effect() && own.candidate != usize::MAX && own.variant.is_none();
            if !is_new || !selection.live[term] || self.absorbed.contains(&own.name) {
                continue;
            }
            let square: f64 = own.columns.iter().map(|column| selection.square(column)).sum();
            if !(square.is_finite() && square > 0.0) || selection.gain(&[], term).degrees > 0 {
                continue;
            }
            let candidate = &linear.candidates[own.candidate];
            let with = self.fitted.with(&candidate.selected, &typical(linear, term), self.options);
            let Some(with) = with.ok().flatten().filter(Fitted::is_sound) else {
                self.absorbed.push(own.name.clone());
                continue;
            };
            let drop = self.fitted.fit.cost - with.fit.cost;
            let gain = Gain { gain: drop, degrees: own.columns.len() };
            let price = drop - 2.0 * selection.ln_bayes_factor(term, gain);
            let cost = with.fit.cost + price - 2.0 * linear.ln_size_prior(&with, term);
            let least = best.as_ref().map_or(otherwise.cost - 2.0 * ENTER, |best| best.cost);
            if cost < least && linear.is_plausible(&with, term) {
                best = Some(Refitted { cost, term, fitted: with });
            }
        }
        best
    }
}

/// The usual values of an effect as the start of a fit: where its parameters are zero there is no
/// slope to follow.
fn typical(linear: &Linear, term: usize) -> Vec<NamedValue> {
    let candidate = &linear.candidates[linear.terms[term].candidate];
    let prefix = format!("{}.", candidate.name);
    let systems = candidate.systems.iter().flatten();
    let names = systems.flat_map(|system| &system.assembly.names.parameters);
    let own = names.map(|one| one.name.as_str()).filter(|name| name.starts_with(&prefix));
    own.filter_map(|name| Some((name.to_owned(), 0, None, candidate.typical(name)?))).collect()
}
