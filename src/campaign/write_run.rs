//! The table of one run as CSV: `time [s]`, captured inputs and readings in the model's units.
//!
//! Rows are written as they come, so a run may be longer than memory. Numbers have the digits that
//! give the same `f64` back; a reading that is missing is an empty cell. Constants and streams are
//! not in it.

use std::io::{self, Write};
use std::path::Path;

use crate::campaign::columns::{derived, reading_columns};
use crate::campaign::header::{self, TIME};
use crate::campaign::record::{Record, Stretch};
use crate::campaign::signal::Track;
use crate::campaign::stamps;
use crate::campaign::timing::capturing::Capturing;
use crate::campaign::whole::WholeFile;
use crate::diagnostic::Diagnostic;
use crate::graph::MeasurandKind;
use crate::model::Model;
use crate::units::Unit;

/// A table in the making.
#[derive(Debug)]
pub struct RunTable {
    file: WholeFile,
    /// How times and inputs are captures, if they are.
    capturing: Option<Capturing>,
    /// Whether there is a column of times.
    timed: bool,
    /// From when times count (s).
    zero: i64,
    /// Units of the captured columns, in the order of [`Track::columns`], and of the readings.
    captured: Vec<Unit>,
    readings: Vec<Unit>,
    /// The text of the rows at hand.
    text: Vec<u8>,
    /// Whether every reading is written, also those that the record lacks.
    complete: bool,
    /// Rows written so far, and the cells without a value by column.
    rows: usize,
    gaps: Vec<Gap>,
}

/// A column of a table in which values are missing that should be there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gap {
    /// The column.
    pub column: String,
    /// How many of its cells are empty because their values are infinite or no numbers.
    pub count: usize,
    /// How many rows the table has.
    pub rows: usize,
}

impl Gap {
    /// What to say of it.
    pub(crate) fn warning(&self, run: &str) -> Diagnostic {
        let Self { column, count, rows } = self;
        let message = format!(
            "run `{run}`: {count} of {rows} values of `{column}` are infinite or undefined: their cells are empty"
        );
        Diagnostic::warning(message)
            .help("the model has no value there at these inputs and parameters")
    }
}

impl RunTable {
    /// Begins the table of a run of a model with its header; `record` says which columns there are.
    ///
    /// # Errors
    /// The disk's.
    pub fn create(path: &Path, model: &Model, record: &Record) -> io::Result<Self> {
        Self::create_captured(path, model, record, None)
    }

    /// The same; with `capturing`, times and inputs are written as they would have been captured.
    pub(crate) fn create_captured(
        path: &Path,
        model: &Model,
        record: &Record,
        capturing: Option<Capturing>,
    ) -> io::Result<Self> {
        let times = [record.first_time(), record.last_time()];
        let timed = record.inputs().iter().any(Track::moves)
            || times.into_iter().flatten().any(|time| time != 0.0);
        let mut header = Vec::new();
        let mut captured = Vec::new();
        for (input, track) in model.inputs.iter().zip(record.inputs()) {
            let Track::Captured { rate, acceleration, .. } = track else { continue };
            let there = [true, rate.is_some(), acceleration.is_some()];
            let orders = ["", "_rate", "_acceleration"].iter().enumerate();
            for (order, suffix) in orders.filter(|(order, _)| there[*order]) {
                let unit = derived(&input.unit, order as u8);
                header.push(format!("{}{suffix} [{}]", input.name, unit.symbol));
                captured.push(unit);
            }
        }
        let mut readings = Vec::new();
        for (index, name) in reading_columns(model) {
            let measurand = &model.measurands[index];
            let unit = match measurand.kind {
                MeasurandKind::Rotation => Unit::one(),
                _ => measurand.unit.clone(),
            };
            header.push(format!("{name} [{}]", unit.symbol));
            readings.push(unit);
        }
        if timed {
            let names = capturing.as_ref().map_or(&[TIME][..], |capturing| &capturing.columns);
            header.splice(0..0, names.iter().map(|name| format!("{name} [s]")));
        }
        let mut file = WholeFile::create(path)?;
        writeln!(file, "{}", header.join(","))?;
        let name = |header: &String| header::split(header).0.to_owned();
        let gap = |header| Gap { column: name(header), count: 0, rows: 0 };
        let gaps = header.iter().map(gap).collect();
        let (text, complete, rows) = (Vec::new(), false, 0);
        Ok(Self { file, capturing, zero: 0, timed, captured, readings, text, complete, rows, gaps })
    }

