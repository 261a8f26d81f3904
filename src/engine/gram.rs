//! Gram sums: everything statistical is small linear algebra on sums over samples, kept by run.
//!
//! Unknowns come in blocks: global columns, columns of one setup, columns of one run. A reading
//! touches the global block, its setup's and its run's, so the normal matrix is a nested arrow:
//! runs hang on setups, setups hang on the global block.

use nalgebra::DMatrix;

/// How many unknowns each block has, and where its columns stand.
///
/// The order of columns: all global ones, then setup 0, 1, ..., then run 0, 1, ....
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Columns {
    /// Number of global unknowns.
    pub global: usize,
    /// Number of unknowns of each setup.
    pub setups: Vec<usize>,
    /// For each run its setup and its number of unknowns.
    pub runs: Vec<(usize, usize)>,
}

impl Columns {
    /// Number of all unknowns.
    pub fn len(&self) -> usize {
        self.global
            + self.setups.iter().sum::<usize>()
            + self.runs.iter().map(|(_, count)| count).sum::<usize>()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// First column of a setup.
    pub fn setup_start(&self, setup: usize) -> usize {
        self.global + self.setups[..setup].iter().sum::<usize>()
    }

    /// First column of a run.
    pub fn run_start(&self, run: usize) -> usize {
        self.global
            + self.setups.iter().sum::<usize>()
            + self.runs[..run].iter().map(|(_, count)| count).sum::<usize>()
    }

    /// Number of a run's own columns, the last that its readings touch.
    pub fn of_run(&self, run: usize) -> usize {
        self.runs[run].1
    }

    /// The columns a run's readings touch, in the order of its Gram matrix.
    pub fn touched_by(&self, run: usize) -> Vec<usize> {
        let (setup, count) = self.runs[run];
        let (s, r) = (self.setup_start(setup), self.run_start(run));
        (0..self.global).chain(s..s + self.setups[setup]).chain(r..r + count).collect()
    }
}

/// Sums of products of whitened Jacobian columns and the whitened residual over one run.
///
/// Square, symmetric (both triangles filled), of size `columns.touched_by(run).len() + 1`; the last
/// row and column belong to the residual `reading - prediction`.
#[derive(Clone, Debug, PartialEq)]
pub struct RunGram {
    /// The sums.
    pub gram: DMatrix<f64>,
    /// Number of readings in them.
    pub readings: usize,
}

impl RunGram {
    /// No reading yet; of this size.
    pub fn empty(size: usize) -> Self {
        Self { gram: DMatrix::zeros(size, size), readings: 0 }
    }

    /// Adds the sums over further samples of the run.
    pub fn add(&mut self, other: &Self) {
        self.gram += &other.gram;
        self.readings += other.readings;
    }
}

/// The sums of a part of a run's columns: those that some readings hang on.
#[derive(Clone, Debug, PartialEq)]
pub struct PartGram {
    /// The place of each column in the run's [`RunGram`], ascending; the residual is last.
    pub places: Vec<usize>,
    /// The sums.
    pub gram: DMatrix<f64>,
}

/// The sums of some runs as they grow: what comes first is kept as it is, so that a run of one
/// piece costs no matrix of zeros.
#[derive(Debug)]
pub struct Growing(Vec<Option<RunGram>>);

impl Growing {
    /// Of so many runs.
    pub fn new(runs: usize) -> Self {
        Self(vec![None; runs])
    }

    /// Adds the sums over further samples of a run.
    pub fn add(&mut self, run: usize, more: RunGram) {
        match &mut self.0[run] {
            Some(sums) => sums.add(&more),
            none => *none = Some(more),
        }
    }

    /// All of them, with the size of each.
    pub fn finish(self, sizes: impl Iterator<Item = usize>) -> Vec<RunGram> {
        let empty =
            |(sums, size): (Option<RunGram>, usize)| sums.unwrap_or_else(|| RunGram::empty(size));
        self.0.into_iter().zip(sizes).map(empty).collect()
    }
}

/// One whitened row of prior knowledge: `residual - Σ coefficient · step`, one to be squared. Its
/// columns all lie within the global block and at most one setup and one of its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorRow {
    /// Column and coefficient.
    pub coefficients: Vec<(usize, f64)>,
    /// (stated value - value) / standard uncertainty.
    pub residual: f64,
}

/// The linearised problem at a point: minimise |residual - J step|² over all runs and priors.
#[derive(Clone, Debug, PartialEq)]
pub struct Normal {
    /// The blocks.
    pub columns: Columns,
    /// One for each run of `columns`.
    pub runs: Vec<RunGram>,
    /// Prior knowledge.
    pub priors: Vec<PriorRow>,
}

impl Normal {
    /// Puts zeros into columns of the readings, as if no reading depended on these unknowns.
    pub fn zero_columns(&mut self, is_zero: impl Fn(usize) -> bool) {
        for (run, sums) in self.runs.iter_mut().enumerate() {
            let touched = self.columns.touched_by(run);
            for (at, _) in touched.iter().enumerate().filter(|(_, column)| is_zero(**column)) {
                sums.gram.row_mut(at).fill(0.0);
                sums.gram.column_mut(at).fill(0.0);
            }
        }
    }
}

/// The bounds of a step, or of a value, that has none.
pub const UNBOUNDED: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// A nonlinear least-squares problem over blocks of unknowns, on a manifold.
pub trait LeastSquares {
    /// The unknowns' values.
    type Point: Clone;

    /// The blocks of unknowns.
    fn columns(&self) -> &Columns;

    /// Hears that an iteration of a fit begins, from 1.
    fn begins(&mut self, _iteration: usize) {}

    /// Lets the weights (input errors, noise levels) follow a point; `cost` and `normal` use them
    /// until the next call.
    fn reweight(&mut self, point: &Self::Point);

    /// Whether the weights that `reweight` made hang on the point.
    fn weights_move(&self) -> bool;

    /// Sum of squares of all whitened residuals and priors; not finite where the model is
    /// undefined.
    fn cost(&self, point: &Self::Point) -> f64;

    /// The linearised problem at a point. The squares of its residuals add up to `cost`.
    fn normal(&self, point: &Self::Point) -> Normal;

    /// The point moved by a step in the tangent space.
    fn moved(&self, point: &Self::Point, step: &[f64]) -> Self::Point;

    /// Bounds on a step from `point`, column by column; none without.
    fn step_bounds(&self, _point: &Self::Point) -> Vec<(f64, f64)> {
        vec![UNBOUNDED; self.columns().len()]
    }
}
