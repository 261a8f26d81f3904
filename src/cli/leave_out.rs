//! `--leave-out FILE`: readings that an estimate is made without, such as those that a diagnosis left
//! out. It does not say which these are.

use std::collections::BTreeMap;
use std::fs;
use std::ops::{Range, RangeInclusive};
use std::path::Path;

use crate::diagnostic::Diagnostic;
use crate::engine::{Part, Problem};
use crate::report::left_out::COLUMNS;

use super::Failure;

/// Readings of a run in some rows of its data file.
struct Stretch {
    rows: RangeInclusive<usize>,
    /// `None`: all that the sample has.
    measurand: Option<String>,
    run: String,
}

/// Leaves the readings out that a table lists.
pub(super) fn leave_out(problem: &mut Problem, file: &Path) -> Result<(), Failure> {
    let shown = file.display();
    let text = fs::read_to_string(file).map_err(|error| {
        Diagnostic::error(format!("cannot read `{shown}`: {error}"))
            .help("`homepoint diagnose CAMPAIGN --out DIR` writes such a table: DIR/left_out.csv")
    })?;
    let mut lines = text.lines();
    if lines.next().map(str::trim) != Some(COLUMNS) {
        let message = format!("`{shown}` is no table of readings that are left out");
        return Err(Diagnostic::error(message).help(format!("it begins with {COLUMNS}")).into());
    }
    let mut all = Vec::new();
    for (number, line) in (2..).zip(lines).filter(|(_, line)| !line.trim().is_empty()) {
        let one = read(line).ok_or_else(|| {
            Diagnostic::error(format!("`{shown}`, line {number}: expected first and last row, a measurand or nothing, and a run; found `{line}`"))
        })?;
        if !is_known(problem, &one) {
            let what = one.measurand.map_or_else(String::new, |name| format!("`{name}` in "));
            let message = format!("`{shown}`, line {number}: there is no {what}run `{}`", one.run);
            return Err(Diagnostic::error(message)
                .help("the table is of other campaigns, or of another model")
                .into());
        }
        all.push(one);
    }
    let had = with_readings(problem);
    take(problem, &all);
    without_emptied(problem, &had);
    Ok(())
}

/// For each run of each campaign whether it has readings.
fn with_readings(problem: &Problem) -> Vec<Vec<bool>> {
    let of_part = |part: &Part| (0..part.runs.len()).map(|run| part.has_readings(run)).collect();
    problem.parts.iter().map(of_part).collect()
}

/// Takes runs out of which nothing is left: they have nothing to determine.
fn without_emptied(problem: &mut Problem, had: &[Vec<bool>]) {
    let has = with_readings(problem);
    if let Some(rest) = problem.without_runs(|part, run| had[part][run] && !has[part][run]) {
        *problem = rest;
    }
}

/// A line of the table.
fn read(line: &str) -> Option<Stretch> {
    let mut cells = line.splitn(4, ',').map(str::trim);
    let (first, last): (usize, usize) = (cells.next()?.parse().ok()?, cells.next()?.parse().ok()?);
    if first > last {
        return None;
    }
    let measurand = Some(cells.next()?.to_owned()).filter(|name| !name.is_empty());
    let run = cells.next()?;
    let bare = run.strip_prefix('"').and_then(|run| run.strip_suffix('"'));
    let run = bare.map_or_else(|| run.to_owned(), |run| run.replace("\"\"", "\""));
    Some(Stretch { rows: first..=last, measurand, run })
}

/// Whether there are such a run and measurand.
fn is_known(problem: &Problem, one: &Stretch) -> bool {
    let names = problem.run_names();
    let runs = problem.parts.iter().zip(&problem.layout.first_run);
    runs.filter(|(part, first)| names[**first..**first + part.runs.len()].contains(&one.run))
        .any(|(part, _)| columns(part, one).is_some())
}

/// The reading columns of a campaign that a line is of.
fn columns(part: &Part, one: &Stretch) -> Option<Range<usize>> {
    let Some(name) = &one.measurand else { return Some(part.reading_columns()) };
    let mut known = part.system.assembly.names.measurands.iter();
    known.position(|own| own.name == *name).map(|index| part.slots()[index].columns())
}

/// Takes readings out, each run in one walk.
fn take(problem: &mut Problem, all: &[Stretch]) {
    let mut of_runs: BTreeMap<&str, Vec<&Stretch>> = BTreeMap::new();
    all.iter().for_each(|one| of_runs.entry(&one.run).or_default().push(one));
    let names = problem.run_names();
    let mut names = names.iter();
    for part in &mut problem.parts {
        for run in 0..part.runs.len() {
            let Some(own) = names.next().and_then(|name| of_runs.get(name.as_str())) else {
                continue;
            };
            let mut rows: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
            part.runs[run].record.walk(|stretch| {
                stretch.each().for_each(|one| rows.entry(one.row()).or_default().push(one.number));
            });
            let of_line = |one: &&Stretch| {
                let samples = rows.range(one.rows.clone()).flat_map(|(_, samples)| samples);
                let columns = columns(part, one)?;
                Some(samples.map(|at| (*at..at + 1, columns.clone())).collect::<Vec<_>>())
            };
            let out: Vec<_> = own.iter().filter_map(of_line).flatten().collect();
            part.runs[run].record.leave_out(out);
        }
    }
}
