//! The noise that `diagnose` found, for people: its effects, its levels and memories, and what is
//! left out.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnose::Diagnosis;
use crate::diagnose::found::{
    AutocorrelatedNoise, LeftOut, Level, Lost, NoReading, NoiseEffect, Reading, Stretch, Wrong,
};
use crate::graph::names::MeasurandKind;
use crate::model::Shape;
use crate::report::figure;
use crate::report::layout::{drawn, table};
use crate::report::text::unit_of;
use crate::units::{Dimension, Unit, decimal, ratio};

/// Readings and stretches left out that are shown.
const SHOWN: usize = 5;
const STRETCHES: usize = 12;

/// Whether the draws of an effect on the noise are rectangular, as what is rounded has them.
fn is_rectangular(one: &NoiseEffect) -> bool {
    let local = one.parameter.rsplit('.').next();
    let mut declared = one.selected.effect.parameters.iter();
    declared.any(|own| Some(own.name.as_str()) == local && own.shape == Shape::Uniform)
}

/// The noise as it was found.
pub(super) fn noise(diagnosis: &Diagnosis) -> String {
    let mut text = String::new();
    for one in &diagnosis.noise {
        let figure = figure::measured(one.value, one.sigma, &one.unit);
        text.push_str(&format!("\n{}\n  {} = {figure}\n", one.name, one.parameter));
        if is_rectangular(one) {
            let width = figure::size(12.0_f64.sqrt() * one.value, &one.unit);
            text.push_str(&format!(
                "  That is a standard deviation: steps of {width} scatter so.\n"
            ));
        }
    }
    let has_structure = |one: &Level| {
        let mut all = diagnosis.autocorrelation.iter();
        all.any(|other| (&other.measurand, &other.of) == (&one.measurand, &one.of))
    };
    let shown: Vec<String> =
        diagnosis.levels.iter().map(|one| level(one, has_structure(one))).collect();
    if !shown.is_empty() {
        text.push_str(&format!("\nnoise (times as stated): {}\n", shown.join(", ")));
    }
    for AutocorrelatedNoise { measurand, of, noise, is_over_rows } in &diagnosis.autocorrelation {
        let each = noise.processes().enumerate().map(|(index, one)| {
            let time = match is_over_rows {
                true => format!("{} rows", decimal(one.time, 0)),
                false => figure::size(one.time, &Unit::coherent(Dimension::TIME)),
            };
            let of = if index == 0 { " of its variance" } else { "" };
            format!("{:.0} %{of} over {time}", 100.0 * one.share)
        });
        text.push_str(&format!(
            "The noise of `{measurand}`{} is autocorrelated: {}; weights and shares of the gap take account of it, an rms does not.\n",
            in_campaign(of.as_deref()),
            each.collect::<Vec<_>>().join(" and ")
        ));
    }
    if !diagnosis.autocorrelation.is_empty() && diagnosis.remainder.is_empty() {
        text.push_str(SLOW_EFFECT);
    }
    text.push_str(&left_out(diagnosis, &diagnosis.left_out));
    text
}

/// What autocorrelated noise may be, too.
const SLOW_EFFECT: &str = "An unmodelled effect that varies as slowly and depends on none of the inputs, such as creep or a lag, is not distinguished from such noise.\n";

/// A noise scale factor; noise of a wrong size alone is asked for its unit.
fn level(one: &Level, is_autocorrelated: bool) -> String {
    let Level { measurand, of, run, factor } = one;
    let is_usual = (0.1..10.0).contains(factor) || is_autocorrelated;
    let hint = if is_usual { "" } else { " (is its unit right?)" };
    let factor = ratio(*factor, 2);
    let run = run.as_ref().map_or_else(String::new, |run| format!(" in run `{run}`"));
    format!("{measurand}{run}{} {factor}{hint}", in_campaign(of.as_deref()))
}

/// Times are shown to this part of their size.
const DIGITS: f64 = 1e-2;

/// ``row 7`` or ``rows 7 to 9``.
fn rows(first: usize, last: usize) -> String {
    if first == last { format!("row {first}") } else { format!("rows {first} to {last}") }
}

/// In which campaign, where there are several.
fn in_campaign(of: Option<&str>) -> String {
    of.map_or_else(String::new, |of| format!(" in campaign `{of}`"))
}

