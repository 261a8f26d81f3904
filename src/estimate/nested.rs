//! A fit with effects against the fit without them.
//!
//! A larger model cannot fit worse than a smaller one that it contains: where it does, its fit ended
//! somewhere else. Then it is begun again from the optimum of the smaller one, with the effects
//! switched off; if it still ends above, it is no result.

use std::collections::BTreeSet;

use crate::effect::{PatchLine, Target};
use crate::engine::part::Part;
use crate::engine::problem::Problem;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate, calibrate_from};
use crate::estimate::refused::Refused;

/// How far chi squared may lie above that of the smaller model, as a part of it: rounding.
const ROUNDING: f64 = 1e-6;
/// The same as a number.
const LEAST: f64 = 0.01;

/// An estimate with effects (`NAME` or `NAME.HEAD`) of which the model without them is a part, if
/// need be made again from its optimum. Effects on the noise change weights, and chi squared says
/// nothing of them: then the estimate stays as it is.
///
/// # Errors
/// As [`calibrate`].
pub fn against_nominal(
    result: Calibration,
    effects: &[String],
    options: &Options,
) -> Result<Calibration, FitError> {
    let parts = &result.problem.parts;
    if effects.is_empty() || parts.iter().any(|part| acts_on_noise(part, effects)) {
        return Ok(result);
    }
    let without = calibrate(without(&result.problem, effects), options)?;
    let is_worse = |with: &Calibration| {
        let cost = without.fit.cost;
        !with.fit.outcome.is_result() || with.fit.cost > cost + (ROUNDING * cost).max(LEAST)
    };
    if !without.fit.outcome.is_result() || !is_worse(&result) {
        return Ok(result);
    }
    // Both have the same instances in the same order.
    let again = calibrate_from(result.problem.clone(), without.fit.point.clone(), options)?;
    let settles = again.fit.outcome.is_result();
    let is_better =
        settles && (!result.fit.outcome.is_result() || again.fit.cost < result.fit.cost);
    let mut best = if is_better {
        Calibration { aligned: result.aligned, held: result.held, ..again }
    } else {
        result
    };
    if best.fit.outcome.is_result() && is_worse(&best) {
        let chi_squared = [best.fit.cost, without.fit.cost];
        best.refused.push(Refused::Worse { effects: effects.to_vec(), chi_squared });
    }
    Ok(best)
}

/// Whether an effect of a campaign is one of these.
pub(super) fn is_of(part: &Part, effect: usize, effects: &[String]) -> bool {
    let one = &part.system.effects[effect];
    effects.iter().any(|name| *name == one.name || *name == one.effect.name)
}

/// Whether one of the effects draws random numbers or changes a stated uncertainty.
fn acts_on_noise(part: &Part, effects: &[String]) -> bool {
    let all = &part.system.effects;
    let mut own = (0..all.len()).filter(|effect| is_of(part, *effect, effects));
    own.any(|effect| {
        let is_level =
            |line: &PatchLine| matches!(line.target, Target::Sigma(_) | Target::EachAngleSigma);
        !all[effect].randoms.is_empty() || all[effect].effect.patches.iter().any(is_level)
    })
}

/// The problem with what these effects leave free held at zero.
pub(super) fn without(problem: &Problem, effects: &[String]) -> Problem {
    let mut parts = problem.parts.clone();
    for part in &mut parts {
        let own = part.system.declared.iter().enumerate().filter_map(|(parameter, declared)| {
            let effect = declared.effect?;
            let is_free = !part.system.settings[parameter].fixed;
            (is_free && is_of(part, effect, effects)).then_some(parameter)
        });
        let own: BTreeSet<usize> = own.collect();
        for parameter in own {
            let count = part.system.assembly.names.parameters[parameter].kind.dimension();
            for setting in part.system.settings_mut(parameter) {
                setting.sum_zero = false;
                setting.hold_at(vec![0.0; count]);
            }
        }
    }
    let mut made = Problem::new(parts);
    made.progress = problem.progress.clone();
    made
}
