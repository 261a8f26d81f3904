//! How far the gap shrinks: on readings that the effects were not fitted to.
//!
//! For each fold, both models, without and with the adopted effects, are fitted to everything else;
//! the drop `D = Σ (e₀² - e₁²)` is summed over the folds. Raw rms hides nearly everything, and
//! subtracting a noise floor from it is ill-conditioned; paired differences are not. The part
//! closed is `D / (D + leftover)` with the largest block of structure that is left.
//!
//! Sums are linear about the fit with the effects; the models without them differ by the effects'
//! values, which is where the linear form is good to second order.
//!
//! | file | answers |
//! |---|---|
//! | [`steps`] | the models with one effect after the other |
//! | `folds` | what is left out at a time |
//! | [`mod@holdout`] | the same on a campaign that no model was fitted to |

pub(super) mod folds;
pub mod holdout;
pub mod steps;

use nalgebra::{DMatrix, DVector};

use crate::engine::gram::{LeastSquares, Normal, PriorRow, RunGram};
use crate::engine::noise::{active_randoms, covariance_of};
use crate::estimate::calibrate::rms;

use self::folds::{Fold, folds, within_runs};
use self::steps::Steps;
use super::evidence::nominal::factored;
use super::fitted::Fitted;
use super::thresholds::BELOW_ENTRY;
use crate::statistics::student;

/// Samples looked at for the floor at most.
const MOST_SAMPLES: usize = 5_000;
/// Level of the intervals, and its normal quantile.
const LEVEL: f64 = 0.95;
const QUANTILE: f64 = 1.96;
/// Part of the effects' squared length that must show in what a fold is fitted to.
const SHOWN: f64 = 0.5;

/// What one effect contributes, after those before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The effect.
    pub effect: String,
    /// rms of the residuals of each measurand with it (SI).
    pub rms: Vec<(String, f64)>,
    /// Drop of the sum of squares that it brings on readings that were not fitted to.
    pub held_out_drop: f64,
}

/// The gap before and after.
#[derive(Clone, Debug)]
pub struct Gap {
    /// The campaign on which it is judged, if that is another one than was fitted.
    pub held_out: Option<String>,
    /// rms of the residuals of each measurand without the effects (SI).
    pub before: Vec<(String, f64)>,
    /// The same with them.
    pub after: Vec<(String, f64)>,
    /// What each of them contributes, in the order of adoption.
    pub steps: Vec<Step>,
    /// What noise alone gives.
    pub floor: Vec<(String, f64)>,
    /// Length of what the effects explain, in units of the noise.
    pub lambda: f64,
    /// Drop of the sum of squares on readings that the effects were not fitted to.
    pub held_out_drop: f64,
    /// Squared length of the largest structure that is left.
    pub leftover: f64,
    /// Part of the gap that is closed; `None` where the evidence lies in prior values.
    pub closed: Option<f64>,
    /// Its interval (95 %).
    pub closed_interval: Option<[f64; 2]>,
    /// Number of folds.
    pub folds: usize,
    /// Readings of a held-out campaign that are left out of the comparison: lost or gross.
    pub left_out: usize,
}

/// Part of the gap that is closed below which readings contradict what was named.
const BORNE_OUT: f64 = 0.25;

/// Held-out readings that are missed by so many times their noise, all of them, are of something
/// else.
const MISSED: f64 = 10.0;

impl Gap {
    /// Whether the readings may close so much of the gap that they do not contradict what was
    /// named; `None` where the evidence lies in prior values, and where they can judge nothing.
    pub fn is_borne_out(&self) -> Option<bool> {
        let most = self.closed_interval?[1];
        (most >= BORNE_OUT || self.missed().is_none()).then_some(most >= BORNE_OUT)
    }

    /// How many times its noise a held-out campaign is missed, with and without what was named,
    /// where that is so much that it is of something else: another rig, or values that are held
    /// wrongly.
    pub fn missed(&self) -> Option<f64> {
        let times = |rms: &[(String, f64)]| {
            let noise = |name: &str| self.floor.iter().find(|one| one.0 == name);
            let each = rms.iter().filter_map(|(name, rms)| Some(rms / noise(name)?.1));
            each.fold(f64::INFINITY, f64::min)
        };
        let least = times(&self.before).min(times(&self.after));
        (self.held_out.is_some() && least.is_finite() && least >= MISSED).then_some(least)
    }
}

