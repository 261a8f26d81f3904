//! Effects that nominal parameters absorb to first order, such as a low-pass filter, which begins as
//! a delay. Their second-order part appears at large values only, so it takes a refit to find them.
//! They are tried where another effect enters, which has the form of that part.

use crate::diagnose::budget::absorbed::{is_unseen, squared_length};
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::ENTER;
use crate::engine::point::NamedValue;
use crate::estimate::batch::FitError;
use crate::graph::Parameter;

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
            if !selection.live[term]
                || self.absorbed.contains(&own.name)
                || !is_unseen(own, selection, term)
            {
                continue;
            }
            let square = squared_length(own, selection);
            if !square.is_finite() || square <= 0.0 {
                continue;
            }
            let candidate = &linear.candidates[own.candidate];
            let start = typical(linear, term);
            let with = self.fitted.with(&candidate.selected, &start, self.options)?;
            let Some(with) = with.filter(Fitted::is_sound) else { continue };
            let drop = self.fitted.fit.cost - with.fit.cost;
            let gain = Gain { gain: scaled * drop, degrees: own.columns.len() };
            let ln_bayes = selection.ln_bayes_factor(term, gain);
            if ln_bayes < ENTER {
                self.absorbed.push(own.name.clone());
                continue;
            }
            let size = linear.ln_size_prior(&with, term);
            let cost = with.fit.cost + drop - 2.0 * (ln_bayes / scaled + size);
            let least = otherwise.cost - 2.0 * ENTER / scaled;
            let least = best.as_ref().map_or(least, |best| best.cost);
            if cost < least && linear.is_plausible(&with, term) {
                best = Some(Refitted { cost, term, ln_bayes, fitted: with });
            }
        }
        Ok(best)
    }
}

/// The usual values of an effect as the start of a fit: where its parameters are zero there is no
/// slope to follow.
fn typical(linear: &Linear, term: usize) -> Vec<NamedValue> {
    let candidate = &linear.candidates[linear.terms[term].candidate];
    let prefix = format!("{}.", candidate.name);
    let system = candidate.systems.iter().flatten().next();
    let parameters = system.into_iter().flat_map(|system| &system.assembly.names.parameters);
    let own = parameters.filter(|one| one.name.starts_with(&prefix));
    let of = |one: &Parameter| {
        let size = candidate.typical(&one.name).unwrap_or(0.0);
        let name = one.name.clone();
        (0..one.kind.dimension()).map(move |k| (name.clone(), k, None, size)).collect::<Vec<_>>()
    };
    own.flat_map(of).collect()
}
