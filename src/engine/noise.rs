//! The covariance of the readings of one sample, and its whitening.
//!
//! `V = diag(σ²) + Σ_k s_k² g_k g_kᵀ`: every reading has its own standard uncertainty σ (times an
//! effect's factor), and every random quantity of the sample (an input's error, a time stamp's
//! jitter) with standard deviation `s_k` is shared by the readings through their derivatives `g_k`.
//! With `V = L Lᵀ`, rows are whitened by `L⁻¹`. Readings that are missing stand aside as unit rows.
//!
//! Correlation from sample to sample is not in here.

use nalgebra::DMatrix;

use crate::engine::point::Point;
use crate::engine::problem::{Part, Problem, SampleLeaves};
use crate::model::Process;
use crate::number::{Gradient, Number, partial, partials};

/// Random quantities handled in one pass of the engine.
const CHUNK: usize = 4;

/// Frozen whitening of one run: `L⁻¹` of each sample, row by row.
#[derive(Clone, Debug, Default)]
pub struct Whitening {
    size: usize,
    inverse: Vec<f64>,
    /// `Σ ln det V` over the run: what a likelihood needs.
    pub log_determinant: f64,
}

impl Whitening {
    /// Whitens `rows` (one for each residual component of a sample, each of the same length) in place.
    pub fn apply(&self, sample: usize, rows: &mut DMatrix<f64>) {
        let m = self.size;
        let inverse = &self.inverse[sample * m * m..(sample + 1) * m * m];
        for column in 0..rows.ncols() {
            for i in (0..m).rev() {
                rows[(i, column)] = (0..=i).map(|j| inverse[i * m + j] * rows[(j, column)]).sum();
            }
        }
    }

    /// Whitens one column of residuals in place.
    pub fn apply_to(&self, sample: usize, residual: &mut [f64]) {
        let m = self.size;
        let inverse = &self.inverse[sample * m * m..(sample + 1) * m * m];
        for i in (0..m).rev() {
            residual[i] = (0..=i).map(|j| inverse[i * m + j] * residual[j]).sum();
        }
    }
}

impl Problem {
    /// Lets the weights follow a point.
    pub fn refresh_weights(&mut self, point: &Point) {
        self.whitening = (0..self.parts.len())
            .map(|part| {
                (0..self.parts[part].runs.len())
                    .map(|run| self.whitening_of(part, run, point))
                    .collect()
            })
            .collect();
    }

    fn whitening_of(&self, p: usize, run: usize, point: &Point) -> Whitening {
        let part = &self.parts[p];
        let m = part.residual_count();
        let samples = part.runs[run].record.len();
        let mut whitening = Whitening {
            size: m,
            inverse: Vec::with_capacity(samples * m * m),
            log_determinant: 0.0,
        };
        let parameters = self.parameters::<Gradient<CHUNK>>(p, run, point);
        let mut workspace = Vec::new();
        let active = active_randoms(part);
        for sample in 0..samples {
            let covariance =
                covariance_of(part, run, sample, &parameters, &active, &mut workspace).covariance;
            match covariance.cholesky() {
                Some(factor) => {
                    let lower = factor.l_dirty();
                    whitening.log_determinant +=
                        (0..m).map(|i| 2.0 * lower[(i, i)].ln()).sum::<f64>();
                    invert_lower(lower, &mut whitening.inverse);
                }
                // Not finite here: the residuals are not either, and the cost says so.
                None => whitening.inverse.extend((0..m * m).map(|_| f64::NAN)),
            }
        }
        whitening
    }
}

/// Random quantities that act in the covariance of a sample: independent from sample to sample and
/// with a standard deviation.
pub fn active_randoms(part: &Part) -> Vec<usize> {
    (0..part.random_sigma.len())
        .filter(|k| {
            part.random_sigma[*k] != 0.0 && part.system.randoms[*k].process == Process::White
        })
        .collect()
}

/// Covariance of one sample's residual components, with what it is made of.
#[derive(Clone, Debug)]
pub struct SampleCovariance {
    /// `V`.
    pub covariance: DMatrix<f64>,
    /// Derivatives `g_k` of the predictions, one column for each of the random quantities asked for.
    pub sensitivities: DMatrix<f64>,
}

/// `V` of one sample from the random quantities `active`.
pub fn covariance_of(
    part: &Part,
    run: usize,
    sample: usize,
    parameters: &[[Gradient<CHUNK>; 4]],
    active: &[usize],
    workspace: &mut Vec<Gradient<CHUNK>>,
) -> SampleCovariance {
    let m = part.residual_count();
    let mut covariance = DMatrix::zeros(m, m);
    let mut sensitivities = DMatrix::zeros(m, active.len());
    let mut randoms = vec![Gradient::constant(0.0); part.random_sigma.len()];
    // One pass even without random quantities: the noise factors are wanted.
    for start in (0..active.len().max(1)).step_by(CHUNK) {
        let chunk = &active[start.min(active.len())..active.len().min(start + CHUNK)];
        for (seed, random) in chunk.iter().enumerate() {
            randoms[*random] = partial(0.0, seed);
        }
        let leaves = SampleLeaves {
            parameters,
            randoms: &randoms,
            columns: part.columns(),
            run: &part.runs[run],
            sample,
        };
        let outputs = part.evaluate(&leaves, workspace);
        for (slot, sigma) in part.slots().iter().zip(&part.sigma) {
            let present = part.is_present(run, sample, slot);
            let factor = slot.sigma_factor.map_or(1.0, |output| outputs[output].value());
            let residual = part.residual(run, sample, slot, outputs);
            for (component, residual) in residual.iter().take(slot.components).enumerate() {
                let row = slot.residual + component;
                covariance[(row, row)] = if present { (sigma * factor).powi(2) } else { 1.0 };
                if present {
                    for (seed, value) in partials(residual).iter().enumerate().take(chunk.len()) {
                        sensitivities[(row, start + seed)] = -value;
                    }
                }
            }
        }
        for random in chunk {
            randoms[*random] = Gradient::constant(0.0);
        }
    }
    for (k, random) in active.iter().enumerate() {
        let g = sensitivities.column(k) * part.random_sigma_in(run, *random);
        covariance += &g * g.transpose();
    }
    SampleCovariance { covariance, sensitivities }
}

/// Appends the inverse of a lower triangle, row by row.
fn invert_lower(lower: &DMatrix<f64>, into: &mut Vec<f64>) {
    let m = lower.nrows();
    let start = into.len();
    into.resize(start + m * m, 0.0);
    let inverse = &mut into[start..];
    for column in 0..m {
        for i in column..m {
            let unit = if i == column { 1.0 } else { 0.0 };
            let sum: f64 = (column..i).map(|j| lower[(i, j)] * inverse[j * m + column]).sum();
            inverse[i * m + column] = (unit - sum) / lower[(i, i)];
        }
    }
}
