//! When a row stands: five conditions, each with its reason.
//!
//! A row is judged beside all the structure there is: basis blocks enter until none has the
//! evidence. The row that fails with the least predictive gain goes and does not come back; then the
//! search goes on. What is too small for a name stays in the model without one.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::held_out::Folded;
use super::labels::Label;
use super::linear::Linear;
use super::pieces::Pieces;
use super::search::{Log, MOST, Pools};
use super::selection::Selection;
use super::selection::exchange::Exchange;
use super::terms::Term;
use crate::diagnose::library::variant::Variant;
use crate::diagnose::thresholds::{
    APART, APART_OF_ALL, APART_SHARE, BLOCKS_FOR_A_ROW, ENTER, HELD_OUT, LONE_MARGIN, LONE_SHARE,
    MARGIN, OWN_EFFECT, OWN_SHARE, RELAXED_MARGIN, ROW, ROW_BESIDE_REMAINDER, SHARE_OF_REMAINDER,
    SMALL_ROW, TIE,
};

mod beside;
mod groups;
mod objection;

use self::beside::SAME_FORM;
pub use self::objection::Objection;

/// Blocks that enter before a judgement at most.
const MOST_BLOCKS: usize = 8;

/// What the judgement left.
#[derive(Clone, Debug, Default)]
pub struct Judged {
    /// The model.
    pub model: Vec<usize>,
    /// Terms of the model that are too small for a name.
    pub nameless: Vec<usize>,
    /// Rows that were taken back, with the reason.
    pub objections: Vec<(usize, Objection)>,
}

