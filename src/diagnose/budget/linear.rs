//! A fitted model, linearised, with everything that may be added to it: effects of the library with
//! the best member of each family, and basis blocks.
//!
//! Rows that are in the fit already are terms like the others: what they explain is added back to
//! the residual.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::diagnose::evidence::scan::{scan, scan_all};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::{Candidate, NotTestable};
use crate::diagnose::library::offer::Offer;
use crate::diagnose::library::relaxed::with_variants;
use crate::diagnose::library::structure::over_values;
use crate::diagnose::library::variant::Variant;
use crate::diagnose::library::wanted::Wanted;
use crate::engine::Problem;
use crate::engine::signatures::Signatures;

use crate::diagnose::thresholds::{OWN_EFFECT, RELAXED};

use super::families::{Families, best_members};
use super::in_fit::{Row, columns_of, effect_of};
use super::no_covariates::NoCovariates;
use super::selection::Selection;
use super::spreads::spreads;
use super::sums::Sums;
use super::terms::Term;

/// Share of a row's form that a block over the same reading leaves, below which its covariate is
/// the row.
const OWN_COVARIATE: f64 = 0.1;

/// A linearised model with its terms.
#[derive(Clone, Debug)]
pub struct Linear {
    /// The fit.
    pub fitted: Fitted,
    /// What may be added: effects, then blocks.
    pub candidates: Vec<Candidate>,
    /// The terms: those of the candidates, then the rows that are in the fit.
    pub terms: Vec<Term>,
    /// The sums of all columns.
    pub sums: Sums,
    /// Columns of rows in the fit with their values.
    pub active: Vec<(usize, f64)>,
    /// Effects on the noise alone.
    pub noise: Vec<Candidate>,
    /// Effects that cannot be tested.
    pub not_testable: Vec<NotTestable>,
    /// The signatures of the candidates in each campaign.
    pub signed: Arc<Vec<Signatures>>,
    /// For each run its place in the order of time.
    pub order: Vec<usize>,
    rows: std::ops::Range<usize>,
    /// For each campaign and candidate the places of its signatures.
    pub(super) signatures: Vec<Vec<Vec<usize>>>,
}

/// A measurand of a campaign.
#[derive(Clone, Copy, Debug)]
pub struct Measurand<'a> {
    /// Its number among those of all campaigns.
    pub number: usize,
    /// Index of the campaign.
    pub part: usize,
    /// Index in the campaign.
    pub measurand: usize,
    /// Its name.
    pub name: &'a str,
}

impl Linear {
    /// Linearises a fit in which the named `rows` are effects of the diagnosis; `with_blocks` for
    /// basis blocks, too. `scanned` has the members of families that need no scan again.
    pub fn new(
        fitted: Fitted,
        rows: &[Row],
        wanted: &Wanted,
        with_blocks: bool,
        scanned: &mut Families,
    ) -> Option<Self> {
        let made = wanted.catalogue.of(&fitted.recipes);
        let Offer { effects, noise, mut not_testable } =
            wanted.of(made.offer.clone()).of_runs(&fitted.recipes, &fitted.problem);
        let effects = with_variants(effects, &wanted.variants, &fitted.recipes);
        let (mut candidates, mut members, blind) =
            best_members(&fitted, &made, effects, &mut scanned.effects)?;
        not_testable.extend(blind);
        if with_blocks {
            let of_values = over_values(&fitted.recipes, &spreads(&fitted.problem));
            let blocks = || made.blocks.iter().chain(&of_values);
            let is_family = |block: &&Candidate| !block.selected.effect.shape.is_empty();
            scan_all(&fitted, blocks().filter(is_family), &mut scanned.blocks);
            for block in blocks() {
                let found = if is_family(&block) {
                    scan(&fitted, block, &mut scanned.blocks)
                } else {
                    Some((block.clone(), 1))
                };
                if let Some((found, tried)) = found {
                    candidates.push(found);
                    members.push(tried);
                }
            }
        }
        if fitted.problem.parts.iter().map(|part| part.setups.len()).sum::<usize>() == 1 {
            let places = candidates.iter_mut().filter_map(|one| one.place.as_mut());
            places.for_each(|place| *place = place.in_one_setup());
        }
        let all: Vec<&Candidate> = candidates.iter().collect();
        let signed = made.signatures(&fitted.problem, &all);
        let priors = fitted.fit.normal.priors.clone();
        let sums_of = |problem: &Problem| {
            let (point, count) = (&fitted.fit.point, candidates.len());
            Sums::new(problem, point, &signed, count, priors.clone())
        };
        let mut sums = sums_of(&fitted.problem);
        if let Some(noisier) = fitted.problem.with_noisier_streams() {
            sums.compare_with_noisier_streams(&noisier.each_ref().map(sums_of));
        }
        let own = fitted.recipes.iter().flat_map(|recipe| recipe.library.own_effects());
        let own: BTreeSet<&str> = own.map(|effect| effect.name.as_str()).collect();
        let mut terms: Vec<Term> = candidates
            .iter()
            .zip(&members)
            .enumerate()
            .map(|(number, (one, members))| {
                let mut term = Term::of(&sums, number, one, *members);
                term.is_own = own.contains(one.selected.effect.name.as_str());
                term.variant = one.variant;
                if term.is_effect() && one.variant.is_none() {
                    term.variants = Variant::of_all(&one.selected.effect);
                }
                term
            })
            .collect();
        set_ln_priors(&mut terms, &candidates, wanted);
        let mut active = Vec::new();
        for row in rows {
            let columns = columns_of(&fitted, &row.name);
            active.extend(columns.iter().copied());
            let effect = effect_of(&fitted, &row.name).map(|selected| &selected.effect);
            let forms = effect.filter(|_| row.variant.is_none()).map(|own| Variant::of_all(own));
            let columns = columns.iter().map(|(column, _)| vec![(*column, 1.0)]).collect();
            terms.push(Term {
                members: row.members,
                ln_prior: row.ln_prior,
                variant: row.variant,
                variants: forms.unwrap_or_default(),
                is_own: effect.is_some_and(|effect| own.contains(effect.name.as_str())),
                change: row.change.as_ref().map(|(change, _)| change.clone()),
                in_fit: true,
                ..Term::new(row.name.clone(), row.change.as_ref().map(|one| one.1.clone()), columns)
            });
        }
        let rows = candidates.len()..terms.len();
        let order = fitted.problem.order_in_time();
        let signatures = signed.iter().map(|one| by_candidate(one, candidates.len())).collect();
        let mut linear = Self {
            fitted,
            candidates,
            terms,
            sums,
            active,
            noise,
            not_testable,
            signed,
            order,
            rows,
            signatures,
        };
        if with_blocks {
            linear.with_stated_values();
        }
        Some(linear)
    }

