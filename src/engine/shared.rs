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

use std::cmp::Ordering;
use std::collections::BTreeMap;

use crate::diagnostic::{Diagnostic, Place};
use crate::graph::Kind;
use crate::model::Setting;
use crate::model::component::AXES;
use crate::system::System;
use crate::units::Unit;

/// Relative difference of numbers that are the same but for the unit in which they were written.
const SAME: f64 = 1e-12;

/// What one campaign states of a shared parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Statement<'a> {
    /// The campaign's name.
    pub(super) label: &'a str,
    /// Its model with effects.
    pub(super) system: &'a System,
    /// The parameter, by its index there.
    pub(super) parameter: usize,
}

/// A shared parameter.
#[derive(Clone, Debug)]
pub(super) struct Combined {
    pub(super) kind: Kind,
    pub(super) unit: Unit,
    pub(super) setting: Setting,
    /// Statements that do not fit together; the setting is then one that does not depend on order.
    pub(super) conflicts: Vec<Diagnostic>,
}

/// Which of a parameter's keys are asked for.
type Keys = [&'static str];

impl<'a> Statement<'a> {
    fn kind(&self) -> Kind {
        self.system.assembly.names.parameters[self.parameter].kind
    }

    fn unit(&self) -> &'a Unit {
        &self.system.assembly.names.parameters[self.parameter].unit
    }

    fn setting(&self) -> &'a Setting {
        &self.system.settings[self.parameter]
    }

    fn stated(&self) -> &'a BTreeMap<&'static str, Option<Place>> {
        &self.system.declared[self.parameter].stated
    }

    fn states(&self, keys: &Keys) -> bool {
        keys.iter().any(|key| self.stated().contains_key(key))
    }

    fn place(&self, keys: &Keys) -> Option<&'a Place> {
        keys.iter().find_map(|key| self.stated().get(key)?.as_ref())
    }

    /// Chosen members of the effect that it belongs to, with their units.
    fn members(&self) -> Vec<(String, String)> {
        let Some(effect) = self.system.declared[self.parameter].effect else { return Vec::new() };
        let placed = &self.system.effects[effect];
        let shape = &placed.effect.shape;
        let words = |(family, value): (&String, &f64)| {
            let unit = shape.get(family).map_or_else(Unit::one, |family| family.unit.clone());
            (format!("{}.{family}", placed.effect.name), quantity(&[*value], &unit))
        };
        placed.member.iter().map(words).collect()
    }

    /// The kind of quantity in words.
    fn quantity(&self) -> String {
        let symbol = &self.unit().symbol;
        match self.kind() {
            Kind::Scalar => format!("a number in `{symbol}`"),
            Kind::Vector => format!("a vector in `{symbol}`"),
            Kind::Rotation => "a rotation".to_owned(),
        }
    }

    /// What is said of single components, in words.
    fn components(&self) -> String {
        let setting = self.setting();
        let of = |component: usize| {
            let value = setting.value_of(component).map(|value| quantity(&[value], self.unit()));
            let sigma = setting.sigma_of(component);
            let width = self.unit().of_differences();
            match (value, sigma) {
                (Some(value), Some(sigma)) => {
                    format!("{value} with sigma {}", quantity(&[sigma], &width))
                }
                (Some(value), None) if setting.is_fixed(component) => format!("fixed at {value}"),
                (Some(value), None) => format!("free, from {value} on"),
                (None, _) => "free".to_owned(),
            }
        };
        let all = AXES.iter().enumerate().map(|(k, axis)| format!("{axis} {}", of(k)));
        all.collect::<Vec<_>>().join(", ")
    }

    /// The value in words.
    fn value(&self) -> String {
        let Setting { value, sigma, fixed, degrees_of_freedom, .. } = self.setting();
        let value = value.as_ref().map(|value| quantity(value, self.unit()));
        match (value, sigma) {
            (Some(value), _) if *fixed => format!("fixed at {value}"),
            (Some(value), Some(sigma)) => {
                let width = self.unit().of_differences();
                let degrees = degrees_of_freedom
                    .map_or_else(String::new, |count| format!(" ({count} degrees of freedom)"));
                format!("{value} with sigma {}{degrees}", quantity(sigma, &width))
            }
            (Some(value), None) => format!("free, from {value} on"),
            (None, _) => "free".to_owned(),
        }
    }
}

/// The statements of those that state one of the keys; without such, all of them.
fn chosen<'a>(list: &[Statement<'a>], keys: &Keys) -> Vec<Statement<'a>> {
    let stated: Vec<Statement<'a>> = list.iter().copied().filter(|one| one.states(keys)).collect();
    if stated.is_empty() { list.to_vec() } else { stated }
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

/// How the parameter is called in messages.
#[derive(Clone, Copy)]
struct Naming<'a> {
    name: &'a str,
    owner: &'a str,
}

