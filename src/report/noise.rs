//! The noise for which uncertainties hold.

use serde_json::{Value, json};

use crate::engine::gauss_markov::{GaussMarkov, Process};
use crate::estimate::noise::{Clusters, Estimated, Noise};
use crate::report::json::number;
use crate::units::decimal;

/// In sentences; empty where it is as stated.
pub fn text(noise: &Noise) -> String {
    match noise {
        Noise::Stated => String::new(),
        Noise::Autocorrelated(all) => {
            let each = all.iter().map(|one| format!("- {}\n", estimated(one)));
            format!(
                "\nUncertainties hold for noise as it was estimated:\n{}",
                each.collect::<String>()
            )
        }
        Noise::Sandwich(Clusters { count, samples: None }) => {
            format!("\nUncertainties are cluster-robust, over {count} runs.\n")
        }
        Noise::Sandwich(Clusters { count, samples: Some(samples) }) => format!(
            "\nUncertainties are cluster-robust, over {count} stretches of {samples} samples.\n"
        ),
    }
}

fn estimated(one: &Estimated) -> String {
    let is_over_rows = one.is_over_rows;
    let of = one.of.as_ref().map_or_else(String::new, |of| format!(" of `{of}`"));
    let level =
        format!("`{}`{of}: {} times the stated scatter", one.measurand, decimal(one.level, 2));
    let part = |noise: &Option<GaussMarkov>| match noise {
        None => "white".to_owned(),
        Some(noise) => {
            let each = noise.processes().map(|one| {
                let percent = 100.0 * one.share;
                let unit = if is_over_rows { "rows" } else { "s" };
                let time = significant(one.time);
                format!("{percent:.0} % of its variance correlated over {time} {unit}")
            });
            each.collect::<Vec<_>>().join(" and ")
        }
    };
    let mut parts: Vec<String> = one.components.iter().map(part).collect();
    parts.dedup();
    format!("{level}, {}", parts.join("; "))
}

/// Three digits that count.
fn significant(value: f64) -> String {
    let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0);
    decimal(value, decimals as usize)
}

/// A Gauss-Markov process for programs: its correlation time, or a number of rows.
pub(super) fn process_json(one: Process, is_over_rows: bool) -> Value {
    let (time, rows) = if is_over_rows { (None, Some(one.time)) } else { (Some(one.time), None) };
    json!({ "share": number(Some(one.share)), "time": number(time), "rows": number(rows) })
}

/// The noise for programs.
pub fn json(noise: &Noise) -> Value {
    let value = match noise {
        Noise::Stated => json!({ "model": "stated" }),
        Noise::Autocorrelated(all) => {
            let each = all.iter().map(|one| {
                let components = one.components.iter().map(|noise| {
                    let processes = noise.iter().flat_map(GaussMarkov::processes);
                    let each = processes.map(|process| process_json(process, one.is_over_rows));
                    each.collect::<Vec<_>>()
                });
                json!({
                    "measurand": one.measurand,
                    "of": one.of,
                    "level": number(Some(one.level)),
                    "components": components.collect::<Vec<_>>(),
                })
            });
            json!({ "model": "autocorrelated", "measurands": each.collect::<Vec<_>>() })
        }
        Noise::Sandwich(Clusters { count, samples }) => {
            json!({ "model": "sandwich", "clusters": count, "samples": samples })
        }
    };
    json!({ "noise": value })
}
