//! The rows of a budget with their values, shares and what they are confounded with, and how far they
//! close the gap on readings that they were not fitted to.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnose::budget::answer::{Confounded, Row};
use crate::diagnose::budget::confounded::confounded;
use crate::diagnose::budget::held_out::Folded;
use crate::diagnose::budget::in_fit::effect_of;
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::member::member_uncertainties;
use crate::diagnose::budget::noise_scale::scale_noise;
use crate::diagnose::budget::pieces::Pieces;
use crate::diagnose::budget::selection::{Ranked as RankedTerm, Selection};
use crate::diagnose::budget::sizes::WellDetermined;
use crate::diagnose::budget::solved::{Solved, ratio_to_typical};
use crate::diagnose::budget::stamp_jumps::stamp_jumps;
use crate::diagnose::budget::terms::without;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::gap::{Gap, Steps, gap};
use crate::diagnose::price::{Gain, ROUNDING, posterior};
use crate::diagnose::thresholds::{ENTER, OWN_EFFECT, TIE};
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, finish};
use crate::system::Selected;

use super::Budget;

/// Effects that are compared with a row.
const RIVALS: usize = 8;

/// Part of the standard uncertainty of a row below which a sum with others is reported.
const BETTER: f64 = 0.5;

/// A way to cut readings into folds.
type Cut = fn(&Linear, &Selection<'_>, &[usize]) -> Pieces;

/// The rows of a budget.
pub(super) struct Rows {
    /// Largest first.
    pub(super) rows: Vec<Row>,
    /// How far they close the gap.
    pub(super) gap: Gap,
    /// The fits without them and with one after the other.
    pub(super) steps: Steps,
    /// The joint estimate with them.
    pub(super) explained: Calibration,
}

impl Budget<'_> {
    /// The terms of the model that stand as rows, beside the rest and what each part of that takes off
    /// chi squared.
    pub(super) fn rows(
        &self,
        stands: &[usize],
        (rest, parts): (&[usize], &[f64]),
        gains: &[Gain],
        options: &Options,
    ) -> Result<Rows, FitError> {
        let Self { linear, selection, model, .. } = self;
        let in_fit = selection.rows_of(&linear.rows());
        // What a block was reduced by may be in the remainder all the same.
        let whole: Vec<usize> = model.iter().map(|term| selection.whole(*term)).collect();
        let mut of_rows = Solved::of(selection, &whole, rest, gains);
        if linear.fitted.problem.has_autocorrelated_noise() {
            of_rows = of_rows.with_shifts(selection, &whole, rest, gains);
        }
        let mut rows: Vec<Row> = Vec::new();
        // Change points, in the fit or not, are not explained: rows are judged beside them.
        let changes: Vec<usize> =
            linear.rows().into_iter().filter(|row| !in_fit.contains(row)).collect();
        let is_found = |term: &usize| linear.terms[*term].appended().is_some();
        let found = model.iter().copied().filter(is_found);
        let moments: Vec<usize> = changes.iter().copied().chain(found).collect();
        let terms = [moments.clone(), in_fit.clone()].concat();
        let folded_rows = |cut: Cut| {
            let (folded, pieces) = self.folded(&terms, cut);
            (folded.with_nominal_terms(moments.len()), pieces)
        };
        let (mut rows_folded, mut pieces) = folded_rows(Pieces::new);
        let mut folded = self.folded(model, Pieces::new).0;
        if !rows_folded.is_shown() {
            (rows_folded, pieces) = folded_rows(Pieces::within_runs);
            folded = self.folded(model, Pieces::within_runs).0;
        }
        let mut with_rows = linear.fitted.clone();
        scale_noise(&mut with_rows.problem, linear, &selection.scale);
        let with_rows = with_rows.again(options)?;
        let of_terms = |terms: &[usize]| -> Vec<Selected> {
            let named = terms.iter().map(|row| &linear.terms[*row].name);
            named.filter_map(|name| effect_of(&with_rows, name).cloned()).collect()
        };
        let selected = of_terms(&in_fit);
        let changes = of_terms(&changes);
        let rows_alone = match changes.as_slice() {
            [] => with_rows.clone(),
            all => with_rows.without(&all.iter().collect::<Vec<_>>(), options)?,
        };
        let steps = Steps::of(&rows_alone, &selected, options)?;
        let degrees = stands.iter().map(|at| gains[*at].degrees).sum();
        let leftover = parts.iter().sum::<f64>() + self.of_transients;
        let drops = rows_folded.drops(selection, &pieces);
        let gap = gap(&steps, &drops, degrees, leftover);
        let all = (gap.held_out_drop.max(0.0) + leftover).max(f64::MIN_POSITIVE);
        let members = member_uncertainties(&with_rows, &selected, options)?;
        let Fitted { problem, fit, .. } = with_rows.clone();
        let explained = finish(problem, fit, Vec::new(), Vec::new())?;
        let of_rest = (whole.as_slice(), rest, gains);
        let without_others = of_rows.clone();
        let confounded = confounded(linear, selection, &mut of_rows, of_rest, stands);
        let predictive_gains = folded.predictive_gains(stands);
        for ((at, confounded), predictive_gain) in
            stands.iter().zip(confounded).zip(predictive_gains)
        {
            let term = model[*at];
            let name = &linear.terms[term].name;
            // Beside the other rows: what the remainder could take over from it is the row's. Beside
            // the remainder, too, where that hides all of it.
            let row = in_fit.iter().position(|own| *own == term);
            let beside_rows = row.map_or(0.0, |row| rows_folded.squares_drop(row));
            let drop = if beside_rows > 0.0 { beside_rows } else { folded.squares_drop(*at) };
            let closes = drop.clamp(0.0, gap.held_out_drop.max(0.0)) / all;
            let mut values = of_rows.values(linear, name, *at, &explained);
            let own = || members.iter().filter(|one| one.effect == *name);
            for (instance, share) in own().flat_map(|one| &one.shares) {
                let own = values.iter_mut().filter(|value| value.instance == Some(*instance));
                own.for_each(|value| value.sigma = value.sigma.map(|own| own.hypot(*share)));
            }
            let mut row = Row {
                closes,
                confounded,
                member_sigma: own().map(|one| (one.family.clone(), one.sigma)).collect(),
                ratio_to_typical: ratio_to_typical(&linear.fitted.problem, &values),
                values,
                predictive_gain,
                ..self.row(*at, gains)
            };
            let others: Vec<&Confounded> = row.together().collect();
            let mut found =
                without_others.well_determined(linear, selection, (&whole, *at), &others);
            let shares =
                members.iter().filter(|one| one.effect == *name).flat_map(|one| &one.shares);
            if let Some(sum) = &mut found {
                sum.sigma = shares.fold(sum.sigma, |sigma, (_, share)| sigma.hypot(*share));
            }
            let sigma = row.values.first().and_then(|one| one.sigma);
            let is_better = |one: &WellDetermined| sigma.is_some_and(|u| one.sigma < BETTER * u);
            row.well_determined = found.filter(is_better);
            rows.push(row);
        }
        rows.sort_by(|a, b| b.gain.gain.total_cmp(&a.gain.gain));
        Ok(Rows { rows, gap, steps, explained })
    }

    /// The sums of some terms by fold.
    fn folded(&self, terms: &[usize], cut: Cut) -> (Folded, Pieces) {
        let pieces = cut(self.linear, self.selection, terms);
        (Folded::new(self.selection, terms, &pieces), pieces)
    }

    /// A row without its values and what it brings on held-out readings.
    fn row(&self, at: usize, gains: &[Gain]) -> Row {
        let Self { linear, selection, pools, .. } = self;
        let term = self.model[at];
        let own = &linear.terms[term];
        let rest = without(self.model, term);
        let ln_bayes = selection.ln_bayes_factor(term, gains[at]);
        let tie = TIE.max(ROUNDING * ln_bayes);
        let rivals = selection.ranked(&rest, &pools.effects);
        // An effect in two forms is one rival.
        let mut names: BTreeSet<&str> = BTreeSet::from([own.name.as_str()]);
        let is_new = |one: &RankedTerm| names.insert(&linear.terms[one.term].name);
        let rivals: Vec<_> = rivals.into_iter().filter(is_new).take(RIVALS).collect();
        let aliases: Vec<String> = rivals
            .iter()
            .filter(|one| one.ln_bayes >= ENTER && one.ln_bayes > ln_bayes - tie)
            .map(|one| linear.terms[one.term].name.clone())
            .collect();
        let blocks = selection.ranked(&rest, &pools.blocks);
        // What has nearly the form of a cause that a user suspects is no other cause. As a copy it is no more
        // probable than by what it is known for beforehand.
        let of_rival = |one: &RankedTerm| match selection.is_copy(self.model, term, one.term) {
            true => one.ln_bayes.min(ln_bayes - OWN_EFFECT.ln()),
            false => one.ln_bayes,
        };
        let other = |one: &&RankedTerm| !selection.is_nearly_own(self.model, term, one.term);
        let others = rivals.iter().chain(blocks.iter().find(other)).map(of_rival);
        let selected = effect_of(&linear.fitted, &own.name);
        let alone = selection.gain(&[], term);
        Row {
            name: own.name.clone(),
            variant: own.variant,
            member: selected.map(|one| one.member.clone()).unwrap_or_default(),
            member_sigma: BTreeMap::new(),
            ratio_to_typical: None,
            values: Vec::new(),
            gain: gains[at],
            ln_bayes,
            closes: 0.0,
            alone: (alone.excess() / self.total.max(f64::MIN_POSITIVE)).min(1.0),
            posterior: posterior(ln_bayes, others),
            predictive_gain: 0.0,
            aliases,
            unmodelled_alias: blocks
                .first()
                .filter(|one| one.ln_bayes > ln_bayes - tie)
                .and_then(|one| Some(linear.terms[one.term].place.as_ref()?.words.clone())),
            confounded: Vec::new(),
            well_determined: None,
            stamp_jumps: stamp_jumps(&linear.fitted.problem, selected),
        }
    }
}
