//! One line that says something of a parameter: in a model, in an effect, in a campaign.

use crate::diagnostic::Source;
use crate::document::{Item, Section};
use crate::graph::{Kind, Scope};
use crate::model::{Override, ParameterDeclaration, Process, Setting, Shape};
use crate::units::Unit;

/// The words for scopes.
pub const SCOPES: &[(&str, Scope)] = &[
    ("rig", Scope::Rig),
    ("instrument", Scope::Instrument),
    ("setup", Scope::Setup),
    ("run", Scope::Run),
    ("sample", Scope::Sample),
];

const KINDS: &[(&str, Kind)] =
    &[("scalar", Kind::Scalar), ("vector", Kind::Vector), ("rotation", Kind::Rotation)];
const PROCESSES: &[(&str, Process)] =
    &[("white", Process::White), ("walk", Process::Walk), ("memory", Process::Memory)];
const SHAPES: &[(&str, Shape)] = &[("normal", Shape::Normal), ("uniform", Shape::Uniform)];

/// Number of components that a person gives: a rotation's are those of its rotation vector.
pub fn component_count(kind: Kind) -> usize {
    match kind {
        Kind::Scalar => 1,
        Kind::Vector | Kind::Rotation => 3,
    }
}

/// Reads a declaration; its keys beyond those of [`override_of`] are `kind`, `unit`, `per`,
/// `process`, `shape`, `memory`, `typical` and `about`.
pub fn declaration_of(
    item: &Item<'_>,
    name: String,
    default: Scope,
) -> Option<ParameterDeclaration> {
    let section = item.section(&format!("the parameter `{name}`"))?;
    let kind = section.get("kind").map_or(Some(Kind::Scalar), |item| item.choice(KINDS));
    let unit = match (section.get("unit"), kind) {
        (Some(item), Some(Kind::Rotation)) => item.unit().filter(|unit| {
            let angle = unit.is_angle();
            if !angle {
                item.error(
                    "a rotation is given in units of angle",
                    "write unit = \"rad\" or leave it out",
                );
            }
            angle
        }),
        (Some(item), _) => item.unit(),
        (None, Some(Kind::Rotation)) => Unit::parse("rad").ok(),
        (None, _) => Some(Unit::one()),
    };
    let per_measurand =
        section.get("per").and_then(|item| item.choice(&[("measurand", true)])).unwrap_or(false);
    let process = section.get("process").and_then(|item| item.choice(PROCESSES));
    let shape = section.get("shape").and_then(|item| item.choice(SHAPES));
    let memory = section.get("memory").and_then(|item| item.positive(&Unit::parse("s").ok()?));
    // With an unreadable unit or kind the rest is only looked at for its keys.
    let like = unit.clone().unwrap_or_else(Unit::one);
    let readable = unit.is_some() && kind.is_some();
    let typical = section.get("typical").filter(|_| readable).and_then(|item| item.positive(&like));
    let about = section.get("about").and_then(|item| item.string()).unwrap_or("").to_owned();
    let said = said_of(&section, readable.then_some((&like, kind.unwrap_or(Kind::Scalar))));
    section.finish();
    let values = |list: Option<Vec<(f64, Unit)>>| {
        list.map(|list| list.into_iter().map(|(value, _)| value).collect::<Vec<f64>>())
    };
    Some(ParameterDeclaration {
        name,
        span: item.key_span(),
        kind: kind?,
        unit: unit?,
        per_measurand,
        process: process.unwrap_or(Process::White),
        shape: shape.unwrap_or(Shape::Normal),
        memory: memory.map(|(value, _)| value),
        setting: Setting {
            fixed: said.fixed.unwrap_or(false),
            sum_zero: said.sum_zero.unwrap_or(false),
            value: values(said.value),
            sigma: values(said.sigma),
            lower: values(said.lower),
            upper: values(said.upper),
            start: values(said.start),
            plausible: said.plausible.map(|(value, _)| value),
            linear_range: said.linear_range.map(|(value, _)| value),
            simulated_at: said.simulated_at.map(|(value, _)| value),
            typical: typical.map(|(value, _)| value),
            ..Setting::new(said.scope.unwrap_or(default))
        },
        about,
    })
}

