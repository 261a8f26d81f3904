//! Uncertainty budgets of delays, in a table and for programs.

use serde_json::{Value, json};

use crate::estimate::blind::BlindRange;
use crate::estimate::budget::{Budget, Contribution};
use crate::estimate::coverage::{Combined, LEVEL};
#[cfg(feature = "cli")]
use crate::report::layout;
#[cfg(feature = "cli")]
use crate::units::decimal;

/// What programs read of a budget.
pub fn json(budget: &Budget) -> Value {
    let contributions: Vec<Value> = budget
        .contributions
        .iter()
        .map(|one| {
            json!({
                "source": one.source,
                "name": one.name,
                "part": part(one),
                "reading": one.reading,
                "reading_percent": percent(one.reading, budget.reading.sigma),
                "mean": one.mean,
                "mean_percent": percent(one.mean, budget.mean.sigma),
                "degrees_of_freedom": one.degrees_of_freedom,
            })
        })
        .collect();
    let differences = budget.differences.map(|one| {
        json!({
            "boundary": one.boundary,
            "median_expanded_uncertainty": one.median,
            "smallest_expanded_uncertainty": one.smallest,
            "exact_median_expanded_uncertainty": one.exact_median,
            "exact_smallest_expanded_uncertainty": one.exact_smallest,
            "worst_ratio": one.worst_ratio,
        })
    });
    json!({
        "contributions": contributions,
        "reading": combined(&budget.reading),
        "mean": combined(&budget.mean),
        "level": LEVEL,
        "one_millisecond_table": differences,
    })
}

fn combined(one: &Combined) -> Value {
    let finite = Some(one.degrees_of_freedom).filter(|degrees| degrees.is_finite());
    json!({
        "sigma": one.sigma,
        "degrees_of_freedom": finite,
        "coverage_factor": one.coverage_factor,
        "expanded_uncertainty": one.expanded(),
    })
}

/// Blind ranges for programs (rad).
pub fn blind_json(ranges: &[BlindRange]) -> Value {
    let one = |range: &BlindRange| {
        let BlindRange { setup, from, to, readings } = range;
        json!({ "setup": setup, "from": from, "to": to, "readings": readings })
    };
    ranges.iter().map(one).collect()
}

fn part(one: &Contribution) -> &'static str {
    if one.is_common { "common" } else { "random" }
}

/// Share of the variance in percent.
fn percent(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { 100.0 * (part / whole).powi(2) } else { 0.0 }
}

/// A line below the contributions: its name, and what it says.
#[cfg(feature = "cli")]
type Line = (&'static str, fn(&Combined) -> String);

/// The budgets as tables.
#[cfg(feature = "cli")]
pub fn text(budgets: &[Budget]) -> String {
    let mut text = String::new();
    for budget in budgets {
        text.push_str(&format!(
            "\nbudget of the delays of {} (standard uncertainties, percent of the variance)\n",
            budget.measurand
        ));
        let header = ["contribution", "part", "one reading [µs]", "%", "mean [µs]", "%", "d.o.f."];
        let mut rows = layout::table(&header);
        let micro = |seconds: f64| decimal(1e6 * seconds, 4);
        let share = |part, whole| decimal(percent(part, whole), 1);
        for one in &budget.contributions {
            rows.add_row([
                one.name.clone(),
                part(one).to_owned(),
                micro(one.reading),
                share(one.reading, budget.reading.sigma),
                micro(one.mean),
                share(one.mean, budget.mean.sigma),
                one.degrees_of_freedom.map_or_else(String::new, |degrees| degrees.to_string()),
            ]);
        }
        let lines: [Line; 4] = [
            ("combined", |one| decimal(1e6 * one.sigma, 4)),
            ("effective degrees of freedom", |one| match one.degrees_of_freedom {
                degrees if degrees > 1e4 => "∞".to_owned(),
                degrees => decimal(degrees, 1),
            }),
            ("coverage factor k (95.45 %)", |one| decimal(one.coverage_factor, 3)),
            ("expanded, U", |one| decimal(1e6 * one.expanded(), 4)),
        ];
        for (name, of) in lines {
            let (reading, mean) = (of(&budget.reading), of(&budget.mean));
            rows.add_row([name, "", &reading, "", &mean, "", ""]);
        }
        layout::align_right(&mut rows, &[2, 3, 4, 5, 6]);
        text.push_str(&layout::drawn(&rows));
        if let Some(one) = budget.differences {
            text.push_str(&format!(
                "U (k=2) of one reading by differences over 1 ms: median {} µs, smallest {} µs; exactly {} and {}; at most {} times apart\n",
                micro(one.median),
                micro(one.smallest),
                micro(one.exact_median),
                micro(one.exact_smallest),
                decimal(one.worst_ratio, 2)
            ));
        }
    }
    text
}

/// Ranges shown of a measurand; the rest is in the JSON.
#[cfg(feature = "cli")]
const MOST_RANGES: usize = 12;

/// Blind ranges in a line for each measurand that has some.
#[cfg(feature = "cli")]
pub fn blind_text(measurand: &str, ranges: &[BlindRange]) -> String {
    if ranges.is_empty() {
        return String::new();
    }
    let several = ranges.iter().any(|range| range.setup != ranges[0].setup);
    let shown: Vec<String> = ranges
        .iter()
        .take(MOST_RANGES)
        .map(|range| {
            let (from, to) = (range.from.to_degrees(), range.to.to_degrees());
            // Past the homepoint people count anew; a whole turn stays one.
            let to = if to > 360.0 { to - 360.0 } else { to };
            let of = if several { format!(" ({})", range.setup) } else { String::new() };
            format!("{from:.1} to {to:.1}{of}")
        })
        .collect();
    let more = match ranges.len().saturating_sub(MOST_RANGES) {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    format!("{measurand} is blind at arm angles [deg] {}{more}\n", shown.join(", "))
}
