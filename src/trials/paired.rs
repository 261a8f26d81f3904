//! Scores of the same trials, recorded and replayed, side by side: for a diagnosis that has changed.
//!
//! A rate is worse where McNemar's exact test says so (Psychometrika 12, 1947): of `n` trials of
//! which only one side is right, more than chance gives at [`LEVEL`] are right as recorded alone. A
//! mean is worse where the differences of the pairs are above zero by a one-sided t test at that
//! level. The calibration error, which no single trial has, is worse where it rises by more than
//! its uncertainty (a jackknife over [`GROUPS`] groups of trials) times that test's factor.
//!
//! Verdicts are counted by their words, whatever these are.

use std::collections::BTreeMap;

use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, StudentsT};

use super::bound::Count;
use super::outcome::Outcome;
use super::replay::Pair;
use super::tally::calibration_error;

/// Probability of calling unchanged scores worse.
pub const LEVEL: f64 = 0.01;
/// Groups of the jackknife.
pub const GROUPS: usize = 20;

/// A rate on both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Rate {
    /// What is counted.
    pub name: String,
    /// As recorded.
    pub recorded: Count,
    /// As replayed.
    pub replayed: Count,
    /// Trials that are right as recorded alone.
    pub lost: usize,
    /// Trials that are right as replayed alone.
    pub gained: usize,
    /// Probability of so many lost ones, or more, if both sides are alike.
    pub p: f64,
}

impl Rate {
    /// Whether it is worse than recorded, beyond chance.
    pub fn is_worse(&self) -> bool {
        self.p < LEVEL
    }
}

/// A score without hits on both sides; less is better.
#[derive(Clone, Debug, PartialEq)]
pub struct Mean {
    /// What it is.
    pub name: &'static str,
    /// As recorded.
    pub recorded: f64,
    /// As replayed.
    pub replayed: f64,
    /// The most that it may rise.
    pub bound: f64,
    /// Trials that it is of.
    pub trials: usize,
}

impl Mean {
    /// Whether it is worse than recorded, beyond its bound.
    pub fn is_worse(&self) -> bool {
        self.replayed - self.recorded > self.bound
    }
}

/// Scores side by side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Trials that both sides have.
    pub trials: usize,
    /// Trials that are other ones now: what was put in differs. They count nowhere.
    pub other: usize,
    /// Rates; more is better.
    pub rates: Vec<Rate>,
    /// Scores; less is better.
    pub means: Vec<Mean>,
    /// How often each verdict was given: recorded, replayed.
    pub verdicts: BTreeMap<String, (usize, usize)>,
}

impl Summary {
    /// Whether some score is worse than recorded.
    pub fn is_worse(&self) -> bool {
        self.rates.iter().any(Rate::is_worse) || self.means.iter().any(Mean::is_worse)
    }
}

/// Compares the scores of pairs.
pub fn compare(pairs: &[Pair]) -> Summary {
    let is_same =
        |pair: &&Pair| super::difference::truth(&pair.recorded, &pair.replayed).is_empty();
    let same: Vec<&Pair> = pairs.iter().filter(is_same).collect();
    let mut verdicts: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for pair in &same {
        verdicts.entry(word(&pair.recorded)).or_default().0 += 1;
        verdicts.entry(word(&pair.replayed)).or_default().1 += 1;
    }
    Summary {
        trials: same.len(),
        other: pairs.len() - same.len(),
        rates: rates(&same),
        means: brier(&same).into_iter().chain(calibration(&same)).collect(),
        verdicts,
    }
}

fn word(one: &Outcome) -> String {
    if one.verdict.is_empty() { "no diagnosis".to_owned() } else { one.verdict.clone() }
}

