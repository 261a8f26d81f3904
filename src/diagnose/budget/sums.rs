//! Gram sums of all columns of a linearised model, by measurand: one pass over the readings, all
//! that follows is algebra on them.
//!
//! Columns: the nominal parameters, then those of every candidate with one column for each value of
//! a parameter. A column that acts in all runs is *wide*, one of a setup or of a run is *narrow*.
//! Products of wide columns are summed over all runs, those of a narrow column with the wide ones
//! too; products of two narrow columns are kept run by run. So memory grows with the number of runs
//! and not with its square. Sums of a measurand have only the columns that change its readings.
//!
//! It does not say which columns explain anything.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use crate::diagnose::evidence::Owner;
use crate::diagnose::evidence::columns::joined;
use crate::engine::gram::PriorRow;
use crate::engine::signatures::Signatures;
use crate::engine::{Point, Problem};

pub use self::store::Index;
use self::store::{Placed, Store, columns_of_runs, placed};

mod store;
mod weighted;

pub use self::weighted::Weighted;

/// The sums of a linearised model.
#[derive(Clone, Debug)]
pub struct Sums {
    /// Whose value each column of a candidate is, after the nominal ones.
    pub owners: Vec<Owner>,
    /// For each candidate its columns.
    pub of_candidate: Vec<Vec<usize>>,
    /// Typical magnitude of the value of each column, where it is declared.
    pub typical: Vec<Option<f64>>,
    /// Number of nominal columns.
    pub nominal: usize,
    /// Number of readings of each measurand of each campaign, a rotation counting as three.
    pub readings: Vec<usize>,
    /// The first measurand of each campaign.
    pub first_measurand: Vec<usize>,
    /// Prior knowledge of nominal parameters.
    pub priors: Vec<PriorRow>,
    place: Vec<Placed>,
    /// Number of wide columns, the residual among them.
    wide: usize,
    by_measurand: Vec<Store>,
    /// For each column the measurands whose readings it changes; all of them.
    acts_in: Vec<Vec<usize>>,
    all: Vec<usize>,
    /// What the noise of smoothed streams adds to the products with the residual, by measurand and
    /// column; empty where there is none.
    of_streams: Vec<Vec<f64>>,
    /// The columns of each run's Gram matrix.
    of_runs: Arc<Vec<Vec<usize>>>,
}

/// Products of one more column with the others.
#[derive(Clone, Debug, Default)]
pub struct Appended {
    /// By run and measurand: with the columns of the run's Gram matrix, the residual last, and with
    /// itself.
    of_runs: BTreeMap<(usize, usize), (Vec<f64>, f64)>,
    /// By measurand: with columns that were appended before.
    others: Vec<(usize, usize, f64)>,
}

impl Appended {
    /// Adds a whitened row of a run in which the column has the value `x`.
    pub fn add(&mut self, at: (usize, usize), x: f64, row: &[f64]) {
        let (sums, square) = self.of_runs.entry(at).or_insert_with(|| (vec![0.0; row.len()], 0.0));
        sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += x * value);
        *square += x * x;
    }

    /// Adds a product with a column that was appended before.
    pub fn add_to(&mut self, measurand: usize, column: usize, product: f64) {
        let known = self.others.iter_mut().find(|one| (one.0, one.1) == (measurand, column));
        match known {
            Some(known) => known.2 += product,
            None => self.others.push((measurand, column, product)),
        }
    }
}

impl Sums {
    /// Typical magnitude of the value of a column of a candidate, where it is declared.
    pub fn typical_of(&self, column: usize) -> Option<f64> {
        column.checked_sub(self.nominal).and_then(|own| *self.typical.get(own)?)
    }

