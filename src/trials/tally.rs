//! The score: rates by kind, effect and size, each with its bound, and how honest probabilities and
//! shrinkage are.

pub mod mixtures;

use std::collections::BTreeMap;

use super::bound::Count;
use super::outcome::Outcome;
use crate::statistics::upper_median;
use mixtures::Mixtures;

/// Sizes drawn from a range are put together between these.
const BANDS: [f64; 9] = [2.0, 4.0, 6.0, 8.0, 12.0, 18.0, 25.0, 50.0, 100.0];
/// Bins of the calibration error, each with as many trials as any other.
const BINS: usize = 10;
/// Shrinkage is judged from this size.
const LEAST_LAMBDA: f64 = 12.0;

/// Trials of a kind, an effect and a size.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// The word of the kind.
    pub kind: String,
    /// Whether the effects have forms that the library lacks; `None` for both together.
    pub own_form: Option<bool>,
    /// What was put in; `None` for all together.
    pub effect: Option<String>,
    /// Its size; the middle of a range.
    pub lambda: f64,
    /// The range, where sizes were drawn.
    pub band: Option<(f64, f64)>,
    /// Verdict other than adequate.
    pub detected: Count,
    /// What is true is among the named effects.
    pub declared: Count,
    /// It is the first of the candidates.
    pub top1: Count,
    /// It is among the first three.
    pub top3: Count,
    /// Verdict unknown.
    pub unknown: Count,
    /// Exactly what is true is said.
    pub exact: Count,
}

impl Cell {
    fn add(&mut self, one: &Outcome) {
        self.detected.add(one.is_diagnosed() && one.verdict != "adequate");
        self.declared.add(one.declared);
        self.top1.add(one.rank == Some(1));
        self.top3.add(one.rank.is_some_and(|rank| rank <= 3));
        self.unknown.add(one.verdict == "unknown");
        self.exact.add(one.is_exact());
    }
}

/// What was put in against what was said.
#[derive(Clone, Debug, PartialEq)]
pub struct Confusion {
    /// What was put in.
    pub truth: String,
    /// What was said: the first named effect, else the verdict.
    pub said: String,
    /// How often.
    pub trials: usize,
}

/// The score of some trials.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    /// Trials.
    pub trials: usize,
    /// By kind and size, first all effects together, then one by one.
    pub cells: Vec<Cell>,
    /// Something was declared although readings follow the model and the noise is what is stated.
    pub false_alarms: Count,
    /// An effect was declared or something unknown was seen, although only the noise is not what is
    /// stated, by kind of noise.
    pub noise_alarms: BTreeMap<String, Count>,
    /// Mean of the multi-class Brier score over the mix; `None` without it.
    pub brier: Option<f64>,
    /// Mean difference between the probability of the most probable answer and how often it is
    /// right, over `BINS` bins.
    pub calibration_error: Option<f64>,
    /// Median of the difference between the part of the gap that is said to be closed and the true
    /// one.
    pub shrinkage_error: Option<f64>,
    /// Trials in that median.
    pub shrinkages: usize,
    /// Where effects of size `LEAST_LAMBDA` and more went, those that went wrong.
    pub confusion: Vec<Confusion>,
    /// What was identified in mixtures; `None` without any.
    pub mixtures: Option<Mixtures>,
    /// Trials without diagnosis: they count as wrong, but as no false alarm.
    pub failed: usize,
}