/// Reads what a file says of a parameter that it does not declare: value, sigma, fixed, lower,
/// upper, start, plausible, linear_range, simulated_at, scope, sum. Units are checked when the
/// parameter is known.
pub fn override_of(source: &Source, item: &Item<'_>) -> Option<Override> {
    let section = item.section(&format!("the line on `{}`", item.key()))?;
    let said = said_of(&section, None);
    let _ = section.get("about").and_then(|item| item.string());
    section.finish();
    Some(Override {
        name: item.key().to_owned(),
        place: Some(source.place(item.key_span())),
        ..said
    })
}

/// The keys that a declaration and an override share; `known` is the parameter's unit and kind.
pub fn said_of(section: &Section<'_>, known: Option<(&Unit, Kind)>) -> Override {
    let list = |key: &'static str, read: &dyn Fn(&Item<'_>) -> Option<(f64, Unit)>| {
        let item = section.get(key)?;
        let count = match known {
            Some((_, kind)) => component_count(kind),
            None if item.is_list() => 3,
            None => 1,
        };
        item.components(count, read)
    };
    let value = |item: &Item<'_>| match known {
        Some((unit, _)) => item.quantity(unit),
        None => item.any_quantity(None),
    };
    let width = |item: &Item<'_>| match known {
        Some((unit, _)) => item.positive(unit),
        None => {
            let (_, unit) = item.any_quantity(None)?;
            item.positive(&unit)
        }
    };
    let said = Override {
        name: String::new(),
        setup: None,
        place: None,
        value: list("value", &value),
        sigma: list("sigma", &width),
        lower: list("lower", &value),
        upper: list("upper", &value),
        start: list("start", &value),
        plausible: section.get("plausible").and_then(|item| width(&item)),
        linear_range: section.get("linear_range").and_then(|item| width(&item)),
        simulated_at: section.get("simulated_at").and_then(|item| value(&item)),
        fixed: section.get("fixed").and_then(|item| item.boolean()),
        free: false,
        scope: section.get("scope").and_then(|item| item.choice(SCOPES)),
        sum_zero: section
            .get("sum")
            .and_then(|item| item.choice(&[("zero", true), ("free", false)])),
        degrees_of_freedom: None,
    };
    if let (Some(lower), Some(upper)) = (&said.lower, &said.upper)
        && lower.iter().zip(upper).any(|((lower, _), (upper, _))| lower >= upper)
        && let Some(item) = section.get("lower")
    {
        item.error("`lower` must be below `upper`", "");
    }
    let beyond = |bound: &Option<Vec<(f64, Unit)>>, is_beyond: fn(f64, f64) -> bool| {
        let mut pairs = said.value.iter().flatten().zip(bound.iter().flatten());
        pairs.any(|((value, _), (bound, _))| is_beyond(*value, *bound))
    };
    if (beyond(&said.lower, |value, lower| value < lower)
        || beyond(&said.upper, |value, upper| value > upper))
        && let Some(item) = section.get("value")
    {
        item.error("`value` is not between `lower` and `upper`", "");
    }
    if said.fixed == Some(true)
        && said.sigma.is_some()
        && let Some(item) = section.get("sigma")
    {
        item.error(
            "a parameter is either fixed or known with a standard uncertainty",
            "leave out `fixed` to use `sigma` as prior knowledge",
        );
    }
    if said.sigma.is_some()
        && said.value.is_none()
        && known.is_some()
        && let Some(item) = section.get("sigma")
    {
        item.error("`sigma` is the standard uncertainty of `value`, which is missing", "");
    }
    said
}
