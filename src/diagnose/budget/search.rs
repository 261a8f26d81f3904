//! The search for a model: terms enter, leave, are exchanged and taken apart, each by the same
//! price.
//!
//! Effects come first; where none enters, the best basis block does, and effects may enter again. A
//! row goes for an effect that is better, or for a block that is no wider and better by
//! [`TIE`]; a block goes for a change. A block may hide several effects: each is taken out once and
//! effects are grown in its place, two at once where none enters by itself (`pair`), or with a narrower
//! block beside them (`unblock`). Whether a row stands is for [`super::judge`] to say.

use super::selection::exchange::Exchange;
use super::selection::{Ranked, Selection};
use crate::diagnose::price::ROUNDING;
use crate::diagnose::thresholds::{ENTER, MOST_ROWS, TIE};

mod pair;
mod unblock;

/// Terms that enter in one go at most.
pub(super) const MOST: usize = 40;
/// Rounds of blocks and effects.
const ROUNDS: usize = 6;
/// Values of blocks from which no more of them enter: what so many do not explain is for noise to
/// explain, if anything is.
const MOST_VALUES: usize = 400;
/// Swaps at most.
const SWAPS: usize = 12;

/// What a search does, step by step: for a reader who wants to know why.
pub type Log = Vec<String>;

/// The pools of a search.
#[derive(Clone, Debug)]
pub struct Pools {
    /// Library effects.
    pub effects: Vec<usize>,
    /// Basis blocks.
    pub blocks: Vec<usize>,
}

impl Pools {
    /// Of a selection.
    pub fn of(selection: &Selection<'_>) -> Self {
        let of = |effect: bool| {
            let all = 0..selection.terms.len();
            all.filter(|term| selection.terms[*term].is_effect() == effect).collect()
        };
        Self { effects: of(true), blocks: of(false) }
    }
}