/// What is left out, by row, and what that does to the delays.
fn left_out(diagnosis: &Diagnosis, found: &LeftOut) -> String {
    let mut text = String::new();
    for one in &found.lost {
        let Lost { name, periods, .. } = one;
        let side = if *periods > 0 { "later" } else { "earlier" };
        let plural = if periods.abs() == 1 { "" } else { "s" };
        let time =
            figure::value(one.seconds.abs(), Some(DIGITS * one.seconds.abs()), &Unit::second());
        let clock = match one.is_whole_run {
            true if *periods > 0 => format!("; over the whole run its clock is {time} behind"),
            true => format!("; over the whole run its clock is {time} ahead"),
            false => String::new(),
        };
        text.push_str(&format!(
            "Readings in {} of run `{name}` are those of samples {} row{plural} ({time}) {side}{clock}; they are left out.\n",
            rows(one.rows.0, one.rows.1),
            periods.abs()
        ));
    }
    let (no_readings, outliers): (Vec<&Reading>, Vec<&Reading>) =
        found.readings.iter().partition(|one| one.instead.is_some());
    text.push_str(&no_readings_left_out(diagnosis, &no_readings));
    let all = outliers.len();
    if all > 0 {
        let are = match all {
            1 => "reading is left out as an outlier",
            _ => "readings are left out as outliers",
        };
        text.push_str(&format!("{all} {are}:"));
        let shown = if all <= SHOWN + 1 { all } else { SHOWN };
        for one in &outliers[..shown] {
            let Reading { run, row, measurand, deviations, .. } = one;
            let deviations = match deviations.abs() < 1e6 {
                true => decimal(*deviations, 0),
                false => format!("{deviations:.1e}"),
            };
            text.push_str(&format!(
                "\n  `{measurand}` in row {row} of run `{run}` ({deviations} deviations)"
            ));
        }
        text.push_str(if all > shown { "\n  ... all with `--format json`\n" } else { "\n" });
    }
    for RunLeftOut { measurand, run, out, all } in &runs_left_out(diagnosis, found) {
        let part = if out == all { format!("All {all}") } else { format!("{out} of {all}") };
        text.push_str(&format!(
            "{part} readings of `{measurand}` in run `{run}` are left out: look at its file (units, setup, clock, a step).\n"
        ));
    }
    text.push_str(&stretches_left_out(found));
    let second = Unit::coherent(Dimension::TIME);
    let mut rows = table(&["nominal delay", "with all readings", "without those left out"]);
    for one in &diagnosis.delays {
        let of = one.of.as_ref().map_or_else(String::new, |of| format!(" ({of})"));
        let figure = |value| figure::value(value, one.sigma, &second);
        rows.add_row([format!("{}{of}", one.name), figure(one.with), figure(one.without)]);
    }
    // Beside a remainder, which may be an error in time, a delay of the nominal model says nothing.
    if !diagnosis.delays.is_empty() && !diagnosis.verdict.has_remainder() {
        text.push_str(&drawn(&rows));
    }
    text
}

/// Codes and limits that stand in the place of readings, each with its number.
fn no_readings_left_out(diagnosis: &Diagnosis, all: &[&Reading]) -> String {
    let mut counts: Vec<(&str, NoReading, usize)> = Vec::new();
    for (measurand, instead) in all.iter().filter_map(|one| Some((&*one.measurand, one.instead?))) {
        match counts.iter_mut().find(|known| (known.0, known.1) == (measurand, instead)) {
            Some(known) => known.2 += 1,
            None => counts.push((measurand, instead, 1)),
        }
    }
    let words = |(measurand, instead, count): (&str, NoReading, usize)| {
        let exact = |number| figure::exact(number, &unit_of(&diagnosis.nominal, measurand));
        let what = match instead {
            NoReading::Code(_) if is_rotation(diagnosis, measurand) => {
                "one and the same turn, a code for what was not measured".to_owned()
            }
            NoReading::Code(code) => format!("{}, a code for what was not measured", exact(code)),
            NoReading::Limit(limit) => {
                format!("{}, the limit at which they are saturated", exact(limit))
            }
        };
        format!(
            "{count} readings of `{measurand}` are {what}; they are left out. \
             All rows with `--format json`.\n"
        )
    };
    counts.into_iter().map(words).collect()
}