impl Naming<'_> {
    /// Two statements that do not fit together.
    fn conflict<'s>(
        self,
        verb: &str,
        [one, other]: [&Statement<'s>; 2],
        words: impl Fn(&Statement<'s>) -> String,
        keys: &Keys,
    ) -> Diagnostic {
        let Self { name, owner } = self;
        let message = format!(
            "`{name}` of {owner} {verb} {} in campaign `{}`, but {} in campaign `{}`",
            words(one),
            one.label,
            words(other),
            other.label,
        );
        let (place, more) = match (one.place(keys), other.place(keys)) {
            (Some(place), Some(more)) => (Some(place), Some((one.label, more, other.label))),
            (place, more) => (place.or(more), None),
        };
        let mut error = Diagnostic::error(message).at_maybe(place);
        if let Some((label, more, other)) = more {
            let Place { file, line, column, .. } = more;
            error = error.label(format!("of campaign `{label}`"));
            error = error.help(format!("campaign `{other}` states it at {file}:{line}:{column}"));
        }
        error.help("campaigns that name the same rig or instrument share its parameters: state the same in both, or give them different names")
    }

    /// The first statement of another quantity.
    fn another_quantity(self, list: &[Statement<'_>]) -> Option<Diagnostic> {
        let first = &list[0];
        let is_other = |one: &&Statement<'_>| {
            let units = [first.unit(), one.unit()];
            one.kind() != first.kind()
                || !(units[0].accepts(units[1]) && units[1].accepts(units[0]))
        };
        if let Some(other) = list.iter().find(is_other) {
            return Some(self.conflict("is", [first, other], Statement::quantity, &["value"]));
        }
        let members = first.members();
        let other = list.iter().find(|one| one.members() != members)?;
        let differs = |(one, other): &((String, String), (String, String))| one != other;
        let (family, _) = members.iter().cloned().zip(other.members()).find(differs)?.0;
        let words = |one: &Statement<'_>| {
            let own = one.members().into_iter().find(|(name, _)| *name == family);
            own.map_or_else(String::new, |(_, value)| value)
        };
        let named = Naming { name: &family, owner: self.owner };
        Some(named.conflict("is", [first, other], words, &[]))
    }

    /// Value, standard uncertainty, whether it is fixed, start.
    fn value(self, list: &[Statement<'_>], setting: &mut Setting, faults: &mut Vec<Diagnostic>) {
        const KEYS: &Keys = &["value", "sigma", "fixed"];
        let fixed = list.iter().find(|one| one.setting().fixed);
        let free = list.iter().find(|one| !one.setting().fixed);
        if let (Some(fixed), Some(free)) = (fixed, free) {
            faults.push(self.conflict("is", [fixed, free], Statement::value, KEYS));
        }
        let known: Vec<Statement<'_>> = if fixed.is_some() {
            let held: Vec<_> = list.iter().copied().filter(|one| one.setting().fixed).collect();
            chosen(&held, KEYS)
        } else {
            let has_prior = |one: &Statement<'_>| one.setting().sigma.is_some();
            let priors: Vec<_> = list.iter().copied().filter(has_prior).collect();
            chosen(&priors, KEYS)
        };
        let is_other = |one: &&Statement<'_>| !is_same(one.setting(), known[0].setting());
        if let Some(other) = known.iter().find(is_other) {
            faults.push(self.conflict("is", [&known[0], other], Statement::value, KEYS));
        }
        let order = |a: &&Statement<'_>, b: &&Statement<'_>| {
            let (a, b) = (a.setting(), b.setting());
            compared(a.value.as_ref(), b.value.as_ref())
                .then_with(|| compared(a.sigma.as_ref(), b.sigma.as_ref()))
        };
        let least = |values: Vec<Statement<'_>>, get: fn(&Setting) -> &Option<Vec<f64>>| {
            let all = values.iter().filter_map(|one| get(one.setting()).clone());
            all.min_by(|a, b| compared(Some(a), Some(b)))
        };
        setting.fixed = fixed.is_some();
        match known.iter().min_by(order) {
            Some(known) => {
                let Setting { value, sigma, degrees_of_freedom, .. } = known.setting();
                setting.value.clone_from(value);
                setting.sigma.clone_from(sigma);
                setting.degrees_of_freedom = *degrees_of_freedom;
            }
            None => {
                setting.value = least(chosen(list, &["value"]), |one| &one.value);
                (setting.sigma, setting.degrees_of_freedom) = (None, None);
            }
        }
        setting.start = least(chosen(list, &["value", "start"]), |one| &one.start);
        let says = |one: &&Statement<'_>| one.setting().components.is_some();
        let stated: Vec<&Statement<'_>> = list.iter().filter(says).collect();
        let is_other =
            |one: &&&Statement<'_>| one.setting().components != stated[0].setting().components;
        if let Some(other) = stated.iter().find(is_other) {
            faults.push(self.conflict("is", [stated[0], other], Statement::components, KEYS));
        }
        setting.components = stated.first().and_then(|one| one.setting().components.clone());
    }

    /// Bounds, which hold together.
    fn bounds<'s>(
        self,
        list: &[Statement<'s>],
        setting: &mut Setting,
        faults: &mut Vec<Diagnostic>,
    ) {
        let (lower, upper) = (chosen(list, &["lower"]), chosen(list, &["upper"]));
        setting.lower = tightest(lower.iter().map(|one| &one.setting().lower), f64::max);
        setting.upper = tightest(upper.iter().map(|one| &one.setting().upper), f64::min);
        let at =
            |values: &Option<Vec<f64>>, component: usize| values.as_ref()?.get(component).copied();
        let is_known = setting.fixed || setting.sigma.is_some();
        for component in 0..self::components(setting) {
            let (least, most) = (at(&setting.lower, component), at(&setting.upper, component));
            let value = at(&setting.value, component).filter(|_| is_known);
            let below = least.zip(value).is_some_and(|(least, value)| value < least);
            let above = most.zip(value).is_some_and(|(most, value)| value > most);
            let none = least.zip(most).is_some_and(|(least, most)| least >= most);
            if !(below || above || none) {
                continue;
            }
            let bounded = |list: &[Statement<'s>], get: fn(&Setting) -> &Option<Vec<f64>>, by| {
                list.iter().copied().find(|one| at(get(one.setting()), component) == by)
            };
            let low = bounded(&lower, |one| &one.lower, least);
            let high = bounded(&upper, |one| &one.upper, most);
            let valued =
                list.iter().copied().find(|one| at(&one.setting().value, component) == value);
            let pair = match (below, above) {
                (true, _) => low.zip(valued),
                (_, true) => high.zip(valued),
                _ => low.zip(high),
            };
            if let Some((one, other)) = pair {
                let words = |one: &Statement<'s>| {
                    let unit = one.unit();
                    let bound = |word: &str, values: &Option<Vec<f64>>| {
                        values.as_ref().map(|values| format!("{word} {}", quantity(values, unit)))
                    };
                    let Setting { lower, upper, .. } = one.setting();
                    let bounds = [bound("above", lower), bound("below", upper)];
                    let mut all: Vec<String> = bounds.into_iter().flatten().collect();
                    if is_known && one.setting().value.is_some() {
                        all.insert(0, one.value());
                    }
                    if all.is_empty() { "without bounds".to_owned() } else { all.join(" and ") }
                };
                let keys: &Keys = &["lower", "upper", "value"];
                faults.push(self.conflict("is", [&one, &other], words, keys));
                return;
            }
        }
    }
}

