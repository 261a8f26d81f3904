//! Where the products of columns are kept: those of wide columns once, those of narrow ones by run.

use nalgebra::DMatrix;

use crate::engine::Problem;
use crate::engine::signatures::Signatures;

/// Where a column stands.
#[derive(Clone, Debug)]
pub(super) enum Placed {
    Wide(usize),
    /// Its number, and where it stands in the sums of which runs.
    Narrow(usize, Vec<(usize, usize)>),
}

/// Sums of products.
#[derive(Clone, Debug)]
pub(super) struct Store {
    /// Of wide columns, the residual last.
    pub(super) wide: DMatrix<f64>,
    /// Of narrow columns (one a column) with the wide ones and the residual.
    pub(super) strips: DMatrix<f64>,
    /// Of the narrow columns of each run.
    pub(super) runs: Vec<DMatrix<f64>>,
}

impl Store {
    pub(super) fn empty(wide: usize, narrow: usize, runs: &[usize]) -> Self {
        Self {
            wide: DMatrix::zeros(wide + 1, wide + 1),
            strips: DMatrix::zeros(wide + 1, narrow),
            runs: runs.iter().map(|size| DMatrix::zeros(*size, *size)).collect(),
        }
    }

    pub(super) fn add(&mut self, other: &Self, factor: f64) {
        let more = |sum: &mut DMatrix<f64>, other: &DMatrix<f64>| {
            sum.iter_mut().zip(other.iter()).for_each(|(sum, more)| *sum += factor * more);
        };
        more(&mut self.wide, &other.wide);
        more(&mut self.strips, &other.strips);
        self.runs.iter_mut().zip(&other.runs).for_each(|(sum, other)| more(sum, other));
    }
}

/// What a run's Gram matrix has in each place: the columns of all, and which of its own are narrow.
#[derive(Clone, Debug)]
pub(super) struct Local {
    pub(super) columns: Vec<usize>,
}

/// The columns that each run's Gram matrix has.
pub(super) fn locals(
    problem: &Problem,
    signed: &[Signatures],
    at: &[Vec<(usize, usize)>],
) -> Vec<Local> {
    let nominal = problem.layout.columns.len();
    let mut all: Vec<Local> = Vec::new();
    for (part, signatures) in signed.iter().enumerate() {
        for run in 0..problem.parts[part].runs.len() {
            let touched = problem.layout.columns.touched_by(problem.run_index(part, run));
            let mut columns = touched;
            columns.resize(columns.len() + signatures.columns.len(), usize::MAX);
            all.push(Local { columns });
        }
    }
    let first: Vec<usize> =
        (0..all.len()).map(|run| problem.layout.columns.touched_by(run).len()).collect();
    for (number, at) in at.iter().enumerate() {
        for (run, index) in at {
            all[*run].columns[first[*run] + index] = nominal + number;
        }
    }
    all
}

/// Wide and narrow columns, and where the narrow ones stand in each run.
pub(super) fn placed(problem: &Problem, at: &[Vec<(usize, usize)>], runs: usize) -> Vec<Placed> {
    let nominal = problem.layout.columns.len();
    let mut acts: Vec<Vec<usize>> = vec![Vec::new(); nominal];
    for run in 0..runs {
        for column in problem.layout.columns.touched_by(run) {
            acts[column].push(run);
        }
    }
    acts.extend(at.iter().map(|at| at.iter().map(|(run, _)| *run).collect()));
    let (mut wide, mut narrow) = (0, 0);
    let mut next = vec![0; runs];
    let place = |runs_of: &Vec<usize>| {
        if runs_of.len() * 2 > runs {
            wide += 1;
            return Placed::Wide(wide - 1);
        }
        narrow += 1;
        let mut own = Vec::with_capacity(runs_of.len());
        for run in runs_of {
            own.push((*run, next[*run]));
            next[*run] += 1;
        }
        own.sort_unstable();
        Placed::Narrow(narrow - 1, own)
    };
    acts.iter().map(place).collect()
}

/// Adds the Gram matrix of a run.
pub(super) fn add_run(
    store: &mut Store,
    gram: &DMatrix<f64>,
    run: usize,
    local: &Local,
    place: &[Placed],
) {
    let last = gram.nrows() - 1;
    let residual = store.wide.nrows() - 1;
    let (mut wide, mut narrow) = (vec![(last, residual)], Vec::new());
    for (here, column) in local.columns.iter().enumerate() {
        match place.get(*column) {
            Some(Placed::Wide(at)) => wide.push((here, *at)),
            Some(Placed::Narrow(number, at)) => {
                if let Ok(found) = at.binary_search_by_key(&run, |(run, _)| *run) {
                    narrow.push((here, *number, at[found].1));
                }
            }
            None => {}
        }
    }
    for (here, at) in &wide {
        let from = gram.column(*here);
        let mut to = store.wide.column_mut(*at);
        wide.iter().for_each(|(other, there)| to[*there] += from[*other]);
    }
    for (here, number, at) in &narrow {
        let from = gram.column(*here);
        let mut to = store.strips.column_mut(*number);
        wide.iter().for_each(|(other, there)| to[*there] += from[*other]);
        let mut own = store.runs[run].column_mut(*at);
        narrow.iter().for_each(|(other, _, there)| own[*there] += from[*other]);
    }
}
