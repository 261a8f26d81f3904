//! The covariance of the readings of one sample.
//!
//! `V = diag(σ²) + Σ_k s_k² g_k g_kᵀ`: every reading has its own standard uncertainty σ (times an
//! effect's factor), and every random quantity of the sample (an input's error, a time stamp's
//! jitter) with standard deviation `s_k` is shared by the readings through their derivatives `g_k`.
//! What whitens it is [`super::whitening`]'s business; here it is made sample by sample, for what
//! estimates noise.
//!
//! Correlation from sample to sample is not in here.

use nalgebra::DMatrix;

use crate::campaign::Sample;
use crate::engine::part::{Part, SampleLeaves};
use crate::model::Process;
use crate::number::{Gradient, Number, partial, partials};

/// Random quantities handled in one pass of the engine.
pub const CHUNK: usize = 4;

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
    /// Derivatives `g_k` of the predictions, one column for each of the random quantities asked
    /// for.
    pub sensitivities: DMatrix<f64>,
}

impl Part {
    /// Standard uncertainty of one reading of a measurand in a run (SI).
    pub fn sigma_in(&self, run: usize, measurand: usize) -> f64 {
        let level = self.run_levels.get(run).map_or(1.0, |levels| levels[measurand]);
        let own = level * self.sigma[measurand];
        match self.smoothing_sigma.get(run) {
            Some(added) if added[measurand] > 0.0 => own.hypot(added[measurand]),
            _ => own,
        }
    }
}

/// `V` of one sample from the random quantities `active`.
pub fn covariance_of(
    part: &Part,
    run: usize,
    sample: Sample<'_>,
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
        let leaves =
            SampleLeaves { parameters, randoms: &randoms, columns: part.columns(), sample };
        let outputs = part.evaluate(&leaves, workspace);
        for (measurand, slot) in part.slots().iter().enumerate() {
            let sigma = part.sigma_in(run, measurand);
            let present = part.is_present(sample, slot);
            let factor = slot.sigma_factor.map_or(1.0, |output| outputs[output].value());
            let residual = part.residual(sample, slot, outputs);
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