/// What is counted of an outcome: name, and whether it is right, of each chance it has.
fn counted(one: &Outcome) -> Vec<(String, bool)> {
    let kind = &one.kind;
    let mut all = Vec::new();
    match kind.as_str() {
        "none" | "noise" => {
            // Without a diagnosis there is no alarm.
            all.push((format!("{kind}: no false alarm"), !one.is_diagnosed() || one.exact));
        }
        "withheld" => all.push((format!("{kind}: unknown"), one.verdict == "unknown")),
        "one" | "two" | "mixture" => all.push((format!("{kind}: all named"), one.declared)),
        _ => {}
    }
    all.push((format!("{kind}: exact"), one.is_exact()));
    if let Some(mixture) = &one.mixture {
        let named = mixture.identified.iter().enumerate();
        all.extend(named.map(|(effect, is)| (format!("{kind}: effect {effect} named"), *is)));
        let is_clean = mixture.right.iter().all(|is| *is);
        all.push((format!("{kind}: no wrong name"), is_clean));
        if mixture.outside > 0 {
            all.push((format!("{kind}: remainder seen"), mixture.remainder));
        }
    }
    all.push(("has a diagnosis".to_owned(), one.is_diagnosed()));
    all
}

fn rates(pairs: &[&Pair]) -> Vec<Rate> {
    let mut all: BTreeMap<String, [usize; 4]> = BTreeMap::new();
    for pair in pairs {
        let both = counted(&pair.recorded).into_iter().zip(counted(&pair.replayed));
        for ((name, before), (_, after)) in both {
            // Effects of a mixture count together.
            let is_effect = name.contains(": effect ");
            let name = if is_effect { "mixture: effects named".to_owned() } else { name };
            let cell = usize::from(before) * 2 + usize::from(after);
            all.entry(name).or_default()[cell] += 1;
        }
    }
    let rate = |(name, [neither, gained, lost, both]): (String, [usize; 4])| {
        let trials = neither + gained + lost + both;
        let count = |hits| Count { hits, trials };
        let p = at_least(lost, lost + gained);
        let (recorded, replayed) = (count(both + lost), count(both + gained));
        Rate { name, recorded, replayed, lost, gained, p }
    };
    all.into_iter().map(rate).collect()
}

/// The probability of so many heads or more in some throws of a coin.
fn at_least(heads: usize, throws: usize) -> f64 {
    let coin = Binomial::new(0.5, throws as u64).ok();
    match (coin, heads) {
        (Some(coin), 1..) => coin.sf(heads as u64 - 1),
        _ => 1.0,
    }
}

/// The factor of the one-sided t test.
fn factor(degrees: usize) -> f64 {
    let t = StudentsT::new(0.0, 1.0, degrees.max(1) as f64);
    t.map_or(f64::INFINITY, |t| t.inverse_cdf(1.0 - LEVEL))
}

fn brier(pairs: &[&Pair]) -> Option<Mean> {
    let both = pairs.iter().filter_map(|pair| Some((pair.recorded.brier?, pair.replayed.brier?)));
    let both: Vec<(f64, f64)> = both.collect();
    let n = both.len() as f64;
    if both.len() < 2 {
        return None;
    }
    let recorded = both.iter().map(|one| one.0).sum::<f64>() / n;
    let replayed = both.iter().map(|one| one.1).sum::<f64>() / n;
    let rise = replayed - recorded;
    let squares: f64 = both.iter().map(|(a, b)| (b - a - rise).powi(2)).sum();
    let bound = factor(both.len() - 1) * (squares / (n - 1.0) / n).sqrt();
    Some(Mean { name: "Brier score", recorded, replayed, bound, trials: both.len() })
}

