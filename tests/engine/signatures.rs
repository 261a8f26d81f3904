//! Signatures of effects that are not in the model, against the model that has the effect.

use std::path::Path;
use std::sync::Arc;

use homepoint::engine::gram::LeastSquares;
use homepoint::engine::passes::Passes;
use homepoint::engine::signatures::{Candidate, Signatures};
use homepoint::engine::{Point, Problem};

use crate::planned;

/// Names of a run's columns in their order, with the component; last the residual.
fn names(problem: &Problem, run: usize) -> Vec<(String, usize)> {
    let mut names = Vec::new();
    for column in problem.layout.columns.touched_by(run) {
        for (index, instance) in problem.layout.instances.iter().enumerate() {
            for component in 0..instance.dimension() {
                let moves = problem.layout.columns_of(index, component);
                if moves.iter().any(|(moved, _)| *moved == column) {
                    names.push((instance.name.clone(), component));
                }
            }
        }
    }
    names.dedup();
    names.push((String::new(), 0));
    names
}

/// The campaign with each effect that fits it.
fn with_each_effect(path: &Path) -> Vec<(String, Problem)> {
    let effects = planned::fitting(path).into_iter();
    effects.map(|effect| (effect.clone(), planned::problem(path, &[&effect]))).collect()
}

#[test]
fn sums_are_those_of_the_model_that_has_the_effect() {
    let folder = planned::folder("signatures");
    let mut compared = 0;
    for campaign in ["arm", "robot", "stations"] {
        let path = folder.join(campaign);
        let mut nominal = planned::problem(&path, &[]);
        let point = Point::stated(&nominal.layout);
        nominal.refresh_weights(&point);
        for effect in planned::fitting(&path) {
            let mut with = planned::problem(&path, &[&effect]);
            // Values that sum to zero have columns of their own kind.
            if with.layout.instances.iter().any(|one| one.setting.sum_zero) {
                continue;
            }
            // Switched off, the noise is the nominal one.
            with.parts[0].random_sigma.fill(0.0);
            for (sigma, one) in
                nominal.parts[0].random_sigma.iter().zip(&nominal.parts[0].system.randoms)
            {
                let index = with.parts[0].system.randoms.iter().position(|r| r.name == one.name);
                with.parts[0].random_sigma[index.unwrap()] = *sigma;
            }
            let stated = Point::stated(&with.layout);
            with.refresh_weights(&stated);
            let candidate = Candidate { number: 0, system: &with.parts[0].system };
            let signatures = Signatures::new(&nominal, 0, &[candidate]);
            let found = nominal.gram_with(&signatures, &point);
            let due = with.normal(&stated);
            for run in 0..found.len() {
                let mut own = names(&nominal, run);
                let residual = own.pop().unwrap();
                own.extend(signatures.columns.iter().map(|s| (s.parameter.clone(), s.component)));
                own.push(residual);
                let all = names(&with, run);
                let place: Vec<usize> =
                    own.iter().map(|one| all.iter().position(|o| o == one).unwrap()).collect();
                let (found, due) = (&found[run].gram, &due.runs[run].gram);
                for (i, a) in place.iter().enumerate() {
                    for (j, b) in place.iter().enumerate() {
                        let scale = (due[(*a, *a)] * due[(*b, *b)]).sqrt();
                        let off = (found[(i, j)] - due[(*a, *b)]).abs();
                        assert!(
                            off <= 1e-10 * scale,
                            "{effect} in {campaign}: {:?} {:?} {} for {}",
                            own[i],
                            own[j],
                            found[(i, j)],
                            due[(*a, *b)]
                        );
                    }
                }
                // What the effect's model moves and has no signature does not act at zero.
                for (index, name) in all.iter().enumerate().filter(|(_, name)| !own.contains(name))
                {
                    assert!(due[(index, index)].abs() < 1e-20, "{effect} in {campaign}: {name:?}");
                }
                compared += signatures.columns.len();
            }
        }
    }
    assert!(compared > 300, "{compared}");
}

