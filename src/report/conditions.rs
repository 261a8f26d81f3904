//! What stands beside the delays: the transformation's residuals, the bias of the paper's way, the
//! delays under changed conditions, the agreement of campaigns.

use serde_json::{Map, Value, json};

use crate::estimate::bias::Bias;
use crate::estimate::conditions::SelfCalibration;
use crate::estimate::repeatability::Repeatability;
use crate::estimate::transformation::Transformation;
use crate::report::json::number;

fn run_name(given: &Transformation, part: usize, run: usize) -> &str {
    &given.problem.parts[part].runs[run].name
}

/// Where the transformation is from, and its residuals.
pub fn transformation_json(given: &Transformation) -> Value {
    let residuals: Map<String, Value> =
        given.residuals.iter().map(|(name, one)| (name.clone(), number(Some(*one)))).collect();
    json!({
        "transformation": given.from.word(),
        "transformation_residuals": residuals,
        "rounds": given.rounds,
    })
}

/// The bias of the paper's way.
pub fn bias_json(given: &Transformation, part: usize, list: &[Bias]) -> Value {
    let rows: Vec<Value> = list
        .iter()
        .map(|one| {
            json!({
                "run": run_name(given, part, one.run),
                "measurand": one.measurand,
                "paper": one.paper,
                "iterated": one.iterated,
                "bias": one.paper - one.iterated,
                "expected": number(one.expected),
            })
        })
        .collect();
    json!({ "paper_bias": rows })
}

/// Delays under changed conditions.
pub fn json(given: &Transformation, part: usize, whole: &SelfCalibration) -> Value {
    let name = |run: usize| run_name(given, part, run);
    let setups = &given.problem.parts[part].setups;
    let conditions: Vec<Value> = whole
        .conditions
        .iter()
        .map(|one| {
            json!({
                "run": name(one.run),
                "setup": setups[one.setup],
                "arm_rate": number(Some(one.rate)),
                "platform_rate": number(Some(one.platform_rate)),
                "measurand": one.measurand,
                "mean": number(Some(one.mean)),
                "sigma": number(Some(one.sigma)),
            })
        })
        .collect();
    let contrasts: Vec<Value> = whole
        .contrasts
        .iter()
        .map(|one| {
            json!({
                "measurand": one.measurand,
                "changed": one.changed.word(),
                "runs": one.runs.map(name),
                "difference": number(Some(one.difference)),
                "sigma": number(Some(one.sigma)),
                "p": number(Some(one.probability())),
            })
        })
        .collect();
    let splits: Vec<Value> = whole
        .splits
        .iter()
        .map(|one| {
            json!({
                "measurand": one.measurand,
                "delay": number(Some(one.delay)),
                "delay_sigma": number(Some(one.delay_sigma)),
                "angle": number(Some(one.angle)),
                "angle_sigma": number(Some(one.angle_sigma)),
                "chi_squared": number(Some(one.chi_squared)),
                "degrees_of_freedom": one.degrees_of_freedom,
            })
        })
        .collect();
    json!({ "conditions": conditions, "contrasts": contrasts, "splits": splits, "words": whole.words() })
}

/// Agreement of campaigns.
pub fn repeatability_json(labels: &[String], list: &[(String, Repeatability)]) -> Value {
    let entries: Map<String, Value> = list
        .iter()
        .map(|(name, one)| {
            let pairs: Vec<Value> = one
                .pairs
                .iter()
                .map(|pair| {
                    json!({
                        "campaigns": pair.campaigns.map(|k| &labels[k]),
                        "difference": number(Some(pair.difference)),
                        "normalised_error": number(Some(pair.normalised_error)),
                    })
                })
                .collect();
            let value = json!({
                "mean": number(Some(one.mean)),
                "sigma": number(Some(one.sigma)),
                "between": number(Some(one.between)),
                "chi_squared": number(Some(one.chi_squared)),
                "degrees_of_freedom": one.degrees_of_freedom,
                "drift": number(one.drift),
                "drift_sigma": number(one.drift_sigma),
                "pairs": pairs,
            });
            (name.clone(), value)
        })
        .collect();
    json!({ "repeatability": entries })
}

#[cfg(feature = "cli")]
mod words {
    use super::*;
    use crate::estimate::transformation::From;
    use crate::report::figure::{measured, size};
    use crate::report::layout::{align_right, drawn, table};
    use crate::report::text::residual_unit;
    use crate::units::{Unit, decimal};

    /// Rows of contrasts that are shown; the rest is in the JSON.
    const MOST_ROWS: usize = 40;

    fn microseconds(seconds: f64) -> String {
        format!("{:+.2} µs", (seconds * 1e8).round() / 100.0 + 0.0)
    }