/// What effects take off the sum of squares of one fold, which they were not fitted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drop {
    /// So much.
    pub taken: f64,
    /// Squared length of what they do there.
    pub length: f64,
}

/// The sum of what is taken off.
pub fn taken(drops: &[Drop]) -> f64 {
    drops.iter().map(|one| one.taken).sum()
}

/// Drops by fold, with what is left, as parts closed. Folds differ in how much of the effects they
/// see: it is the ratio of what is taken off to that by which they are compared, and noise alone
/// makes a drop uncertain by twice its root.
pub fn closed(drops: &[Drop], leftover: f64) -> (f64, [f64; 2]) {
    let total = taken(drops);
    let length: f64 = drops.iter().map(|one| one.length).sum();
    let ratio = if length > 0.0 { total / length } else { 0.0 };
    let scatter: f64 = drops.iter().map(|one| (one.taken - ratio * one.length).powi(2)).sum();
    let count = drops.len() as f64;
    let of_noise = QUANTILE * 2.0 * total.max(0.0).sqrt();
    let spread = if drops.len() > 1 {
        (student(LEVEL, count - 1.0) * (scatter * count / (count - 1.0)).sqrt()).max(of_noise)
    } else {
        of_noise
    };
    // What is not seen may be as large as what just does not enter.
    let most =
        leftover + if leftover > 0.0 { QUANTILE * 2.0 * leftover.sqrt() } else { BELOW_ENTRY };
    let least = (leftover - QUANTILE * 2.0 * leftover.sqrt()).max(0.0);
    let part = |drop: f64, left: f64| {
        let drop = drop.max(0.0);
        if drop + left > 0.0 { drop / (drop + left) } else { 0.0 }
    };
    (part(total, leftover), [part(total - spread, most), part(total + spread, least)])
}

/// The gap of a model with its adopted effects against the same without them.
/// The effects have so many `degrees` of freedom that the readings determine.
pub fn gap(models: &Steps, degrees: usize, leftover: f64, memory: f64, in_data: bool) -> Gap {
    let (before, after) = (&models.nominal, models.last());
    let drops = drops(before, after, memory);
    let mut steps: Vec<Step> = Vec::new();
    let mut last = before;
    for (effect, fitted) in &models.with {
        let held_out_drop = if models.with.len() == 1 {
            taken(&drops)
        } else {
            taken(&self::drops(last, fitted, memory))
        };
        let rms = rms(&fitted.problem, &fitted.fit.point);
        steps.push(Step { effect: effect.clone(), rms, held_out_drop });
        last = fitted;
    }
    let (part, interval) = closed(&drops, leftover);
    let gain = before.cost() - after.cost();
    Gap {
        held_out: None,
        before: rms(&before.problem, &before.fit.point),
        after: rms(&after.problem, &after.fit.point),
        steps,
        floor: floor(after),
        lambda: (gain - degrees as f64).max(0.0).sqrt(),
        held_out_drop: taken(&drops),
        leftover,
        closed: in_data.then_some(part),
        closed_interval: in_data.then_some(interval),
        folds: drops.len(),
        left_out: 0,
    }
}

/// rms that the noise alone gives, by measurand.
pub fn floor(fitted: &Fitted) -> Vec<(String, f64)> {
    let mut sums: Vec<(String, f64, f64)> = Vec::new();
    let problem = &fitted.problem;
    for (p, part) in problem.parts.iter().enumerate() {
        let samples: usize = part.runs.iter().map(|run| run.record.len()).sum();
        let stride = samples.div_ceil(MOST_SAMPLES).max(1);
        let active = active_randoms(part);
        let mut memory = Vec::new();
        for (run, data) in part.runs.iter().enumerate() {
            let parameters = problem.parameters(p, run, &fitted.fit.point);
            data.record.walk(|stretch| {
                for sample in stretch.each().filter(|sample| sample.number % stride == 0) {
                    let made = covariance_of(part, run, sample, &parameters, &active, &mut memory);
                    let names = &part.system.assembly.names.measurands;
                    let all = names.iter().zip(part.slots());
                    for (measurand, slot) in all.filter(|(_, slot)| part.is_present(sample, slot)) {
                        let rows = slot.residual..slot.residual + slot.components;
                        let variance: f64 = rows.map(|row| made.covariance[(row, row)]).sum();
                        match sums.iter_mut().find(|(name, ..)| *name == measurand.name) {
                            Some((_, sum, count)) => {
                                *sum += variance;
                                *count += 1.0;
                            }
                            None => sums.push((measurand.name.clone(), variance, 1.0)),
                        }
                    }
                }
            });
        }
    }
    sums.into_iter().map(|(name, sum, count)| (name, (sum / count).sqrt())).collect()
}

