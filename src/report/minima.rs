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
        let values: Vec<String> =
            others.iter().filter(own).map(|one| value(one.values[0])).collect();
        let most = others.iter().filter(own).map(|one| one.chi_squared).fold(0.0, f64::max);
        text.push_str(&format!(
            "\nThe solution is ambiguous: `{}` = {} fits equally well as {} (chi squared larger by {}).\n",
            instance.name,
            values.join(" or "),
            value(one.values[1]),
            decimal(most, 1)
        ));
    }
    if !others.is_empty() {
        text.push_str("Other parameters may differ there, too; the uncertainties are those of one solution. State what is known: a value with its sigma, or bounds.\n");
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
