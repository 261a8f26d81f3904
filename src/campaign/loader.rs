//! What the readers of runs share: the model, settled inputs, what was found on the way, and tables
//! opened and read on.

use std::collections::HashSet;
use std::path::PathBuf;

use crate::campaign::calibration::Corrections;
use crate::campaign::declared::RunEntry;
use crate::campaign::delay_range::DelayRange;
use crate::campaign::form::Form;
use crate::campaign::header::Wanted;
use crate::campaign::loaded::{HeadUnit, LeftOut};
use crate::campaign::recorder::Store;
use crate::campaign::spline::Smoothing;
use crate::campaign::streamed::Streamed;
use crate::campaign::table::{Skipped, Table, TableError};
use crate::campaign::timing::Timing;
use crate::campaign::timing::replies::RequestToReply;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::document::COPY_INTO_FOLDER;
use crate::document::entries::{Named, Reader};
use crate::document::files::Files;
use crate::model::Model;
use crate::progress::{Progress, Task};

/// What is settled of an input for the whole campaign.
#[derive(Clone, Debug)]
pub(crate) struct InputSetting {
    pub(crate) smoothing: Smoothing,
    pub(crate) period: Option<f64>,
    /// Some formula of the model needs it.
    pub(crate) needed: bool,
    /// From its calibration.
    pub(crate) corrections: Option<Corrections>,
}

/// Reads runs against a model and collects what was found on the way.
pub(crate) struct Loader<'a> {
    pub(crate) model: &'a Model,
    pub(crate) folder: PathBuf,
    pub(crate) reader: Reader,
    pub(crate) files: Files,
    pub(crate) inputs: Vec<InputSetting>,
    pub(crate) delay_range: DelayRange,
    /// That of each measurand of the model (s).
    pub(crate) delay_ranges: Vec<[f64; 2]>,
    pub(crate) skip_bad_rows: bool,
    pub(crate) warnings: Vec<Diagnostic>,
    pub(crate) warned: HashSet<String>,
    pub(crate) skipped: Vec<Skipped>,
    pub(crate) skipped_count: usize,
    pub(crate) left_out: Vec<LeftOut>,
    /// Where samples and streams of the runs read so far lie.
    pub(crate) streamed: Vec<Streamed>,
    /// What was recognised of the layout of files.
    pub(crate) recognised: Vec<String>,
    pub(crate) store: &'a mut Store,
    pub(crate) progress: Progress,
    /// Bytes of data files read so far, and of all.
    pub(crate) bytes: (u64, u64),
    pub(crate) timing: Option<Timing>,
    pub(crate) request_to_reply: Vec<RequestToReply>,
    pub(crate) head_units: Vec<HeadUnit>,
}

impl Loader<'_> {
    /// Tells that the disk does not take a run.
    pub(crate) fn cannot_keep(&mut self, entry: &RunEntry, error: &std::io::Error) {
        let folder = std::env::temp_dir();
        let message = format!(
            "run `{}` is larger than the memory for it, and cannot be put into a temporary file in {}: {error}",
            entry.name.text,
            folder.display()
        );
        let help = "say with TMPDIR where there is room, or allow more memory with `--memory 8GB`";
        self.reader.fault(entry.name.span, message, help);
    }

    /// Takes over what a table left out, and what was recognised of it.
    pub(crate) fn note_read(&mut self, table: &mut Table) {
        if let Some(told) = table.layout_told().filter(|told| !self.recognised.contains(told)) {
            self.recognised.push(told);
        }
        // One log may be read as data and as a stream.
        let name = table.name();
        let repeated = [table.repeated.told(&name), table.repeated.header_warning(&name)];
        for warning in repeated.into_iter().flatten() {
            if self.warnings.iter().all(|one| one.message != warning.message) {
                self.warnings.push(warning);
            }
        }
        self.skipped.append(&mut table.skipped);
        self.skipped_count += table.skipped_count;
    }

    /// Opens a table of such a form.
    pub(crate) fn table(&mut self, name: &Named, form: &Form, wanted: &[Wanted]) -> Option<Table> {
        let path = self.folder.join(&name.text);
        let table = Table::open_of(&mut self.files, &path, form, wanted, self.skip_bad_rows);
        let mut table = self.told(name, table)?;
        for column in &table.columns {
            let Some(wanted) = &column.wanted else { continue };
            let one = HeadUnit {
                name: wanted.clone(),
                unit: column.unit.clone(),
                is_in_header: column.is_unit_in_header,
            };
            if !self.head_units.contains(&one) {
                self.head_units.push(one);
            }
        }
        // Captured times are small, and stay as they are.
        if self.timing.is_none() {
            table.count_from(self.store.zero(table.first_stamp()));
        }
        Some(table)
    }

    /// Reads a table of at most so many rows whole, for it stays in memory; `None` after a fault.
    pub(crate) fn whole(&mut self, name: &Named, table: &mut Table, most: usize) -> Option<()> {
        self.more(name, table, most + 1)?;
        if table.lines.len() <= most {
            return Some(());
        }
        let message = format!("`{}` has more than {most} rows", name.text);
        let help =
            "it is held in memory as a whole: leave out what no sample needs, or log it less often";
        self.reader.fault(name.span, message, help);
        None
    }

    /// Reads on in a table; `None` after a fault.
    pub(crate) fn more(&mut self, name: &Named, table: &mut Table, most: usize) -> Option<bool> {
        let before = table.bytes_read();
        let more = match table.more(most) {
            Err(TableError::Unordered) => table.sort().and_then(|told| {
                self.warnings.extend(told);
                table.more(most)
            }),
            more => more,
        };
        self.bytes.0 += table.bytes_read().saturating_sub(before);
        self.progress.tell(Task::Reading, self.bytes.0, self.bytes.1);
        self.told(name, more)
    }

    fn told<T>(&mut self, name: &Named, result: Result<T, TableError>) -> Option<T> {
        match result {
            Ok(value) => return Some(value),
            Err(TableError::Unreadable(message)) => {
                let help = match self.folder.join(&name.text).exists() {
                    true => "",
                    false => "paths count from the campaign's folder",
                };
                self.reader.fault(name.span, message, help);
            }
            Err(TableError::Refused(message)) => {
                self.reader.fault(name.span, message, COPY_INTO_FOLDER);
            }
            Err(TableError::Unordered) => {
                let help = "sort the rows by time";
                self.reader.fault(name.span, "the rows are not in the order of time", help);
            }
            Err(TableError::Content(Diagnostics(faults))) => {
                faults.into_iter().for_each(|fault| self.reader.report(fault));
            }
        }
        None
    }
}