    /// The transformation's residuals for people.
    pub fn transformation_text(given: &Transformation, part: usize) -> String {
        let names = &given.problem.parts[part].system.assembly.names.measurands;
        let unit = |name: &str| {
            names.iter().find(|one| one.name == name).map_or_else(Unit::one, |one| one.unit.clone())
        };
        let words: Vec<String> = given
            .residuals
            .iter()
            .map(|(name, one)| format!("{name} {}", size(*one, &residual_unit(*one, &unit(name)))))
            .collect();
        let mut text = format!("standard uncertainty from residuals: {}\n", words.join(", "));
        if given.from == From::Iterated {
            text.push_str(&format!(
                "{} rounds until delays and transformation agree\n",
                given.rounds
            ));
        }
        text + "\n"
    }

    /// The bias of the paper's way for people.
    pub fn bias_text(given: &Transformation, part: usize, list: &[Bias]) -> String {
        let mut rows =
            table(&["run", "measurand", "paper", "iterated", "bias", "-delay x slow rate / rate"]);
        for one in list {
            rows.add_row([
                run_name(given, part, one.run).to_owned(),
                one.measurand.clone(),
                microseconds(one.paper),
                microseconds(one.iterated),
                microseconds(one.paper - one.iterated),
                one.expected.map_or_else(|| "-".to_owned(), microseconds),
            ]);
        }
        align_right(&mut rows, &[2, 3, 4, 5]);
        format!("bias of the paper's transformation\n{}\n", drawn(&rows))
    }

    /// Delays under changed conditions for people; nothing where there is one run.
    pub fn text(given: &Transformation, part: usize, whole: &SelfCalibration) -> String {
        if whole.contrasts.is_empty() {
            return String::new();
        }
        let setups = &given.problem.parts[part].setups;
        let mut rows = table(&["run", "setup", "arm", "measurand", "delay"]);
        for one in &whole.conditions {
            let platform = match one.platform_rate.to_degrees() {
                0.0 => String::new(),
                rate => format!(", platform {rate:+.1}"),
            };
            rows.add_row([
                run_name(given, part, one.run).to_owned(),
                setups[one.setup].clone(),
                format!("{:+.1}{platform} deg/s", one.rate.to_degrees()),
                one.measurand.clone(),
                measured(one.mean, one.sigma, &Unit::second()),
            ]);
        }
        align_right(&mut rows, &[2, 4]);
        let mut text = format!("self-calibration\n{}\n", drawn(&rows));
        let mut rows = table(&["changed", "measurand", "from", "to", "difference", "p"]);
        for one in whole.contrasts.iter().take(MOST_ROWS) {
            let [a, b] = one.runs.map(|run| run_name(given, part, run).to_owned());
            let p = one.probability();
            let p = if p < 1e-3 { format!("{p:.0e}") } else { format!("{p:.3}") };
            rows.add_row([
                one.changed.word().to_owned(),
                one.measurand.clone(),
                a,
                b,
                measured(one.difference, one.sigma, &Unit::second()),
                p,
            ]);
        }
        align_right(&mut rows, &[4, 5]);
        text.push_str(&drawn(&rows));
        if whole.contrasts.len() > MOST_ROWS {
            let rest = whole.contrasts.len() - MOST_ROWS;
            text.push_str(&format!("... and {rest} more: `--format json` has all\n"));
        }
        for one in &whole.splits {
            let arcsec = |radians: f64| radians.to_degrees() * 3600.0;
            text.push_str(&format!(
                "`{}`: a delay of {} that stays, and an arm angle of {:+.2} ± {:.2} arcsec that turns with the arm\n",
                one.measurand,
                measured(one.delay, one.delay_sigma, &Unit::second()),
                arcsec(one.angle),
                arcsec(one.angle_sigma),
            ));
        }
        for words in whole.words() {
            text.push_str(&format!("- {words}\n"));
        }
        text + "\n"
    }

    /// Agreement of campaigns for people.
    pub fn repeatability_text(labels: &[String], list: &[(String, Repeatability)]) -> String {
        let mut rows = table(&["measurand", "mean", "between", "chi^2", "drift a campaign"]);
        let mut pairs = table(&["measurand", "campaigns", "", "difference", "E_n (k=2)"]);
        for (name, one) in list {
            let drift = one.drift.zip(one.drift_sigma);
            rows.add_row([
                name.clone(),
                measured(one.mean, one.sigma, &Unit::second()),
                format!("{} µs", decimal(one.between * 1e6, 2)),
                format!("{} / {}", decimal(one.chi_squared, 2), one.degrees_of_freedom),
                drift.map_or_else(|| "-".to_owned(), |(d, u)| measured(d, u, &Unit::second())),
            ]);
            for pair in &one.pairs {
                let [a, b] = pair.campaigns.map(|k| labels[k].clone());
                let error = format!("{:+.2}", pair.normalised_error);
                pairs.add_row([name.clone(), a, b, microseconds(pair.difference), error]);
            }
        }
        align_right(&mut rows, &[1, 2, 3, 4]);
        align_right(&mut pairs, &[3, 4]);
        format!("between campaigns\n{}\n{}\n", drawn(&rows), drawn(&pairs))
    }
}

#[cfg(feature = "cli")]
pub use words::{bias_text, repeatability_text, text, transformation_text};
