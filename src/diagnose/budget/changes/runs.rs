//! Runs that differ, in the place of a block with a value for each run: where only some of them need
//! one, each is a change with one value, and effects that the block took up may be seen again.

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
            sparse.terms.extend(changes.iter().map(|(column, change)| Term {
                members: change.members,
                change: Some(change.clone()),
                ..Term::new(
                    String::new(),
                    selection.terms[*block].place.clone(),
                    vec![vec![(*column, 1.0)]],
                )
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
        let block = &self.candidates[candidate].selected.effect;
        let names = self.fitted.problem.run_names();
        let columns = &self.sums.of_candidate[candidate];
        let change = |column: &usize| {
            let owner = &self.sums.owners[column - self.sums.nominal];
            let run = names.iter().position(|name| owner.of.as_ref() == Some(name))?;
            let is_own = |name: &str| owner.parameter.rsplit('.').next() == Some(name);
            let signature = block.parameters.iter().position(|one| is_own(&one.name))?;
            let change = Change {
                base: Base { candidate, signature },
                at: (run, 0),
                end: Some(self.fitted.problem.samples_in(run)),
                gain: Gain::default(),
                members: columns.len(),
            };
            Some((*column, change))
        };
        columns.iter().filter_map(change).collect()
    }
}
