//! Changes that one or two wrong readings imitate: a stretch about a reading that is far out gains what
//! leaving this reading out gains. Such a change does not compete; the reading is an outlier of what is
//! left. Under autocorrelated noise a step shows mostly in its first reading, and is not judged here.

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::terms::{Base, Change};

/// Samples that may carry a change.
const FEW: usize = 2;
/// Share of its gain that a change keeps without them at least. Of the shortest stretch, eight samples
/// with equal contributions, three quarters are kept.
const KEPT: f64 = 0.25;

/// What a sample adds to the score of a change and to its squared length.
#[derive(Clone, Copy, Debug, Default)]
struct Contribution {
    score: f64,
    square: f64,
}

/// The samples of a change.
struct Samples {
    /// Of a stretch its own; of a change from a moment on those of all runs.
    all: Vec<Contribution>,
    /// Of its run the samples in which it would act, but does not.
    beside: Vec<bool>,
    is_autocorrelated: bool,
}

impl Linear {
    /// Takes the changes out that a few samples carry: those in the place of a term, of which the other
    /// ones are not known here, where they act in so few, or in all of a run but so few.
    pub(super) fn retain_not_carried(
        &self,
        selection: &Selection<'_>,
        model: &[usize],
        changes: &mut Vec<(bool, Change)>,
    ) {
        let at_run = |(is_in_place, one): (bool, Change)| Some((is_in_place, self.at_run(one)?));
        *changes = std::mem::take(changes).into_iter().filter_map(at_run).collect();
        if changes.is_empty() {
            return;
        }
        let problem = &self.fitted.problem;
        let (mut firsts, mut ends) = (Vec::new(), 0);
        for run in 0..self.order.len() {
            firsts.push(ends);
            ends += problem.samples_in(run);
        }
        let of_change = |(_, one): &(bool, Change)| Samples {
            all: vec![Contribution::default(); one.end.map_or(ends, |end| end - one.at.1)],
            beside: vec![false; problem.samples_in(one.at.0)],
            is_autocorrelated: false,
        };
        let mut samples: Vec<Samples> = changes.iter().map(of_change).collect();
        let bases: Vec<Base> = changes.iter().map(|(_, one)| one.base).collect();
        let weights = selection.weights();
        let values = selection.values(model);
        self.visit(selection, model, &bases, &mut |row| {
            let explained: f64 = row.model.iter().zip(values.iter()).map(|(x, b)| x * b).sum();
            let weight = weights[row.measurand];
            let of_each = row.further.iter().zip(&*changes).zip(&mut samples);
            for ((x, (_, change)), own) in of_each.filter(|((x, _), _)| **x != 0.0) {
                if !self.acts(change, (row.run, row.sample)) {
                    if row.run == change.at.0 {
                        own.beside[row.sample] = true;
                    }
                    continue;
                }
                own.is_autocorrelated |= row.gains.is_some();
                let at = match change.end {
                    Some(_) => row.sample - change.at.1,
                    None => firsts[row.run] + row.sample,
                };
                own.all[at].score += weight * x * (row.residual - explained);
                own.all[at].square += weight * x * x;
            }
        });
        let mut samples = samples.iter();
        changes.retain(|(is_in_place, _)| {
            let own = samples.next();
            own.is_none_or(|own| {
                let beside = own.beside.iter().filter(|own| **own).count();
                let acting = own.all.iter().filter(|one| one.square > 0.0).count();
                let is_of_few = acting <= FEW || (1..=FEW).contains(&beside);
                let is_judged = !is_in_place && !own.is_autocorrelated;
                let is_outlier = is_of_few || is_judged && is_carried(&own.all);
                !is_outlier
            })
        });
    }

    /// A change from a moment on that is a few samples after the beginning of a run, or before its end, from
    /// the beginning of this run or the next one on; `None` where there is nothing before or behind that.
    fn at_run(&self, change: Change) -> Option<Change> {
        let (run, first) = change.at;
        let problem = &self.fitted.problem;
        if change.end.is_some() || first == 0 {
            return Some(change);
        }
        let part_of = |run: usize| problem.run_at(run).0;
        let others = || (0..self.order.len()).filter(|other| part_of(*other) == part_of(run));
        let at = if problem.samples_in(run) - first <= FEW {
            let later = others().filter(|other| self.order[*other] > self.order[run]);
            (later.min_by_key(|other| self.order[*other])?, 0)
        } else if first <= FEW {
            others().find(|other| self.order[*other] < self.order[run])?;
            (run, 0)
        } else {
            (run, first)
        };
        Some(Change { at, ..change })
    }
}

/// Whether a few samples carry the gain, the squared score over the squared length. What the model absorbs
/// of the length it absorbs of each sample in proportion.
fn is_carried(all: &[Contribution]) -> bool {
    let sum = |of: fn(&Contribution) -> f64| all.iter().map(of).sum::<f64>();
    let (score, square) = (sum(|one| one.score), sum(|one| one.square));
    let mut few: Vec<&Contribution> = Vec::new();
    for one in all.iter().filter(|one| one.score * score > 0.0) {
        few.push(one);
        few.sort_by(|a, b| b.score.abs().total_cmp(&a.score.abs()));
        few.truncate(FEW);
    }
    let rest = score - few.iter().map(|one| one.score).sum::<f64>();
    let rest_square = square - few.iter().map(|one| one.square).sum::<f64>();
    rest_square <= 0.0 || rest.powi(2) * square < KEPT * score.powi(2) * rest_square
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(of: impl IntoIterator<Item = (f64, f64)>) -> Vec<Contribution> {
        of.into_iter().map(|(score, square)| Contribution { score, square }).collect()
    }

    #[test]
    fn a_few_samples_carry_a_spike_and_no_stretch() {
        assert!(!is_carried(&all([(3.0, 1.0); 8])));
        for spikes in [1, 2] {
            let mut spiked = all([(0.1, 1.0); 8]);
            spiked[..spikes].fill(Contribution { score: 18.0, square: 1.0 });
            assert!(is_carried(&spiked), "{spikes}");
        }
        // Of a motion that begins, most of the length is in the last samples.
        let faster = (1..=9).map(|k| f64::from(k * k)).map(|square| (2.0 * square, square));
        assert!(!is_carried(&all(faster)));
        assert!(is_carried(&all([(18.0, 1.0)])));
    }
}
