//! Other minima that the readings cannot exclude.

use serde_json::{Value, json};

use crate::estimate::calibrate::Calibration;
use crate::estimate::minima::Other;
use crate::report::figure;
use crate::units::decimal;

/// A sentence for each parameter; empty if there are none.
pub fn text(result: &Calibration, others: &[Other]) -> String {
    let mut text = String::new();
    for (at, one) in others.iter().enumerate() {
        let instance = &result.problem.layout.instances[one.instance];
        let own = |other: &&Other| other.instance == one.instance;
        if others[..at].iter().any(|other| own(&other)) {
            continue;
        }
        let sigma = result.estimates_of(one.instance).first().and_then(|one| one.sigma);
        let value = |value: f64| figure::value(value, sigma, &instance.unit);
        let values: Vec<String> = others
            .iter()
            .filter(own)
            .map(|one| {
                let (size, word) = (
                    one.chi_squared.abs(),
                    if one.chi_squared < 0.0 { "smaller" } else { "larger" },
                );
                format!("{} (chi squared {word} by {})", value(one.values[0]), decimal(size, 1))
            })
            .collect();
        let of = instance.of.as_ref().map(|of| format!("@{of}")).unwrap_or_default();
        text.push_str(&format!(
            "\nThe solution is ambiguous: beside `{}{of}` = {} the readings do not exclude {}, and perhaps more.\n",
            instance.name,
            value(one.values[1]),
            values.join(" or "),
        ));
    }
    if !others.is_empty() {
        text.push_str("Other parameters may differ there, too; the uncertainties are those of one solution. State what is known: a value with its sigma, a start, bounds or `delay_range`.\n");
    }
    text
}

/// The same for programs.
pub fn json(result: &Calibration, others: &[Other]) -> Value {
    let each = others.iter().map(|one| {
        let instance = &result.problem.layout.instances[one.instance];
        json!({
            "parameter": instance.name,
            "of": instance.of,
            "value": one.values[0],
            "chi_squared": one.chi_squared,
        })
    });
    json!({ "other_minima": each.collect::<Vec<_>>() })
}
