//! Runs that differ, in the place of a block with a value for each run: where only some of them need
//! one, each is a change with one value, and effects that the block absorbed may be seen again.

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::search::{Log, MOST};
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::terms::{Base, Change, Term, without};
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::SWAP;

impl Linear {
    /// Changes of single runs that are, with effects, the better ones in the place of a block of a
    /// model with a value for each run.
    pub(super) fn runs_in_place(&self, selection: &Selection<'_>, model: &[usize]) -> Vec<Change> {
        let evidence = selection.ln_evidence(model);
        let mut found = Vec::new();
        for block in model.iter().filter(|term| selection.terms[**term].is_of_runs()) {
            let mut sparse = selection.clone();
            let first = sparse.terms.len();
            let changes = self.single_runs(selection.terms[*block].candidate);
            let place = &selection.terms[*block].place;
            sparse.terms.extend(changes.iter().map(|(column, change)| Term {
                members: change.members,
                change: Some(change.clone()),
                ..Term::new(String::new(), place.clone(), vec![vec![(*column, 1.0)]])
            }));
            let effects = (0..first).filter(|term| sparse.terms[*term].is_effect());
            let pool: Vec<usize> = effects.chain(first..sparse.terms.len()).collect();
            let grown = sparse.grow(without(model, *block), &pool, 0.0, MOST, &mut Log::new());
            sparse.adopt_scale(&selection.scale);
            if sparse.ln_evidence(&grown) > evidence + SWAP {
                let runs = grown.into_iter().filter(|term| *term >= first);
                found.extend(runs.map(|term| changes[term - first].1.clone()));
            }
        }
        found
    }

    /// The columns of a block with a value for each run, each as a change of that run.
    fn single_runs(&self, candidate: usize) -> Vec<(usize, Change)> {
        let signatures = self.candidates[candidate].selected.effect.parameters.len();
        let change = |run: usize, signature: usize| {
            let base = Base { candidate, signature };
            let column = self.sums.column_at(run, self.place_of(run, base)?)?;
            let change = Change {
                base,
                width: 1,
                at: (run, 0),
                end: Some(self.fitted.problem.samples_in(run)),
                gain: Gain::default(),
                members: self.sums.of_candidate[candidate].len(),
            };
            Some((column, change))
        };
        let all = (0..self.order.len()).flat_map(|run| (0..signatures).map(move |own| (run, own)));
        all.filter_map(|(run, signature)| change(run, signature)).collect()
    }
}