impl Selection<'_> {
    /// Judges the rows of a model until every one stands.
    pub fn judge(
        &mut self,
        mut model: Vec<usize>,
        mut pools: Pools,
        linear: &Linear,
        log: &mut Log,
    ) -> Judged {
        let mut objections: Vec<(usize, Objection)> = Vec::new();
        let mut small: Vec<(f64, usize)> = Vec::new();
        loop {
            for _ in 0..MOST_BLOCKS {
                let Some(best) = self.best_block(&model, &pools) else { break };
                self.note(log, "+", best.term, best.ln_bayes);
                let block = self.beside_rows(&model, best.term);
                model.push(block);
                self.set_scale(&model);
                model = self.prune(model, log);
                model = self.grow(model, &pools.effects, ROW, MOST, log);
            }
            let own = Pieces::new(linear, self, &model);
            let Some((term, objection)) = self.worst(&model, &pools.blocks, &own) else { break };
            log.push(format!("{} does not stand: {objection:?}", self.terms[term].name));
            if let Objection::Small(noncentrality) = objection {
                small.push((noncentrality, term));
            }
            objections.push((term, objection));
            let Term { name, variant, .. } = self.terms[term].clone();
            for own in self.terms.iter_mut().filter(|own| own.name == name) {
                own.may_enter &= variant.is_some() && own.variant != variant;
            }
            pools.effects.retain(|own| self.terms[*own].may_enter);
            model.retain(|own| *own != term);
            model = self.reduced_anew(&model);
            // A block that its row had left something of may have all of it now.
            model = self.prune(model, log);
            model = self.grow(model, &pools.effects, ROW, MOST, log);
        }
        // The rows stand: what blocks that came in the place of another term have of their forms is theirs.
        model = self.all_beside_rows(model);
        // What is too small for a name is still there.
        small.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut nameless = Vec::new();
        for (_, term) in small {
            // Blocks may have taken its place, and be all that remains.
            let with = [model.clone(), vec![term]].concat();
            let (with, evidence) = self.pruned(with, &mut Log::new());
            let Some(at) = with.iter().position(|own| *own == term) else { continue };
            let has_no_block = self.rows_of(&with).len() == with.len();
            let may_leave = |own: &usize| has_no_block && !self.terms[*own].is_effect();
            let keeps_all = model.iter().all(|own| with.contains(own) || may_leave(own));
            if !keeps_all || evidence < self.ln_evidence(&model) + TIE {
                continue;
            }
            let own = Pieces::new(linear, self, &with);
            let drop = Folded::new(self, &with, &own).predictive_gains(&[at])[0];
            if drop < HELD_OUT {
                continue;
            }
            model = with;
            nameless.push(term);
        }
        Judged { model, nameless, objections }
    }

    /// The row that does not stand with the least predictive gain.
    fn worst(
        &self,
        model: &[usize],
        blocks: &[usize],
        pieces: &Pieces,
    ) -> Option<(usize, Objection)> {
        let folded = Folded::new(self, model, pieces);
        let gains = self.contributions(model);
        let is_row = |term: usize| self.terms[term].is_effect();
        let rows: Vec<usize> = (0..model.len()).filter(|at| is_row(model[*at])).collect();
        // What changed at a moment and is in the fit has its form: it leaves nothing to imitators.
        let remains = |at: &usize| !is_row(model[*at]) && !self.terms[model[*at]].in_fit;
        let rest: f64 = (0..model.len()).filter(remains).map(|at| gains[at].excess()).sum();
        let is_form = |term: &Term| !term.is_of_runs() && term.change.is_none();
        let drops = folded.predictive_gains(&rows);
        let mut objections: Vec<(usize, Objection)> = Vec::new();
        for (row, at) in rows.iter().enumerate() {
            let gain = gains[*at].gain;
            // What remains in readings that a row leaves as they are says nothing against a cause that
            // a user suspects.
            let is_own = self.terms[model[*at]].is_own;
            let rest = if is_own { self.excess_beside(model, &gains, *at, is_form) } else { rest };
            let beside = if rest > 0.0 { ROW_BESIDE_REMAINDER } else { 0.0 };
            let least = ROW.max(beside);
            let is_small = || {
                // What remains in other measurands leaves no imitator of the row.
                let beside = self.excess_beside(model, &gains, *at, |term| !term.in_fit);
                let is_part = gain < SHARE_OF_REMAINDER * rest.min(beside);
                gain < least || is_part && !self.needs_its_form(model, *at, gains[*at], blocks)
            };
            if drops[row] < HELD_OUT {
                objections.push((row, Objection::HeldOut(drops[row])));
            } else if is_small() {
                objections.push((row, Objection::Small(gain.sqrt())));
            }
        }
        if objections.is_empty() {
            let lost = self.lost_in_remainder(model, &gains);
            objections.extend(
                rows.iter()
                    .enumerate()
                    .filter_map(|(row, at)| Some((row, Objection::MayBeZero(*lost.get(at)?)))),
            );
        }
        let total = self.chi_squared(&[]) - self.chi_squared(model);
        if objections.is_empty() {
            // Of many rows one differs by chance.
            let least = APART + (rows.len().max(1) as f64).ln();
            for (row, at) in rows.iter().enumerate() {
                // Angles are no test of a cause that cannot have values for each.
                let is_of_angles = self.terms[model[*at]].variants.contains(&Variant::EachAngle);
                let wanted = |label: &Label| *label != Label::Angle || is_of_angles;
                if let Some((label, ln_bayes, gain)) =
                    self.separate_values(model, *at, pieces, wanted)
                    && ln_bayes >= least
                    && gain > (APART_SHARE * gains[*at].gain).max(APART_OF_ALL * total)
                {
                    objections.push((row, Objection::Apart(label, gain)));
                }
            }
        }
        if objections.is_empty() && !blocks.is_empty() {
            let evidence = self.ln_evidence(model);
            let exchange = Exchange::new(self, model, blocks);
            // What remains in the readings that a row changes, of forms that are not known: values of
            // runs, and those that change at a moment, leave nothing to imitators.
            let rest_of = |at: usize| self.excess_beside(model, &gains, at, is_form);
            let one = |row: usize| {
                let at = rows[row];
                let gain = gains[at].gain;
                // Values of setups follow many forms that the library lacks.
                let own = &self.terms[model[at]];
                let margin = if own.variant == Some(Variant::EachSetup) {
                    // Those of a cause that a user suspects are no less probable than forms.
                    if own.is_own { 0.0 } else { RELAXED_MARGIN }
                } else if gain < SMALL_ROW * rest_of(at)
                    && !self.needs_its_form(model, at, gains[at], blocks)
                {
                    MARGIN
                } else if own.is_own {
                    // Within a tie the cause that a user suspects stands.
                    -(TIE + OWN_EFFECT.ln())
                } else {
                    0.0
                };
                let (own, simpler) = self.replaced(&exchange, model[at], blocks);
                // One unmodelled cause may be both the only row, if no user suspects that, and what remains in
                // its readings.
                let is_lone = rows.len() == 1
                    && !self.terms[model[at]].is_own
                    && rest_of(at) > LONE_SHARE * gain;
                let one_cause = is_lone && simpler - evidence > -LONE_MARGIN;
                let own = own - evidence;
                // Where nothing remains, a block of the same form is no evidence against it.
                let may_tie = rest <= 0.0 && margin <= 0.0 && own <= TIE;
                let has_form = |share| self.has_its_form(model, model[at], blocks, share);
                let is_tie = || may_tie && has_form(SAME_FORM);
                // What a formula of the user's own is rounded off by is no evidence against it either.
                let is_nearly_own = || self.terms[model[at]].is_own && has_form(OWN_SHARE);
                let is_replaced = own > -margin && !is_tie() && !is_nearly_own();
                (is_replaced || one_cause).then_some((row, Objection::Replaced(own)))
            };
            let ones: Vec<_> = (0..rows.len()).into_par_iter().filter_map(one).collect();
            objections.extend(ones);
        }
        let worst = objections.into_iter().min_by(|a, b| drops[a.0].total_cmp(&drops[b.0]));
        worst.map(|(row, objection)| (model[rows[row]], objection))
    }

    /// Log evidence of the model with blocks in the place of a row, and that of such models with fewer
    /// terms.
    fn replaced(&self, exchange: &Exchange<'_>, row: usize, blocks: &[usize]) -> (f64, f64) {
        let model = &exchange.model;
        // Blocks that were reduced beside a row are whole again without it.
        let whole = |term: &usize| self.whole(*term);
        let kept = model.iter().filter(|term| **term != row);
        let mut new: Vec<usize> = kept.map(whole).collect();
        let mut best = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        let prices = model.iter().copied().zip(self.prices(model));
        let known: BTreeMap<usize, f64> =
            prices.filter(|(term, _)| self.terms[*term].is_effect()).collect();
        // A block that overlaps with other rows hides a part of what they gain, and makes them no cheaper.
        let cheaper = |new: &[usize]| -> f64 {
            let prices = new.iter().zip(self.prices(new));
            let own = prices.filter_map(|(term, price)| Some(known.get(term)? - price));
            own.map(|less| less.max(0.0)).sum()
        };
        let mut pruned = |new: Vec<usize>| {
            let (new, evidence) = self.pruned(new, &mut Log::new());
            let evidence = evidence - cheaper(&new);
            best.0 = evidence.max(best.0);
            if new.len() < model.len() {
                best.1 = evidence.max(best.1);
            }
            new
        };
        let restored =
            model.iter().filter(|term| self.terms[**term].reduced_from.is_some()).count();
        if restored > 0 {
            new = pruned(new);
        }
        for round in restored..BLOCKS_FOR_A_ROW {
            let first = match round {
                0 => exchange.best(row, |_| true),
                _ => self.ranked(&new, blocks).first().copied(),
            };
            let Some(first) = first.filter(|one| one.ln_bayes >= ENTER) else { break };
            new.push(first.term);
            new = pruned(new);
        }
        best
    }
}
