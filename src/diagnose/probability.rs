//! How probable each cause is, given that there is one cause at most.
//!
//! Before the data: nothing .30, some effect of the library .50, unknown structure .20, each split
//! evenly. Values are normal about zero with a standard deviation of the typical size times a scale;
//! nine scales from 0.1 to 30 are equally likely, so an effect ten times as large as usual is no
//! surprise. With `C = V T² Vᵀ` (typical sizes `T`, `V` from values to lengths) an entry's evidence
//! against nothing is `-½ ln det(1 + s² C) + ½ zᵀ s² C (1 + s² C)⁻¹ z`. Members of a family share its
//! part.

use nalgebra::{DMatrix, SymmetricEigen};

use super::evidence::Entry;
use super::stage::Stage;

/// Probability of nothing, of the library, of unknown structure, before the data.
const BEFORE: [f64; 3] = [0.30, 0.50, 0.20];
/// Scales of the typical size.
const SCALES: [f64; 9] = [0.1, 0.2, 0.43, 0.87, 1.75, 3.5, 7.1, 14.6, 30.0];

/// The probability of each candidate of a stage, in their order, blocks among them.
pub fn probabilities(stage: &Stage) -> Vec<f64> {
    let count = |blocks: bool| {
        let numbers = 0..stage.candidates.len();
        let of_kind = numbers.filter(|n| (*n >= stage.effects) == blocks);
        of_kind.filter(|n| stage.entry(*n).degrees() > 0).count().max(1) as f64
    };
    let share = [BEFORE[1] / count(false), BEFORE[2] / count(true)];
    let logarithms: Vec<f64> = (0..stage.candidates.len())
        .map(|n| {
            let entry = stage.entry(n);
            if entry.degrees() == 0 {
                return f64::NEG_INFINITY;
            }
            let members = (stage.members[n] as f64).ln();
            evidence(entry, &typical(stage, n)) - members
                + share[usize::from(n >= stage.effects)].ln()
        })
        .collect();
    let most = logarithms.iter().copied().fold(BEFORE[0].ln(), f64::max);
    let sum: f64 = logarithms.iter().map(|one| (one - most).exp()).sum::<f64>()
        + (BEFORE[0].ln() - most).exp();
    logarithms.iter().map(|one| (one - most).exp() / sum).collect()
}

/// Logarithm of the evidence of an entry against nothing.
fn evidence(entry: &Entry, typical: &[f64]) -> f64 {
    let scaled =
        DMatrix::from_fn(entry.degrees(), typical.len(), |i, j| entry.lengths[(i, j)] * typical[j]);
    let eigen = SymmetricEigen::new(&scaled * scaled.transpose());
    let score = eigen.eigenvectors.tr_mul(&entry.score);
    let each = SCALES.map(|scale| {
        let terms = eigen.eigenvalues.iter().zip(score.iter()).map(|(value, z)| {
            let size = scale * scale * value.max(0.0);
            0.5 * (z * z * size / (1.0 + size) - size.ln_1p())
        });
        terms.sum::<f64>()
    });
    let most = each.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mean = each.iter().map(|one| (one - most).exp()).sum::<f64>() / SCALES.len() as f64;
    most + mean.ln()
}

/// The typical size of each column's value: as declared; of a block such that all its columns
/// together change a reading by its noise.
fn typical(stage: &Stage, number: usize) -> Vec<f64> {
    let entry = stage.entry(number);
    let candidate = &stage.candidates[number];
    let readings: usize = stage.fitted.fit.normal.runs.iter().map(|run| run.readings).sum();
    let whole = (readings as f64 / entry.owners.len().max(1) as f64).sqrt();
    entry
        .owners
        .iter()
        .zip(entry.raw.iter())
        .map(|(owner, raw)| {
            if candidate.place.is_some() {
                return if *raw > 0.0 { whole / raw } else { 0.0 };
            }
            candidate.typical(&owner.parameter).unwrap_or(0.0)
        })
        .collect()
}
