//! Parameters that act only by their square, or a higher power, about their start.
//!
//! Where every derivative by a parameter is zero, no step of a fit moves it, and it looks like one
//! without any effect. It has one: readings change where it is moved by more than a derivative says.

use crate::diagnostic::number;
use crate::engine::gram::LeastSquares;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::estimate::combination::component_names;
use crate::estimate::observability::{Direction, Kind};

/// How far a parameter is moved (SI) where nobody says which size is plausible.
const SIZES: [f64; 2] = [1e-3, 1.0];
/// A change of chi squared beyond rounding, absolute and relative.
const CHANGE: (f64, f64) = (1e-6, 1e-9);

/// A component with derivatives of zero that has an effect all the same.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stationary {
    name: String,
    parameter: String,
    value: String,
    /// What `start` may be; the user chooses the component.
    start: String,
}

impl Stationary {
    /// The component of a direction, if it is one.
    pub(super) fn of(problem: &Problem, point: &Point, direction: &Direction) -> Option<Self> {
        let [(column, _)] = direction.weights[..] else { return None };
        if direction.kind != Kind::Exact || direction.singular_value != 0.0 {
            return None;
        }
        let layout = &problem.layout;
        let (index, component) = (0..layout.instances.len()).find_map(|index| {
            let mut own = layout.own_columns(index);
            own.find(|(_, own)| *own == column).map(|(component, _)| (index, component))
        })?;
        let instance = &layout.instances[index];
        let cost = problem.cost(point);
        let sizes = instance.setting.plausible.map_or(SIZES.to_vec(), |size| vec![size]);
        let acts = |size: f64| {
            let mut step = vec![0.0; layout.columns.len()];
            step[column] = size;
            let change = (problem.cost(&point.moved(layout, &step)) - cost).abs();
            change > CHANGE.0.max(CHANGE.1 * cost)
        };
        sizes.iter().any(|size| acts(*size) || acts(-size)).then(|| {
            let values = point.components(layout, index);
            let shown = |value: f64| {
                let symbol = &instance.unit.symbol;
                format!("{} {symbol}", number(instance.unit.from_si(value)))
                    .trim_end_matches(" 1")
                    .to_owned()
            };
            // A start needs few digits.
            let rounded = |value: f64| format!("{value:.3e}").parse().unwrap_or(value);
            let each = (0..instance.dimension()).map(|own| match own == component {
                true => "\"...\"".to_owned(),
                false => format!("\"{}\"", shown(rounded(values[own]))),
            });
            let each: Vec<String> = each.collect();
            Self {
                name: component_names(problem, index).swap_remove(component),
                parameter: instance.name.clone(),
                value: shown(values.get(component).copied().unwrap_or(0.0)),
                start: match &each[..] {
                    [only] => only.clone(),
                    several => format!("[{}]", several.join(", ")),
                },
            }
        })
    }

    /// The sentence in place of one that denies any effect.
    pub(super) fn words(&self) -> String {
        let Self { name, value, .. } = self;
        format!(
            "`{name}` acts by its square or a higher power about its start, {value}: the derivative of every reading is zero there, and no step leads away from it"
        )
    }

    /// What helps.
    pub(super) fn remedy(&self) -> String {
        let Self { parameter, start, .. } = self;
        format!("start it elsewhere: [parameters] {parameter} = {{ start = {start} }}")
    }
}
