//! The table of what a diagnosis left out, for estimates that are to be made without it.

use crate::diagnose::Diagnosis;

use super::table::quoted;

/// The columns of the table.
pub const COLUMNS: &str = "first_row,last_row,measurand,run";

/// One row a stretch of readings: first and last row of the data file, the measurand (empty: all),
/// the run.
pub fn table(diagnosis: &Diagnosis) -> String {
    let mut text = format!("{COLUMNS}\n");
    let mut add = |(first, last): (usize, usize), measurand: &str, run: &str| {
        text.push_str(&format!("{first},{last},{},{}\n", quoted(measurand), quoted(run)));
    };
    for one in &diagnosis.left_out.readings {
        add((one.row, one.row), &one.measurand, &one.run);
    }
    for one in diagnosis.left_out.runs.iter().chain(&diagnosis.left_out.stretches) {
        add(one.rows, &one.measurand, &one.run);
    }
    for one in &diagnosis.left_out.lost {
        add(one.rows, "", &one.name);
    }
    text
}

/// Whether there is anything to leave out.
pub fn is_any(diagnosis: &Diagnosis) -> bool {
    !diagnosis.left_out.is_empty()
}
