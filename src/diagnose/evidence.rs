//! Evidence: what each candidate would explain beyond the nominal parameters, from one pass.
//!
//! With the whitened normal equations of nominal columns `n` (priors among them) and a candidate's
//! columns `e`: `S = H_ee - H_en H_nn⁻¹ H_ne` and the score `g = b_e - H_en H_nn⁻¹ b_n`. Without
//! the effect `gᵀ S⁻¹ g` is chi squared (Rao's score test); `λ² = gᵀ S⁻¹ g` less its degrees is the
//! squared length of the effect's signature that nominal parameters cannot follow. Columns are cut
//! where less than [`self::basis::RANK`] of their length is left; where nothing is left, the effect
//! is absorbed.
//!
//! Values of scope setup and run have a column each; sums are kept by run, so nothing more is
//! summed.

pub mod basis;
pub(super) mod columns;
pub mod members;
pub(in crate::diagnose) mod sampling;
pub mod scan;

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::engine::gram::{Normal, RunGram};
use crate::engine::signatures::Signatures;
use crate::engine::{Point, Problem};
use crate::estimate::arrow::normal_matrix;
use crate::estimate::inverse_factor::Factor;

use self::basis::basis;
pub use self::columns::Owner;
use self::columns::{Column, joined, shared, shows};
use super::library::candidate::Candidate;
use super::library::catalogue::sign;
use super::price::Gain;

/// One pass over the readings.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// One for each candidate, in their order.
    pub entries: Vec<Entry>,
    /// Sums of each run over all campaigns.
    runs: Arc<Vec<RunGram>>,
    /// The nominal columns of each run.
    touched: Vec<Vec<usize>>,
    nominal: Nominal,
}

/// What a pass says of one candidate.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Whose values its columns are.
    pub owners: Vec<Owner>,
    columns: Vec<Column>,
    /// Length of each column before anything is taken off it.
    pub raw: DVector<f64>,
    /// `W` with `Wᵀ S W = 1`: a column for each degree of freedom.
    pub basis: DMatrix<f64>,
    /// `V` with `V W = 1` and `S = Vᵀ V`: from values to lengths in units of the noise.
    pub lengths: DMatrix<f64>,
    /// `Wᵀ g`.
    pub score: DVector<f64>,
    /// `H_ne`.
    across: DMatrix<f64>,
    /// `H_nn⁻¹ H_ne`.
    pub coupling: DMatrix<f64>,
    /// Whether every number is finite.
    pub finite: bool,
}

/// The nominal normal equations, factored: what is taken off everything that a candidate does. The
/// columns of effects that are in the fit are among them; directions that the readings do not
/// determine stay where they are, and take nothing off a candidate.
#[derive(Clone, Debug)]
struct Nominal {
    factor: Factor,
    /// What the readings say of each column.
    score: DVector<f64>,
}

impl Nominal {
    /// Those of a linearised problem; `None` where they hold what is no number.
    fn of(normal: &Normal) -> Option<Self> {
        let (hessian, score) = normal_matrix(normal).ok()?;
        let is_sound = hessian.iter().all(|value| value.is_finite());
        is_sound.then(|| Self { factor: Factor::of(&hessian), score })
    }
}

impl Entry {
    /// Directions that nominal parameters cannot follow.
    pub fn degrees(&self) -> usize {
        self.score.len()
    }

    /// What its best values take off the sum of squares.
    pub fn gain(&self) -> Gain {
        Gain { gain: self.score.norm_squared(), degrees: self.degrees() }
    }

    /// Whether it changes readings at all.
    pub fn acts(&self) -> bool {
        self.raw.iter().any(|length| *length > 0.0)
    }
}

impl Evidence {
    /// Sums the signatures of candidates at a point and projects them off the nominal parameters.
    /// `None` where the nominal parameters are not determined.
    pub fn new(
        problem: &Problem,
        normal: &Normal,
        point: &Point,
        candidates: &[&Candidate],
    ) -> Option<Self> {
        Self::with(problem, normal, point, candidates.len(), &sign(problem, candidates))
    }

