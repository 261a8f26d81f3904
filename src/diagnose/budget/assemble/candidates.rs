//! What every effect would explain alone, and how probable each cause is, if there is one.

use super::Budget;
use crate::diagnose::budget::answer::Ranked;
use crate::diagnose::budget::selection::Ranked as RankedTerm;
use crate::diagnose::budget::terms::Term;
use crate::diagnose::library::place::Place;
use crate::diagnose::library::prior::{Cause, Prior};
use crate::diagnose::price::{ln_bayes_factor, ln_bayes_factor_of_any_size};

impl Budget<'_> {
    /// All effects against the nominal model alone, and the probabilities of nothing, of one of
    /// them and of an unmodelled effect.
    pub(super) fn candidates(&self, prior: &Prior) -> (Vec<Ranked>, Option<[f64; 3]>) {
        let Self { linear, selection, pools, total, .. } = self;
        let mut open = (*selection).clone();
        for term in &mut open.terms {
            let is_change = term.place.as_ref().is_some_and(Place::is_of_a_parameter);
            term.may_enter = !term.columns.is_empty() && !is_change;
        }
        let ranked = open.ranked(&[], &pools.effects);
        // Of an effect in two forms the library's is listed.
        let is_listed = |own: &Term| {
            own.variant.is_none()
                || !linear.terms.iter().any(|one| one.name == own.name && one.variant.is_none())
        };
        let ranked: Vec<_> = ranked
            .into_iter()
            .filter(|one| one.gain.degrees > 0 && is_listed(&linear.terms[one.term]))
            .collect();
        let blocks = open.ranked(&[], &pools.blocks);
        let blocks: Vec<_> = blocks.into_iter().filter(|one| one.gain.degrees > 0).collect();
        // Posterior probabilities use the Bayes factor averaged over sizes.
        let ln_bayes = |one: &RankedTerm| {
            let of_best_width = ln_bayes_factor(one.gain, 1, 1);
            one.ln_bayes - of_best_width + ln_bayes_factor_of_any_size(one.gain)
        };
        let all = || ranked.iter().chain(&blocks).map(ln_bayes);
        let most = all().fold(0.0, f64::max);
        let weight = |cause: Cause, ln_bayes: f64| prior.of(cause) * (ln_bayes - most).exp();
        let nothing = weight(Cause::Nothing, 0.0);
        let library: f64 = ranked.iter().map(|one| weight(Cause::Library, ln_bayes(one))).sum();
        let unknown: f64 = blocks.iter().map(|one| weight(Cause::Unknown, ln_bayes(one))).sum();
        let sum = nothing + library + unknown;
        let candidates = ranked.iter().map(|one| {
            let term = &linear.terms[one.term];
            let member = linear.candidates.get(term.candidate);
            let member = member.map(|one| one.selected.member.clone()).unwrap_or_default();
            Ranked {
                name: term.name.clone(),
                member,
                gain: one.gain,
                ln_bayes: one.ln_bayes,
                share: if *total > 0.0 { (one.gain.gain / total).clamp(0.0, 1.0) } else { 0.0 },
                probability: weight(Cause::Library, ln_bayes(one)) / sum,
                values: linear.sizes(&open, &[], one.term),
            }
        });
        (candidates.collect(), Some([nothing / sum, library / sum, unknown / sum]))
    }
}
