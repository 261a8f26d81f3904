//! Evidence: what each candidate would explain beyond the nominal parameters, from one pass.
//!
//! With the whitened normal equations of nominal columns `n` (priors among them) and a candidate's
//! columns `e`: `S = H_ee - H_en H_nn⁻¹ H_ne` and the score `g = b_e - H_en H_nn⁻¹ b_n`. Without the
//! effect `gᵀ S⁻¹ g` is chi squared (Rao's score test); `λ² = gᵀ S⁻¹ g` less its degrees is the
//! squared length of the effect's signature that nominal parameters cannot follow. Columns are cut
//! where less than [`self::basis::RANK`] of their length is left; where nothing is left, the effect is absorbed.
//!
//! Values of scope setup and run have a column each; sums are kept by run, so nothing more is summed.
//!
//! | file | answers |
//! |---|---|
//! | `nominal` | what the nominal parameters can follow |
//! | `columns` | which column is which value of which candidate |
//! | `pieces` | the same with runs cut into pieces |
//! | [`mod@basis`] | what two sets of columns have in common |
//! | [`mod@scan`], `sampling` | which member of a family explains most, at which members it is looked for |
//! | [`score`], [`tail`] | how unlikely an explanation is by chance |
//! | [`thresholds`], [`detection`] | from where on it counts, and how often an effect gets there |

pub mod basis;
pub(super) mod columns;
pub mod detection;
pub(super) mod nominal;
pub(super) mod pieces;
pub(super) mod sampling;
pub mod scan;
pub mod score;
pub mod tail;
pub mod thresholds;

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::engine::gram::{Normal, RunGram};
use crate::engine::signatures::Signatures;
use crate::engine::stretches::Left;
use crate::engine::{Point, Problem};

use self::basis::{basis, beyond};
pub use self::columns::Owner;
use self::columns::join;
use self::columns::{Column, Owned};
use self::nominal::Nominal;
use super::library::candidates::Candidate;
use super::library::catalogue::sign;

/// Squared sine of the angle below which a direction is taken up by what it stands beside: tangents of
/// effects that are not quite linear differ by as much.
const NEARLY: f64 = 3e-4;
/// Length, in units of the noise, that a column must have at the usual size of its value.
const NEGLIGIBLE: f64 = 1e-4;

/// One pass over the readings.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// One for each candidate, in their order.
    pub entries: Vec<Entry>,
    /// The signatures in each campaign.
    signatures: Arc<Vec<Signatures>>,
    /// Sums of each run over all campaigns.
    runs: Arc<Vec<RunGram>>,
    /// The nominal columns of each run.
    touched: Vec<Vec<usize>>,
    nominal: Nominal,
}

/// A candidate's columns, the nominal parameters' part taken off, as they are.
#[derive(Clone, Debug)]
pub struct Projected {
    owners: Vec<Owner>,
    columns: Vec<Column>,
    /// `S`.
    pub left: DMatrix<f64>,
    /// `g`.
    pub score: DVector<f64>,
    raw: DVector<f64>,
    across: DMatrix<f64>,
    coupling: DMatrix<f64>,
}

impl Projected {
    /// Whose values its columns are.
    pub fn owners(&self) -> &[Owner] {
        &self.owners
    }

    /// The run in which each column acts, the first of several.
    pub fn runs(&self) -> impl Iterator<Item = usize> {
        self.columns.iter().map(|column| column.at.first().map_or(0, |(run, _)| *run))
    }
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

impl Entry {
    /// What is projected, with its basis.
    pub fn of(projected: Projected) -> Self {
        let Projected { owners, columns, left, score, raw, across, coupling } = projected;
        let k = columns.len();
        let finite = left.iter().chain(score.iter()).all(|value| value.is_finite());
        let (basis, lengths) = if finite && k > 0 {
            basis(&left, &raw)
        } else {
            (DMatrix::zeros(k, 0), DMatrix::zeros(0, k))
        };
        let score = basis.tr_mul(&score);
        Self { owners, columns, raw, basis, lengths, score, across, coupling, finite }
    }

    /// Directions that nominal parameters cannot follow.
    pub fn degrees(&self) -> usize {
        self.score.len()
    }

    /// What its best values take off the sum of squares.
    pub fn gain(&self) -> f64 {
        self.score.norm_squared()
    }

