//! A family whose constant is left open, so that one compiled program serves all of its members.

use crate::effect::Effect;
use crate::graph::Scope;

/// The effect with its family as a constant whose value can be given.
pub(super) fn opened(effect: &Effect, family: &str) -> Option<Effect> {
    let mut effect = effect.clone();
    let declared = effect.shape.shift_remove(family)?;
    let mut constant = effect.parameters.first()?.clone();
    constant.name = family.to_owned();
    constant.unit = declared.unit;
    constant.per_measurand = false;
    constant.setting = crate::model::Setting::new(Scope::Instrument);
    constant.setting.fixed = true;
    constant.setting.value = Some(vec![declared.members.default_member()]);
    effect.parameters.push(constant);
    Some(effect)
}
