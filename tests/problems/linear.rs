//! Linear problems in blocks, given by their rows; also under bounds, also rank deficient.

use homepoint::engine::gram::{Columns, LeastSquares, Normal, PriorRow, RunGram, UNBOUNDED};
use nalgebra::{DMatrix, DVector};

use super::Stream;

/// `|y - J x|²` over runs, plus priors; starts and lives at any `x`.
#[derive(Clone, Debug)]
pub(crate) struct Linear {
    pub(crate) columns: Columns,
    /// Rows of each run over the columns it touches, and readings.
    pub(crate) runs: Vec<(DMatrix<f64>, DVector<f64>)>,
    /// Coefficients and stated value.
    pub(crate) priors: Vec<(Vec<(usize, f64)>, f64)>,
    pub(crate) bounds: Vec<(f64, f64)>,
}

impl Linear {
    fn residual(&self, run: usize, x: &[f64]) -> DVector<f64> {
        let touched = self.columns.touched_by(run);
        let local = DVector::from_iterator(touched.len(), touched.iter().map(|&c| x[c]));
        &self.runs[run].1 - &self.runs[run].0 * local
    }

    fn prior_residual(&self, prior: usize, x: &[f64]) -> f64 {
        let (row, value) = &self.priors[prior];
        value - row.iter().map(|(c, k)| k * x[*c]).sum::<f64>()
    }

    /// All rows under each other: dense J and y.
    pub(crate) fn rows(&self) -> (DMatrix<f64>, DVector<f64>) {
        let n = self.columns.len();
        let count = self.runs.iter().map(|r| r.1.len()).sum::<usize>() + self.priors.len();
        let (mut j, mut y) = (DMatrix::zeros(count, n), DVector::zeros(count));
        let mut at = 0;
        for (run, (rows, readings)) in self.runs.iter().enumerate() {
            for i in 0..readings.len() {
                for (k, &c) in self.columns.touched_by(run).iter().enumerate() {
                    j[(at, c)] = rows[(i, k)];
                }
                y[at] = readings[i];
                at += 1;
            }
        }
        for (row, value) in &self.priors {
            for (c, k) in row {
                j[(at, *c)] += k;
            }
            y[at] = *value;
            at += 1;
        }
        (j, y)
    }
}

impl LeastSquares for Linear {
    type Point = Vec<f64>;

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn reweight(&mut self, _: &Vec<f64>) {}

    fn weights_move(&self) -> bool {
        false
    }

    fn cost(&self, x: &Vec<f64>) -> f64 {
        (0..self.runs.len()).map(|r| self.residual(r, x).norm_squared()).sum::<f64>()
            + (0..self.priors.len()).map(|p| self.prior_residual(p, x).powi(2)).sum::<f64>()
    }

    fn normal(&self, x: &Vec<f64>) -> Normal {
        let gram = |run: usize| {
            let (j, y) = (&self.runs[run].0, self.residual(run, x));
            let rows = DMatrix::from_fn(j.nrows(), j.ncols() + 1, |i, k| {
                if k < j.ncols() { j[(i, k)] } else { y[i] }
            });
            RunGram { gram: rows.tr_mul(&rows), readings: j.nrows() }
        };
        Normal {
            columns: self.columns.clone(),
            runs: (0..self.runs.len()).map(gram).collect(),
            priors: (0..self.priors.len())
                .map(|p| PriorRow {
                    coefficients: self.priors[p].0.clone(),
                    residual: self.prior_residual(p, x),
                })
                .collect(),
        }
    }

    fn moved(&self, x: &Vec<f64>, step: &[f64]) -> Vec<f64> {
        x.iter().zip(step).map(|(a, b)| a + b).collect()
    }

    fn step_bounds(&self, x: &Vec<f64>) -> Vec<(f64, f64)> {
        self.bounds.iter().zip(x).map(|((l, u), x)| (l - x, u - x)).collect()
    }
}

/// Random rows over blocks of widely different units, with a prior in the first of each block.
pub(crate) fn random_arrow(seed: u64, columns: Columns) -> Linear {
    let mut stream = Stream(seed);
    let n = columns.len();
    let units: Vec<f64> = (0..n).map(|_| 10f64.powf(5.0 * stream.next())).collect();
    let runs = (0..columns.runs.len())
        .map(|run| {
            let touched = columns.touched_by(run);
            let count = 3 * touched.len() + 2;
            let j =
                DMatrix::from_fn(count, touched.len(), |_, k| stream.next() * units[touched[k]]);
            (j, DVector::from_fn(count, |_, _| stream.next()))
        })
        .collect();
    let mut starts: Vec<(usize, usize)> = vec![(0, columns.global)];
    starts.extend((0..columns.setups.len()).map(|s| (columns.setup_start(s), columns.setups[s])));
    starts.extend((0..columns.runs.len()).map(|r| (columns.run_start(r), columns.runs[r].1)));
    let priors = starts
        .into_iter()
        .filter(|(_, count)| *count > 0)
        .map(|(start, _)| {
            let mut row = vec![(start, 0.5 * units[start])];
            if start > 0 && columns.global > 0 {
                row.push((0, -0.3 * units[0]));
            }
            (row, stream.next())
        })
        .collect();
    Linear { columns, runs, priors, bounds: vec![UNBOUNDED; n] }
}

/// A constant-rate run: azimuth = rate (time + delay) + orientation. Delay and orientation cannot
/// be told apart; a third column, the zenith, is determined, and `idle` has no effect.
///
/// Columns: delay (s), orientation (rad), zenith (rad), idle.
pub(crate) fn constant_rate(rate: f64) -> Linear {
    let count = 40;
    let j = DMatrix::from_fn(2 * count, 4, |i, k| match (i % 2, k) {
        (0, 0) => rate * 1e5,
        (0, 1) | (1, 2) => 1e5,
        _ => 0.0,
    });
    let mut stream = Stream(5);
    Linear {
        columns: Columns { global: 4, setups: vec![0], runs: vec![(0, 0)] },
        runs: vec![(j, DVector::from_fn(2 * count, |_, _| 3.0 + stream.next()))],
        priors: vec![],
        bounds: vec![UNBOUNDED; 4],
    }
}

/// Readings 3, -2 and 0.25 of three unknowns coupled by a fourth row; two bounds hold.
///
/// Rows: a = 3, b = -2, c = 0.25, a + b + c = 0; a ≤ 1, b ≥ -1. With a = 1 and b = -1 held, c
/// minimises (c - 0.25)² + c², so c = 0.125.
pub(crate) fn bounded() -> (Linear, [f64; 3]) {
    let j = DMatrix::from_row_slice(
        4,
        3,
        &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
    );
    let linear = Linear {
        columns: Columns { global: 3, setups: vec![0], runs: vec![(0, 0)] },
        runs: vec![(j, DVector::from_vec(vec![3.0, -2.0, 0.25, 0.0]))],
        priors: vec![],
        bounds: vec![(f64::NEG_INFINITY, 1.0), (-1.0, f64::INFINITY), (-5.0, 5.0)],
    };
    (linear, [1.0, -1.0, 0.125])
}
