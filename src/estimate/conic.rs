//! Bounded steps: minimise `½ xᵀ H x - gᵀ x` with `lower ≤ x ≤ upper`.
//!
//! An interior-point solver (Clarabel) finds which bounds hold the step. Its tolerance is on
//! residuals, so unknowns are first scaled to unit length of their column (unit sigma); the held
//! unknowns are then put exactly on their bounds and the others solved for by Cholesky, until the
//! signs of all multipliers and all bounds agree (primal-dual active set). Works on the normal
//! matrix: its cost does not depend on the number of readings.
//!
//! It does not choose damping; the caller adds it to `H`.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus,
};
use nalgebra::{DMatrix, DVector};

use crate::engine::gram::UNBOUNDED;

use super::cholesky;

/// A bound counts as missed by an unknown beyond this part of its scaled size.
const SLACK: f64 = 1e-12;

/// Which bound holds an unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// None: the unknown is free.
    Free,
    /// The lower one.
    Lower,
    /// The upper one.
    Upper,
}

/// The minimiser within bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundedStep {
    /// The step, one entry for each unknown.
    pub step: DVector<f64>,
    /// What holds each unknown.
    pub held: Vec<Held>,
    /// Whether the step is exact (active set solved by Cholesky); else it has the interior-point
    /// solver's accuracy (about 1e-8 of a sigma).
    pub polished: bool,
}

/// Why there is no bounded step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BoundedError {
    /// Bounds that exclude each other.
    #[error("unknown number {column}: its lower bound {lower} lies above its upper bound {upper}")]
    Empty {
        /// The unknown.
        column: usize,
        /// Its lower bound on the step.
        lower: f64,
        /// Its upper bound on the step.
        upper: f64,
    },
    /// An unknown without effect, or numbers that are not finite.
    #[error("unknown number {column} has no effect on any reading, or its sums are not finite")]
    NoEffect {
        /// The unknown.
        column: usize,
    },
    /// The solver stopped without a solution.
    #[error("the bounded step was not found: {0}")]
    NotSolved(String),
}

/// The step within bounds (infinite where there are none).
///
/// `hessian` is n × n, symmetric and positive definite (damped if need be); `gradient` and `bounds`
/// have n entries. Extra entries are ignored, missing bounds are infinite.
///
/// # Errors
/// [`BoundedError`]: bounds that exclude each other, a column without effect, or no solution.
pub fn bounded_step(
    hessian: &DMatrix<f64>,
    gradient: &DVector<f64>,
    bounds: &[(f64, f64)],
) -> Result<BoundedStep, BoundedError> {
    let n = gradient.len().min(hessian.nrows());
    let bound = |i: usize| bounds.get(i).copied().unwrap_or(UNBOUNDED);
    for column in 0..n {
        let (lower, upper) = bound(column);
        if lower > upper || lower.is_nan() || upper.is_nan() {
            return Err(BoundedError::Empty { column, lower, upper });
        }
        if !(hessian[(column, column)] > 0.0
            && hessian[(column, column)].is_finite()
            && gradient[column].is_finite())
        {
            return Err(BoundedError::NoEffect { column });
        }
    }
    let scale = DVector::from_fn(n, |i, _| 1.0 / hessian[(i, i)].sqrt());
    let scaled = Scaled {
        hessian: DMatrix::from_fn(n, n, |i, j| scale[i] * hessian[(i, j)] * scale[j]),
        gradient: DVector::from_fn(n, |i, _| scale[i] * gradient[i]),
        bounds: (0..n).map(|i| (bound(i).0 / scale[i], bound(i).1 / scale[i])).collect(),
    };
    let (rough, guess) = scaled.interior_point()?;
    let (mut x, mut held, polished) = match scaled.polish(guess.clone()) {
        Some((x, held)) => (x, held, true),
        None => (rough, guess, false),
    };
    for i in 0..n {
        let (lower, upper) = bound(i);
        x[i] = match held[i] {
            Held::Lower => lower,
            Held::Upper => upper,
            Held::Free => (x[i] * scale[i]).clamp(lower, upper),
        };
    }
    held.truncate(n);
    Ok(BoundedStep { step: x, held, polished })
}

/// The problem with unit columns.
struct Scaled {
    hessian: DMatrix<f64>,
    gradient: DVector<f64>,
    bounds: Vec<(f64, f64)>,
}

