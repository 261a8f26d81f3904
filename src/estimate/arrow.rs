//! The nested arrow: solves the normal equations block by block.
//!
//! A run's unknowns meet only its setup's and the global ones, a setup's only the global ones. So
//! runs are eliminated onto their setup and the global block, setups onto the global block, and
//! each step is a Cholesky factor of a small block (Schur complements; Triggs et al. 2000, section
//! 6). Columns are scaled to unit length inside, and the scale is undone in every result.
//!
//! [`normal_matrix`] is the second route to the same numbers: the dense matrix. Covariance is that
//! of the problem at its point: no damping, no scale, unit noise (residuals were whitened once).
//! This room does not iterate, know bounds, or say what a dependent column means.

use nalgebra::{DMatrix, DVector};

use crate::engine::gram::{Columns, Normal};

mod factor;

pub use factor::Factor;

/// Why a linear problem has no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinearError {
    /// A column has no effect, or depends on the others to rounding.
    #[error("unknown number {column} cannot be told from the others by these readings")]
    Singular {
        /// The first such column.
        column: usize,
    },
    /// Sums and blocks do not fit together.
    #[error("the sums do not fit the blocks of unknowns: {found}, expected {expected}")]
    Shape {
        /// What was found.
        found: String,
        /// What was expected.
        expected: String,
    },
}

fn shape(found: String, expected: String) -> LinearError {
    LinearError::Shape { found, expected }
}

/// The blocks of a [`Normal`], each a sum over the readings and priors that belong to it.
#[derive(Clone, Debug)]
pub struct Arrow {
    columns: Columns,
    /// Global × global, with the priors that touch nothing else.
    global: DMatrix<f64>,
    /// For each setup (global + setup)², without its runs.
    setups: Vec<DMatrix<f64>>,
    /// For each run (global + setup + run)².
    runs: Vec<DMatrix<f64>>,
    /// For each run the columns of its block.
    touched: Vec<Vec<usize>>,
    gradient: DVector<f64>,
    diagonal: DVector<f64>,
}

/// The columns of a setup's block.
fn setup_columns(columns: &Columns, setup: usize) -> Vec<usize> {
    let start = columns.setup_start(setup);
    (0..columns.global).chain(start..start + columns.setups[setup]).collect()
}

/// The smallest block that holds all columns of a prior row.
enum Home {
    Global,
    Setup(usize),
    Run(usize),
}

fn home(columns: &Columns, row: &[(usize, f64)]) -> Result<Home, LinearError> {
    let misplaced = || {
        shape(
            format!("a prior row over unknowns {:?}", row.iter().map(|c| c.0).collect::<Vec<_>>()),
            "unknowns of the global block, one setup and one of its runs".to_owned(),
        )
    };
    let all_in =
        |allowed: &[usize]| row.iter().all(|(column, _)| allowed.binary_search(column).is_ok());
    let Some(last) = row.iter().map(|c| c.0).max() else {
        return Ok(Home::Global);
    };
    let candidate = if last < columns.global {
        return Ok(Home::Global);
    } else if let Some(setup) = (0..columns.setups.len()).find(|&s| {
        (columns.setup_start(s)..columns.setup_start(s) + columns.setups[s]).contains(&last)
    }) {
        (Home::Setup(setup), setup_columns(columns, setup))
    } else if let Some(run) = (0..columns.runs.len())
        .find(|&r| (columns.run_start(r)..columns.run_start(r) + columns.runs[r].1).contains(&last))
    {
        (Home::Run(run), columns.touched_by(run))
    } else {
        return Err(misplaced());
    };
    if all_in(&candidate.1) { Ok(candidate.0) } else { Err(misplaced()) }
}

/// Adds the outer product of a row to a block whose columns are `touched` (ascending).
fn add_row(block: &mut DMatrix<f64>, touched: &[usize], row: &[(usize, f64)]) {
    for (a, x) in row {
        for (b, y) in row {
            if let (Ok(i), Ok(j)) = (touched.binary_search(a), touched.binary_search(b)) {
                block[(i, j)] += x * y;
            }
        }
    }
}

