//! Of aliases the most probable one is the row. Effects enter one after the other: the alias that was
//! the most probable beside the first rows may be less so beside all of them, and the search exchanges
//! rows only for what is better by more than a tie.

use std::collections::BTreeSet;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::price::ROUNDING;
use crate::diagnose::thresholds::{ENTER, TIE};
use crate::estimate::batch::{FitError, Options};

use super::driver::{Competed, Found};
use super::families::Families;
use super::in_fit::{Row, effect_of};
use super::linear::Linear;
use super::no_covariates::NoCovariates;
use super::search::{Log, Pools};
use super::selection::Selection;
use super::terms::without;

/// Exchanges that are tried at most.
const MOST: usize = 4;
/// Log Bayes factor from which an alias is the more probable one: twice as probable.
const LEAST: f64 = std::f64::consts::LN_2;

/// A row and the alias in its place, as terms.
#[derive(Clone, Copy)]
struct Exchange {
    row: usize,
    alias: usize,
    /// By how much the alias has a larger log Bayes factor, with the prior of its size or without,
    /// whichever is less.
    by: f64,
}

impl Found {
    /// The same with the most probable of aliases as rows; an effect of the user's own stays where its
    /// alias is none.
    pub fn with_most_probable(
        mut self,
        nominal: &Fitted,
        wanted: &Wanted,
        options: &Options,
    ) -> Result<Self, FitError> {
        let mut tried = BTreeSet::new();
        for _ in 0..MOST {
            let Some(exchange) = self.more_probable(&tried) else { break };
            let [row, alias] = self.names(exchange);
            tried.insert([row.clone(), alias.clone()]);
            let Some(competed) = self.exchanged(exchange, nominal, wanted, options)? else {
                continue;
            };
            let before = std::mem::replace(&mut self.competed, competed);
            let back = [alias.clone(), row.clone()];
            // Beside the alias in the fit the row may be the more probable one.
            if self.more_probable(&tried).is_some_and(|one| self.names(one) == back) {
                self.competed = before;
            } else {
                self.log.push(format!("{alias} for its alias {row} ({:.1})", exchange.by));
                tried.insert(back);
            }
        }
        Ok(self)
    }

    fn names(&self, exchange: Exchange) -> [String; 2] {
        let terms = &self.competed.linear.terms;
        [exchange.row, exchange.alias].map(|term| terms[term].name.clone())
    }

    /// The exchange that gains most of those that were not tried.
    fn more_probable(&self, tried: &BTreeSet<[String; 2]>) -> Option<Exchange> {
        let Competed { linear, judged, .. } = &self.competed;
        let (selection, terms) = (self.selection(linear), &linear.terms);
        let effects = Pools::of(&selection).effects;
        let is_row = |term: &usize| {
            let is_named = judged.model.contains(term) && !judged.nameless.contains(term);
            is_named && terms[*term].is_effect() && terms[*term].variant.is_none()
        };
        let is_in_model = |name: &str| judged.model.iter().any(|term| terms[*term].name == name);
        let mut best: Option<Exchange> = None;
        for row in linear.rows().into_iter().filter(is_row) {
            let rest = without(&judged.model, row);
            let ln_bayes = selection.ln_bayes_factor(row, selection.gain(&rest, row));
            let rounding = ROUNDING * ln_bayes;
            let with_size = ln_bayes + ln_size(linear, &selection, &rest, row);
            for one in selection.ranked(&rest, &effects) {
                let (alias, other) = (one.term, &terms[one.term]);
                let is_alias = one.ln_bayes >= ENTER
                    && (one.ln_bayes - ln_bayes).abs() < TIE.max(rounding)
                    && other.variant.is_none()
                    && (other.is_own || !terms[row].is_own);
                if !is_alias || is_in_model(&other.name) {
                    continue;
                }
                // A size that is far from typical is no reason for another name, and one against it.
                let size = ln_size(linear, &selection, &rest, alias);
                let by = (one.ln_bayes - ln_bayes).min(one.ln_bayes + size - with_size);
                let exchange = Exchange { row, alias, by };
                if by > LEAST.max(rounding)
                    && best.is_none_or(|best| by > best.by)
                    && !tried.contains(&self.names(exchange))
                {
                    best = Some(exchange);
                }
            }
        }
        best
    }