/// Number of components of which anything is said.
fn components(setting: &Setting) -> usize {
    let lists = [&setting.value, &setting.lower, &setting.upper];
    lists.into_iter().flatten().map(Vec::len).max().unwrap_or(0)
}

/// The tightest of bounds, component by component.
fn tightest<'a>(
    all: impl Iterator<Item = &'a Option<Vec<f64>>>,
    tighter: fn(f64, f64) -> f64,
) -> Option<Vec<f64>> {
    all.flatten().cloned().reduce(|a, b| a.iter().zip(&b).map(|(a, b)| tighter(*a, *b)).collect())
}

/// Whether two settings state the same value with the same standard uncertainty.
fn is_same(a: &Setting, b: &Setting) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
    let alike = |a: &Option<Vec<f64>>, b: &Option<Vec<f64>>| match (a, b) {
        (Some(a), Some(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| near(*a, *b)),
        (None, None) => true,
        _ => false,
    };
    alike(&a.value, &b.value)
        && alike(&a.sigma, &b.sigma)
        && a.degrees_of_freedom == b.degrees_of_freedom
}

/// Lists of numbers in order: component by component, nothing first.
fn compared(a: Option<&Vec<f64>>, b: Option<&Vec<f64>>) -> Ordering {
    match (a, b) {
        (Some(a), Some(b)) => {
            let pairs = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
            pairs.fold(Ordering::Equal, Ordering::then)
        }
        (a, b) => a.is_some().cmp(&b.is_some()),
    }
}

/// SI values as a person writes them, to nine digits.
fn quantity(values: &[f64], unit: &Unit) -> String {
    let number = |value: &f64| {
        let value = unit.from_si(*value);
        format!("{value:.8e}").parse().unwrap_or(value).to_string()
    };
    let numbers: Vec<String> = values.iter().map(number).collect();
    let text =
        if let [one] = &numbers[..] { one.clone() } else { format!("[{}]", numbers.join(", ")) };
    if unit.symbol == "1" { text } else { format!("{text} {}", unit.symbol) }
}
