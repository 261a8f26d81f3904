//! Recorded trials made again.

use std::collections::BTreeMap;

use crate::progress::{Progress, Task};

use super::design::Design;
use super::heading::Heading;
use super::ledger::Recorded;
use super::make;
use super::outcome::Outcome;
use super::plan::Plan;

/// Why recorded trials cannot be made again.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The plan is in no form that is known.
    #[error("its plan cannot be read")]
    Plan,
    /// It holds no trials.
    #[error("it holds no trials")]
    Empty,
    /// They are of another campaign, or effects have changed.
    #[error(
        "its trials are of another campaign or library (design {recorded}, here {present}): readings, times, noise, model or effects differ"
    )]
    Design {
        /// Stamp of the recorded design.
        recorded: String,
        /// Stamp of the present one.
        present: String,
    },
}

/// A recorded trial beside the same one made again.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// As recorded.
    pub recorded: Outcome,
    /// As it is now.
    pub replayed: Outcome,
}

/// The plan of recorded trials.
///
/// # Errors
/// Where there are none, or the plan cannot be read.
pub fn plan(recorded: &Recorded) -> Result<Plan, ReplayError> {
    let last = recorded.outcomes.last().ok_or(ReplayError::Empty)?;
    recorded.heading.plan(last.trial + 1).ok_or(ReplayError::Plan)
}

/// Whether recorded trials are of this design.
///
/// # Errors
/// Where they are not.
pub fn same_design(recorded: &Heading, present: &Heading) -> Result<(), ReplayError> {
    if recorded.design == present.design {
        return Ok(());
    }
    let [recorded, present] = [recorded, present].map(|one| one.design.clone());
    Err(ReplayError::Design { recorded, present })
}

/// At most so many of the trials, each stratum in its proportion and evenly from its first to its
/// last: the same ones each time.
pub fn sample(plan: &Plan, outcomes: &[Outcome], count: usize) -> Vec<Outcome> {
    let mut strata: BTreeMap<Option<usize>, Vec<&Outcome>> = BTreeMap::new();
    for one in outcomes {
        strata.entry(plan.stratum(one.trial)).or_default().push(one);
    }
    let all: Vec<&Outcome> = strata.into_values().flatten().collect();
    let count = count.min(all.len());
    // The middle of each of as many equal pieces.
    let at = |piece: usize| (2 * piece + 1) * all.len() / (2 * count);
    let mut found: Vec<Outcome> = (0..count).map(|piece| all[at(piece)].clone()).collect();
    found.sort_by_key(|one| one.trial);
    found
}

/// Makes recorded trials again, on so many threads; they come back in the order of the trials.
pub fn replay(
    design: &Design,
    plan: &Plan,
    recorded: Vec<Outcome>,
    threads: usize,
    progress: &Progress,
) -> Vec<Pair> {
    let trials: Vec<usize> = recorded.iter().map(|one| one.trial).collect();
    let made = make(design, plan, &trials, threads, |_, count| {
        progress.tell(Task::Trials, count as u64, trials.len() as u64);
        Ok(())
    });
    // Nothing is written, so nothing fails.
    let mut made: BTreeMap<usize, Outcome> =
        made.into_iter().flatten().map(|one| (one.trial, one)).collect();
    let pair = |recorded: Outcome| {
        let replayed = made.remove(&recorded.trial)?;
        Some(Pair { recorded, replayed })
    };
    recorded.into_iter().filter_map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trials::plan::Kind;

    fn outcomes(count: usize) -> Vec<Outcome> {
        let text = r#"{"trial":0,"seed":1,"kind":"none","own_form":false,"effects":[],
            "lambda":0.0,"spread":false,"mixed":false,"verdict":"adequate","named":[],"noise":[],
            "best":[],"rank":null,"declared":false,"exact":true,"brier":null,"confidence":null,
            "sure":null,"closed":null,"closed_in_truth":null,"failed":null}"#;
        let one: Outcome = serde_json::from_str(text).unwrap_or_else(|_| unreachable!());
        (0..count).map(|trial| Outcome { trial, ..one.clone() }).collect()
    }

    #[test]
    fn a_sample_has_every_stratum_in_its_proportion() {
        for plan in [Plan::standard(900, 3), Plan::situations(256, 3)] {
            let all = outcomes(plan.trials);
            let weight = |index: usize, of: &[Outcome]| {
                let own = of.iter().filter(|one| plan.stratum(one.trial) == Some(index));
                own.count() as f64 / of.len() as f64
            };
            for count in [32, 100] {
                let found = sample(&plan, &all, count);
                assert_eq!(found.len(), count);
                assert_eq!(found, sample(&plan, &all, count));
                for index in 0..plan.strata.len() {
                    let off = (weight(index, &found) - weight(index, &all)).abs();
                    assert!(off <= 1.0 / count as f64, "{index} of {count}: {off}");
                }
            }
            assert_eq!(sample(&plan, &all, 5000), all);
        }
    }

    #[test]
    fn a_sample_of_nothing_is_empty() {
        let plan = Plan::of(3, 1, &[Kind::None], &[]);
        assert_eq!(sample(&plan, &[], 4), []);
        assert_eq!(sample(&plan, &outcomes(3), 0), []);
    }
}