impl Arrow {
    /// Sorts sums and priors into blocks.
    ///
    /// # Errors
    /// [`LinearError::Shape`] if a Gram matrix has another size than its block, a run names a setup
    /// that does not exist, or a prior row spans several setups or runs.
    pub fn assemble(normal: &Normal) -> Result<Self, LinearError> {
        let columns = normal.columns.clone();
        if normal.runs.len() != columns.runs.len() {
            return Err(shape(
                format!("sums of {} runs", normal.runs.len()),
                format!("{}", columns.runs.len()),
            ));
        }
        let mut gradient = DVector::zeros(columns.len());
        let mut runs = Vec::with_capacity(columns.runs.len());
        let mut touched = Vec::with_capacity(columns.runs.len());
        for (run, sums) in normal.runs.iter().enumerate() {
            let setup = columns.runs[run].0;
            if setup >= columns.setups.len() {
                return Err(shape(
                    format!("run {run} of setup {setup}"),
                    format!("a setup below {}", columns.setups.len()),
                ));
            }
            let indices = columns.touched_by(run);
            let n = indices.len();
            if sums.gram.shape() != (n + 1, n + 1) {
                return Err(shape(
                    format!("a {:?} Gram matrix of run {run}", sums.gram.shape()),
                    format!("{:?}", (n + 1, n + 1)),
                ));
            }
            for (i, &column) in indices.iter().enumerate() {
                gradient[column] += sums.gram[(i, n)];
            }
            runs.push(sums.gram.view((0, 0), (n, n)).into_owned());
            touched.push(indices);
        }
        let mut global = DMatrix::zeros(columns.global, columns.global);
        let mut setups: Vec<_> = columns
            .setups
            .iter()
            .map(|count| DMatrix::zeros(columns.global + count, columns.global + count))
            .collect();
        for prior in &normal.priors {
            let row = &prior.coefficients;
            match home(&columns, row)? {
                Home::Global => {
                    add_row(&mut global, &(0..columns.global).collect::<Vec<_>>(), row);
                }
                Home::Setup(s) => add_row(&mut setups[s], &setup_columns(&columns, s), row),
                Home::Run(r) => add_row(&mut runs[r], &touched[r], row),
            }
            for (column, coefficient) in row {
                gradient[*column] += coefficient * prior.residual;
            }
        }
        let mut arrow = Self {
            diagonal: DVector::zeros(columns.len()),
            columns,
            global,
            setups,
            runs,
            touched,
            gradient,
        };
        let mut diagonal = arrow.diagonal.clone();
        arrow.each_block(|block, indices| {
            for (i, &column) in indices.iter().enumerate() {
                diagonal[column] += block[(i, i)];
            }
        });
        arrow.diagonal = diagonal;
        Ok(arrow)
    }

    /// Calls `visit` with every block and its columns.
    fn each_block(&self, mut visit: impl FnMut(&DMatrix<f64>, &[usize])) {
        visit(&self.global, &(0..self.columns.global).collect::<Vec<_>>());
        for (setup, block) in self.setups.iter().enumerate() {
            visit(block, &setup_columns(&self.columns, setup));
        }
        for (block, touched) in self.runs.iter().zip(&self.touched) {
            visit(block, touched);
        }
    }

    /// `g = Jᵀ residual`: minus half the gradient of the cost.
    pub fn gradient(&self) -> &DVector<f64> {
        &self.gradient
    }

    /// Diagonal of `H = JᵀJ`: squared lengths of the whitened columns.
    pub fn diagonal(&self) -> &DVector<f64> {
        &self.diagonal
    }

    /// `|J step|²`, the squared length of a step in units of the noise.
    pub fn squared_length(&self, step: &DVector<f64>) -> f64 {
        let mut sum = 0.0;
        self.each_block(|block, touched| {
            let local = DVector::from_iterator(touched.len(), touched.iter().map(|&c| step[c]));
            sum += local.dot(&(block * &local));
        });
        sum.max(0.0)
    }

    /// `H` as one dense matrix.
    pub fn dense(&self) -> DMatrix<f64> {
        let n = self.columns.len();
        let mut matrix = DMatrix::zeros(n, n);
        self.each_block(|block, touched| {
            for (j, &b) in touched.iter().enumerate() {
                for (i, &a) in touched.iter().enumerate() {
                    matrix[(a, b)] += block[(i, j)];
                }
            }
        });
        matrix
    }

    /// The step that solves `(H + diag(damping)) step = g`.
    ///
    /// # Errors
    /// [`LinearError::Singular`] with the first dependent column.
    pub fn solve(&self, damping: &DVector<f64>) -> Result<DVector<f64>, LinearError> {
        Ok(self.factor(damping)?.solve(&self.gradient))
    }
}

/// Sum of squares at the point itself: what a zero step leaves.
pub fn cost(normal: &Normal) -> f64 {
    let last = |m: &DMatrix<f64>| m.nrows().checked_sub(1).map_or(0.0, |i| m[(i, i)]);
    normal.runs.iter().map(|run| last(&run.gram)).sum::<f64>()
        + normal.priors.iter().map(|prior| prior.residual.powi(2)).sum::<f64>()
}

/// `H = JᵀJ` and `g = Jᵀ residual` of the whole problem, dense; priors included.
///
/// # Errors
/// [`LinearError::Shape`], as [`Arrow::assemble`].
pub fn normal_matrix(normal: &Normal) -> Result<(DMatrix<f64>, DVector<f64>), LinearError> {
    let arrow = Arrow::assemble(normal)?;
    Ok((arrow.dense(), arrow.gradient))
}

/// Covariance `H⁻¹` of all unknowns (n × n, own units) for unit noise, priors included, undamped.
///
/// # Errors
/// [`LinearError::Singular`] if an unknown is not determined to rounding: the caller removes or
/// fixes such directions (see `observability`), the inverse is not faked.
pub fn covariance(normal: &Normal) -> Result<DMatrix<f64>, LinearError> {
    let arrow = Arrow::assemble(normal)?;
    let n = arrow.columns.len();
    let factor = arrow.factor(&DVector::zeros(n))?;
    let mut inverse = DMatrix::zeros(n, n);
    let mut unit = DVector::zeros(n);
    for j in 0..n {
        unit[j] = 1.0;
        inverse.set_column(j, &factor.solve(&unit));
        unit[j] = 0.0;
    }
    Ok((&inverse + inverse.transpose()) * 0.5)
}
