//! What recorded trials have otherwise when they are made again: the comparison, and its keys for
//! programs, `docs/formats.md`, section 6.

use serde_json::{Value, json};

use crate::report::json::number;
use crate::trials::difference::{Difference, differences};
use crate::trials::paired::{Mean, Rate, Summary};
use crate::trials::replay::Pair;

/// Recorded trials, compared with the same made again.
#[derive(Clone, Debug)]
pub enum Replayed {
    /// Trial by trial.
    Each {
        /// Trials that were made again.
        trials: usize,
        /// Trials of the file.
        total: usize,
        /// Those that differ: number, what was put in, and what differs.
        changed: Vec<Changed>,
    },
    /// By their scores.
    Summary {
        /// Scores side by side.
        summary: Summary,
        /// Trials of the file.
        total: usize,
    },
}

/// A trial that differs.
#[derive(Clone, Debug)]
pub struct Changed {
    /// Its number.
    pub trial: usize,
    /// What was put in.
    pub truth: String,
    /// What differs.
    pub differences: Vec<Difference>,
}

impl Replayed {
    /// Pairs compared trial by trial; `total` is the number of trials of the file.
    pub fn each(pairs: &[Pair], total: usize) -> Self {
        let changed = pairs.iter().map(|pair| Changed {
            trial: pair.recorded.trial,
            truth: format!("{}: {}", pair.recorded.kind, pair.recorded.truth()),
            differences: differences(&pair.recorded, &pair.replayed),
        });
        let changed = changed.filter(|one| !one.differences.is_empty()).collect();
        Self::Each { trials: pairs.len(), total, changed }
    }

    /// Whether nothing differs, or no score is worse.
    pub fn is_good(&self) -> bool {
        match self {
            Self::Each { changed, .. } => changed.is_empty(),
            Self::Summary { summary, .. } => !summary.is_worse(),
        }
    }
}

/// For programs.
pub fn json(replayed: &Replayed) -> Value {
    match replayed {
        Replayed::Each { trials, total, changed } => json!({
            "recorded": total,
            "replayed": trials,
            "equal": trials - changed.len(),
            "changed": changed.iter().map(|one| json!({
                "trial": one.trial,
                "truth": one.truth,
                "differences": one.differences.iter().map(|one| json!({
                    "field": one.field,
                    "recorded": one.recorded,
                    "replayed": one.replayed,
                })).collect::<Vec<_>>(),
            })).collect::<Vec<_>>(),
        }),
        Replayed::Summary { summary, total } => json!({
            "recorded": total,
            "replayed": summary.trials,
            "other_trials": summary.other,
            "rates": summary.rates.iter().map(rate).collect::<Vec<_>>(),
            "scores": summary.means.iter().map(mean).collect::<Vec<_>>(),
            "verdicts": summary.verdicts.iter().map(|(verdict, (recorded, replayed))| json!({
                "verdict": verdict,
                "recorded": recorded,
                "replayed": replayed,
            })).collect::<Vec<_>>(),
            "worse": summary.is_worse(),
        }),
    }
}

fn rate(one: &Rate) -> Value {
    json!({
        "name": one.name,
        "recorded": number(one.recorded.rate()),
        "replayed": number(one.replayed.rate()),
        "lost": one.lost,
        "gained": one.gained,
        "p": number(Some(one.p)),
        "trials": one.recorded.trials,
        "worse": one.is_worse(),
    })
}

fn mean(one: &Mean) -> Value {
    json!({
        "name": one.name,
        "recorded": number(Some(one.recorded)),
        "replayed": number(Some(one.replayed)),
        "bound": number(Some(one.bound)),
        "trials": one.trials,
        "worse": one.is_worse(),
    })
}
