//! How probable each cause is, given that there is one cause at most.
//!
//! Before the data ([`Prior`]): nothing .30, some effect of the library .50, unknown structure .20,
//! each split evenly over its effects (whose heads share it) and its blocks that are not counted as
//! scatter, unless the user says otherwise. Values are normal about zero with a standard deviation
//! of the typical size times a scale. `SCALES` of them, in equal ratios, are equally likely: from
//! the one at which the signature has the length `SEEN` (an effect that is smaller is nothing, as
//! far as these readings can say) to `LARGEST`, so an effect ten times as large as usual is no
//! surprise, and neither is one that barely shows in a campaign that would see a hundredth of the
//! usual size. With `C = V T² Vᵀ` (typical sizes `T`, `V` from values to lengths) an entry's
//! evidence against nothing is `-½ ln det(1 + s² C) + ½ zᵀ s² C (1 + s² C)⁻¹ z`. Members of a
//! family share its part.
//!
//! What nobody wrote down need not look like one block: it may look like an effect and leave
//! something that a block explains. An effect that explains less than [`NAMED`] of what is there
//! beside a block stands for that, too, where both are beyond chance: their evidence together is
//! evidence for the block.

use std::collections::HashMap;

use nalgebra::DMatrix;

use crate::diagnose::evidence::Entry;
use crate::diagnose::evidence::score::of_gain;
use crate::diagnose::evidence::thresholds::{NAMED, level};
use crate::diagnose::library::prior::{Cause, Prior};
use crate::diagnose::stage::Stage;
use crate::estimate::eigen;

/// Number of scales.
const SCALES: usize = 12;
/// Length of a signature, in units of the noise, from which on it is something.
const SEEN: f64 = 2.0;
/// The largest scale, in typical sizes; where even that is hardly seen, so many times what is.
const LARGEST: (f64, f64) = (30.0, 10.0);
/// From this probability on unknown structure is told, although no block is beyond chance by
/// itself.
const LIKELY: f64 = 0.95;
/// Effects whose logarithm of probability is this much below the best are not asked what they
/// leave.
const OUT_OF_QUESTION: f64 = 12.0;

/// Whether an effect so many times as large as usual is larger than the largest scale.
pub fn is_implausible(times: f64) -> bool {
    times > LARGEST.0
}

/// The probability of each candidate of a stage, in their order, blocks among them.
pub fn probabilities(stage: &Stage) -> Vec<f64> {
    let nothing = stage.prior.of(Cause::Nothing).ln();
    normalised(&with_imitations(stage, stage.logarithms()), Some(nothing))
}

/// The same where a walk may be there instead of an effect: the walk's part of it is nothing, and
/// beside an accepted walk the effect's part of that, which is nothing, is the effect's.
pub fn beside_walks(stage: &Stage) -> Vec<f64> {
    let mut all = probabilities(stage);
    for rival in &stage.noise_found.rivals {
        let Some(number) = stage.effect_named(&rival.effect) else { continue };
        if stage.noise_found.instead().any(|one| one.effect == rival.effect) {
            let nothing = 1.0 - all.iter().sum::<f64>();
            all[number] += rival.part() * nothing.max(0.0);
        } else {
            all[number] *= rival.part();
        }
    }
    all
}

/// The probability of each effect of a stage, in their order, if it is one of them.
pub fn among_effects(stage: &Stage) -> Vec<f64> {
    normalised(&stage.logarithms()[..stage.effects], None)
}

/// The probabilities of nothing, of effects and of blocks in all, from those of each candidate.
pub fn of_causes(stage: &Stage, all: &[f64]) -> [f64; 3] {
    let (effects, blocks) = all.split_at(stage.effects);
    let (library, unknown) = (effects.iter().sum::<f64>(), blocks.iter().sum::<f64>());
    [(1.0 - library - unknown).max(0.0), library, unknown]
}

/// Whether something that nobody wrote down is what there is in all likelihood, by the
/// probabilities of [`of_causes`]: not because the user said so before.
pub fn is_unknown(stage: &Stage, [nothing, _, unknown]: [f64; 3]) -> bool {
    let known = Prior::default();
    let [before, usual] = [&stage.prior, &known]
        .map(|prior| [Cause::Unknown, Cause::Nothing].map(|one| prior.of(one)));
    // How much more likely the readings make it against nothing.
    let least = LIKELY / (1.0 - LIKELY) * usual[1] / usual[0];
    unknown >= LIKELY && unknown * before[1] >= least * nothing * before[0]
}

/// Probabilities from their logarithms, that of `nothing` beside them.
fn normalised(logarithms: &[f64], nothing: Option<f64>) -> Vec<f64> {
    let all = logarithms.iter().copied().chain(nothing);
    let most = all.clone().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY {
        return vec![0.0; logarithms.len()];
    }
    let sum: f64 = all.map(|one| (one - most).exp()).sum();
    logarithms.iter().map(|one| (one - most).exp() / sum).collect()
}

