//! What a block hides: each block of a model is taken out once, and effects grow in its place, one after
//! the other or two at once, with a narrower block beside them where one is worth its price.

use crate::diagnose::budget::search::{Log, MOST, Pools};
use crate::diagnose::budget::selection::{Ranked, Selection};
use crate::diagnose::budget::terms::{Term, without};

impl Selection<'_> {
    /// Takes each block out once and lets effects grow in its place.
    pub(super) fn without_wide_blocks(
        &mut self,
        mut model: Vec<usize>,
        pools: &Pools,
        tried: &mut Vec<usize>,
        log: &mut Log,
    ) -> Vec<usize> {
        let blocks: Vec<usize> =
            model.iter().copied().filter(|term| !self.terms[*term].is_effect()).collect();
        for block in blocks {
            if !model.contains(&block) || tried.contains(&block) {
                continue;
            }
            tried.push(block);
            let (scale, evidence) = (self.scale.clone(), self.ln_evidence(&model));
            let rest = without(&model, block);
            let is_new = |found: &[usize]| found.iter().any(|term| !model.contains(term));
            let pool = self.in_place_of(block, pools);
            let (mut grown, mut steps) = self.grown_in_place(&rest, &pool, &scale);
            if !is_new(&grown) {
                continue;
            }
            if let Some(narrower) = self.narrower_block(&grown, block, pools) {
                self.note(&mut steps, "+", narrower.term, narrower.ln_bayes);
                grown.push(narrower.term);
                grown = self.prune(grown, &mut steps);
            }
            let name = self.terms[block].name.clone();
            let without = self.ln_evidence(&grown) - evidence;
            if without > 0.0 {
                log.push(format!("effects instead of {name} ({without:.1})"));
                log.append(&mut steps);
                model = grown;
            }
        }
        model
    }

    /// The block that enters beside effects in the place of another block, if it has fewer values: an
    /// effect and a wave that have both been in a block of many orders.
    fn narrower_block(&self, model: &[usize], block: usize, pools: &Pools) -> Option<Ranked> {
        let values = |term: usize| self.terms[term].columns.len();
        self.best_block(model, pools).filter(|best| values(best.term) < values(block))
    }

    /// What may grow in the place of a block: effects, and of one with a value for each run the runs that
    /// are known to differ.
    fn in_place_of(&self, block: usize, pools: &Pools) -> Vec<usize> {
        let Term { candidate, .. } = self.terms[block];
        let is_run = |term: &&usize| {
            let change = self.terms[**term].change.as_ref();
            self.terms[block].is_of_runs()
                && change.is_some_and(|one| one.base.candidate == candidate)
        };
        pools.effects.iter().chain(pools.blocks.iter().filter(is_run)).copied().collect()
    }

    /// A model in which effects have grown one after the other, or from the best two at once: two that
    /// nearly cancel explain more than what enters in the place of either. Returns the one with more
    /// evidence under these noise scale factors, which are restored.
    fn grown_in_place(
        &mut self,
        rest: &[usize],
        pool: &[usize],
        scale: &[f64],
    ) -> (Vec<usize>, Log) {
        let pair = self.best_pair(rest, pool);
        let mut steps = Log::new();
        let grown = self.grow(rest.to_vec(), pool, 0.0, MOST, &mut steps);
        let Some(pair) = pair.filter(|pair| pair.iter().any(|term| !grown.contains(term))) else {
            self.adopt_scale(scale);
            return (grown, steps);
        };
        let mut of_pair =
            vec![format!("+ {} and {}", self.terms[pair[0]].name, self.terms[pair[1]].name)];
        let both = self.prune([rest, &pair].concat(), &mut of_pair);
        let both = self.grow(both, pool, 0.0, MOST, &mut of_pair);
        self.adopt_scale(scale);
        if self.ln_evidence(&both) > self.ln_evidence(&grown) {
            return (both, of_pair);
        }
        (grown, steps)
    }
}
