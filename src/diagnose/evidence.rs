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
//!
//! | file | answers |
//! |---|---|
//! | `nominal` | what the nominal parameters can follow |
//! | `columns` | which column is which value of which candidate |
//! | `entry` | what a pass says of one candidate |
//! | `shared` | what candidates have in common with each other and with nominal parameters |
//! | [`mod@basis`] | directions in which columns differ beyond the nominal parameters |
//! | [`mod@scan`], `sampling` | which member of a family explains most, at which members it is looked for |

pub mod basis;
pub(super) mod columns;
mod entry;
pub(super) mod nominal;
pub(in crate::diagnose) mod sampling;
pub mod scan;
mod shared;

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::engine::gram::{Normal, RunGram};
use crate::engine::signatures::Signatures;
use crate::engine::{Point, Problem};

pub use self::columns::Owner;
use self::columns::join;
use self::columns::{Column, Owned};
pub use self::entry::{Entry, Projected};
use self::nominal::Nominal;
use super::library::candidate::Candidate;
use super::library::catalogue::sign;

/// Length, in units of the noise, that a column must have at the usual size of its value.
const NEGLIGIBLE: f64 = 1e-4;

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

impl Evidence {
    /// Sums the signatures of candidates at a point and projects them off the nominal parameters.
    /// `None` where the nominal parameters are not determined.
    pub fn new(
        problem: &Problem,
        normal: &Normal,
        point: &Point,
        candidates: &[&Candidate],
    ) -> Option<Self> {
        Self::with(problem, normal, point, candidates.len(), sign(problem, candidates))
    }

    /// The same of so many candidates whose signatures in each campaign are known.
    pub fn with(
        problem: &Problem,
        normal: &Normal,
        point: &Point,
        candidates: usize,
        signed: Arc<Vec<Signatures>>,
    ) -> Option<Self> {
        let (mut evidence, columns) = Self::summed(problem, normal, point, candidates, signed)?;
        evidence.enter(columns);
        Some(evidence)
    }

    /// All sums, and the columns of each candidate.
    fn summed(
        problem: &Problem,
        normal: &Normal,
        point: &Point,
        candidates: usize,
        signed: Arc<Vec<Signatures>>,
    ) -> Option<(Self, Vec<Owned>)> {
        let nominal = Nominal::of(normal)?;
        let mut runs = Vec::new();
        let mut touched = Vec::new();
        let mut columns: Vec<Vec<(Owner, Column)>> = vec![Vec::new(); candidates];
        for (part, signatures) in signed.iter().enumerate() {
            for (index, signature) in signatures.columns.iter().enumerate() {
                if let Some(own) =
                    signature.effect.parse().ok().and_then(|n: usize| columns.get_mut(n))
                {
                    join(problem, part, index, signature, own);
                }
            }
            let first = problem.layout.first_run[part];
            for (run, gram) in problem.gram_with(signatures, point).into_iter().enumerate() {
                touched.push(problem.layout.columns.touched_by(first + run));
                runs.push(gram);
            }
        }
        let runs = Arc::new(runs);
        let evidence = Self { entries: Vec::new(), runs, touched, nominal };
        Some((evidence, columns.into_iter().map(|own| own.into_iter().unzip()).collect()))
    }

    /// Whether a column changes readings at a size that can be: what does not even show at
    /// thousands of times its usual size is rounding, such as stamps that are uniform but for their
    /// last digit.
    fn shows(&self, column: &Column) -> bool {
        let one = std::slice::from_ref(column);
        let square = self.products(one, one)[(0, 0)];
        let shows = |usual: f64| square.is_nan() || usual * square.sqrt() >= NEGLIGIBLE;
        column.typical.is_none_or(shows)
    }

    fn enter(&mut self, columns: Vec<Owned>) {
        for (owners, columns) in columns {
            let own = owners.into_iter().zip(columns);
            let (owners, columns) = own.filter(|(_, column)| self.shows(column)).unzip();
            let entry = self.entry(owners, columns);
            self.entries.push(entry);
        }
    }

    /// Sums of products of two sets of columns.
    fn products(&self, left: &[Column], right: &[Column]) -> DMatrix<f64> {
        DMatrix::from_fn(left.len(), right.len(), |i, j| {
            let mut sum = 0.0;
            for (run, a, b) in left[i].beside(&right[j]) {
                let first = self.touched[run].len();
                sum += self.runs[run].gram[(first + a, first + b)];
            }
            sum
        })
    }

    /// Sums of products of the nominal columns with some others.
    fn across(&self, columns: &[Column]) -> DMatrix<f64> {
        let mut across = DMatrix::zeros(self.nominal.length.len(), columns.len());
        for (j, column) in columns.iter().enumerate() {
            for (run, index) in &column.at {
                let (gram, touched) = (&self.runs[*run].gram, &self.touched[*run]);
                for (place, nominal) in touched.iter().enumerate() {
                    across[(*nominal, j)] += gram[(place, touched.len() + index)];
                }
            }
        }
        across
    }

    fn entry(&self, owners: Vec<Owner>, columns: Vec<Column>) -> Entry {
        Entry::of(self.projected(owners, columns))
    }

    fn projected(&self, owners: Vec<Owner>, columns: Vec<Column>) -> Projected {
        let across = self.across(&columns);
        let mut score = DVector::zeros(columns.len());
        for (j, column) in columns.iter().enumerate() {
            for (run, index) in &column.at {
                let gram = &self.runs[*run].gram;
                score[j] += gram[(gram.nrows() - 1, self.touched[*run].len() + index)];
            }
        }
        let own = self.products(&columns, &columns);
        let raw = own.diagonal().map(|square| square.max(0.0).sqrt());
        let coupling = self.nominal.solve(&across);
        let left = &own - across.tr_mul(&coupling);
        let score = score - coupling.tr_mul(&self.nominal.score);
        Projected { owners, columns, left, score, raw, across, coupling }
    }
}