    /// Sums the signatures of so many candidates at a point.
    pub fn new(
        problem: &Problem,
        point: &Point,
        signed: &Arc<Vec<Signatures>>,
        candidates: usize,
        priors: Vec<PriorRow>,
    ) -> Self {
        let nominal = problem.layout.columns.len();
        let (mut owners, mut of_candidate, mut typical) = (Vec::new(), Vec::new(), Vec::new());
        let mut at: Vec<Vec<(usize, usize)>> = Vec::new();
        for own in joined(problem, signed, candidates) {
            let first = nominal + owners.len();
            of_candidate.push((first..first + own.len()).collect());
            for (owner, column) in own {
                owners.push(owner);
                typical.push(column.typical);
                at.push(column.at);
            }
        }
        let of_runs = columns_of_runs(problem, signed, &at);
        let (place, wide) = placed(problem, &at, of_runs.len());
        let mut first_measurand = Vec::new();
        let mut by_measurand: Vec<Store> = Vec::new();
        let mut readings = Vec::new();
        for (part, signatures) in signed.iter().enumerate() {
            let first = by_measurand.len();
            first_measurand.push(first);
            let slots = problem.parts[part].slots().len();
            by_measurand.extend((0..slots).map(|_| Store::empty(of_runs.len())));
            readings.extend(problem.parts[part].components_present());
            let first_run = problem.layout.first_run[part];
            problem.grams_by_measurand(signatures, point, |run, grams| {
                let run = first_run + run;
                let own = by_measurand[first..].par_iter_mut().zip(grams);
                own.for_each(|(store, gram)| store.add_run(&gram, run, &of_runs[run], &place));
            });
        }
        let acts_in = place.iter().map(|one| Self::acts_in(&by_measurand, one)).collect();
        Self {
            owners,
            of_candidate,
            typical,
            nominal,
            readings,
            first_measurand,
            priors,
            place,
            wide,
            all: (0..by_measurand.len()).collect(),
            acts_in,
            by_measurand,
            of_streams: Vec::new(),
            of_runs: Arc::new(of_runs),
        }
    }

    /// Finds what the noise of smoothed streams adds to the products with the residual, from sums
    /// over streams with as much noise again: a column that has the noise of the same stream as the
    /// residual is correlated with it, and would explain it. (Errors in variables: simulation and
    /// linear extrapolation, Cook and Stefanski 1994.)
    pub fn compare_with_noisier_streams(&mut self, noisier: &[Self]) {
        let added = |measurand: usize, column: usize| {
            let product = |sums: &Self| sums.product_in(measurand, column, sums.residual());
            let mean = noisier.iter().map(product).sum::<f64>() / noisier.len() as f64;
            mean - product(self)
        };
        let columns =
            |measurand| (0..self.residual()).map(|column| added(measurand, column)).collect();
        self.of_streams = (0..self.by_measurand.len()).map(columns).collect();
    }

    /// What the noise of smoothed streams adds to the product of each column with the residual, for
    /// these weights of the measurands; `None` where no stream is smoothed.
    pub fn scores_of_streams(&self, weights: &[f64]) -> Option<Vec<f64>> {
        let all = || self.of_streams.iter().zip(weights);
        let of = |column: usize| all().filter_map(|(own, by)| Some(by * own.get(column)?)).sum();
        (!self.of_streams.is_empty()).then(|| (0..self.residual()).map(of).collect())
    }

    /// Appends a column; its number.
    pub fn append(&mut self, added: &Appended) -> usize {
        let number = self.wide;
        for ((run, measurand), (sums, square)) in &added.of_runs {
            // Columns of no candidate have no place, and no product.
            let placed = self.of_runs[*run].iter().zip(sums);
            let others = placed
                .filter_map(|(column, sum)| Some((Some(self.place.get(*column)?), *sum)))
                .chain(sums.last().map(|sum| (None, *sum)));
            self.by_measurand[*measurand].add_wide(number, *square, others);
        }
        for (measurand, column, product) in &added.others {
            let others = std::iter::once((self.place.get(*column), *product));
            self.by_measurand[*measurand].add_wide(number, 0.0, others);
        }
        self.wide += 1;
        let place = Placed::Wide(number);
        self.acts_in.push(Self::acts_in(&self.by_measurand, &place));
        self.place.push(place);
        self.place.len() - 1
    }

    /// Number of columns without the residual, which is the number of the residual's.
    pub fn residual(&self) -> usize {
        self.place.len()
    }

    /// The column at a place of a run's Gram matrix: those that the run touches, then those of the
    /// candidates' signatures.
    pub fn column_at(&self, run: usize, place: usize) -> Option<usize> {
        self.of_runs[run].get(place).copied().filter(|column| *column != usize::MAX)
    }

    /// The measurands in which two columns may have a product: those of the one that acts in fewer.
    #[inline]
    fn measurands_of(&self, a: usize, b: usize) -> &[usize] {
        match (self.acts_in.get(a), self.acts_in.get(b)) {
            (Some(a), Some(b)) => {
                if a.len() < b.len() {
                    a
                } else {
                    b
                }
            }
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => &self.all,
        }
    }

    /// The measurands whose readings a column changes.
    fn acts_in(by_measurand: &[Store], place: &Placed) -> Vec<usize> {
        (0..by_measurand.len()).filter(|own| by_measurand[*own].has(place)).collect()
    }

    /// The product of two columns in the sums of one measurand; the column after the last is the
    /// residual.
    #[inline]
    pub fn product_in(&self, measurand: usize, a: usize, b: usize) -> f64 {
        self.by_measurand[measurand].product(self.place.get(a), self.place.get(b))
    }
}