/// Scores trials.
pub fn tally(outcomes: &[Outcome]) -> Tally {
    let mut false_alarms = Count::default();
    let mut noise_alarms: BTreeMap<String, Count> = BTreeMap::new();
    for one in outcomes {
        let is_alarm = one.is_diagnosed() && !one.exact;
        match one.kind.as_str() {
            "none" => false_alarms.add(is_alarm),
            "noise" => {
                let name = one.effects.first().cloned().unwrap_or_default();
                noise_alarms.entry(name).or_default().add(is_alarm);
            }
            _ => {}
        }
    }
    let shrinkage = shrinkage(outcomes);
    Tally {
        trials: outcomes.len(),
        cells: cells(outcomes),
        false_alarms,
        noise_alarms,
        brier: mean(outcomes.iter().filter_map(|one| one.brier)),
        calibration_error: calibration_error(outcomes.iter()),
        shrinkage_error: upper_median(&mut shrinkage.clone()),
        shrinkages: shrinkage.len(),
        confusion: confusion(outcomes),
        mixtures: mixtures::score(outcomes),
        failed: outcomes.iter().filter(|one| !one.is_diagnosed()).count(),
    }
}

/// The size by which a trial is put together with others.
fn band(one: &Outcome) -> (f64, Option<(f64, f64)>) {
    if !one.spread {
        return (one.lambda, None);
    }
    let upper = BANDS.iter().position(|edge| one.lambda < *edge).unwrap_or(BANDS.len() - 1).max(1);
    let (from, to) = (BANDS[upper - 1], BANDS[upper]);
    ((from * to).sqrt(), Some((from, to)))
}

/// What sets a cell apart: kind, form, effect (all first), size in millionths.
type Key = (String, Option<bool>, Option<String>, u64);

fn cells(outcomes: &[Outcome]) -> Vec<Cell> {
    let mut cells: BTreeMap<Key, Cell> = BTreeMap::new();
    for one in outcomes {
        let (lambda, band) = band(one);
        let effect = one.truth();
        let is_of_several = matches!(one.kind.as_str(), "two" | "mixture");
        let alone = if is_of_several || effect.is_empty() { None } else { Some(effect) };
        let has_forms = matches!(one.kind.as_str(), "one" | "two" | "withheld" | "noise");
        let own = Some(one.own_form).filter(|_| has_forms);
        let mut places = vec![(None, None), (own, None), (own, alone)];
        places.dedup();
        for (own_form, effect) in places {
            let key = (one.kind.clone(), own_form, effect.clone(), (1e6 * lambda) as u64);
            let cell = cells.entry(key).or_insert_with(|| Cell {
                kind: one.kind.clone(),
                own_form,
                effect,
                lambda,
                band,
                ..Cell::default()
            });
            cell.add(one);
        }
    }
    cells.into_values().collect()
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f64)
}

/// Mean absolute difference between confidence and success over bins of as many trials each.
pub(super) fn calibration_error<'o>(outcomes: impl Iterator<Item = &'o Outcome>) -> Option<f64> {
    let mut said: Vec<(f64, bool)> =
        outcomes.filter_map(|one| Some((one.confidence?, one.sure?))).collect();
    said.sort_by(|a, b| a.0.total_cmp(&b.0));
    let bins = BINS.min(said.len());
    let each = (0..bins).map(|bin| {
        let part = &said[bin * said.len() / bins..(bin + 1) * said.len() / bins];
        let difference: f64 =
            part.iter().map(|(sure, right)| sure - f64::from(u8::from(*right))).sum();
        difference.abs()
    });
    (bins > 0).then(|| each.sum::<f64>() / said.len() as f64)
}

/// How far the part of the gap that is said to be closed is from the truth.
fn shrinkage(outcomes: &[Outcome]) -> Vec<f64> {
    let large = outcomes.iter().filter(|one| one.lambda >= LEAST_LAMBDA);
    large.filter_map(|one| Some((one.closed? - one.closed_in_truth?).abs())).collect()
}