#[test]
fn a_library_in_one_pass_gives_the_same_as_each_effect_alone() {
    let folder = planned::folder("library_pass");
    let path = folder.join("arm");
    let nominal = planned::problem(&path, &[]);
    let point = Point::stated(&nominal.layout);
    let problems = with_each_effect(&path);
    let candidates: Vec<Candidate<'_>> = problems
        .iter()
        .enumerate()
        .map(|(number, (_, with))| Candidate { number, system: &with.parts[0].system })
        .collect();
    let together = Signatures::new(&nominal, 0, &candidates);
    let all = nominal.gram_with(&together, &point);
    let mut column = 0;
    for candidate in &candidates {
        let alone = Signatures::new(&nominal, 0, &[*candidate]);
        let one = nominal.gram_with(&alone, &point);
        for (run, (one, all)) in one.iter().zip(&all).enumerate() {
            let nominal_columns = nominal.layout.columns.touched_by(run).len();
            for k in 0..alone.columns.len() {
                let (i, j) = (nominal_columns + k, nominal_columns + column + k);
                let (one, all) = (one.gram[(i, i)], all.gram[(j, j)]);
                assert!(
                    (one - all).abs() <= 1e-12 * one,
                    "{}: {one} {all}",
                    problems[candidate.number].0
                );
            }
        }
        column += alone.columns.len();
    }
    assert_eq!(column, together.columns.len());
    assert!(column > 80, "{column}");
}

/// Passes of some candidates, each with its constant (none is open here): what each sums by itself
/// is in the sums of all, pass after pass; with noise that readings share, and without.
#[test]
fn passes_sum_what_each_candidate_does_by_itself() {
    let folder = planned::folder("passes");
    let path = folder.join("arm");
    for shared in [false, true] {
        let mut nominal = planned::problem(&path, &[]);
        if !shared {
            nominal.parts[0].random_sigma.fill(0.0);
        }
        let point = Point::stated(&nominal.layout);
        nominal.refresh_weights(&point);
        let problems = with_each_effect(&path);
        let candidates: Vec<Candidate<'_>> = problems
            .iter()
            .enumerate()
            .map(|(number, (_, with))| Candidate { number, system: &with.parts[0].system })
            .collect();
        for among in [true, false] {
            let signatures = Arc::new(Signatures::open(&nominal, 0, &candidates, "", among));
            let due = nominal.gram_with(&signatures, &point);
            let owner = |column: usize| signatures.columns[column].candidate;
            for across in [false, true] {
                let passes = Passes::new(&nominal, Arc::clone(&signatures), &point, across);
                passes.sums(&[]);
                for (run, (found, due)) in passes.sums(&[]).iter().zip(&due).enumerate() {
                    let touched = nominal.layout.columns.touched_by(run).len();
                    let gram = &due.gram;
                    let last = gram.nrows() - 1;
                    for column in 0..signatures.columns.len() {
                        let here = touched + column;
                        let is_due = |found: f64, other: usize| {
                            let scale = (gram[(here, here)] * gram[(other, other)]).sqrt();
                            let due = gram[(here, other)];
                            assert!((found - due).abs() <= 1e-12 * scale, "{found} for {due}");
                        };
                        is_due(found.residual(column), last);
                        let sums = found.nominal(column);
                        assert_eq!(sums.len(), if among { touched } else { 0 });
                        sums.iter().enumerate().for_each(|(nominal, sum)| is_due(*sum, nominal));
                        let beside: Vec<usize> = (0..signatures.columns.len())
                            .filter(|other| across || owner(*other) == owner(column))
                            .collect();
                        for (other, sum) in beside.iter().zip(found.own(column)) {
                            is_due(*sum, touched + other);
                        }
                    }
                }
            }
        }
    }
}
