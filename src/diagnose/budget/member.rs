//! How well the readings say which member of a family a named effect is (a frequency, a length, a
//! width), and how much less certain that makes the effect's values.
//!
//! A fit holds the member. About the best one the sum of squares is a parabola: where it is larger
//! by one is a standard uncertainty, and values that follow the member share in it. What is not
//! asked: members of a list, which are counted, and those that a user states.

use std::f64::consts::SQRT_2;

use crate::diagnose::fitted::Fitted;
use crate::effect::Members;
use crate::estimate::batch::{FitError, Options};
use crate::system::Selected;

/// Steps to members beside the best, as parts of it or of a range through zero: the first.
const FIRST: f64 = 1e-3;
/// Steps that are tried at most.
const TRIES: usize = 6;
/// Between these the sum of squares rises by so much that the parabola is seen, and is one.
const RISE: std::ops::Range<f64> = 0.3..3.0;
/// By so much a step is made longer or shorter, at most.
const LONGER: f64 = 20.0;

/// The uncertainty of a member.
#[derive(Clone, Debug)]
pub struct MemberUncertainty {
    /// The effect, as it is named.
    pub effect: String,
    /// The family.
    pub family: String,
    /// Standard uncertainty (SI) of the member, its distance from the best one included.
    pub sigma: f64,
    /// Part of the standard uncertainty of each of the effect's values that comes from it: instance
    /// and size (SI), in the model with all named effects.
    pub shares: Vec<(usize, f64)>,
}

/// Those of the named effects, in the model with all of them.
pub fn member_uncertainties(
    fitted: &Fitted,
    effects: &[Selected],
    options: &Options,
) -> Result<Vec<MemberUncertainty>, FitError> {
    let mut found = Vec::new();
    for selected in effects {
        for (family, declared) in &selected.effect.shape {
            let Members::Range { from, to } = declared.members else { continue };
            let name = format!("{}.{family}", selected.effect.name);
            let overrides = fitted.recipes.iter().flat_map(|recipe| &recipe.overrides);
            if overrides.into_iter().any(|said| said.name == name) {
                continue;
            }
            let range = (family.as_str(), [from, to]);
            let Some((sigma, shares)) = beside(fitted, selected, range, options)? else { continue };
            let (effect, family) = (selected.name(), family.clone());
            found.push(MemberUncertainty { effect, family, sigma, shares });
        }
    }
    Ok(found)
}

/// A standard uncertainty, and the parts of it that values share.
type Known = (f64, Vec<(usize, f64)>);

/// The uncertainty of one; `None` at the edge of a range, and where the sum of squares does not
/// rise.
fn beside(
    fitted: &Fitted,
    selected: &Selected,
    (family, [from, to]): (&str, [f64; 2]),
    options: &Options,
) -> Result<Option<Known>, FitError> {
    let Some(best) = selected.member.get(family).copied() else { return Ok(None) };
    let own = values(fitted, selected);
    let without = fitted.without(&[selected], options)?;
    let start: Vec<_> =
        own.iter().map(|(_, name, of, value)| (name.clone(), 0, of.clone(), *value)).collect();
    let at = |member: f64| -> Result<Option<Fitted>, FitError> {
        let mut one = selected.clone();
        one.member.insert(family.to_owned(), member);
        Ok(without.with(&one, &start, options)?.filter(Fitted::is_sound))
    };
    let room = (best - from).min(to - best);
    let scale = if from > 0.0 { best } else { to - from };
    let mut step = (FIRST * scale).min(room);
    for _ in 0..TRIES {
        if step <= 0.0 {
            return Ok(None);
        }
        let (Some(below), Some(above)) = (at(best - step)?, at(best + step)?) else {
            return Ok(None);
        };
        let rise = 0.5 * (below.fit.cost + above.fit.cost) - fitted.fit.cost;
        if RISE.contains(&rise) {
            let farther = step * (below.fit.cost - above.fit.cost) / (4.0 * rise);
            let sigma = (step / rise.sqrt()).hypot(farther);
            let [below, above] = [&below, &above].map(|one| values(one, selected));
            let value = |all: &[Value], like: &Value| {
                let same = all.iter().find(|one| (&one.1, &one.2) == (&like.1, &like.2));
                same.map(|one| one.3)
            };
            // A value may turn about at the best member: both sides count, not their slope.
            let share = |one: &Value| {
                let apart = (value(&above, one)? - one.3).hypot(value(&below, one)? - one.3);
                Some((one.0, apart / (SQRT_2 * step) * sigma))
            };
            return Ok(Some((sigma, own.iter().filter_map(share).collect())));
        }
        let longer = if rise > 0.0 { rise.sqrt().recip() } else { LONGER };
        let next = (step * longer.clamp(LONGER.recip(), LONGER)).min(room);
        if next == step {
            return Ok(None);
        }
        step = next;
    }
    Ok(None)
}

/// A value of an effect: its instance, name, whose it is, and the number (SI).
type Value = (usize, String, Option<String>, f64);

/// The values of an effect that are numbers.
fn values(fitted: &Fitted, selected: &Selected) -> Vec<Value> {
    let name = format!("{}.", selected.name());
    let Fitted { problem, fit, .. } = fitted;
    let instances = problem.layout.instances.iter().enumerate();
    instances
        .filter(|(_, one)| one.name.starts_with(&name) && one.dimension() == 1)
        .filter(|(_, one)| !one.setting.fixed)
        .map(|(index, one)| {
            let of = one.whose().map(str::to_owned);
            (index, one.name.clone(), of, fit.point.values[index][0])
        })
        .collect()
}
