//! What errors of smoothed streams add to the standard uncertainties of readings.

use serde_json::{Value, json};

use crate::engine::Part;
use crate::estimate::calibrate::Calibration;
use crate::report::figure;
use crate::report::json::number;

/// Where to look for the part of it that is no noise.
pub const WHERE: &str = "An oscillation, or what is found over a rate or an acceleration of such a stream, may be what its smoothing takes off the motion: compare with a shorter `smooth`.\n";

/// For each campaign, run and measurand what is added (SI).
fn all(result: &Calibration) -> impl Iterator<Item = (&Part, usize, usize, f64)> {
    result.problem.parts.iter().flat_map(|part| {
        let runs = part.smoothing_sigma.iter().enumerate();
        runs.flat_map(move |(run, added)| {
            let added = added.iter().enumerate().filter(|(_, sigma)| **sigma > 0.0);
            added.map(move |(measurand, sigma)| (part, run, measurand, *sigma))
        })
    })
}

/// In a sentence, with the most of all runs; empty where nothing is added.
pub fn text(result: &Calibration) -> String {
    let mut most: Vec<(&Part, usize, f64)> = Vec::new();
    for (part, _, measurand, sigma) in all(result) {
        let name = |part: &Part, measurand: usize| {
            part.system.assembly.names.measurands[measurand].name.clone()
        };
        let same = |one: &&mut (&Part, usize, f64)| name(one.0, one.1) == name(part, measurand);
        match most.iter_mut().find(same) {
            Some(known) => known.2 = known.2.max(sigma),
            None => most.push((part, measurand, sigma)),
        }
    }
    if most.is_empty() {
        return String::new();
    }
    let each = most.iter().map(|(part, measurand, sigma)| {
        let declared = &part.system.assembly.names.measurands[*measurand];
        format!("`{}` {}", declared.name, figure::size(*sigma, &part.unit_of(*measurand)))
    });
    format!(
        "\nThe smoothing of streams (their noise, and what it takes off the motion) adds to the standard uncertainty of readings: {}. The weights count it.\n",
        each.collect::<Vec<_>>().join(", ")
    )
}

/// The same for programs.
pub fn json(result: &Calibration) -> Value {
    let each = all(result).map(|(part, run, measurand, sigma)| {
        json!({
            "measurand": part.system.assembly.names.measurands[measurand].name,
            "run": part.run_name(run),
            "sigma": number(Some(sigma)),
        })
    });
    json!({ "smoothing": each.collect::<Vec<_>>() })
}
