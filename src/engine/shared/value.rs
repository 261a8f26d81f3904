//! The value that campaigns share, with its standard uncertainty: fixed, known, or free.

use std::cmp::Ordering;

use super::conflicts::Naming;
use super::statement::{Keys, Statement, chosen};
use crate::diagnostic::Diagnostic;
use crate::model::Setting;

/// Relative difference of numbers that are the same but for the unit in which they were written.
const SAME: f64 = 1e-12;

impl Naming<'_> {
    /// Value, standard uncertainty, whether it is fixed, start.
    pub(super) fn value(
        self,
        list: &[Statement<'_>],
        setting: &mut Setting,
        faults: &mut Vec<Diagnostic>,
    ) {
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