    /// What a fit with an alias in the place of a row leaves; `None` where it is not sound, or where the
    /// alias does not stand.
    fn exchanged(
        &self,
        Exchange { row, alias, .. }: Exchange,
        nominal: &Fitted,
        wanted: &Wanted,
        options: &Options,
    ) -> Result<Option<Competed>, FitError> {
        let Competed { linear: old, judged: before, .. } = &self.competed;
        let Some(gone) = effect_of(&old.fitted, &old.terms[row].name) else { return Ok(None) };
        let start = old.start(&self.selection(old), &without(&before.model, row), alias);
        let selected = &old.candidates[old.terms[alias].candidate].selected;
        let fitted = old.fitted.without(&[gone], options)?.with(selected, &start, options)?;
        let can_be = |one: &Fitted| one.is_sound() && old.is_plausible(one, alias);
        let Some(fitted) = fitted.filter(can_be) else { return Ok(None) };
        let place = |term: usize| if term == row { alias } else { term };
        let rows: Vec<Row> = old.rows().into_iter().map(|term| row_of(old, place(term))).collect();
        let mut wanted = wanted.clone();
        wanted
            .variants
            .extend(rows.iter().filter_map(|one| Some((one.name.clone(), one.variant?))));
        let linear = Linear::new(fitted, &rows, &wanted, true, &mut Families::default());
        let Some(mut linear) = linear else { return Ok(None) };
        linear.without_own_covariates(&NoCovariates::of(nominal));
        linear.with_changes(&linear.known_changes(&old.changes_in(&before.model)));
        let terms = before.model.iter().map(|term| {
            let name = &old.terms[place(*term)].name;
            carried(old, *term, name, &linear)
        });
        let Some(model) = terms.collect::<Option<Vec<usize>>>() else { return Ok(None) };
        let mut selection = self.selection(&linear);
        let pools = Pools::of(&selection);
        let judged = selection.judge(model.clone(), pools, &linear, &mut Log::new());
        selection.set_scale(&judged.model);
        let effects = |model: &[usize]| -> BTreeSet<usize> {
            model.iter().copied().filter(|term| selection.terms[*term].is_effect()).collect()
        };
        let stands = effects(&judged.model) == effects(&model)
            && judged.nameless.len() == before.nameless.len();
        let scale = selection.scale.clone();
        linear.terms = selection.terms;
        Ok(stands.then_some(Competed { linear, judged, scale }))
    }

    /// A selection under the noise scale factors that were found, in which effects that did not stand,
    /// and those that show in no reading, have no part.
    fn selection<'l>(&self, linear: &'l Linear) -> Selection<'l> {
        let mut selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
        selection.adopt_scale(&self.competed.scale);
        let Competed { linear: own, judged, .. } = &self.competed;
        let mut refused: BTreeSet<&str> =
            self.objections.iter().map(|one| one.0.as_str()).collect();
        for term in &judged.model {
            refused.remove(own.terms[*term].name.as_str());
        }
        let outside = selection.terms.iter_mut().filter(|one| one.is_effect() && !one.in_fit);
        for one in outside {
            one.may_enter &= !refused.contains(one.name.as_str()) && !self.unseen.has(&one.name);
        }
        selection
    }
}

/// A term that is in a fit, or is to be, as a row.
fn row_of(linear: &Linear, term: usize) -> Row {
    let own = &linear.terms[term];
    Row { change: own.change.clone().zip(own.place.clone()), ..linear.row(term) }
}

/// A term of a model in another linearisation, by its name there; a block that was reduced beside rows
/// as a whole.
fn carried(old: &Linear, term: usize, name: &str, new: &Linear) -> Option<usize> {
    let own = &old.terms[term];
    let change = match own.appended() {
        Some(_) => Some(new.known_changes(&old.changes_in(&[term])).pop()?),
        None => None,
    };
    new.terms.iter().position(|other| {
        other.name == name
            && other.in_fit == own.in_fit
            && other.variant == own.variant
            && other.appended() == change.as_ref()
    })
}

/// Log prior of the size of an effect as the sums find it beside other terms: that of
/// [`Linear::ln_size_prior`].
fn ln_size(linear: &Linear, selection: &Selection<'_>, rest: &[usize], term: usize) -> f64 {
    let own = &linear.terms[term];
    if own.in_fit {
        return linear.ln_size_prior(&linear.fitted, term);
    }
    let candidate = &linear.candidates[own.candidate];
    let sizes = linear.sizes(selection, rest, term).into_iter();
    let ratios =
        sizes.filter_map(|one| Some(one.value.abs() / candidate.setting(&one.parameter)?.typical?));
    -ratios.fold(0.0, f64::max).powi(2).ln_1p()
}