/// The part of each candidate before the data: of effects by how probable they are beside each
/// other, heads alike; of blocks that may be structure evenly.
fn shares(stage: &Stage) -> Vec<f64> {
    let prior = &stage.prior;
    let name = |n: usize| stage.candidates[n].selected.effect.name.as_str();
    let is_testable = |n: &usize| stage.entry(*n).degrees() > 0;
    let mut heads: HashMap<&str, f64> = HashMap::new();
    for effect in (0..stage.effects).filter(is_testable) {
        *heads.entry(name(effect)).or_default() += 1.0;
    }
    let times = |n: usize| match heads.get(name(n)) {
        _ if !is_testable(&n) => 0.0,
        Some(heads) if n < stage.effects => prior.times(name(n)) / heads,
        _ => f64::from(u8::from(!stage.is_scatter(n))),
    };
    let times: Vec<f64> = (0..stage.candidates.len()).map(times).collect();
    let sum = |some: &[f64]| match some.iter().sum::<f64>() {
        sum if sum > 0.0 => sum,
        _ => 1.0,
    };
    let (effects, blocks) = times.split_at(stage.effects);
    let (library, unknown) = (prior.of(Cause::Library), prior.of(Cause::Unknown));
    let (effect, block) = (library / sum(effects), unknown / sum(blocks));
    let effects = effects.iter().map(|times| effect * times);
    effects.chain(blocks.iter().map(|times| block * times)).collect()
}

/// Logarithm of the evidence of each candidate against nothing, times its part before the data.
pub(in crate::diagnose) fn logarithms(stage: &Stage) -> Vec<f64> {
    let shares = shares(stage);
    (0..stage.candidates.len())
        .map(|n| {
            let entry = stage.entry(n);
            if entry.degrees() == 0 {
                return f64::NEG_INFINITY;
            }
            let members = (stage.members[n] as f64).ln();
            evidence(entry, &typical(stage, n)) - members + shares[n].ln()
        })
        .collect()
}

/// The largest probability that a finding is no chance that its probability by chance allows
/// against even odds: `1 / (1 - e p ln p)` (Sellke, Bayarri and Berger 2001, "Calibration of p
/// values").
pub fn at_most(ln_p: f64) -> f64 {
    // Beyond p = 1/e a finding speaks for chance.
    let ln_p = ln_p.min(-1.0);
    1.0 / (1.0 - (1.0 + ln_p).exp() * ln_p)
}

/// Gives blocks what effects and they explain together where the effects alone are not enough.
fn with_imitations(stage: &Stage, alone: &[f64]) -> Vec<f64> {
    let shares = shares(stage);
    // Blocks have one part before the data, or none.
    let block_share = shares[stage.effects..].iter().copied().fold(0.0, f64::max);
    let (effects, blocks) = alone.split_at(stage.effects);
    let best = effects.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let readings: usize = stage.fitted.fit.normal.runs.iter().map(|run| run.readings).sum();
    let mut all = alone.to_vec();
    for (number, own) in effects.iter().enumerate() {
        let score = &stage.scores[number];
        if *own < best - OUT_OF_QUESTION || !score.is_seen(level(effects.len())) {
            continue;
        }
        let length = score.lambda().powi(2);
        let odds = (block_share / shares[number]).ln();
        for (block, whole) in all.iter_mut().enumerate().skip(stage.effects) {
            if shares[block] <= 0.0 {
                continue;
            }
            let (gain, degrees) = stage.evidence.beyond(stage.entry(number), stage.entry(block));
            let left = of_gain(gain, degrees, stage.members[block]);
            let is_enough = length >= NAMED * (length + left.lambda().powi(2));
            if is_enough || !left.is_seen(level(blocks.len())) {
                continue;
            }
            let each = vec![readings as f64 / degrees as f64; degrees];
            let squares = vec![gain / degrees as f64; degrees];
            let choice = (stage.members[block] as f64).ln();
            let together = own + odds + mixed(&each, &squares) - choice;
            let (more, less) = (whole.max(together), whole.min(together));
            *whole = more + (less - more).exp().ln_1p();
        }
    }
    all
}

/// Logarithm of the evidence of an entry against nothing.
fn evidence(entry: &Entry, typical: &[f64]) -> f64 {
    let scaled =
        DMatrix::from_fn(entry.degrees(), typical.len(), |i, j| entry.lengths[(i, j)] * typical[j]);
    let Some(eigen) = eigen::symmetric(&scaled * scaled.transpose()) else {
        return f64::NEG_INFINITY;
    };
    let score = eigen.eigenvectors.tr_mul(&entry.score);
    let squares: Vec<f64> = score.iter().map(|z| z * z).collect();
    mixed(eigen.eigenvalues.as_slice(), &squares)
}

/// The same from the squared lengths that values of typical size have along independent axes, and
/// the squared scores there.
fn mixed(lengths: &[f64], squares: &[f64]) -> f64 {
    let whole = lengths.iter().map(|one| one.max(0.0)).sum::<f64>().sqrt();
    if whole <= 0.0 {
        return f64::NEG_INFINITY;
    }
    let least = SEEN / whole;
    let largest = LARGEST.0.max(LARGEST.1 * least);
    let each: [f64; SCALES] = std::array::from_fn(|k| {
        let scale = least * (largest / least).powf(k as f64 / (SCALES - 1) as f64);
        let terms = lengths.iter().zip(squares).map(|(length, square)| {
            let size = scale * scale * length.max(0.0);
            0.5 * (square * size / (1.0 + size) - size.ln_1p())
        });
        terms.sum()
    });
    let most = each.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mean = each.iter().map(|one| (one - most).exp()).sum::<f64>() / SCALES as f64;
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

#[cfg(test)]
mod tests {
    use super::at_most;

    #[test]
    fn a_small_probability_by_chance_is_no_certainty() {
        // The paper's figures: p = .05 leaves at least .289 for chance, p = .01 at least .111.
        assert!((1.0 - at_most(0.05_f64.ln()) - 0.289).abs() < 5e-4);
        assert!((1.0 - at_most(0.01_f64.ln()) - 0.111).abs() < 5e-4);
        assert_eq!(at_most(0.0), 0.5);
        assert_eq!(at_most(-1e4), 1.0);
    }
}
