//! Cheap looks at the set-up before any fit: rates that contradict their angles, angles that cannot
//! be, readings that are rounded more coarsely than stated, and mistakes that would make the coordinates fit far better if they were undone.
//!
//! Each finding is a sentence; nothing is changed.

mod mistakes;
mod rates;
mod repeated;
mod resolution;
mod stamps;

use std::f64::consts::PI;

use crate::campaign::Run;
use crate::diagnostic::Diagnostic;
use crate::engine::part::Slot;
use crate::engine::{Part, Point, Problem};
use crate::formula::{ExpressionKind, Function};
use crate::graph::MeasurandKind;
use crate::graph::names::Measurand;
use crate::units::decimal;

pub use repeated::repeated;

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
            found.extend(stamps::stamps(run));
        }
        found.extend(rates::missing_rates(part));
        found.extend(unread(part));
        found.extend(resolution::resolution(part));
        found.extend(angles(part));
        found.extend(periods_to_state(part));
        found.extend(mistakes::mistakes(problem, p, &start));
    }
    found
}

/// Measurands that a run does not read, though it reads others and other runs read them.
fn unread(part: &Part) -> Vec<Diagnostic> {
    let present: Vec<Vec<bool>> = part.runs.iter().map(|run| read_in(part, run)).collect();
    let mut found = Vec::new();
    for (m, measurand) in part.system.assembly.names.measurands.iter().enumerate() {
        let lacks = |run: &(&Run, &Vec<bool>)| run.1.contains(&true) && !run.1[m];
        let without = part.runs.iter().zip(&present).filter(lacks);
        let names: Vec<String> = without.map(|(run, _)| run.name.clone()).collect();
        if names.is_empty() || present.iter().all(|run| !run[m]) {
            continue;
        }
        let words =
            format!("{} no reading of `{}`, which other runs have", having(&names), measurand.name);
        let help =
            "is its column there, under this name? a run says nothing of what it does not read";
        found.push(Diagnostic::warning(words).help(help));
    }
    found
}

/// Whether a run reads each measurand; looked through until all are found.
fn read_in(part: &Part, run: &Run) -> Vec<bool> {
    let mut read = vec![false; part.slots().len()];
    // An error ends the walk: the rest has nothing new.
    let _ = run.record.try_walk(|stretch| {
        for (slot, read) in part.slots().iter().zip(&mut read) {
            let readings = &stretch.samples.readings[slot.column][stretch.range()];
            *read |= readings.iter().any(|reading| !reading.is_nan());
        }
        if read.contains(&false) { Ok(()) } else { Err(()) }
    });
    read
}

/// Runs named in one warning.
const MOST_NAMES: usize = 6;

/// ``run `a` has`` or ``runs `a`, `b` have``.
fn having(names: &[String]) -> String {
    let (runs, has) = if names.len() == 1 { ("run", "has") } else { ("runs", "have") };
    format!("{runs} {} {has}", listed(names))
}

/// `` `a`, `b` ``, and how many more.
fn listed(names: &[String]) -> String {
    let quoted = names.iter().take(MOST_NAMES).map(|name| format!("`{name}`"));
    let quoted = quoted.collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST_NAMES) {
        0 => quoted,
        more => format!("{quoted} and {more} more"),
    }
}

/// Angles that cannot be: beyond two turns, but for those that went there from the first turn without
/// a leap, as a heading does that nobody wraps.
fn angles(part: &Part) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for (measurand, slot) in part.system.assembly.names.measurands.iter().zip(part.slots()) {
        if !matches!(measurand.kind, MeasurandKind::Angle { .. }) {
            continue;
        }
        for run in &part.runs {
            let (mut reading, mut last, mut leaps) = (None, None, false);
            run.record.walk(|stretch| {
                let readings = &stretch.samples.readings[slot.column][stretch.range()];
                for value in readings.iter().copied().filter(|value| !value.is_nan()) {
                    let step = last.map_or(value.abs() - PI, |last: f64| (value - last).abs());
                    leaps |= step > PI;
                    last = Some(value);
                    reading = reading.or((value.abs() > 4.0 * PI).then_some(value));
                }
            });
            let Some(reading) = reading.filter(|_| leaps) else { continue };
            found.push(
                Diagnostic::warning(format!(
                    "run `{}`: `{}` reads {} rad, more than two turns",
                    run.name,
                    measurand.name,
                    decimal(reading, 3)
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

/// Angles without a period whose readings go beyond half a turn, where their formula comes back there;
/// by number.
pub(in crate::estimate) fn without_period(part: &Part) -> Vec<usize> {
    let measurands = &part.system.assembly.names.measurands;
    let is_asked = |(_, (measurand, slot)): &(usize, (&Measurand, &Slot))| {
        let mut comes_back = false;
        measurand.formula.root.visit(&mut |one| {
            comes_back |= matches!(one.kind, ExpressionKind::Call(Function::Atan2, _));
        });
        let is_beyond = |value: &f64| value.abs() > PI * (1.0 + f64::EPSILON);
        measurand.kind == MeasurandKind::Angle { period: 0.0 }
            && comes_back
            && part.readings_of(slot.column).iter().flatten().any(is_beyond)
    };
    let all = measurands.iter().zip(part.slots()).enumerate().filter(is_asked);
    all.map(|(number, _)| number).collect()
}

/// The warnings of them.
fn periods_to_state(part: &Part) -> Vec<Diagnostic> {
    let measurands = &part.system.assembly.names.measurands;
    let found = without_period(part).into_iter().map(|number| {
        let name = &measurands[number].name;
        Diagnostic::warning(format!(
            "`{name}` is read beyond half a turn, where its formula comes back from the other side"
        ))
        .help(format!("state its period in the model: `{name} = {{ …, period = \"360 deg\" }}`"))
    });
    found.collect()
}
