//! The captures of a run made into reference times, with the inputs at them.
//!
//! Captures stand in the data file, or in a file of their own, row by row. They must make sense:
//! edges in order, each reply after its request and before the next one, a capture for each reading.

use crate::campaign::entries::Reader;
use crate::campaign::file::RunEntry;
use crate::campaign::header::Column;
use crate::campaign::run::Samples;
use crate::campaign::signal::Track;
use crate::campaign::table::{TIME, Table};
use crate::campaign::timing::{Method, REPLY, RunTiming, Timing};
use crate::diagnostic::{Diagnostic, Place};

/// The time from request to reply (start bit to start bit) in a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RequestToReply {
    /// The run.
    pub run: String,
    /// Replies captured.
    pub count: usize,
    /// Mean (s).
    pub mean: f64,
    /// Standard deviation (s).
    pub standard_deviation: f64,
    /// Smallest (s).
    pub smallest: f64,
    /// Largest (s).
    pub largest: f64,
}

/// What is wrong with a row: row, column, message, help.
type Fault = (usize, &'static str, String, String);

impl Timing {
    /// Puts reference times into a data table, whose captures may stand in a table of their own.
    /// A table with ready times stays as it is. `None` after a fault.
    pub(crate) fn refer(
        &self,
        reader: &mut Reader,
        entry: &RunEntry,
        inputs: &[String],
        mut data: Table,
        captures: Option<Table>,
    ) -> Option<(Table, Option<RequestToReply>)> {
        let beside = captures.is_some();
        if let Some(captures) = &captures {
            let faults = faults_of_pairing(&data, captures);
            if !faults.is_empty() {
                reader.faults.extend(faults);
                return None;
            }
        }
        let from = captures.as_ref().unwrap_or(&data);
        let edge = self.method.column();
        let Some(edges) = from.column(edge) else {
            if data.column(TIME).is_some() && !beside {
                return Some((data, None));
            }
            let message = format!("`{}` has no column `{edge} [s]`", from.file);
            let help = format!(
                "method = \"{}\" takes the reference times from it; columns found: {}",
                self.method.word(),
                from.names()
            );
            let span = entry.timing.captures.as_ref().or(entry.data.as_ref()).map(|name| name.span);
            reader.fault(span.unwrap_or(entry.name.span), message, help);
            return None;
        };
        if let Some(time) = from.column(TIME) {
            let message = format!("the file has ready times and captures, `{TIME}` and `{edge}`");
            let fault = Diagnostic::error(message).at(from.header_place(time));
            reader.faults.push(fault.help("keep one: `[timing]` makes the times from captures"));
            return None;
        }
        let replies = from.column(REPLY).filter(|_| self.method != Method::Trigger);
        let fault = fault_of_edges(&edges.values, edge).or_else(|| {
            fault_of_replies(&edges.values, &replies?.values, self.length(&entry.timing))
        });
        if let Some((row, column, message, help)) = fault {
            let mut fault = Diagnostic::error(message);
            if let Some(column) = from.column(column) {
                fault = fault.at(from.cell_place(row, column));
            }
            reader.faults.push(fault.help(help));
            return None;
        }
        let replied =
            replies.and_then(|column| spread(&entry.name.text, &edges.values, &column.values));
        let mut time = edges.clone();
        if let Some(captures) = captures {
            data.columns.extend(captures.columns);
        }
        let shift = self.shift(&entry.timing);
        time.wanted = Some(TIME.to_owned());
        time.values.iter_mut().for_each(|time| *time += shift);
        data.columns.retain(|column| column.wanted.as_deref() != Some(TIME));
        data.columns.push(time);
        for input in inputs {
            move_columns(&mut data.columns, input, shift);
        }
        Some((data, replied))
    }

    /// The samples of a run as they would have been captured: the inverse of [`Self::refer`].
    pub(crate) fn captured(&self, samples: &Samples, run: &RunTiming) -> Samples {
        let shift = -self.shift(run);
        let mut captured = samples.clone();
        captured.time.iter_mut().for_each(|time| *time += shift);
        for track in &mut captured.inputs {
            if let Track::Captured { value, rate: Some(rate), acceleration } = track {
                for (row, (value, rate)) in value.iter_mut().zip(rate).enumerate() {
                    let bend = acceleration.as_ref().map_or(0.0, |column| column[row]);
                    (*value, *rate) = moved(*value, *rate, bend, shift);
                }
            }
        }
        captured
    }
}

/// What keeps captures and readings from being pairs, row by row.
fn faults_of_pairing(data: &Table, captures: &Table) -> Vec<Diagnostic> {
    let first_cell = |table: &Table, row: usize| -> Option<Place> {
        table.columns.first().map(|column| table.cell_place(row, column))
    };
    let (readings, edges) = (data.lines.len(), captures.lines.len());
    let mut faults = Vec::new();
    for table in [data, captures] {
        if let Some(row) = table.skipped.first() {
            let message = format!(
                "row {} of `{}` is bad, and captures belong to readings row by row",
                row.row, table.file
            );
            let help = "mend the row: leaving it out would shift all that follow; a reading that is not there is an empty cell";
            faults.push(Diagnostic::error(message).help(help));
        }
    }
    if faults.is_empty() && edges != readings {
        let (place, message) = if edges > readings {
            (first_cell(captures, readings), "this capture has no reading")
        } else {
            (first_cell(data, edges), "this reading has no capture")
        };
        let help = format!(
            "`{}` holds {edges} captures, `{}` {readings} rows of readings: they belong together row by row; a reading that is not there is an empty cell",
            captures.file, data.file
        );
        faults.push(Diagnostic::error(message).at_maybe(place.as_ref()).help(help));
    }
    for column in captures.columns.iter().filter(|column| column.wanted.is_some()) {
        if column.wanted.as_deref().is_some_and(|name| data.column(name).is_some()) {
            let message = format!("`{}` stands in `{}`, too", column.name, data.file);
            let place = captures.header_place(column);
            faults.push(Diagnostic::error(message).at(place).help("keep one of the columns"));
        }
    }
    faults
}

fn fault_of_edges(edges: &[f64], name: &'static str) -> Option<Fault> {
    for (row, edge) in edges.iter().enumerate() {
        if edge.is_nan() {
            let help = "every sample has its edge; leave out the reading, not the capture";
            return Some((row, name, format!("the row has no `{name}`"), help.to_owned()));
        }
        if row > 0 && *edge <= edges[row - 1] {
            let help = "rows are in the order of their edges, each later than the one before";
            return Some((row, name, "the edges are out of order here".into(), help.to_owned()));
        }
    }
    None
}

fn fault_of_replies(requests: &[f64], replies: &[f64], length: f64) -> Option<Fault> {
    for (row, (request, reply)) in requests.iter().zip(replies).enumerate() {
        let (message, help) = if reply <= request {
            (
                "the reply comes before its request".to_owned(),
                "are the two columns exchanged?".into(),
            )
        } else if *reply < request + length {
            (
                format!(
                    "the reply comes {:.2} µs after its request began, which is {:.2} µs long",
                    1e6 * (reply - request),
                    1e6 * length
                ),
                "check `baud` and `bits`: nothing can reply before the request is complete".into(),
            )
        } else if requests.get(row + 1).is_some_and(|next| reply >= next) {
            let help = "requests and replies alternate: is a capture missing?";
            ("the reply comes after the next request".to_owned(), help.to_owned())
        } else {
            continue;
        };
        return Some((row, REPLY, message, help));
    }
    None
}

fn spread(run: &str, requests: &[f64], replies: &[f64]) -> Option<RequestToReply> {
    let times = || requests.iter().zip(replies).map(|(a, b)| b - a).filter(|time| !time.is_nan());
    let count = times().count();
    let mean = times().sum::<f64>() / count as f64;
    let squares: f64 = times().map(|time| (time - mean).powi(2)).sum();
    (count > 0).then(|| RequestToReply {
        run: run.to_owned(),
        count,
        mean,
        standard_deviation: if count > 1 { (squares / (count - 1) as f64).sqrt() } else { 0.0 },
        smallest: times().fold(f64::INFINITY, f64::min),
        largest: times().fold(f64::NEG_INFINITY, f64::max),
    })
}

/// Value and rate a while later, at constant acceleration.
fn moved(value: f64, rate: f64, acceleration: f64, by: f64) -> (f64, f64) {
    (value + by * (rate + 0.5 * by * acceleration), rate + by * acceleration)
}

/// Moves a captured input along its rate. Without a rate it stands still.
fn move_columns(columns: &mut [Column], input: &str, by: f64) {
    let find = |suffix: &str| {
        let name = format!("{input}{suffix}");
        columns.iter().position(|column| column.wanted.as_deref() == Some(name.as_str()))
    };
    let (Some(value), Some(rate)) = (find(""), find("_rate")) else { return };
    let acceleration = find("_acceleration");
    for row in 0..columns[value].values.len() {
        let bend = acceleration.map_or(0.0, |column| columns[column].values[row]);
        let (at, speed) = (columns[value].values[row], columns[rate].values[row]);
        let moved = moved(at, speed, bend, by);
        (columns[value].values[row], columns[rate].values[row]) = moved;
    }
}