fn is_rotation(diagnosis: &Diagnosis, name: &str) -> bool {
    let mut all = diagnosis
        .nominal
        .problem
        .parts
        .iter()
        .flat_map(|one| &one.system.assembly.names.measurands);
    all.any(|one| one.name == name && one.kind == MeasurandKind::Rotation)
}

/// A measurand in a run of which most readings are left out.
struct RunLeftOut {
    measurand: String,
    run: String,
    out: usize,
    all: usize,
}

/// Runs of which most readings of a measurand are left out: their files are to be looked at.
fn runs_left_out(diagnosis: &Diagnosis, left_out: &LeftOut) -> Vec<RunLeftOut> {
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for one in &left_out.readings {
        *counts.entry((&one.run, &one.measurand)).or_default() += 1;
    }
    for one in &left_out.runs {
        *counts.entry((&one.run, &one.measurand)).or_default() += one.readings;
    }
    let mut all: Vec<RunLeftOut> = Vec::new();
    let mut runs: BTreeSet<String> = BTreeSet::new();
    for part in &diagnosis.nominal.problem.parts {
        let names = &part.system.assembly.names.measurands;
        for index in 0..part.runs.len() {
            let run = part.run_name(index);
            runs.insert(run.clone());
            for (one, rest) in names.iter().zip(part.present_in(index)) {
                let out = counts.get(&(&run[..], &one.name[..])).copied().unwrap_or(0);
                if out > rest && out > 1 {
                    let (measurand, run) = (one.name.clone(), run.clone());
                    all.push(RunLeftOut { measurand, run, out, all: out + rest });
                }
            }
        }
    }
    // A run of which nothing is left is not in the problem.
    for ((run, measurand), out) in counts {
        let is_of_run = |one: &&Stretch| one.run == run;
        let is_known = all.iter().any(|one| one.run == run && one.measurand == measurand);
        if !is_known && !runs.contains(run) && left_out.runs.iter().any(|one| is_of_run(&one)) {
            let (run, measurand) = (run.to_owned(), measurand.to_owned());
            all.push(RunLeftOut { measurand, run, out, all: out });
        }
    }
    all
}

/// Stretches of wrong readings, rows of several measurands together.
fn stretches_left_out(left_out: &LeftOut) -> String {
    let mut of_rows: Vec<(&Stretch, Vec<String>)> = Vec::new();
    for one in &left_out.stretches {
        let measurand = format!("`{}`", one.measurand);
        let is_same = |known: &&mut (&Stretch, Vec<String>)| {
            let known = known.0;
            (&known.run, known.rows, known.how) == (&one.run, one.rows, one.how)
        };
        match of_rows.iter_mut().find(is_same) {
            Some(known) => known.1.push(measurand),
            None => of_rows.push((one, vec![measurand])),
        }
    }
    if of_rows.is_empty() {
        return String::new();
    }
    let count: usize = left_out.stretches.iter().map(|one| one.readings).sum();
    let plural = if of_rows.len() == 1 { "" } else { "es" };
    let mut text = format!(
        "{count} readings in {} stretch{plural} of wrong readings are left out:",
        of_rows.len()
    );
    let shown = if of_rows.len() <= STRETCHES + 1 { of_rows.len() } else { STRETCHES };
    for (Stretch { run, rows: (first, last), how, deviations, .. }, measurands) in &of_rows[..shown]
    {
        let what = match (how, measurands.len()) {
            (Wrong::Repeated, 1) => "repeats its last value".to_owned(),
            (Wrong::Repeated, _) => "repeat their last values".to_owned(),
            (Wrong::Unresponsive, _) => "hardly varies, while the prediction does".to_owned(),
            (Wrong::FarOut, _) => format!("about {} deviations off", decimal(*deviations, 0)),
        };
        let measurands = measurands.join(" and ");
        text.push_str(&format!(
            "\n  {measurands} in {} of run `{run}`: {what}",
            rows(*first, *last)
        ));
    }
    text.push_str(if of_rows.len() > shown { "\n  ... all with `--format json`\n" } else { "\n" });
    text
}