fn confusion(outcomes: &[Outcome]) -> Vec<Confusion> {
    let mut counts: BTreeMap<(String, String), usize> = BTreeMap::new();
    for one in outcomes.iter().filter(|one| !one.is_exact()) {
        if one.lambda >= LEAST_LAMBDA || matches!(one.kind.as_str(), "none" | "noise" | "situation")
        {
            let truth = format!("{}: {}", one.kind, one.truth());
            let said = match one.named.as_slice() {
                [] if one.verdict.is_empty() => "no diagnosis".to_owned(),
                [] => one.verdict.clone(),
                named => named.join(" + "),
            };
            *counts.entry((truth.trim_end_matches(": ").to_owned(), said)).or_default() += 1;
        }
    }
    let mut all: Vec<Confusion> = counts
        .into_iter()
        .map(|((truth, said), trials)| Confusion { truth, said, trials })
        .collect();
    all.sort_by(|a, b| b.trials.cmp(&a.trials).then_with(|| a.truth.cmp(&b.truth)));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(confidence: f64, sure: bool) -> Outcome {
        let text = r#"{"trial":0,"seed":1,"kind":"one","own_form":false,"effects":["collimation"],
            "lambda":8.0,"spread":false,"mixed":true,"verdict":"explained","named":["collimation"],
            "noise":[],"best":[],"rank":1,"declared":true,"exact":true,"brier":0.5,"confidence":0.5,
            "sure":true,"closed":0.9,"closed_in_truth":1.0,"failed":null}"#;
        let mut one: Outcome = serde_json::from_str(text).unwrap_or_else(|_| unreachable!());
        (one.confidence, one.sure) = (Some(confidence), Some(sure));
        one
    }

    #[test]
    fn calibration_is_right_where_confidence_is_the_rate() {
        let all: Vec<Outcome> = (0..100).map(|k| said(0.8, k % 5 != 0)).collect();
        let error = tally(&all).calibration_error.unwrap_or(1.0);
        assert!(error < 1e-12, "{error}");
        let all: Vec<Outcome> = (0..100).map(|_| said(0.8, true)).collect();
        let error = tally(&all).calibration_error.unwrap_or(1.0);
        assert!((error - 0.2).abs() < 1e-12, "{error}");
    }

    /// A campaign that cannot be diagnosed is a wrong answer, and no alarm.
    #[test]
    fn what_has_no_diagnosis_counts() {
        let mut without = said(0.5, false);
        (without.verdict, without.rank) = ("unobservable".to_owned(), None);
        (without.declared, without.confidence, without.sure) = (false, None, None);
        let mut failed = without.clone();
        (failed.verdict, failed.failed) = (String::new(), Some("no fit".to_owned()));
        let mut clean = without.clone();
        clean.kind = "none".to_owned();
        let found = tally(&[said(0.5, true), without, failed, clean]);
        assert_eq!((found.trials, found.failed), (4, 3));
        let of_one = found.cells.iter().find(|one| one.kind == "one").cloned().unwrap_or_default();
        let rates = [of_one.detected, of_one.top1, of_one.exact].map(|one| (one.hits, one.trials));
        assert_eq!(rates, [(1, 3); 3]);
        assert_eq!((found.false_alarms.hits, found.false_alarms.trials), (0, 1));
        assert_eq!(found.confusion.len(), 1);
    }

    #[test]
    fn cells_count_what_was_said() {
        let mut wrong = said(0.5, false);
        (wrong.rank, wrong.declared, wrong.exact) = (Some(2), false, false);
        (wrong.lambda, wrong.closed) = (20.0, Some(0.7));
        let all = [said(0.5, true), said(0.5, true), wrong];
        let found = tally(&all);
        let cell = |lambda: f64| found.cells.iter().find(|one| one.lambda == lambda).cloned();
        let small = cell(8.0).unwrap_or_default();
        assert_eq!((small.top1.hits, small.top1.trials), (2, 2));
        let large = cell(20.0).unwrap_or_default();
        assert_eq!((large.top1.hits, large.top3.hits, large.top3.trials), (0, 1, 1));
        assert_eq!(found.confusion.len(), 1);
        // Only the large one is judged by its shrinkage.
        assert!((found.shrinkage_error.unwrap_or(0.0) - 0.3).abs() < 1e-12);
        assert_eq!(found.shrinkages, 1);
    }
}
