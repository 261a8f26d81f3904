//! Changes that one or two wrong readings imitate: a stretch about a reading that is far out gains what
//! leaving this reading out gains. Such a change does not compete; the reading is an outlier of what is
//! left. Under autocorrelated noise a step shows mostly in its first reading: nothing is said there.

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::terms::{Base, Change};

/// Samples that may carry a change.
const FEW: usize = 2;
/// Share of its gain that a change keeps without them at least. Of the shortest stretch, eight samples
/// with equal parts, three quarters are kept.
const KEPT: f64 = 0.25;

/// What a sample adds to the score of a change and to its squared length.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    score: f64,
    square: f64,
}

impl Linear {
    /// Takes the changes beside a model out that a few of their samples carry.
    pub(super) fn retain_not_carried(
        &self,
        selection: &Selection<'_>,
        model: &[usize],
        changes: &mut Vec<Change>,
    ) {
        if changes.is_empty() {
            return;
        }
        let problem = &self.fitted.problem;
        let firsts: Vec<usize> = (0..self.order.len())
            .scan(0, |end, run| {
                let first = *end;
                *end += problem.samples_in(run);
                Some(first)
            })
            .collect();
        let samples: usize = (0..self.order.len()).map(|run| problem.samples_in(run)).sum();
        let mut parts = vec![vec![Part::default(); samples]; changes.len()];
        let mut is_autocorrelated = vec![false; changes.len()];
        let bases: Vec<Base> = changes.iter().map(|one| one.base).collect();
        let weights = selection.weights();
        let values = selection.values(model);
        self.visit(selection, model, &bases, &mut |row| {
            let explained: f64 = row.model.iter().zip(values.iter()).map(|(x, b)| x * b).sum();
            let weight = weights[row.measurand];
            for (number, x) in row.further.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                if self.acts(&changes[number], (row.run, row.sample)) {
                    is_autocorrelated[number] |= row.gains.is_some();
                    let part = &mut parts[number][firsts[row.run] + row.sample];
                    part.score += weight * x * (row.residual - explained);
                    part.square += weight * x * x;
                }
            }
        });
        let mut number = 0;
        changes.retain(|one| {
            number += 1;
            is_autocorrelated[number - 1] || !is_carried(&parts[number - 1], one.gain.gain)
        });
    }
}

/// Whether a few samples carry a gain.
fn is_carried(parts: &[Part], gain: f64) -> bool {
    let score: f64 = parts.iter().map(|part| part.score).sum();
    let mut along: Vec<Part> =
        parts.iter().filter(|part| part.score * score > 0.0).copied().collect();
    let few = FEW.min(along.len());
    if few > 0 {
        along.select_nth_unstable_by(few - 1, |a, b| b.score.abs().total_cmp(&a.score.abs()));
    }
    let taken = |of: fn(&Part) -> f64| along.iter().take(few).map(of).sum::<f64>();
    // What the model leaves of the squared length, with all samples and without the few.
    let left = score.powi(2) / gain - taken(|part| part.square);
    let rest = score - taken(|part| part.score);
    left <= 0.0 || rest.powi(2) < KEPT * gain * left
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gain(parts: &[Part]) -> f64 {
        let sum = |of: fn(&Part) -> f64| parts.iter().map(of).sum::<f64>();
        sum(|part| part.score).powi(2) / sum(|part| part.square)
    }

    #[test]
    fn a_few_samples_carry_a_spike_and_no_stretch() {
        let equal = [Part { score: 3.0, square: 1.0 }; 8];
        assert!(!is_carried(&equal, gain(&equal)));
        for spikes in [1, 2] {
            let mut parts = [Part { score: 0.1, square: 1.0 }; 8];
            parts[..spikes].fill(Part { score: 18.0, square: 1.0 });
            assert!(is_carried(&parts, gain(&parts)), "{spikes}");
        }
        // Of a motion that begins, most of the length is in the last samples.
        let faster: Vec<Part> = (1..=9)
            .map(|k| f64::from(k * k))
            .map(|square| Part { score: 2.0 * square, square })
            .collect();
        assert!(!is_carried(&faster, gain(&faster)));
        assert!(is_carried(&[Part { score: 18.0, square: 1.0 }], 324.0));
    }
}
