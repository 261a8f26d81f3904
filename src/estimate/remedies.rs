//! What would determine a direction that the readings leave open.
//!
//! A remedy is printed only if it was tried: the rows that a further run would bring, or the row of
//! a stated value, are added to the sums of the fit, and these are examined again. What leaves as
//! many directions open as before is no remedy, however often the field recommends it.
//!
//! | file | answers |
//! |---|---|
//! | `further` | which further runs there could be, from the model's own inputs |
//! | `tried` | whether rows that are added determine a direction |

use crate::diagnostic::number;
use crate::engine::gram::Normal;
use crate::engine::layout::Instance;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::estimate::combination::{component_names, place_of};
use crate::estimate::observability::{Direction, Limit, NEGLIGIBLE};
use crate::estimate::remedies::further::{best_of_its_motion, others};
use crate::estimate::remedies::tried::Tried;
use crate::graph::Kind;

mod further;
mod tried;

/// Further runs of other inputs that are named for one direction.
const MOST_RUNS: usize = 2;

/// An open direction, among all of a fit.
#[derive(Clone, Copy, Debug)]
pub struct Open<'a> {
    /// What was fitted.
    pub problem: &'a Problem,
    /// The estimate.
    pub point: &'a Point,
    /// The sums there.
    pub normal: &'a Normal,
    /// The limit of every column.
    pub limits: &'a [Limit],
    /// All open directions.
    pub directions: &'a [Direction],
}

impl Open<'_> {
    /// What would determine one of the directions, in words.
    pub fn remedy(&self, at: usize) -> String {
        let direction = &self.directions[at];
        let tried = Tried::new(self, at);
        let mut runs: Vec<String> = Vec::new();
        runs.extend(best_of_its_motion(self, direction, &tried));
        if runs.is_empty() {
            runs.extend(others(self, direction, &tried).into_iter().take(MOST_RUNS));
        }
        let (names, alone) = self.stated(direction, &tried);
        let one = if names.len() == 1 { "" } else { "one of " };
        let line = if alone { self.line(direction).unwrap_or_default() } else { String::new() };
        let names_of = names.join(", ");
        let state =
            format!("state a value with its sigma for {one}{names_of} or set it fixed{line}");
        match (runs.is_empty(), names.is_empty()) {
            (true, true) => {
                "none of the remedies that were tried determines it (further runs, stated values): leave one of these parameters out of the model".to_owned()
            }
            (true, false) if alone => format!("leave it out: {state}"),
            (true, false) => state,
            (false, true) => runs.join("; or "),
            (false, false) => format!("{}; or {state}", runs.join("; or ")),
        }
    }

    /// What to type to state the only parameter of a direction: a scalar with one value, to its
    /// plausible size where it has one, or fixed.
    fn line(&self, direction: &Direction) -> Option<String> {
        let (column, _) = direction.weights.first()?;
        let layout = &self.problem.layout;
        let index = (0..layout.instances.len())
            .find(|index| layout.own_columns(*index).any(|(_, own)| own == *column))?;
        let Instance { name, unit, setting, .. } = &layout.instances[index];
        let is_single = layout.instances.iter().filter(|one| one.name == *name).count() == 1;
        if !is_single || layout.instances[index].kind != Kind::Scalar {
            return None;
        }
        let said = |number_of_units: f64| {
            // Digits of the conversion are none of the value.
            let rounded = format!("{number_of_units:.11e}").parse().unwrap_or(number_of_units);
            let said = format!("{} {}", number(rounded), unit.symbol);
            said.trim_end_matches(" 1").to_owned()
        };
        let first = |values: &Option<Vec<f64>>| values.as_ref()?.first().copied();
        let known = first(&setting.value).or_else(|| first(&setting.start));
        let value = known.or((unit.offset == 0.0).then_some(0.0))?;
        let value = said(unit.from_si(value));
        let fixed = format!("`--set {name}=\"{value}\"`");
        Some(match setting.plausible {
            Some(plausible) => {
                // A sigma is a difference: an offset of the unit is no part of it.
                let sigma = said(plausible / unit.factor);
                format!(", as in `--set {name}=\"{value}~{sigma}\"` or {fixed}")
            }
            None => format!(", as in {fixed}"),
        })
    }

    /// The parameters, or components of vectors, of which a stated value determines the direction;
    /// and whether no other parameter takes part in it.
    fn stated(&self, direction: &Direction, tried: &Tried<'_>) -> (Vec<String>, bool) {
        let layout = &self.problem.layout;
        let mut names: Vec<String> = Vec::new();
        let mut parameters = 0;
        for (index, instance) in layout.instances.iter().enumerate() {
            let columns = |component: usize| layout.columns_of(index, component);
            let carries = |component: &usize| {
                let own = columns(*component);
                direction.weights.iter().zip(&direction.shares).any(|((column, _), share)| {
                    share.abs() >= NEGLIGIBLE && own.iter().any(|(other, _)| other == column)
                })
            };
            let blamed: Vec<usize> = (0..instance.dimension()).filter(carries).collect();
            parameters += usize::from(!blamed.is_empty());
            let mut add = |name: String| {
                if !names.contains(&name) {
                    names.push(name);
                }
            };
            let of = place_of(self.problem, index).map_or_else(String::new, |of| format!("@{of}"));
            match instance.kind {
                Kind::Rotation if !blamed.is_empty() => {
                    let all: Vec<_> = (0..3).map(columns).collect();
                    if tried.determined_by_values(&all) {
                        add(format!("`{}`", instance.name));
                    }
                }
                Kind::Scalar | Kind::Rotation => {
                    if !blamed.is_empty() && tried.determined_by_values(&[columns(0)]) {
                        add(format!("`{}`", instance.name));
                    }
                }
                Kind::Vector => {
                    let all = component_names(self.problem, index);
                    for component in blamed {
                        if tried.determined_by_values(&[columns(component)]) {
                            let name = all[component].strip_suffix(&of);
                            add(format!("`{}`", name.unwrap_or(&all[component])));
                        }
                    }
                }
            }
        }
        (names, parameters == 1)
    }
}