    /// Its best values, one a column.
    pub fn values(&self) -> DVector<f64> {
        &self.basis * &self.score
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

    /// The same; the last candidate is projected only, and has no entry.
    pub fn beside(
        problem: &Problem,
        normal: &Normal,
        point: &Point,
        candidates: &[&Candidate],
    ) -> Option<(Self, Projected)> {
        let signed = sign(problem, candidates);
        let (mut evidence, mut columns) =
            Self::summed(problem, normal, point, candidates.len(), signed)?;
        let (owners, last) = columns.pop()?;
        let last = evidence.projected(owners, last);
        evidence.enter(columns);
        Some((evidence, last))
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
        let evidence = Self { entries: Vec::new(), signatures: signed, runs, touched, nominal };
        Some((evidence, columns.into_iter().map(|own| own.into_iter().unzip()).collect()))
    }

    /// Whether a column changes readings at a size that can be: what does not even show at thousands of
    /// times its usual size is rounding, such as stamps that are uniform but for their last digit.
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

    /// Several candidates as one.
    pub fn together(&self, entries: &[&Entry]) -> Entry {
        let owners = entries.iter().flat_map(|one| one.owners.clone()).collect();
        let columns = entries.iter().flat_map(|one| one.columns.clone()).collect();
        self.entry(owners, columns)
    }

    /// The columns of a candidate that are wanted, those of a parameter in several runs as one: it
    /// has the same value in all of them. `wanted` sees whose value a column is, and its run.
    pub fn tied(&self, own: &Projected, wanted: impl Fn(&Owner, usize) -> bool) -> Entry {
        self.tied_of(&own.owners, &own.columns, |owner, column| {
            column.at.iter().copied().filter(|(run, _)| wanted(owner, *run)).collect()
        })
    }

    /// The same of an entry, in the runs that are wanted.
    pub fn tied_over(&self, own: &Entry, wanted: impl Fn(usize) -> bool) -> Entry {
        self.tied_of(&own.owners, &own.columns, |_, column| {
            column.at.iter().copied().filter(|(run, _)| wanted(*run)).collect()
        })
    }

    /// The same in ranges of runs.
    fn tied_within(&self, own: &Entry, wanted: &[Range<usize>]) -> Entry {
        self.tied_of(&own.owners, &own.columns, |_, column| column.within(wanted))
    }

    fn tied_of(
        &self,
        owners: &[Owner],
        columns: &[Column],
        wanted: impl Fn(&Owner, &Column) -> Vec<(usize, usize)>,
    ) -> Entry {
        let mut tied: Vec<(Owner, Column)> = Vec::new();
        for (owner, column) in owners.iter().zip(columns) {
            let at = wanted(owner, column);
            if at.is_empty() {
                continue;
            }
            let same = tied.iter_mut().find(|(known, _)| {
                (&known.parameter, known.component) == (&owner.parameter, owner.component)
            });
            match same {
                Some((_, known)) => known.at.extend(at),
                None => {
                    let owner = Owner { of: None, ..owner.clone() };
                    tied.push((owner, Column { at, typical: column.typical }));
                }
            }
        }
        tied.iter_mut().for_each(|(_, column)| column.at.sort_unstable());
        let (owners, columns) = tied.into_iter().unzip();
        self.entry(owners, columns)
    }

    /// What is left of the readings of each run, campaign after campaign, with an entry's best values
    /// and the nominal parameters that go with them; scores are summed over stretches of so many
    /// samples.
    pub fn left(
        &self,
        problem: &Problem,
        point: &Point,
        entry: &Entry,
        length: usize,
    ) -> Vec<Left> {
        self.left_by(problem, point, &self.steps(entry), length)
    }

    /// The same with a step for each run.
    fn left_by(
        &self,
        problem: &Problem,
        point: &Point,
        steps: &[Vec<f64>],
        length: usize,
    ) -> Vec<Left> {
        let parts = self.signatures.iter().enumerate();
        let of_part = |(part, signatures): (usize, &Signatures)| {
            let first = problem.run_index(part, 0);
            let steps = &steps[first..first + problem.parts[part].runs.len()];
            problem.left(signatures, point, steps, length)
        };
        parts.flat_map(of_part).collect()
    }

    /// For each run, or piece of one, an entry's best values and the nominal parameters that go with them, one for
    /// each column of its sums.
    fn steps(&self, entry: &Entry) -> Vec<Vec<f64>> {
        let (values, nominal) = (entry.values(), self.nominal_step(entry));
        let sums = self.runs.iter().zip(&self.touched);
        let nominal = |(sums, touched): (&RunGram, &Vec<usize>)| {
            let mut step: Vec<f64> = touched.iter().map(|column| nominal[*column]).collect();
            step.resize(sums.gram.nrows() - 1, 0.0);
            step
        };
        let mut steps: Vec<Vec<f64>> = sums.map(nominal).collect();
        for (column, value) in entry.columns.iter().zip(values.iter()) {
            for (run, index) in &column.at {
                steps[*run][self.touched[*run].len() + index] += value;
            }
        }
        steps
    }

    /// How much more an entry's score scatters from stretch to stretch than the noise model says: 1 if
    /// it is right. `left` is what a good model leaves of each run.
    pub fn inflation(&self, entry: &Entry, left: &[Left]) -> f64 {
        let mut sum = 0.0;
        for (run, left) in left.iter().enumerate() {
            let touched = &self.touched[run];
            // Places of this run's columns, once for all its stretches.
            let own: Vec<(usize, usize)> = entry
                .columns
                .iter()
                .enumerate()
                .filter_map(|(j, column)| {
                    let at = column.at.iter().find(|(other, _)| *other == run)?;
                    Some((j, touched.len() + at.1))
                })
                .collect();
            for score in &left.scores {
                let mut raw = DVector::zeros(entry.columns.len());
                for (j, at) in &own {
                    raw[*j] = score[*at];
                }
                for (place, column) in touched.iter().enumerate() {
                    for j in 0..raw.len() {
                        raw[j] -= entry.coupling[(*column, j)] * score[place];
                    }
                }
                sum += entry.basis.tr_mul(&raw).norm_squared();
            }
        }
        sum / entry.degrees().max(1) as f64
    }

    /// The step of the nominal parameters that goes with an entry's best values.
    fn nominal_step(&self, entry: &Entry) -> DVector<f64> {
        let score = &self.nominal.score;
        let score = DMatrix::from_column_slice(score.len(), 1, score.as_slice());
        self.nominal.solve(&score).column(0) - &entry.coupling * entry.values()
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

    /// `W_aᵀ S_ab`: what a candidate has in common with the columns of another one.
    pub fn shared(&self, a: &Entry, b: &Projected) -> DMatrix<f64> {
        self.shared_with(a, &b.columns, &b.across)
    }

    fn shared_with(&self, a: &Entry, columns: &[Column], across: &DMatrix<f64>) -> DMatrix<f64> {
        let own = self.products(&a.columns, columns);
        a.basis.tr_mul(&(own - a.coupling.tr_mul(across)))
    }

    /// `W_aᵀ S_ab W_b`: the cosines between what two candidates do beyond the nominal parameters.
    pub fn overlap(&self, a: &Entry, b: &Entry) -> DMatrix<f64> {
        self.shared_with(a, &b.columns, &b.across) * &b.basis
    }

    /// What `b` explains beyond the nominal parameters and `a`, with its degrees of freedom.
    pub fn beyond(&self, a: &Entry, b: &Entry) -> (f64, usize) {
        if a.degrees() == 0 || b.degrees() == 0 {
            return (b.gain(), b.degrees());
        }
        beyond(&self.overlap(a, b), &a.score, &b.score, NEARLY)
    }

    /// Part of an entry's gain that lies in prior rows: what its best values take off their squares.
    pub fn prior_share(&self, entry: &Entry) -> f64 {
        let own = entry.gain();
        if own <= 0.0 || self.nominal.priors.is_empty() {
            return 0.0;
        }
        let step = self.nominal_step(entry);
        let mut gain = 0.0;
        for row in &self.nominal.priors {
            let moved: f64 = row.coefficients.iter().map(|(column, by)| by * step[*column]).sum();
            gain += row.residual.powi(2) - (row.residual - moved).powi(2);
        }
        (gain / own).clamp(0.0, 1.0)
    }

    /// For each nominal column, how much of the length of an entry's first column it takes up.
    pub fn takers(&self, entry: &Entry) -> Vec<(usize, f64)> {
        let Some(column) = (0..entry.raw.len()).find(|k| entry.raw[*k] > 0.0) else {
            return Vec::new();
        };
        let mut takers: Vec<(usize, f64)> = (0..self.nominal.length.len())
            .map(|n| {
                let share = entry.coupling[(n, column)] * self.nominal.length[n];
                (n, (share / entry.raw[column]).abs())
            })
            .collect();
        takers.sort_by(|a, b| b.1.total_cmp(&a.1));
        takers
    }
}