    /// Draws what is captured beside the readings from a seed; `run` is the run's number.
    pub fn seed(&mut self, seed: u64, run: usize) {
        if let Some(capturing) = &mut self.capturing {
            capturing.seed(seed, run);
        }
    }

    /// Lets times be written that count from another moment (s), see [`stamps`].
    pub fn count_from(&mut self, zero: i64) {
        self.zero = zero;
    }

    /// Whether readings that the record lacks are written, too: those of a planned run.
    pub fn expect_all(&mut self, complete: bool) {
        self.complete = complete;
    }

    /// Adds the samples of a stretch, with these columns of readings instead of its own, if any.
    ///
    /// # Errors
    /// The disk's.
    pub fn write(&mut self, stretch: Stretch<'_>, other: Option<&[Vec<f64>]>) -> io::Result<()> {
        let captured = self.capturing.as_ref().map(|capturing| capturing.captured(stretch));
        let stretch = match &captured {
            Some(samples) => Stretch { samples, start: 0, ..stretch },
            None => stretch,
        };
        let (range, samples) = (stretch.range(), stretch.samples);
        let readings_of = &samples.readings;
        let (readings, read) = match other {
            Some(readings) => (readings, 0..stretch.len),
            None => (samples.readings.as_slice(), range.clone()),
        };
        let second = Unit::one();
        let time = self.timed.then_some((&second, &samples.time[range.clone()]));
        let captured = samples.inputs.iter().flat_map(Track::columns);
        let captured = self.captured.iter().zip(captured.map(|column| &column[range.clone()]));
        let readings = self.readings.iter().zip(readings.iter().map(|c| &c[read.clone()]));
        let requests = time.map_or(&[][..], |(_, times)| times);
        let replies = self.capturing.as_mut().map(|capturing| capturing.replies(requests));
        let replies = replies.as_deref().filter(|replies| !replies.is_empty());
        let replies = replies.map(|replies| (&second, replies));
        let columns: Vec<(&Unit, &[f64])> =
            time.into_iter().chain(replies).chain(captured).chain(readings).collect();
        self.text.clear();
        for row in 0..stretch.len {
            for (number, (unit, values)) in columns.iter().enumerate() {
                if number > 0 {
                    self.text.push(b',');
                }
                let value = unit.from_si(values[row]);
                if self.zero != 0 && value.is_finite() && number == 0 && self.timed {
                    self.text.extend_from_slice(stamps::written(self.zero, value).as_bytes());
                    continue;
                }
                if value.is_finite() {
                    write!(self.text, "{value:?}")?;
                    continue;
                }
                let reading = number.checked_sub(columns.len() - readings_of.len());
                let recorded = reading.map_or(f64::NAN, |k| readings_of[k][range.start + row]);
                let is_expected = reading.is_some() && (self.complete || !recorded.is_nan());
                self.gaps[number].count += usize::from(is_expected || !values[row].is_nan());
            }
            self.text.push(b'\n');
        }
        self.rows += stretch.len;
        self.file.write_all(&self.text)
    }

    /// Puts the file in its place; returns the columns that have gaps.
    ///
    /// # Errors
    /// The disk's.
    pub fn finish(self) -> io::Result<Vec<Gap>> {
        self.file.finish()?;
        let rows = self.rows;
        let gaps = self.gaps.into_iter().filter(|gap| gap.count > 0);
        Ok(gaps.map(|gap| Gap { rows, ..gap }).collect())
    }
}