fn calibration(pairs: &[&Pair]) -> Option<Mean> {
    let has = |one: &Outcome| one.confidence.is_some() && one.sure.is_some();
    let own: Vec<&&Pair> =
        pairs.iter().filter(|pair| has(&pair.recorded) && has(&pair.replayed)).collect();
    if own.len() < GROUPS {
        return None;
    }
    let error = |without: Option<usize>| {
        let part = own.iter().enumerate().filter(|(k, _)| Some(k % GROUPS) != without);
        let part: Vec<&Pair> = part.map(|(_, pair)| **pair).collect();
        let recorded = calibration_error(part.iter().map(|pair| &pair.recorded))?;
        let replayed = calibration_error(part.iter().map(|pair| &pair.replayed))?;
        Some((recorded, replayed))
    };
    let (recorded, replayed) = error(None)?;
    let rises: Vec<f64> =
        (0..GROUPS).filter_map(|group| error(Some(group))).map(|(a, b)| b - a).collect();
    let n = rises.len() as f64;
    let mean = rises.iter().sum::<f64>() / n;
    let squares: f64 = rises.iter().map(|rise| (rise - mean).powi(2)).sum();
    let bound = factor(GROUPS - 1) * (squares * (n - 1.0) / n).sqrt();
    Some(Mean { name: "calibration error", recorded, replayed, bound, trials: own.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(trial: usize, change: impl Fn(&mut Outcome, &mut Outcome)) -> Pair {
        let text = r#"{"trial":0,"seed":1,"kind":"one","own_form":false,"effects":["collimation"],
            "lambda":8.0,"spread":false,"mixed":true,"verdict":"explained","named":["collimation"],
            "noise":[],"best":[],"rank":1,"declared":true,"exact":true,"brier":0.2,"confidence":0.9,
            "sure":true,"closed":0.9,"closed_in_truth":1.0,"failed":null}"#;
        let mut recorded: Outcome = serde_json::from_str(text).unwrap_or_else(|_| unreachable!());
        recorded.trial = trial;
        let mut replayed = recorded.clone();
        change(&mut recorded, &mut replayed);
        Pair { recorded, replayed }
    }

    #[test]
    fn equal_scores_are_not_worse() {
        let pairs: Vec<Pair> = (0..60).map(|k| pair(k, |_, _| ())).collect();
        let summary = compare(&pairs);
        assert!(!summary.is_worse(), "{summary:?}");
        assert_eq!((summary.trials, summary.other, summary.means.len()), (60, 0, 2));
    }

    /// Six of six lost is 1/64 by chance, seven of seven 1/128.
    #[test]
    fn a_rate_is_worse_from_seven_lost_trials_on() {
        for (lost, is_worse) in [(6, false), (7, true)] {
            let pairs: Vec<Pair> = (0..60)
                .map(|k| {
                    pair(k, |_, replayed| {
                        (replayed.exact, replayed.declared) = (k >= lost, k >= lost);
                    })
                })
                .collect();
            let summary = compare(&pairs);
            assert_eq!(summary.is_worse(), is_worse, "{lost}: {:?}", summary.rates);
            let exact = summary.rates.iter().find(|one| one.name == "one: exact").cloned();
            let p = exact.map_or(0.0, |one| one.p);
            assert!((p - 0.5_f64.powi(lost as i32)).abs() < 1e-9, "{p}");
        }
    }

    #[test]
    fn probabilities_that_get_worse_are_seen() {
        // Each a little worse: beyond the scatter of the differences.
        let pairs: Vec<Pair> = (0..60)
            .map(|k| {
                pair(k, |_, replayed| {
                    replayed.brier = Some(0.25 + 0.001 * (k % 5) as f64);
                    replayed.confidence = Some(0.6);
                })
            })
            .collect();
        let worse: Vec<bool> = compare(&pairs).means.iter().map(Mean::is_worse).collect();
        assert_eq!(worse, [true, true]);
        // One far worse among many equal ones may be chance.
        let pairs: Vec<Pair> = (0..60)
            .map(|k| pair(k, |_, replayed| replayed.brier = Some(if k == 0 { 1.5 } else { 0.2 })))
            .collect();
        assert!(!compare(&pairs).means[0].is_worse());
    }

    #[test]
    fn new_verdicts_are_counted_and_other_trials_left_out() {
        let new = |k| pair(k, |_, replayed| replayed.verdict = "partly_explained".to_owned());
        let other = pair(9, |_, replayed| replayed.effects = vec!["beam_offset".to_owned()]);
        let summary = compare(&[new(0), new(1), other]);
        assert_eq!((summary.trials, summary.other), (2, 1));
        assert_eq!(summary.verdicts["partly_explained"], (0, 2));
        assert_eq!(summary.verdicts["explained"], (2, 0));
    }
}
