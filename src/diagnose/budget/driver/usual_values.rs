//! Effects that are fitted from their usual values, because the slope at zero does not describe
//! what they do.
//!
//! Some are absorbed by nominal parameters to first order, such as a low-pass filter, which begins as
//! a delay: their second-order part appears at large values only. They are tried where another effect
//! enters, which has the form of that part, and where something is found that no effect explains.
//!
//! Others move readings so far at their usual size that the model is not linear there, such as a clock
//! that was set by seconds. Where residuals are far beyond what is stated, one that takes off nearly
//! all of chi squared enters the nominal fit, and the search begins anew: what was found beside so
//! wrong a model is worth nothing.

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::diagnose::budget::absorbed::{is_unseen, squared_length};
use crate::diagnose::budget::in_fit::columns_of;
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::terms::Term;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::relaxed::Variants;
use crate::diagnose::library::variant::Variant;
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::{ENTER, FAR_BEYOND_STATED, RELAXED};
use crate::engine::layout::Instance;
use crate::estimate::batch::FitError;
use crate::system::Selected;

use super::forward::Refitted;
use super::{Competed, Search};

/// Part of chi squared, in units of the noise, that an effect of the usual size has at least.
const LEAST: f64 = 0.1;
/// Part of chi squared that it leaves at most.
const LEAVES: f64 = 0.1;

