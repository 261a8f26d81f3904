//! What one campaign states of a shared parameter, and in which words.

use std::collections::BTreeMap;

use crate::diagnostic::Place;
use crate::graph::Kind;
use crate::model::Setting;
use crate::model::component::AXES;
use crate::system::System;
use crate::units::Unit;

/// What one campaign states of a shared parameter.
#[derive(Clone, Copy, Debug)]
pub(in crate::engine) struct Statement<'a> {
    /// The campaign's name.
    pub(in crate::engine) label: &'a str,
    /// Its model with effects.
    pub(in crate::engine) system: &'a System,
    /// The parameter, by its index there.
    pub(in crate::engine) parameter: usize,
}

/// Which of a parameter's keys are asked for.
pub(super) type Keys = [&'static str];

impl<'a> Statement<'a> {
    pub(super) fn kind(&self) -> Kind {
        self.system.assembly.names.parameters[self.parameter].kind
    }

    pub(super) fn unit(&self) -> &'a Unit {
        &self.system.assembly.names.parameters[self.parameter].unit
    }

    pub(super) fn setting(&self) -> &'a Setting {
        &self.system.settings[self.parameter]
    }

    fn stated(&self) -> &'a BTreeMap<&'static str, Option<Place>> {
        &self.system.declared[self.parameter].stated
    }

    fn states(&self, keys: &Keys) -> bool {
        keys.iter().any(|key| self.stated().contains_key(key))
    }

    pub(super) fn place(&self, keys: &Keys) -> Option<&'a Place> {
        keys.iter().find_map(|key| self.stated().get(key)?.as_ref())
    }

    /// Chosen members of the effect that it belongs to, with their units.
    pub(super) fn members(&self) -> Vec<(String, String)> {
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
    pub(super) fn quantity(&self) -> String {
        let symbol = &self.unit().symbol;
        match self.kind() {
            Kind::Scalar => format!("a number in `{symbol}`"),
            Kind::Vector => format!("a vector in `{symbol}`"),
            Kind::Rotation => "a rotation".to_owned(),
        }
    }

    /// What is said of single components, in words.
    pub(super) fn components(&self) -> String {
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
    pub(super) fn value(&self) -> String {
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
pub(super) fn chosen<'a>(list: &[Statement<'a>], keys: &Keys) -> Vec<Statement<'a>> {
    let stated: Vec<Statement<'a>> = list.iter().copied().filter(|one| one.states(keys)).collect();
    if stated.is_empty() { list.to_vec() } else { stated }
}

/// SI values as a person writes them, to nine digits.
pub(super) fn quantity(values: &[f64], unit: &Unit) -> String {
    let number = |value: &f64| {
        let value = unit.from_si(*value);
        format!("{value:.8e}").parse().unwrap_or(value).to_string()
    };
    let numbers: Vec<String> = values.iter().map(number).collect();
    let text =
        if let [one] = &numbers[..] { one.clone() } else { format!("[{}]", numbers.join(", ")) };
    if unit.symbol == "1" { text } else { format!("{text} {}", unit.symbol) }
}