/// The drop of each fold. Where the effects hardly show without what some fold leaves out, say for
/// they act in one run, every run is judged between the stretches that it is fitted to.
pub fn drops(before: &Fitted, after: &Fitted, memory: f64) -> Vec<Drop> {
    let Some(off) = switched_off(before, after) else { return Vec::new() };
    let normal = after.problem.normal(&after.fit.point);
    let whole = squared_length(&normal, &normal.runs, &off);
    let shows = |fold: &Fold| squared_length(&normal, &fold.training, &off) >= SHOWN * whole;
    let mut folds = folds(after, &normal, memory);
    if !folds.iter().all(shows) {
        folds = within_runs(after, &normal);
    }
    folds.iter().filter_map(|fold| drop_of(&normal, fold, &off)).collect()
}

/// The columns of the nominal model.
fn nominal_columns(off: &[Option<f64>]) -> Vec<usize> {
    (0..off.len()).filter(|column| off[*column].is_none()).collect()
}

/// The step that switches the effects off, nominal columns held.
fn held(off: &[Option<f64>]) -> DVector<f64> {
    DVector::from_iterator(off.len(), off.iter().map(|step| step.unwrap_or(0.0)))
}

/// Squared length of what the effects do in some sums, beyond what nominal parameters follow.
fn squared_length(normal: &Normal, runs: &[RunGram], off: &[Option<f64>]) -> f64 {
    let (hessian, _) = sums(normal, runs);
    let whole = &hessian * held(off);
    let followed = solve(&hessian, &whole, &nominal_columns(off)).unwrap_or(held(off));
    held(off).dot(&whole) - followed.dot(&whole)
}

/// For each column of the model with the effects the step that switches them off; `None` for
/// nominal columns.
fn switched_off(before: &Fitted, after: &Fitted) -> Option<Vec<Option<f64>>> {
    let layout = &after.problem.layout;
    let mut step = vec![None; layout.columns.len()];
    for (index, instance) in layout.instances.iter().enumerate() {
        let known = before.problem.layout.instances.iter().any(|one| one.name == instance.name);
        if known {
            continue;
        }
        // A turn is undone along its own axis: its tangent there is its rotation vector.
        let values = after.fit.point.components(layout, index);
        for (component, column) in layout.own_columns(index) {
            step[column] = Some(-values[component]);
        }
        // Values that sum to zero share columns: orthonormal, so a column is the sum over its
        // values.
        if !layout.is_free(index) {
            for (component, value) in values.iter().enumerate() {
                for (column, by) in layout.columns_of(index, component) {
                    let value = -by * value;
                    step[column] = Some(step[column].unwrap_or(0.0) + value);
                }
            }
        }
    }
    step.iter().any(Option::is_some).then_some(step)
}

/// `e₀² - e₁²` of one fold: of what the rest does not determine effects stay off.
fn drop_of(normal: &Normal, fold: &Fold, off: &[Option<f64>]) -> Option<Drop> {
    let (hessian, gradient) = sums(normal, &fold.training);
    let held = held(off);
    let all: Vec<usize> = (0..off.len()).collect();
    let left = gradient - &hessian * &held;
    let with = solve(&hessian, &left, &all)? + &held;
    let without = solve(&hessian, &left, &nominal_columns(off))? + held;
    let squares = |step: &DVector<f64>, of_readings: f64| -> f64 {
        fold.judged
            .iter()
            .map(|(run, sums)| {
                let touched = normal.columns.touched_by(*run);
                let last = touched.len();
                let mut move_by = DVector::zeros(last + 1);
                for (place, column) in touched.iter().enumerate() {
                    move_by[place] = -step[*column];
                }
                move_by[last] = of_readings;
                move_by.dot(&(&sums.gram * &move_by))
            })
            .sum()
    };
    let taken = squares(&without, 1.0) - squares(&with, 1.0);
    Some(Drop { taken, length: squares(&(with - without), 0.0) })
}