impl Scaled {
    /// Solution to the solver's tolerance, and which bounds it found active.
    fn interior_point(&self) -> Result<(DVector<f64>, Vec<Held>), BoundedError> {
        let n = self.gradient.len();
        // Unknowns whose bounds coincide leave the problem: the cone would have no interior.
        let fixed: Vec<bool> = self.bounds.iter().map(|(l, u)| l == u).collect();
        let free: Vec<usize> = (0..n).filter(|&i| !fixed[i]).collect();
        let mut x = DVector::from_fn(n, |i, _| if fixed[i] { self.bounds[i].0 } else { 0.0 });
        let mut held: Vec<_> =
            fixed.iter().map(|&f| if f { Held::Lower } else { Held::Free }).collect();
        let right = &self.gradient - &self.hessian * &x;
        // Rows `-x ≤ -lower`, `x ≤ upper`.
        let mut rows: Vec<(usize, f64, f64, Held)> = Vec::new();
        for (k, &i) in free.iter().enumerate() {
            let (lower, upper) = self.bounds[i];
            if lower.is_finite() {
                rows.push((k, -1.0, -lower, Held::Lower));
            }
            if upper.is_finite() {
                rows.push((k, 1.0, upper, Held::Upper));
            }
        }
        if free.is_empty() {
            return Ok((x, held));
        }
        let quadratic = upper_triangle(&self.hessian, &free);
        let linear: Vec<f64> = free.iter().map(|&i| -right[i]).collect();
        let constraints = CscMatrix::new_from_triplets(
            rows.len(),
            free.len(),
            (0..rows.len()).collect(),
            rows.iter().map(|r| r.0).collect(),
            rows.iter().map(|r| r.1).collect(),
        );
        let limits: Vec<f64> = rows.iter().map(|r| r.2).collect();
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .max_iter(200)
            .build()
            .map_err(|error| BoundedError::NotSolved(error.to_string()))?;
        let cones = [NonnegativeConeT(rows.len())];
        let mut solver =
            DefaultSolver::new(&quadratic, &linear, &constraints, &limits, &cones, settings)
                .map_err(|error| BoundedError::NotSolved(error.to_string()))?;
        solver.solve();
        let solution = &solver.solution;
        match solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {}
            status => return Err(BoundedError::NotSolved(format!("{status:?}"))),
        }
        for (k, &i) in free.iter().enumerate() {
            x[i] = solution.x[k];
        }
        for (row, (k, _, _, side)) in rows.iter().enumerate() {
            if solution.z[row] > solution.s[row] {
                held[free[*k]] = *side;
            }
        }
        Ok((x, held))
    }

    /// Corrects the active set until every sign agrees; `None` if it does not settle.
    fn polish(&self, mut held: Vec<Held>) -> Option<(DVector<f64>, Vec<Held>)> {
        let n = self.gradient.len();
        for _ in 0..n + 10 {
            let free: Vec<usize> = (0..n).filter(|&i| held[i] == Held::Free).collect();
            let mut x = DVector::from_fn(n, |i, _| match held[i] {
                Held::Free => 0.0,
                Held::Lower => self.bounds[i].0,
                Held::Upper => self.bounds[i].1,
            });
            let right = &self.gradient - &self.hessian * &x;
            let block =
                DMatrix::from_fn(free.len(), free.len(), |i, j| self.hessian[(free[i], free[j])]);
            let lower = cholesky::factor(block, f64::EPSILON * n as f64).ok()?;
            let part = DVector::from_iterator(free.len(), free.iter().map(|&i| right[i]));
            for (k, value) in cholesky::solve(&lower, &part).iter().enumerate() {
                x[free[k]] = *value;
            }
            // Positive where the cost would fall if the unknown grew.
            let pull = &self.gradient - &self.hessian * &x;
            let size = 1.0 + self.gradient.amax();
            let mut settled = true;
            for i in 0..n {
                let (l, u) = self.bounds[i];
                let next = match held[i] {
                    _ if l == u => held[i],
                    Held::Free if x[i] < l - SLACK * (1.0 + l.abs()) => Held::Lower,
                    Held::Free if x[i] > u + SLACK * (1.0 + u.abs()) => Held::Upper,
                    Held::Lower if pull[i] > SLACK * size => Held::Free,
                    Held::Upper if pull[i] < -SLACK * size => Held::Free,
                    same => same,
                };
                settled &= next == held[i];
                held[i] = next;
            }
            if settled {
                return Some((x, held));
            }
        }
        None
    }
}

/// Upper triangle of the rows and columns `keep`, in the solver's storage.
fn upper_triangle(matrix: &DMatrix<f64>, keep: &[usize]) -> CscMatrix<f64> {
    let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (j, &b) in keep.iter().enumerate() {
        for (i, &a) in keep.iter().enumerate().take(j + 1) {
            rows.push(i);
            columns.push(j);
            values.push(matrix[(a, b)]);
        }
    }
    CscMatrix::new_from_triplets(keep.len(), keep.len(), rows, columns, values)
}
