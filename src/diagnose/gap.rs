//! How far the gap shrinks: on readings that the effects were not fitted to.
//!
//! Both models, without and with the adopted effects, predict readings that they were not fitted
//! to; the drop `D = Σ (e₀² - e₁²)` is summed over these. Raw rms hides nearly everything, and
//! subtracting a noise floor from it is ill-conditioned; paired differences are not. The part
//! closed is `D / (D + leftover)` with the structure that is left.
//!
//! Which readings are held out is not its business: drops come from the budget, or from
//! [`mod@holdout`], which judges the gap of a campaign that no model was fitted to.

pub mod holdout;

use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::rms;
use crate::statistics::student;
use crate::system::Selected;

use super::fitted::Fitted;
use super::thresholds::{BELOW_ENTRY, HELD_OUT};

/// Level of the intervals, and its normal quantile.
const LEVEL: f64 = 0.95;
const QUANTILE: f64 = 1.96;

/// Models from the nominal one to the one with every row.
#[derive(Clone, Debug)]
pub struct Steps {
    /// Without the effects.
    pub nominal: Fitted,
    /// Each effect with the model that has it and those before it.
    pub with: Vec<(String, Fitted)>,
}

impl Steps {
    /// Those of a model in which some effects are rows, in this order.
    pub fn of(whole: &Fitted, effects: &[Selected], options: &Options) -> Result<Self, FitError> {
        let selected: Vec<&Selected> = effects.iter().collect();
        let upto = |count: usize| match &selected[count..] {
            [] => Ok(whole.clone()),
            later => whole.without(later, options),
        };
        let with =
            effects.iter().enumerate().map(|(number, one)| Ok((one.name(), upto(number + 1)?)));
        Ok(Self { nominal: upto(0)?, with: with.collect::<Result<_, FitError>>()? })
    }

    /// With every effect.
    pub fn last(&self) -> &Fitted {
        self.with.last().map_or(&self.nominal, |(_, fitted)| fitted)
    }
}

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
#[derive(Clone, Debug, Default)]
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
    /// Part of the gap that is closed.
    pub closed: f64,
    /// Its interval (95 %).
    pub closed_interval: [f64; 2],
    /// Number of runs, or stretches of runs, that were held out.
    pub folds: usize,
    /// Readings of a held-out campaign that are left out of the comparison: lost or outliers.
    pub left_out: usize,
}

/// Part of the gap that is closed below which readings contradict what was named.
const BORNE_OUT: f64 = 0.25;

/// A drop of so many times what effects take off when they are fitted is that of an extrapolation.
const EXTRAPOLATED: f64 = 2.0;

/// Where all measurands are missed by so many times their noise, they are of something else.
const MISSED: f64 = 10.0;

impl Gap {
    /// Of the model with all effects, the drops that they bring in each fold, and what is left;
    /// without steps, as if nothing had been before.
    fn of(after: &Fitted, drops: &[Drop], leftover: f64) -> Self {
        let (closed, closed_interval) = closed(drops, leftover);
        let after_rms = rms(&after.problem, &after.fit.point);
        Self {
            before: after_rms.clone(),
            after: after_rms,
            floor: after.problem.noise_rms(&after.fit.point),
            held_out_drop: taken(drops),
            leftover,
            closed,
            closed_interval,
            folds: drops.len(),
            ..Self::default()
        }
    }

    /// Whether the readings may close so much of the gap that they do not contradict what was
    /// named; `None` where they can judge nothing.
    pub fn is_borne_out(&self) -> Option<bool> {
        // Beside a large remainder a small part of the gap may be closed for certain.
        let is_certain = self.held_out.is_none() && self.held_out_drop >= HELD_OUT;
        let is_borne_out = is_certain || self.closed_interval[1] >= BORNE_OUT;
        (is_borne_out || self.missed().is_none()).then_some(is_borne_out)
    }

    /// How many times its noise a held-out campaign is missed, with and without what was named, where
    /// it is that of something else: of another rig, or with values that are held wrongly.
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

/// Drops, those of effects that take off so much when they are fitted where they are larger by far: a model
/// without them may extrapolate to readings that it was not fitted to by any distance, which is no gap of the
/// campaign.
fn of_the_gap(drops: &[Drop], gain: f64) -> Vec<Drop> {
    let (taken, gain) = (taken(drops), gain.max(0.0));
    let factor = if taken > EXTRAPOLATED * gain { gain / taken } else { 1.0 };
    drops.iter().map(|one| Drop { taken: factor * one.taken, ..*one }).collect()
}

/// The gap of a model with its adopted effects, which have so many `degrees` of freedom that the readings
/// determine, against the same without them: from the drops by the first of them, the first two, ...
pub fn gap(models: &Steps, drops: &[Vec<Drop>], degrees: usize, leftover: f64) -> Gap {
    let (before, after) = (&models.nominal, models.last());
    let gain = before.fit.cost - after.fit.cost;
    let drops: Vec<Vec<Drop>> = drops.iter().map(|one| of_the_gap(one, gain)).collect();
    let mut known = 0.0;
    let steps = models.with.iter().zip(&drops).map(|((effect, fitted), drops)| {
        let rms = rms(&fitted.problem, &fitted.fit.point);
        let held_out_drop = taken(drops) - known;
        known += held_out_drop;
        Step { effect: effect.clone(), rms, held_out_drop }
    });
    let steps = steps.collect();
    let drops = drops.last().map_or(&[][..], Vec::as_slice);
    Gap {
        before: rms(&before.problem, &before.fit.point),
        steps,
        lambda: (gain - degrees as f64).max(0.0).sqrt(),
        ..Gap::of(after, drops, leftover)
    }
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
    fn what_a_model_extrapolates_to_is_no_gap() {
        let drops = [Drop { taken: 9e5, length: 50.0 }, Drop { taken: 140.0, length: 50.0 }];
        assert!((taken(&of_the_gap(&drops, 100.0)) - 100.0).abs() < 1e-9);
        assert_eq!(of_the_gap(&drops[1..], 100.0), drops[1..]);
        let none = [Drop { taken: -3.0, length: 50.0 }];
        assert_eq!(of_the_gap(&none, -1.0), none);
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
            floor: of(0.01),
            closed: most,
            closed_interval: [0.0, most],
            folds: 1,
            ..Gap::default()
        };
        let far = gap(Some("other"), 0.9, 0.0);
        assert_eq!(far.is_borne_out(), None);
        assert!((far.missed().unwrap_or(0.0) - 90.0).abs() < 1e-9);
        // What closes it is borne out; what leaves no more than noise there is judged; folds of the
        // campaign itself always are.
        assert_eq!(gap(Some("other"), 0.5, 0.9).is_borne_out(), Some(true));
        assert_eq!(gap(Some("other"), 0.01, 0.0).is_borne_out(), Some(false));
        assert_eq!(gap(None, 0.9, 0.0).is_borne_out(), Some(false));
        // A small part of a large gap that is certainly closed.
        let certain = Gap { held_out_drop: 400.0, ..gap(None, 0.9, 0.04) };
        assert_eq!(certain.is_borne_out(), Some(true));
    }
}
