//! The bounds that campaigns share, and whether they hold together.

use super::conflicts::Naming;
use super::statement::{Keys, Statement, chosen, quantity};
use crate::diagnostic::Diagnostic;
use crate::model::Setting;

impl Naming<'_> {
    /// Bounds, which hold together.
    pub(super) fn bounds<'s>(
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
        for component in 0..components(setting) {
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
