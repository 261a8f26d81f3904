//! Wild readings: those beyond [`TRIM`] robust standard deviations of their measurand are left out, and
//! listed by row. Where many are far out the noise has long tails and none is left out.

use crate::engine::Problem;
use crate::units::Unit;

use super::search::level;
use super::stage::{Fitted, Stage};
use super::tail::ln_chi_squared;
use super::whiten::{Noise, NoiseEffect, Sequence, median};

/// Readings farther out are left out, in robust standard deviations.
pub const TRIM: f64 = 4.5;
/// Share of readings farther out by chance.
const BEYOND_TRIM: f64 = 6.8e-6;
/// Where more readings than this share are far out, the noise has long tails and none is left out.
const MOST_WILD: f64 = 0.05;
/// Standard deviation over median absolute deviation of a normal distribution.
const NORMAL: f64 = 1.482_602_2;

/// A reading that is left out because it is wild.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Name of the run.
    pub run: String,
    /// Row of its data file.
    pub row: usize,
    /// The measurand.
    pub measurand: String,
    /// How far out it was, in robust standard deviations of its measurand.
    pub deviations: f64,
}

/// Leaves wild readings of a stage out. `white` is what is left as if there were no memory: one wild
/// reading is one there, not the beginning of several.
pub(super) fn without_wild(stage: &Stage, white: &[Sequence], noise: &mut Noise) -> Option<Fitted> {
    let mut fitted = stage.fitted.clone();
    let wild = trim(&mut fitted.problem, white)?;
    noise.wild += wild.len();
    noise.left_out.extend(wild);
    Some(fitted)
}

/// Leaves wild readings out and lists them; `None` where there is none.
fn trim(problem: &mut Problem, all: &[Sequence]) -> Option<Vec<LeftOut>> {
    let mut wild = Vec::new();
    for one in all {
        let mut sizes: Vec<f64> = one.present().map(f64::abs).collect();
        let Some(median) = median(&mut sizes) else { continue };
        let limit = TRIM * NORMAL * median;
        let far = sizes.iter().filter(|size| **size > limit).count();
        if far == 0 || far as f64 > MOST_WILD * sizes.len() as f64 {
            continue;
        }
        let part = &mut problem.parts[one.part];
        let slot = part.slots()[one.measurand].clone();
        let name = part.system.assembly.names.measurands[one.measurand].name.clone();
        for (run, residuals) in part.runs.iter_mut().zip(&one.runs) {
            if !residuals.iter().any(|value| value.abs() > limit) {
                continue;
            }
            let far = residuals.iter().enumerate().filter(|(_, value)| value.abs() > limit);
            let far: Vec<(usize, f64)> = far.map(|(sample, value)| (sample, *value)).collect();
            wild.extend(far.iter().map(|(sample, value)| LeftOut {
                run: run.name.clone(),
                row: run.record.row(*sample),
                measurand: name.clone(),
                deviations: *value / (NORMAL * median),
            }));
            let readings = far.iter().map(|(sample, _)| (*sample..*sample + 1, slot.columns()));
            run.record.leave_out(readings);
        }
    }
    (!wild.is_empty()).then_some(wild)
}

/// Names outliers where there are more wild readings than chance gives.
pub(super) fn name_wild(stage: &Stage, noise: &mut Noise) {
    let readings = stage.fitted.problem.reading_count() + noise.wild;
    let ln_p = ln_wild(noise.wild, readings);
    if noise.wild > 0 && ln_p <= level(stage.noise.len() + 1) {
        let share = noise.wild as f64 / readings as f64;
        noise.effects.push(NoiseEffect {
            name: "outliers".to_owned(),
            selected: None,
            parameter: "outliers.share".to_owned(),
            unit: Unit::one(),
            value: share,
            sigma: (share / readings as f64).sqrt(),
            aliases: Vec::new(),
            memory: None,
            ln_p,
        });
    }
}

/// Logarithm of the probability of so many wild readings among normal ones.
pub fn ln_wild(wild: usize, readings: usize) -> f64 {
    // Poisson: the chance of at least so many is that of a chi squared below twice the mean.
    let mean = BEYOND_TRIM * readings as f64;
    let upper = ln_chi_squared(2.0 * mean, 2 * wild);
    (-upper.exp()).ln_1p().max(-700.0)
}
