//! One value that several campaigns share, from what each of them states of it.
//!
//! Campaigns that name the same rig or instrument share its parameters. Their order never matters:
//! statements are looked at in the order of the campaigns' names.
//!
//! - The parameter must be the same quantity everywhere: kind, dimension, members of the effect's
//!   families, fixed or free.
//! - What a campaign (or the command line) states counts over what models and effects declare. A
//!   campaign that states nothing adds nothing.
//! - The same value with the same standard uncertainty in several campaigns is one statement, not
//!   several observations: campaigns copy it from one certificate. Different ones are a conflict.
//! - Bounds hold together. Of starts the least is taken, of plausible sizes, too.

mod bounds;
mod conflicts;
pub(super) mod statement;
mod value;

use crate::diagnostic::Diagnostic;
use crate::graph::Kind;
use crate::model::Setting;
use crate::units::Unit;
use conflicts::Naming;
use statement::{Statement, chosen};

/// A shared parameter.
#[derive(Clone, Debug)]
pub(super) struct Combined {
    pub(super) kind: Kind,
    pub(super) unit: Unit,
    pub(super) setting: Setting,
    /// Statements that do not fit together; the setting is then one that does not depend on order.
    pub(super) conflicts: Vec<Diagnostic>,
}

/// One parameter from the statements of all campaigns that share it; `name` is its own, `owner`
/// that of its rig or instrument, in words.
///
/// There is at least one statement.
pub(super) fn combined(name: &str, owner: &str, list: &[Statement<'_>]) -> Combined {
    let mut list = list.to_vec();
    list.sort_by(|a, b| a.label.cmp(b.label));
    let first = list[0];
    let symbol = |one: &&Unit| one.symbol.clone();
    let unit = list.iter().map(Statement::unit).min_by_key(symbol).unwrap_or(first.unit());
    let mut of_all = Combined {
        kind: first.kind(),
        unit: unit.clone(),
        setting: first.setting().clone(),
        conflicts: Vec::new(),
    };
    let naming = Naming { name, owner };
    if let Some(conflict) = naming.another_quantity(&list) {
        of_all.conflicts.push(conflict);
        return of_all;
    }
    let setting = &mut of_all.setting;
    if list.iter().all(|one| one.setting() == first.setting()) {
        return of_all;
    }
    let conflicts = &mut of_all.conflicts;
    if let Some(other) = list.iter().find(|one| one.setting().sum_zero != setting.sum_zero) {
        let words = |one: &Statement<'_>| {
            if one.setting().sum_zero { "summing to zero" } else { "free to add up" }.to_owned()
        };
        conflicts.push(naming.conflict("has values", [&first, other], words, &["sum"]));
    }
    naming.value(&list, setting, conflicts);
    naming.bounds(&list, setting, conflicts);
    let plausible = chosen(&list, &["plausible"]);
    setting.plausible =
        plausible.iter().filter_map(|one| one.setting().plausible).min_by(f64::total_cmp);
    let at = |one: &Statement<'_>| one.setting().simulated_at;
    let simulated: Vec<&Statement<'_>> = list.iter().filter(|one| at(one).is_some()).collect();
    // Only parameters of effects count from it.
    let differs = |one: &&&Statement<'_>| name.contains('.') && at(one) != at(simulated[0]);
    if let Some(other) = simulated.iter().find(differs) {
        let words = |one: &Statement<'_>| format!("{:?} (SI)", at(one).unwrap_or(0.0));
        let pair = [simulated[0], *other];
        conflicts.push(naming.conflict("counts from", pair, words, &["simulated_at"]));
    }
    setting.simulated_at = simulated.first().and_then(|one| at(one));
    let ranges = list.iter().filter_map(|one| one.setting().linear_range);
    setting.linear_range = ranges.min_by(f64::total_cmp);
    setting.typical = list.iter().filter_map(|one| one.setting().typical).min_by(f64::total_cmp);
    of_all
}
