//! Other minima that the readings cannot exclude.

use serde_json::{Value, json};

use crate::estimate::calibrate::Calibration;
use crate::estimate::minima::Other;
use crate::graph::Kind;
use crate::model::component::AXES;
use crate::report::figure;
use crate::units::decimal;

/// Which parameters are ambiguous, each by itself; empty if there are none.
pub fn text(result: &Calibration, others: &[Other]) -> String {
    let mut lines: Vec<Line> = Vec::new();
    for (at, one) in others.iter().enumerate() {
        let own =
            |other: &&Other| (other.instance, other.component) == (one.instance, one.component);
        if others[..at].iter().any(|other| own(&other)) {
            continue;
        }
        let values = others.iter().filter(own).map(|other| excluded(result, other));
        lines.push(Line {
            name: name(result, one.instance, one.component),
            value: value(result, one.instance, one.component, one.values[1]),
            others: values.collect::<Vec<_>>().join(" or ") + &alike(result, one.instance),
        });
    }
    let text = match &lines[..] {
        [] => return String::new(),
        [Line { name, value, others }] => format!(
            "\nThe solution is ambiguous: beside `{name}` = {value} the readings do not exclude {others}, and perhaps more.\n"
        ),
        _ => {
            let each = lines.iter().map(|Line { name, value, others }| {
                format!("  `{name}` = {value}: not excluded is {others}\n")
            });
            format!(
                "\nThe solution is ambiguous in {} parameters, in each by itself, and perhaps in more:\n{}",
                lines.len(),
                each.collect::<String>()
            )
        }
    };
    text + "Other parameters may differ there, too; the uncertainties are those of one solution. State what is known: a value with its sigma, a start, bounds or `delay_range`.\n"
}

/// What is said of one parameter.
struct Line {
    name: String,
    value: String,
    others: String,
}

/// That of an angle of each run or setup one was tried.
fn alike(result: &Calibration, instance: usize) -> String {
    let instances = &result.problem.layout.instances;
    let own = &instances[instance];
    let count = instances.iter().filter(|one| one.name == own.name).count();
    match own.kind != Kind::Rotation && own.unit.is_angle() && count > 1 {
        true => format!(" (of the {count} values of `{}` one was tried)", own.name),
        false => String::new(),
    }
}

/// A value that the readings do not exclude, with what goes with it.
fn excluded(result: &Calibration, one: &Other) -> String {
    let word = if one.chi_squared < 0.0 { "smaller" } else { "larger" };
    let size = decimal(one.chi_squared.abs(), 1);
    let with = one.with.iter().map(|(instance, component, at)| {
        let value = value(result, *instance, *component, *at);
        format!(" with `{}` = {value}", name(result, *instance, *component))
    });
    let own = value(result, one.instance, one.component, one.values[0]);
    format!("{own}{} (chi squared {word} by {size})", with.collect::<String>())
}

/// A value of a component, to the place of the estimate's uncertainty.
fn value(result: &Calibration, instance: usize, component: usize, value: f64) -> String {
    let estimates = result.estimates_of(instance);
    let sigma = estimates.get(component).and_then(|one| one.sigma);
    figure::value(value, sigma, &result.problem.layout.instances[instance].unit)
}

/// `anchor.z`, or `anchor.z@SETUP`.
fn name(result: &Calibration, instance: usize, component: usize) -> String {
    let of = result.problem.layout.instances[instance].of.as_ref();
    let of = of.map(|of| format!("@{of}")).unwrap_or_default();
    own_name(result, instance, component) + &of
}

/// `anchor.z`, wherever it holds.
fn own_name(result: &Calibration, instance: usize, component: usize) -> String {
    let one = &result.problem.layout.instances[instance];
    match one.kind {
        Kind::Scalar => one.name.clone(),
        _ => format!("{}.{}", one.name, AXES[component]),
    }
}

/// The same for programs.
pub fn json(result: &Calibration, others: &[Other]) -> Value {
    let of = |instance: usize| &result.problem.layout.instances[instance].of;
    let each = others.iter().map(|one| {
        let with = one.with.iter().map(|(instance, component, value)| {
            json!({
                "parameter": own_name(result, *instance, *component),
                "of": of(*instance),
                "value": value,
            })
        });
        json!({
            "parameter": own_name(result, one.instance, one.component),
            "of": of(one.instance),
            "value": one.values[0],
            "chi_squared": one.chi_squared,
            "with": with.collect::<Value>(),
        })
    });
    json!({ "other_minima": each.collect::<Vec<_>>() })
}