impl Selection<'_> {
    /// The model that the sums bear out, from a first one.
    pub fn search(&mut self, start: &[usize], pools: &Pools, log: &mut Log) -> Vec<usize> {
        self.set_scale(start);
        let mut model = self.prune(start.to_vec(), log);
        model = self.grow(model, &pools.effects, 0.0, MOST_ROWS + 4, log);
        model = self.swap(model, pools, log);
        let mut tried: Vec<usize> = Vec::new();
        for _ in 0..ROUNDS {
            if pools.blocks.is_empty() {
                break;
            }
            let before = sorted(&model);
            self.set_scale(&model);
            if let Some(best) = self.best_block(&model, pools) {
                self.note(log, "+", best.term, best.ln_bayes);
                let block = self.beside_rows(&model, best.term);
                model.push(block);
                self.set_scale(&model);
                model = self.prune(model, log);
            }
            model = self.grow(model, &pools.effects, 0.0, MOST, log);
            model = self.without_wide_blocks(model, pools, &mut tried, log);
            model = self.swap(model, pools, log);
            if sorted(&model) == before {
                break;
            }
        }
        self.set_scale(&model);
        model
    }

    /// The block that enters next beside a model.
    pub(super) fn best_block(&self, model: &[usize], pools: &Pools) -> Option<Ranked> {
        if self.has_most_blocks(model) {
            return None;
        }
        let mut ranked = self.ranked(model, &pools.blocks);
        if ranked.first().is_some_and(|best| best.ln_bayes < ENTER) {
            self.rank_under_any_noise(model, &mut ranked);
        }
        ranked.first().copied().filter(|best| best.ln_bayes >= ENTER)
    }

    /// Whether a model has so many blocks that no more of them enter.
    pub fn has_most_blocks(&self, model: &[usize]) -> bool {
        let terms = model.iter().map(|term| &self.terms[*term]);
        let values = terms.filter(|term| !term.is_effect()).map(|term| term.columns.len());
        values.sum::<usize>() >= MOST_VALUES
    }

    /// Lets the terms of a pool enter one after the other.
    pub fn grow(
        &mut self,
        mut model: Vec<usize>,
        pool: &[usize],
        least: f64,
        most: usize,
        log: &mut Log,
    ) -> Vec<usize> {
        let mut seen: Vec<Vec<usize>> = Vec::new();
        for _ in 0..most {
            // Terms may drive each other out in turn.
            let now = sorted(&model);
            if seen.contains(&now) {
                break;
            }
            seen.push(now);
            self.set_scale(&model);
            let ranked = self.ranked(&model, pool);
            let best = ranked.iter().find(|one| one.gain.gain >= least);
            let Some(best) = best.filter(|best| best.ln_bayes >= ENTER) else { break };
            self.note(log, "+", best.term, best.ln_bayes);
            model.push(best.term);
            model = self.prune(model, log);
        }
        model
    }

    /// Takes out the terms that are not worth their price any more.
    pub fn prune(&self, model: Vec<usize>, log: &mut Log) -> Vec<usize> {
        self.pruned(model, log).0
    }

    /// A model without those, and its log evidence.
    pub(super) fn pruned(&self, mut model: Vec<usize>, log: &mut Log) -> (Vec<usize>, f64) {
        loop {
            let (gains, evidence) = self.contributions_with_evidence(&model);
            let worst = model
                .iter()
                .zip(gains)
                .map(|(term, gain)| (self.ln_bayes_factor(*term, gain), *term))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((ln_bayes, term)) = worst.filter(|(ln_bayes, _)| *ln_bayes < ENTER) else {
                return (model, evidence);
            };
            self.note(log, "-", term, ln_bayes);
            model.retain(|own| *own != term);
        }
    }

    /// Exchanges rows for better ones, and blocks for changes.
    fn swap(&self, mut model: Vec<usize>, pools: &Pools, log: &mut Log) -> Vec<usize> {
        for _ in 0..SWAPS {
            if model.is_empty() {
                break;
            }
            let gains = self.contributions(&model);
            let is_effect = |term: usize| self.terms[term].is_effect();
            let rows = model.iter().zip(&gains).filter(|(term, _)| is_effect(**term));
            let widest = rows.map(|(_, gain)| gain.degrees).max().unwrap_or(0);
            let is_simple = |block: usize, degrees: usize| {
                let term = &self.terms[block];
                !term.is_effect() && !term.is_of_runs() && term.columns.len() <= degrees
            };
            let is_change = |block: usize| self.terms[block].change.is_some();
            let is_tried = |block: &&usize| is_simple(**block, widest) || is_change(**block);
            let simple = pools.blocks.iter().filter(is_tried);
            let pool: Vec<usize> = pools.effects.iter().chain(simple).copied().collect();
            let exchange = Exchange::new(self, &model, &pool);
            let mut best: Option<(f64, usize, usize)> = None;
            for (term, gain) in model.iter().zip(&gains) {
                let own = self.ln_bayes_factor(*term, *gain);
                let effect = exchange.best(*term, is_effect);
                let tie = TIE.max(ROUNDING * own);
                let effect = effect.filter(|one| one.ln_bayes >= ENTER.max(own + tie));
                let is_plain = |block: usize| is_simple(block, gain.degrees);
                let block = match &self.terms[*term] {
                    own if own.is_effect() => exchange.best(*term, is_plain),
                    // A wide block may follow one change.
                    own if own.change.is_none() => exchange.best(*term, is_change),
                    _ => None,
                };
                let block = block.filter(|one| {
                    one.ln_bayes >= ENTER.max(own) + tie
                        && !self.is_nearly_own(&model, *term, one.term)
                });
                for found in effect.into_iter().chain(block) {
                    let gained = found.ln_bayes - own;
                    if best.is_none_or(|(known, ..)| gained > known) {
                        best = Some((gained, *term, found.term));
                    }
                }
            }
            let Some((gained, out, other)) = best else { break };
            log.push(format!(
                "{} for {} ({gained:.1})",
                self.terms[other].name, self.terms[out].name
            ));
            model.retain(|own| *own != out);
            model.push(other);
            model = self.prune(model, log);
        }
        model
    }

    pub(super) fn note(&self, log: &mut Log, sign: &str, term: usize, ln_bayes: f64) {
        log.push(format!("{sign} {} ({ln_bayes:.1})", self.terms[term].name));
    }
}

fn sorted(model: &[usize]) -> Vec<usize> {
    let mut sorted = model.to_vec();
    sorted.sort_unstable();
    sorted
}