/// The normal matrix and gradient of some sums with all priors.
fn sums(normal: &Normal, runs: &[RunGram]) -> (DMatrix<f64>, DVector<f64>) {
    let n = normal.columns.len();
    let mut hessian = DMatrix::zeros(n, n);
    let mut gradient = DVector::zeros(n);
    for (run, sums) in runs.iter().enumerate() {
        let touched = normal.columns.touched_by(run);
        let last = touched.len();
        for (i, a) in touched.iter().enumerate() {
            gradient[*a] += sums.gram[(i, last)];
            for (j, b) in touched.iter().enumerate() {
                hessian[(*a, *b)] += sums.gram[(i, j)];
            }
        }
    }
    for PriorRow { coefficients, residual } in &normal.priors {
        for (a, x) in coefficients {
            gradient[*a] += x * residual;
            for (b, y) in coefficients {
                hessian[(*a, *b)] += x * y;
            }
        }
    }
    (hessian, gradient)
}

/// The step along some columns; what the sums do not determine stays.
fn solve(hessian: &DMatrix<f64>, gradient: &DVector<f64>, along: &[usize]) -> Option<DVector<f64>> {
    let own = DMatrix::from_fn(along.len(), along.len(), |i, j| hessian[(along[i], along[j])]);
    let (factor, length) = factored(&own)?;
    let right = DVector::from_fn(along.len(), |i, _| gradient[along[i]] / length[i]);
    let found = factor.solve(&right);
    let mut step = DVector::zeros(hessian.nrows());
    for (k, column) in along.iter().enumerate() {
        step[*column] = found[k] / length[k];
    }
    Some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_lowers_the_part_closed() {
        let alike = |all: &[f64]| -> Vec<Drop> {
            all.iter().map(|taken| Drop { taken: *taken, length: 100.0 }).collect()
        };
        let (part, [low, high]) = closed(&alike(&[100.0, 120.0, 80.0, 100.0]), 100.0);
        assert!((part - 0.8).abs() < 1e-12);
        assert!(low < part && part < high && high <= 1.0);
        let (part, [low, _]) = closed(&alike(&[100.0; 4]), 0.0);
        assert_eq!(part, 1.0);
        // 400, less twice its root by 1.96, against the 25 that would not be declared.
        let least = 400.0 - 1.96 * 2.0 * 20.0;
        assert!((low - least / (least + 25.0)).abs() < 1e-12);
        assert_eq!(closed(&alike(&[-3.0, 1.0]), 0.0).0, 0.0);
    }

    #[test]
    fn folds_without_the_effect_say_nothing_of_it() {
        let one = |taken, length| Drop { taken, length };
        let (part, [low, _]) = closed(&[one(900.0, 900.0), one(0.5, 0.0), one(-0.5, 0.0)], 0.0);
        assert!(part > 0.99 && low > 0.95, "{part} {low}");
        // Two that should see as much, of which one does not.
        let (_, [low, _]) = closed(&[one(900.0, 900.0), one(0.0, 900.0)], 0.0);
        assert_eq!(low, 0.0);
    }

    #[test]
    fn a_campaign_that_is_missed_by_far_whatever_is_named_refutes_nothing() {
        let of = |rms: f64| vec![("distance".to_owned(), rms), ("vertical".to_owned(), 2.0 * rms)];
        let gap = |held_out: Option<&str>, after: f64, most: f64| Gap {
            held_out: held_out.map(str::to_owned),
            before: of(1.0),
            after: of(after),
            steps: Vec::new(),
            floor: of(0.01),
            lambda: 0.0,
            held_out_drop: 0.0,
            leftover: 0.0,
            closed: Some(most),
            closed_interval: Some([0.0, most]),
            folds: 1,
            left_out: 0,
        };
        let far = gap(Some("other"), 0.9, 0.0);
        assert_eq!(far.is_borne_out(), None);
        assert!((far.missed().unwrap_or(0.0) - 90.0).abs() < 1e-9);
        // What closes it is borne out; what leaves no more than noise there is judged; folds of the
        // campaign itself always are.
        assert_eq!(gap(Some("other"), 0.5, 0.9).is_borne_out(), Some(true));
        assert_eq!(gap(Some("other"), 0.01, 0.0).is_borne_out(), Some(false));
        assert_eq!(gap(None, 0.9, 0.0).is_borne_out(), Some(false));
    }
}