    /// Takes blocks out of the competition whose covariate is none, and those of a reading over itself of
    /// which a row, or all rows together, are the slope.
    pub fn without_own_covariates(&mut self, no_covariates: &NoCovariates) {
        let selection = Selection::new(&self.sums, &self.terms, &self.active);
        let rows = selection.rows_of(&self.rows());
        let whole = if rows.is_empty() { 0.0 } else { selection.whole_form_left(&[], &rows) };
        let mut out = Vec::new();
        for (number, term) in self.terms.iter().enumerate() {
            let Some(place) = &term.place else { continue };
            let takes = |row: &usize| {
                let left = selection.form_left(&[number], &rows, *row);
                left < OWN_COVARIATE * selection.form_left(&[], &rows, *row)
            };
            let takes_all = || selection.whole_form_left(&[number], &rows) < OWN_COVARIATE * whole;
            if no_covariates.has(place)
                || place.is_over_itself() && (takes_all() || rows.iter().any(takes))
            {
                out.push(number);
            }
        }
        out.into_iter().for_each(|number| self.terms[number].may_enter = false);
    }

    /// The measurands of all campaigns.
    pub fn measurands(&self) -> impl Iterator<Item = Measurand<'_>> {
        let parts = self.fitted.problem.parts.iter().enumerate();
        let all = parts.flat_map(|(part, data)| {
            let names = data.system.assembly.names.measurands.iter().enumerate();
            names.map(move |(measurand, one)| (part, measurand, one.name.as_str()))
        });
        all.enumerate().map(|(number, (part, measurand, name))| Measurand {
            number,
            part,
            measurand,
            name,
        })
    }

    /// The terms that are in the fit: rows, and change points.
    pub fn rows(&self) -> Vec<usize> {
        self.rows.clone().collect()
    }

    /// The row that a candidate would be.
    pub fn row(&self, term: usize) -> Row {
        let own = &self.terms[term];
        let Term { name, variant, members, ln_prior, .. } = own;
        let (name, variant) = (name.clone(), *variant);
        Row { name, variant, members: *members, ln_prior: *ln_prior, change: None }
    }
}

/// For each of so many candidates the places of its signatures.
pub(super) fn by_candidate(signed: &Signatures, candidates: usize) -> Vec<Vec<usize>> {
    let mut places = vec![Vec::new(); candidates];
    for (place, signature) in signed.columns.iter().enumerate() {
        places[signature.candidate].push(place);
    }
    places
}

/// Sets the log prior odds of the terms of candidates, beyond those of one among equals. An effect's
/// are shared by its heads; where a prior makes some more probable, the others give way. A user's own
/// are more probable than these, which are not less so for that. Effects that show in no reading have
/// no part in it. Blocks are equals.
fn set_ln_priors(terms: &mut [Term], candidates: &[Candidate], wanted: &Wanted) {
    let shown = |term: &&mut Term| term.is_effect() && !term.columns.is_empty();
    let effect = |term: &Term| candidates[term.candidate].selected.effect.name.as_str();
    let mut heads: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for one in candidates {
        heads.entry(&one.selected.effect.name).or_default().insert(&one.name);
    }
    let weight = |term: &Term| wanted.prior.times(effect(term)) / heads[effect(term)].len() as f64;
    let weights: Vec<f64> = terms.iter_mut().filter(shown).map(|term| weight(term)).collect();
    let mean = weights.iter().sum::<f64>() / weights.len().max(1) as f64;
    for (term, weight) in terms.iter_mut().filter(shown).zip(&weights) {
        let of_form = if term.variant.is_some() { -RELAXED } else { 0.0 };
        let suspected = if term.is_own { OWN_EFFECT } else { 1.0 };
        term.ln_prior = (suspected * weight / mean).ln() + of_form;
    }
}
