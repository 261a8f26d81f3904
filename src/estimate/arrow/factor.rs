//! Elimination of the blocks of an [`Arrow`]: runs first, then setups, then the global block.

use nalgebra::{DMatrix, DVector};

use super::{Arrow, LinearError, setup_columns, shape};
use crate::estimate::cholesky;

/// Least share of a column (squared) that the others must leave unexplained, per unknown.
const PIVOT_FLOOR: f64 = 8.0 * f64::EPSILON;

impl Arrow {
    /// Factor of `H + diag(damping)`.
    ///
    /// # Errors
    /// [`LinearError::Singular`] with the first dependent column, [`LinearError::Shape`] if
    /// `damping` has another length than there are unknowns.
    pub fn factor(&self, damping: &DVector<f64>) -> Result<Factor, LinearError> {
        let n = self.columns.len();
        if damping.len() != n {
            return Err(shape(format!("{} damping terms", damping.len()), n.to_string()));
        }
        let damped = &self.diagonal + damping;
        if let Some(column) = (0..n).find(|&i| !(damped[i] > 0.0 && damped[i].is_finite())) {
            return Err(LinearError::Singular { column });
        }
        let scale = damped.map(|d| 1.0 / d.sqrt());
        let floor = PIVOT_FLOOR * n as f64;
        let scaled = |block: &DMatrix<f64>, touched: &[usize], from: usize| {
            let mut block = DMatrix::from_fn(touched.len(), touched.len(), |i, j| {
                scale[touched[i]] * block[(i, j)] * scale[touched[j]]
            });
            for i in from..touched.len() {
                block[(i, i)] += damping[touched[i]] * scale[touched[i]].powi(2);
            }
            block
        };
        let g = self.columns.global;
        let mut on_setups: Vec<_> = self
            .setups
            .iter()
            .enumerate()
            .map(|(s, block)| scaled(block, &setup_columns(&self.columns, s), g))
            .collect();
        let mut runs = Vec::with_capacity(self.runs.len());
        for (run, block) in self.runs.iter().enumerate() {
            let setup = self.columns.runs[run].0;
            let shared = g + self.columns.setups[setup];
            let block = scaled(block, &self.touched[run], shared);
            let eliminated = Eliminated::new(&block, &self.touched[run], shared, floor)?;
            on_setups[setup] += &eliminated.remainder;
            runs.push(eliminated);
        }
        let every: Vec<_> = (0..g).collect();
        let mut on_global = scaled(&self.global, &every, 0);
        let mut setups = Vec::with_capacity(on_setups.len());
        for (setup, block) in on_setups.iter().enumerate() {
            let touched = setup_columns(&self.columns, setup);
            let eliminated = Eliminated::new(block, &touched, g, floor)?;
            on_global += &eliminated.remainder;
            setups.push(eliminated);
        }
        let global = Eliminated::new(&on_global, &every, 0, floor)?;
        Ok(Factor { scale, order: runs.into_iter().chain(setups).chain([global]).collect() })
    }
}

/// A block after its own unknowns were eliminated onto those it shares.
#[derive(Clone, Debug)]
struct Eliminated {
    shared: Vec<usize>,
    own: Vec<usize>,
    /// Lower factor `L` of the own block.
    lower: DMatrix<f64>,
    /// `L⁻¹ C`, where `C` couples own (rows) to shared unknowns (columns).
    coupling: DMatrix<f64>,
    /// What remains on the shared unknowns.
    remainder: DMatrix<f64>,
}

impl Eliminated {
    fn new(
        block: &DMatrix<f64>,
        touched: &[usize],
        shared: usize,
        floor: f64,
    ) -> Result<Self, LinearError> {
        let own = touched.len() - shared;
        let lower = cholesky::factor(block.view((shared, shared), (own, own)).into_owned(), floor)
            .map_err(|at| LinearError::Singular { column: touched[shared + at] })?;
        let mut coupling = block.view((shared, 0), (own, shared)).into_owned();
        cholesky::forward(&lower, &mut coupling);
        let remainder = block.view((0, 0), (shared, shared)) - coupling.tr_mul(&coupling);
        Ok(Self {
            shared: touched[..shared].to_vec(),
            own: touched[shared..].to_vec(),
            lower,
            coupling,
            remainder,
        })
    }
}

/// Factor of a damped arrow; solves for any right-hand side.
#[derive(Clone, Debug)]
pub struct Factor {
    scale: DVector<f64>,
    /// Runs, then setups, then the global block.
    order: Vec<Eliminated>,
}

impl Factor {
    /// `(H + diag(damping))⁻¹ right`; `right` has one entry for each unknown.
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let mut x = right.component_mul(&self.scale);
        for block in &self.order {
            // y = L⁻¹ own, and what it leaves on the shared unknowns.
            for j in 0..block.own.len() {
                let mut value = x[block.own[j]];
                for i in 0..j {
                    value -= block.lower[(j, i)] * x[block.own[i]];
                }
                let value = value / block.lower[(j, j)];
                x[block.own[j]] = value;
                for (i, &shared) in block.shared.iter().enumerate() {
                    x[shared] -= block.coupling[(j, i)] * value;
                }
            }
        }
        for block in self.order.iter().rev() {
            for j in (0..block.own.len()).rev() {
                let mut value = x[block.own[j]];
                for (i, &shared) in block.shared.iter().enumerate() {
                    value -= block.coupling[(j, i)] * x[shared];
                }
                for i in j + 1..block.own.len() {
                    value -= block.lower[(i, j)] * x[block.own[i]];
                }
                x[block.own[j]] = value / block.lower[(j, j)];
            }
        }
        x.component_mul(&self.scale)
    }
}