    /// The same of so many candidates whose signatures in each campaign are known.
    pub fn with(
        problem: &Problem,
        normal: &Normal,
        point: &Point,
        candidates: usize,
        signed: &[Signatures],
    ) -> Option<Self> {
        let nominal = Nominal::of(normal)?;
        let of = |signatures: &Signatures| problem.gram_with(signatures, point);
        let runs: Vec<RunGram> = signed.iter().flat_map(of).collect();
        let touched = (0..runs.len()).map(|run| problem.layout.columns.touched_by(run)).collect();
        let evidence = Self { entries: Vec::new(), runs: Arc::new(runs), touched, nominal };
        let entries = joined(problem, signed, candidates).into_iter().map(|mut own| {
            own.retain(|_, column| {
                let one = std::slice::from_ref(column);
                shows(evidence.products(one, one)[(0, 0)], column.typical)
            });
            let (owners, columns) = own.into_iter().unzip();
            evidence.entry(owners, columns)
        });
        let entries = entries.collect();
        Some(Self { entries, ..evidence })
    }

    /// Sums of products of two sets of columns.
    fn products(&self, left: &[Column], right: &[Column]) -> DMatrix<f64> {
        DMatrix::from_fn(left.len(), right.len(), |i, j| {
            let mut sum = 0.0;
            for (run, a, b) in shared(&left[i].at, &right[j].at) {
                let first = self.touched[run].len();
                sum += self.runs[run].gram[(first + a, first + b)];
            }
            sum
        })
    }

    /// What the pass says of a candidate with these columns.
    fn entry(&self, owners: Vec<Owner>, columns: Vec<Column>) -> Entry {
        let k = columns.len();
        let mut across = DMatrix::zeros(self.nominal.score.len(), k);
        let mut score = DVector::zeros(k);
        for (j, column) in columns.iter().enumerate() {
            for (run, index) in &column.at {
                let (gram, touched) = (&self.runs[*run].gram, &self.touched[*run]);
                let own = touched.len() + index;
                for (place, nominal) in touched.iter().enumerate() {
                    across[(*nominal, j)] += gram[(place, own)];
                }
                score[j] += gram[(gram.nrows() - 1, own)];
            }
        }
        let own = self.products(&columns, &columns);
        let raw = own.diagonal().map(|square| square.max(0.0).sqrt());
        let coupling = self.nominal.factor.solve(&across);
        let left = own - across.tr_mul(&coupling);
        let score = score - coupling.tr_mul(&self.nominal.score);
        let finite = left.iter().chain(score.iter()).all(|value| value.is_finite());
        let (basis, lengths) = if finite && k > 0 {
            basis(&left, &raw)
        } else {
            (DMatrix::zeros(k, 0), DMatrix::zeros(0, k))
        };
        let score = basis.tr_mul(&score);
        Entry { owners, columns, raw, basis, lengths, score, across, coupling, finite }
    }

    /// `W_aᵀ S_ab W_b`: the cosines between what two candidates do beyond the nominal parameters.
    pub fn overlap(&self, a: &Entry, b: &Entry) -> DMatrix<f64> {
        let own = self.products(&a.columns, &b.columns);
        a.basis.tr_mul(&(own - a.coupling.tr_mul(&b.across))) * &b.basis
    }

    /// For each nominal column, how much of the length of an entry's first column it absorbs.
    pub fn takers(&self, entry: &Entry) -> Vec<(usize, f64)> {
        let Some(column) = (0..entry.raw.len()).find(|k| entry.raw[*k] > 0.0) else {
            return Vec::new();
        };
        let share = |n: usize| {
            let taken = entry.coupling[(n, column)] * self.nominal.factor.length[n];
            (n, (taken / entry.raw[column]).abs())
        };
        let mut takers: Vec<(usize, f64)> = (0..self.nominal.score.len()).map(share).collect();
        takers.sort_by(|a, b| b.1.total_cmp(&a.1));
        takers
    }
}
