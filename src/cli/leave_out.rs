//! `--leave-out FILE`: readings that an estimate is made without, such as those that a diagnosis left
//! out. It does not say which these are.

use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;

use crate::diagnostic::Diagnostic;
use crate::engine::Problem;

use super::Failure;

/// The columns of the table.
const COLUMNS: &str = "first_row,last_row,measurand,run";

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
    for (number, line) in (2..).zip(lines).filter(|(_, line)| !line.trim().is_empty()) {
        let one = read(line).ok_or_else(|| {
            Diagnostic::error(format!("`{shown}`, line {number}: expected two rows, a measurand or nothing, and a run; found `{line}`"))
        })?;
        if !take(problem, &one) {
            let what = one.measurand.map_or_else(String::new, |name| format!("`{name}` in "));
            let message = format!("`{shown}`, line {number}: there is no {what}run `{}`", one.run);
            return Err(Diagnostic::error(message)
                .help("the table is of other campaigns, or of another model")
                .into());
        }
    }
    Ok(())
}

/// A line of the table.
fn read(line: &str) -> Option<Stretch> {
    let mut cells = line.splitn(4, ',').map(str::trim);
    let (first, last) = (cells.next()?.parse().ok()?, cells.next()?.parse().ok()?);
    let measurand = Some(cells.next()?.to_owned()).filter(|name| !name.is_empty());
    let run = cells.next()?;
    let bare = run.strip_prefix('"').and_then(|run| run.strip_suffix('"'));
    let run = bare.map_or_else(|| run.to_owned(), |run| run.replace("\"\"", "\""));
    Some(Stretch { rows: first..=last, measurand, run })
}

/// Takes readings out; whether there are such a run and measurand.
fn take(problem: &mut Problem, one: &Stretch) -> bool {
    let names = problem.run_names();
    let first_runs = problem.layout.first_run.clone();
    let mut is_known = false;
    for (part, first) in problem.parts.iter_mut().zip(first_runs) {
        let measurands = &part.system.assembly.names.measurands;
        let columns = match &one.measurand {
            None => Some(part.reading_columns()),
            Some(name) => {
                let known = measurands.iter().position(|own| own.name == *name);
                known.map(|index| part.slots()[index].columns())
            }
        };
        let Some(columns) = columns else { continue };
        let runs = part.runs.iter_mut().zip(&names[first..]);
        for (run, _) in runs.filter(|(_, name)| **name == one.run) {
            is_known = true;
            let mut samples = Vec::new();
            run.record.walk(|stretch| {
                let own = stretch.each().filter(|sample| one.rows.contains(&sample.row()));
                samples.extend(own.map(|sample| sample.number));
            });
            run.record.leave_out(samples.into_iter().map(|at| (at..at + 1, columns.clone())));
        }
    }
    is_known
}