impl Search<'_> {
    /// The best of those that nominal parameters absorb in the fit, if it is better than what would enter otherwise, if anything, by
    /// what a term must be worth: an effect that the sums can see is simpler. Those that take nothing
    /// off chi squared are tried once.
    pub(super) fn better_curved(
        &mut self,
        linear: &Linear,
        selection: &Selection<'_>,
        model: &[usize],
        otherwise: Option<&Refitted>,
    ) -> Result<Option<Refitted>, FitError> {
        // Chi squared in units of the noise that was found, over that in units of the stated noise.
        let scaled = selection.chi_squared(model) / self.fitted.fit.cost;
        // What would enter may have a value for each angle: then these may, too.
        let is_wider = |own: &Term| {
            otherwise.is_some_and(|one| linear.terms[one.term].columns.len() > own.columns.len())
        };
        let is_tried = |(term, own): &(usize, &Term)| {
            let is_known =
                |known: &(String, bool)| known.0 == own.name && (known.1 || !is_wider(own));
            selection.terms[*term].may_enter
                && is_unseen(own, selection, *term)
                && !self.absorbed.iter().any(is_known)
                && (f64::MIN_POSITIVE..f64::INFINITY).contains(&squared_length(own, selection))
        };
        let tried: Vec<(usize, &Term)> = linear.terms.iter().enumerate().filter(is_tried).collect();
        let forms = |(term, own): &(usize, &Term)| -> Vec<(usize, Option<Variant>)> {
            let wider = own.variants.iter().copied().filter(|form| {
                is_wider(own) && own.variant.is_none() && !self.is_refused(&own.name, *form)
            });
            std::iter::once(own.variant).chain(wider.map(Some)).map(|form| (*term, form)).collect()
        };
        let forms: Vec<(usize, Option<Variant>)> = tried.iter().flat_map(forms).collect();
        let refit = |(term, form): &(usize, Option<Variant>)| {
            let plain = &linear.candidates[linear.terms[*term].candidate].selected;
            self.fit_from_usual_values(&self.fitted, plain, *form, 0.0)
        };
        let refitted: Result<Vec<_>, _> = forms.par_iter().map(refit).collect();
        let mut best: Option<Refitted> = None;
        let mut worth: BTreeSet<usize> = BTreeSet::new();
        for ((term, form), with) in forms.into_iter().zip(refitted?) {
            let (Some(with), own) = (with, &linear.terms[term]) else { continue };
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
            worth.insert(term);
            let size = linear.ln_size_prior(&with, term);
            // As what would enter otherwise is priced; what is better by so much is so in units of
            // the noise that was found.
            let price = gain.gain - 2.0 * ln_bayes;
            let cost = with.fit.cost + price - 2.0 * size;
            let least = otherwise.map_or(self.fitted.fit.cost, |one| one.cost);
            let least = best.as_ref().map_or(least - 2.0 * ENTER / scaled, |best| best.cost);
            if cost < least && linear.is_plausible(&with, term) {
                best = Some(Refitted { cost, term, form, ln_bayes, fitted: with });
            }
        }
        let worthless = tried.into_iter().filter(|(term, _)| !worth.contains(term));
        let worthless = worthless.map(|(_, own)| (own.name.clone(), is_wider(own)));
        self.absorbed.extend(worthless);
        Ok(best)
    }

    /// Lets the best of them enter where a model has terms that are no effects; whether there is one.
    pub(super) fn take_curved(&mut self, competed: &Competed) -> Result<bool, FitError> {
        let Competed { linear, judged, .. } = competed;
        if judged.model.iter().all(|term| linear.terms[*term].is_effect()) {
            return Ok(false);
        }
        let selection = self.selection_of(competed);
        let best = self.better_curved(linear, &selection, &linear.rows(), None)?;
        let is_found = best.is_some();
        if let Some(best) = best {
            // It may leave again, and would come back each time.
            self.absorbed.push((linear.terms[best.term].name.clone(), false));
            self.enter(linear, best);
        }
        Ok(is_found)
    }

    /// The fit with an effect in some form, from its usual values, with delays that begin later (s):
    /// where its parameters are zero there is no slope to follow.
    pub(super) fn fit_from_usual_values(
        &self,
        from: &Fitted,
        plain: &Selected,
        form: Option<Variant>,
        later: f64,
    ) -> Result<Option<Fitted>, FitError> {
        let relaxed = form.and_then(|form| form.selected(plain));
        let selected = relaxed.unwrap_or_else(|| plain.clone());
        let prefix = format!("{}.", selected.name());
        let usual = |one: &Instance, _| {
            if one.name.starts_with(&prefix) {
                return one.setting.typical.filter(|_| !one.setting.fixed);
            }
            let is_later = one.is_delay() && later != 0.0;
            if is_later { Some(from.value(one, 0)? + later) } else { None }
        };
        let with = from.with_starts(&selected, usual, self.options)?;
        Ok(with.filter(Fitted::is_sound))
    }

    /// Lets the best of those that are beyond their linear range enter the nominal fit; whether there is
    /// one.
    pub(super) fn take_beyond_linear(&mut self, competed: &Competed) -> Result<bool, FitError> {
        let Competed { linear, judged, scale } = competed;
        if scale.iter().all(|one| *one <= FAR_BEYOND_STATED) {
            return Ok(false);
        }
        let selection = self.selection_of(competed);
        let chi_squared = selection.chi_squared(&judged.model);
        let mut best: Option<(usize, Fitted)> = None;
        for (term, own) in linear.terms.iter().enumerate() {
            let is_open =
                own.is_effect() && selection.terms[term].may_enter && own.variant.is_none();
            let is_in_fit = self.rows.iter().any(|row| row.name == own.name);
            if !is_open || is_in_fit || usual_length(own, &selection) < LEAST * chi_squared {
                continue;
            }
            let plain = &linear.candidates[own.candidate].selected;
            for later in starts_of_delays(&self.nominal) {
                let nominal = &self.nominal;
                let with = self.fit_from_usual_values(nominal, plain, None, later)?;
                let Some(with) = with else { continue };
                let all = nominal.fit.cost;
                let least = best.as_ref().map_or(LEAVES * all, |best| best.1.fit.cost);
                if with.fit.cost < least && linear.is_plausible(&with, term) {
                    best = Some((term, with));
                }
            }
        }
        let Some((term, fitted)) = best else { return Ok(false) };
        let mut log = std::mem::take(&mut self.log);
        log.push(format!("{} enters the fit from its usual values", linear.terms[term].name));
        let wanted = Wanted { variants: Variants::default(), ..self.wanted.clone() };
        let (nominal, spikes) = (self.nominal.clone(), self.first_spikes.clone());
        let anew = Search::new(nominal, spikes, &wanted, self.options);
        let unseen = self.unseen.take();
        *self = Search { fitted, rows: vec![linear.row(term)], log, unseen, ..anew };
        self.grow()
    }
}

/// Squared length of an effect's columns at its usual size, in units of the noise.
fn usual_length(own: &Term, selection: &Selection<'_>) -> f64 {
    let of = |column: &Vec<(usize, f64)>| {
        let usual = column.first().and_then(|(at, _)| selection.sums.typical_of(*at));
        usual.map_or(0.0, |usual| usual * usual * selection.square(column))
    };
    own.columns.iter().map(of).sum()
}

/// By how much later delays begin (s): the fit holds for stamps before a jump or for those after it.
fn starts_of_delays(fitted: &Fitted) -> Vec<f64> {
    let runs = fitted.problem.parts.iter().flat_map(|part| &part.runs);
    let first = runs.filter_map(|run| run.record.head(1).jump_time.first().copied());
    let mut starts: Vec<f64> = std::iter::once(0.0).chain(first.take(1)).collect();
    starts.dedup();
    starts
}
