//! A stated value that is wrong altogether: another unit, a slip of the pen.
//!
//! It bends a fit so much that nothing else can be judged, and readings that are right look like outliers.
//! Each value that is stated is set free in turn; it is wrong where that alone makes a spoilt fit
//! sound. What is wrong by a few standard uncertainties is judged with everything else
//! ([`mod@crate::estimate::contradicted`]).

use std::collections::BTreeSet;

use crate::engine::Problem;
use crate::engine::layout::Instance;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::contradicted::{Contradicted, against};
use crate::graph::Kind;

use super::settle::{SOUND_WITHOUT, is_spoilt};

/// The stated value without which a spoilt fit is sound, if there is one.
pub(in crate::diagnose) fn wrong_value(
    whole: &Calibration,
    options: &Options,
) -> Result<Option<Contradicted>, FitError> {
    if !is_spoilt(whole) && whole.is_sound() {
        return Ok(None);
    }
    let spoilt = whole.variance_factor().unwrap_or(f64::INFINITY);
    let instances = &whole.problem.layout.instances;
    let is_stated = |index: &usize| {
        instances[*index].setting.value.is_some() && !whole.problem.layout.is_noise_only(*index)
    };
    let stated = (0..instances.len()).filter(is_stated);
    let names: BTreeSet<&String> = stated.map(|index| &instances[index].name).collect();
    let mut best: Option<(f64, Contradicted)> = None;
    for name in names {
        for start in starts(whole, name) {
            let without = calibrate(freed(whole, name, start), options)?;
            let factor = without.variance_factor().filter(|_| without.is_sound());
            let Some(factor) = factor.filter(|factor| SOUND_WITHOUT * factor < spoilt) else {
                continue;
            };
            if !is_spoilt(&without)
                && best.as_ref().is_none_or(|(least, _)| factor < *least)
                && let Some(contradicted) = against(whole, &without, name)
            {
                best = Some((factor, contradicted));
            }
        }
    }
    Ok(best.map(|(_, found)| found))
}

/// A thousand of one unit are one of another.
const PREFIX: f64 = 1e3;

/// Where a parameter of which nothing is stated may start: a number where the fit left it, or at
/// what it would be in a unit next to the one that is said; vectors and rotations as the model has
/// it.
fn starts(whole: &Calibration, name: &str) -> Vec<Option<f64>> {
    let mut all = whole.problem.layout.instances.iter().zip(&whole.fit.point.values);
    let is_own = |(one, _): &(&Instance, _)| one.name == name && one.kind == Kind::Scalar;
    let Some((one, left)) = all.find(is_own) else { return vec![None] };
    let stated = one.setting.value.as_ref().and_then(|all| all.first());
    let other = stated.into_iter().flat_map(|one| [one * PREFIX, one / PREFIX]);
    std::iter::once(left[0]).chain(other).filter(|one| one.is_finite()).map(Some).collect()
}

/// The same problem with nothing stated of a parameter.
fn freed(whole: &Calibration, name: &str, start: Option<f64>) -> Problem {
    let mut parts = whole.problem.parts.clone();
    for part in &mut parts {
        let names = &part.system.assembly.names.parameters;
        let Some(parameter) = names.iter().position(|one| one.name == name) else { continue };
        for setting in part.system.settings_mut(parameter) {
            (setting.value, setting.sigma, setting.fixed) = (None, None, false);
            setting.start = start.map(|one| vec![one]).or(setting.start.take());
        }
    }
    whole.problem.with_parts(parts)
}
