//! Forward selection: effects enter the fit one after the other, each the best of some that were
//! refitted.

use rayon::prelude::*;

use crate::diagnose::budget::absorbed::unseen;
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::search::Pools;
use crate::diagnose::budget::selection::Ranked;
use crate::diagnose::budget::terms::Term;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::variant::Variant;
use crate::diagnose::outliers::records::Records;
use crate::diagnose::thresholds::{ENTER, FAR_BEYOND_STATED, MOST_ROWS};
use crate::effect::Acts;
use crate::engine::layout::Instance;
use crate::estimate::batch::FitError;
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::minima::improved;

use super::Search;

/// Candidates that are refitted before one enters.
const SERIOUS: usize = 3;
/// Gain of a serious candidate, in parts of the best.
const SERIOUS_SHARE: f64 = 0.5;

/// A fit from other starts leaves so many times less.
const FAR_LESS: f64 = 2.0;

/// A candidate in the fit.
pub(super) struct Refitted {
    /// Chi squared and what it costs beyond its gain, with its size against it.
    pub(super) cost: f64,
    /// Its log Bayes factor.
    pub(super) ln_bayes: f64,
    /// The candidate, and its form.
    pub(super) term: usize,
    pub(super) form: Option<Variant>,
    /// The fit.
    pub(super) fitted: Fitted,
}

impl Search<'_> {
    /// Effects enter one after the other, each with a refit. Families are scanned again where one of
    /// them may be the next to enter; what is known of them in the end is of the last fit. Whether
    /// nominal parameters are determined.
    pub(super) fn grow(&mut self) -> Result<bool, FitError> {
        // Effects scanned at the present fit; `None` for all.
        let mut fresh: Option<Vec<String>> = None;
        while self.rows.len() < MOST_ROWS {
            let linear = Linear::new(
                self.fitted.clone(),
                &self.rows,
                &self.wanted,
                false,
                &mut self.scanned,
            );
            let Some(linear) = linear else { return Ok(false) };
            let mut selection = self.selection(&linear);
            let model = linear.rows();
            selection.set_scale(&model);
            if self.unseen.is_none() {
                self.unseen = Some(unseen(&linear, &selection));
            }
            let pools = Pools::of(&selection);
            let ranked = selection.ranked(&model, &pools.effects);
            let best = ranked.first().filter(|best| best.ln_bayes >= ENTER);
            let serious: Vec<_> = best.map_or_else(Vec::new, |best| {
                let is_serious = |one: &&Ranked| {
                    one.ln_bayes >= ENTER && one.gain.gain >= SERIOUS_SHARE * best.gain.gain
                };
                ranked.iter().filter(is_serious).take(SERIOUS).collect()
            });
            if let Some(known) = &mut fresh {
                let name = |one: &&Ranked| linear.terms[one.term].name.clone();
                let scanned = &mut self.scanned.effects;
                let is_stale = |name: &String| scanned.contains_key(name) && !known.contains(name);
                let stale: Vec<String> = serious.iter().map(name).filter(is_stale).collect();
                if serious.is_empty() {
                    fresh = None;
                    scanned.clear();
                    continue;
                }
                if !stale.is_empty() {
                    scanned.retain(|name, _| !stale.contains(name));
                    known.extend(stale);
                    continue;
                }
            }
            let least = best.map_or(0.0, |best| best.ln_bayes);
            if self.relax(&linear, &selection, &model, least)? {
                fresh = Some(Vec::new());
                continue;
            }
            if best.is_none() {
                if self.take_members()? {
                    fresh = Some(Vec::new());
                    continue;
                }
                break;
            }
            let mut next: Option<Refitted> = None;
            let known = self.refused.len();
            let refit = |one: &&Ranked| {
                let start = linear.start(&selection, &model, one.term);
                let selected = &linear.candidates[one.term].selected;
                self.fitted.with(selected, &start, self.options)
            };
            let refitted: Result<Vec<_>, _> = serious.par_iter().map(refit).collect();
            for (one, with) in serious.into_iter().zip(refitted?) {
                let Some(with) = with.filter(Fitted::is_sound) else { continue };
                if !linear.is_plausible(&with, one.term) {
                    self.refuse_size(&linear.terms[one.term]);
                    continue;
                }
                // What a candidate costs more than another counts against it, and its size.
                let price = one.gain.gain - 2.0 * one.ln_bayes;
                let size = linear.ln_size_prior(&with, one.term);
                let cost = with.fit.cost + price - 2.0 * size;
                if next.as_ref().is_none_or(|least| cost < least.cost) {
                    let (term, ln_bayes) = (one.term, one.ln_bayes);
                    let form = linear.terms[term].variant;
                    next = Some(Refitted { cost, term, form, ln_bayes, fitted: with });
                }
            }
            let Some(next) = next else {
                if self.refused.len() > known {
                    continue;
                }
                break;
            };
            let curved = self.better_curved(&linear, &selection, &model, Some(&next))?;
            let next = curved.unwrap_or(next);
            let next = self.suspected(&linear, &selection, &ranked, &next)?.unwrap_or(next);
            let acts = linear.candidates[next.term].selected.effect.acts;
            let is_first_clock = self.rows.is_empty() && acts == Acts::Timing;
            self.enter(&linear, next);
            if is_first_clock {
                self.take_other_starts()?;
            }
            if let Some((with, _)) = self.with_levels(&self.fitted)? {
                self.fitted = with;
            }
            fresh = Some(Vec::new());
        }
        if fresh.is_some() {
            self.scanned.effects.clear();
        }
        Ok(true)
    }

    /// Looks for other starts where the first row is an error of a clock and leaves far more than is stated.
    /// A motion that repeats is like itself: without that row the best delays may have been those of another
    /// cycle.
    fn take_other_starts(&mut self) -> Result<(), FitError> {
        let is_poor = self.fitted.variance_factor() > FAR_BEYOND_STATED.powi(2);
        let has_delays = self.fitted.problem.layout.instances.iter().any(Instance::is_delay);
        if !is_poor || !has_delays {
            return Ok(());
        }
        let (other, _) = improved(self.fitted.problem.clone());
        let Calibration { problem, fit, .. } = calibrate(other, self.options)?;
        if fit.outcome.is_result() && fit.cost * FAR_LESS < self.fitted.fit.cost {
            self.log.push("another start is better beside it".to_owned());
            // Streams may cover fewer readings there.
            self.records = Records::of(&problem);
            self.fitted = Fitted { problem, fit, recipes: self.fitted.recipes.clone() };
        }
        Ok(())
    }

    /// A refitted candidate is the fit from now on.
    pub(super) fn enter(&mut self, linear: &Linear, refitted: Refitted) {
        let Refitted { term, form, ln_bayes, fitted, .. } = refitted;
        let name = &linear.terms[term].name;
        self.log.push(format!("{name} enters the fit ({ln_bayes:.1})"));
        self.rows.push(linear.row(term));
        if let Some(form) = form.filter(|_| linear.terms[term].variant.is_none()) {
            self.take_form(self.rows.len() - 1, form);
        }
        self.fitted = fitted;
    }

    /// An effect whose value cannot be does not come back.
    pub(super) fn refuse_size(&mut self, term: &Term) {
        self.log.push(format!("{} would be too large", term.name));
        self.refused.push((term.name.clone(), term.variant));
    }
}
