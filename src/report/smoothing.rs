//! What errors of smoothed streams add to the standard uncertainties of readings, and by how much they
//! bias estimates.

use serde_json::{Value, json};

use crate::engine::Part;
use crate::estimate::calibrate::Calibration;
use crate::estimate::stream_bias::{Cause, StreamBias};
use crate::report::figure;
use crate::report::json::number;
use crate::units::decimal;

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

/// Which estimates streams bias, in sentences; empty where they bias none.
pub fn text_of_bias(all: &[StreamBias]) -> String {
    let sentence = |by: Cause, what: &str, then: &str| {
        let own = all.iter().filter(|one| one.by == by);
        let each = own.map(|StreamBias { estimate, bias, .. }| {
            let of = estimate.of.as_ref().map_or_else(String::new, |of| format!(" of {of}"));
            let size = figure::value(*bias, estimate.sigma, &estimate.declared);
            let times = decimal(bias.abs() / estimate.sigma.unwrap_or(f64::NAN), 1);
            format!("`{}`{of} by about {size} ({times} times its uncertainty)", estimate.name)
        });
        let each: Vec<String> = each.collect();
        if each.is_empty() {
            return String::new();
        }
        format!("\n{what} biases {}: {then}\n", each.join(", "))
    };
    let of_noise = sentence(
        Cause::Noise,
        "The noise of smoothed streams",
        "what multiplies a noisy rate or acceleration comes out too small, and other parameters follow; no weight corrects that. Smooth more, or record the stream with less noise.",
    );
    let of_smoothing = sentence(
        Cause::Smoothing,
        "What smoothing takes off the motion",
        "smooth less (`smooth`, or a smaller `sigma` of the input).",
    );
    of_noise + &of_smoothing
}

/// The same for programs.
pub fn json_of_bias(all: &[StreamBias]) -> Value {
    let each = all.iter().map(|StreamBias { estimate, bias, by }| {
        let by = match by {
            Cause::Noise => "noise",
            Cause::Smoothing => "smoothing",
        };
        json!({ "name": estimate.name, "of": estimate.of, "bias": number(Some(*bias)), "by": by })
    });
    json!({ "stream_bias": each.collect::<Vec<_>>() })
}

/// What errors of smoothed streams add, for programs.
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
