//! Cheap looks at the set-up before any fit: rates that contradict their angles, angles that cannot be, and
//! mistakes that would make the coordinates fit far better if they were undone.
//!
//! Each finding is a sentence; nothing is changed.

mod mistakes;
mod rates;

use std::f64::consts::PI;

use crate::campaign::Run;
use crate::diagnostic::Diagnostic;
use crate::engine::{Part, Point, Problem};
use crate::graph::MeasurandKind;

/// Samples of a run that are looked at.
const LOOK: usize = 400;

/// Looks at every campaign of a problem.
pub fn check(problem: &Problem) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let start = Point::start(&problem.layout);
    for p in 0..problem.parts.len() {
        let part = &problem.parts[p];
        for run in &part.runs {
            found.extend(rates::rates(part, run));
        }
        found.extend(rates::missing_rates(part));
        found.extend(unread(part));
        found.extend(angles(part));
        found.extend(mistakes::mistakes(problem, p, &start));
    }
    found
}

/// Measurands that a run does not read, though it reads others and other runs read them.
fn unread(part: &Part) -> Vec<Diagnostic> {
    let present: Vec<Vec<usize>> = (0..part.runs.len()).map(|run| part.present_in(run)).collect();
    let is_read = |run: &[usize]| run.iter().any(|count| *count > 0);
    let mut found = Vec::new();
    for (m, measurand) in part.system.assembly.names.measurands.iter().enumerate() {
        let lacks = |run: &(&Run, &Vec<usize>)| is_read(run.1) && run.1[m] == 0;
        let without = part.runs.iter().zip(&present).filter(lacks);
        let names: Vec<&str> = without.map(|(run, _)| run.name.as_str()).collect();
        if names.is_empty() || present.iter().all(|run| run[m] == 0) {
            continue;
        }
        let words =
            format!("{} no reading of `{}`, which other runs have", having(&names), measurand.name);
        let help =
            "is its column there, under this name? what a run does not read it says nothing of";
        found.push(Diagnostic::warning(words).help(help));
    }
    found
}

/// Runs named in one warning.
const MOST_NAMES: usize = 6;

/// ``run `a` has`` or ``runs `a`, `b` have``.
fn having(names: &[&str]) -> String {
    let (runs, has) = if names.len() == 1 { ("run", "has") } else { ("runs", "have") };
    format!("{runs} {} {has}", listed(names))
}

/// `` `a`, `b` ``, and how many more.
fn listed(names: &[&str]) -> String {
    let quoted = names.iter().take(MOST_NAMES).map(|name| format!("`{name}`"));
    let quoted = quoted.collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST_NAMES) {
        0 => quoted,
        more => format!("{quoted} and {more} more"),
    }
}

/// Angles that cannot be: beyond two turns.
fn angles(part: &Part) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for (measurand, slot) in part.system.assembly.names.measurands.iter().zip(part.slots()) {
        if !matches!(measurand.kind, MeasurandKind::Angle { .. }) {
            continue;
        }
        for run in &part.runs {
            let mut reading = None;
            run.record.walk(|stretch| {
                let readings = &stretch.samples.readings[slot.column][stretch.range()];
                let wide = || readings.iter().find(|value| value.abs() > 4.0 * PI);
                reading = reading.or_else(|| wide().copied());
            });
            let Some(reading) = reading else { continue };
            found.push(
                Diagnostic::warning(format!(
                    "run `{}`: `{}` reads {:.3} rad, more than two turns",
                    run.name, measurand.name, reading
                ))
                .help(
                    "check the unit in the column's header: deg, gon and rad are easily confused",
                ),
            );
            break;
        }
    }
    found
}
