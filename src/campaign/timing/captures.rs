//! The captures of a run made into reference times, with the inputs at them, block by block.
//!
//! Captures stand in the data file, or in a file of their own, row by row. They must make sense:
//! edges in order, each reply after its request and before the next one, a capture for each
//! reading.

use crate::campaign::captured::{columns_of, moved};
use crate::campaign::declared::RunEntry;
use crate::campaign::header::TIME;
use crate::campaign::loader::Loader;
use crate::campaign::table::Table;
use crate::campaign::timing::replies::{Moved, RequestToReply};
use crate::campaign::timing::{Method, REPLY, Timing};
use crate::diagnostic::{Diagnostic, Place, decimals};
use crate::document::entries::Named;

/// Resolution (s) of captures that do not state one, at worst.
const COARSE: f64 = 1e-6;
/// A finer one (s) makes no difference.
const FINE: f64 = 1e-9;

/// What is wrong with a row: row, column, message, help.
type Fault = (usize, &'static str, String, String);

/// The captures of a run as they are read.
#[derive(Debug)]
pub(crate) struct Captures {
    /// The column of edges.
    edge: &'static str,
    has_replies: bool,
    /// From an edge to the reference time (s).
    shift: f64,
    /// How long a request is (s).
    length: f64,
    inputs: Vec<String>,
    /// Their own file with its name, and the columns taken from it.
    beside: Option<(Named, Table)>,
    shared: Vec<String>,
    /// Times beyond this (s) cannot be told apart as finely as they are captured.
    largest: f64,
    /// Edge and reply of the row before.
    last: (f64, f64),
    replied: RequestToReply,
}

impl Captures {
    /// Looks at the columns of a run's data, whose captures may stand in a table of their own, and
    /// adds those that come from captures. `Some(None)`: the data have ready times. `None` after a
    /// fault.
    pub(crate) fn begin(
        loader: &mut Loader<'_>,
        timing: Timing,
        entry: &RunEntry,
        data: &mut Table,
        beside: Option<Table>,
    ) -> Option<Option<Self>> {
        let from = beside.as_ref().unwrap_or(data);
        let edge = timing.method.column();
        let Some(edges) = from.column(edge).cloned() else {
            if data.column(TIME).is_some() && beside.is_none() {
                return Some(None);
            }
            let message = format!("`{}` has no column `{edge} [s]`", from.file);
            let help = format!(
                "method = \"{}\" takes the reference times from it; columns found: {}",
                timing.method.word(),
                from.names()
            );
            let own = entry.data.as_ref().map(|data| &data.name);
            let span = entry.timing.captures.as_ref().or(own).map(|name| name.span);
            loader.reader.fault(span.unwrap_or(entry.name.span), message, help);
            return None;
        };
        let mut faults = Vec::new();
        if let Some(time) = from.column(TIME) {
            let message = format!("the file has ready times and captures, `{TIME}` and `{edge}`");
            let fault = Diagnostic::error(message).at(from.header_place(time));
            faults.push(fault.help("keep one: `[timing]` makes the times from captures"));
        }
        let has_replies = timing.method != Method::Trigger && from.column(REPLY).is_some();
        let wanted = |column: &&crate::campaign::header::Column| column.wanted.is_some();
        let own: Vec<_> =
            beside.iter().flat_map(|table| &table.columns).filter(wanted).cloned().collect();
        for column in &own {
            let Some(name) = column.wanted.as_deref() else { continue };
            if data.column(name).is_some() {
                let message = format!("`{}` stands in `{}`, too", column.name, data.file);
                let fault = Diagnostic::error(message).at(from.header_place(column));
                faults.push(fault.help("keep one of the columns"));
            }
        }
        if !faults.is_empty() {
            faults.into_iter().for_each(|fault| loader.reader.report(fault));
            return None;
        }
        let mut shared = Vec::new();
        for column in &own {
            let Some(name) = column.wanted.as_deref() else { continue };
            data.add(name, column);
            shared.push(name.to_owned());
        }
        data.add(TIME, &edges);
        let name = entry.timing.captures.clone();
        Some(Some(Self {
            edge,
            has_replies,
            shift: timing.shift(&entry.timing),
            length: timing.length(&entry.timing),
            inputs: loader.model.inputs.iter().map(|input| input.name.clone()).collect(),
            beside: name.zip(beside),
            shared,
            largest: timing.resolution.unwrap_or(COARSE).max(FINE) / f64::EPSILON,
            last: (f64::NEG_INFINITY, f64::NAN),
            replied: RequestToReply::new(&entry.name.text),
        }))
    }

    /// Puts reference times, and inputs at them, into the rows at hand; `None` after a fault.
    pub(crate) fn refer(&mut self, loader: &mut Loader<'_>, data: &mut Table) -> Option<()> {
        let count = data.lines.len();
        if let Some((name, captures)) = &mut self.beside {
            loader.more(name, captures, count)?;
            skipped(loader, captures);
            skipped(loader, data);
            if captures.lines.len() < count {
                let row = captures.lines.len();
                let place = first_cell(data, row);
                let fault =
                    Diagnostic::error("this reading has no capture").at_maybe(place.as_ref());
                loader.reader.report(fault.help(pairing(captures, data)));
                return None;
            }
        }
        let from = self.beside.as_ref().map_or(&*data, |(_, captures)| captures);
        let edges = from.values(self.edge).unwrap_or_default().to_vec();
        let replies = from.values(REPLY).filter(|_| self.has_replies).map(<[f64]>::to_vec);
        if let Some((row, column, message, help)) = self.fault(&edges, replies.as_deref()) {
            let place = from.column(column).map(|column| from.cell_place(row, column));
            let fault = Diagnostic::error(message).at_maybe(place.as_ref()).help(help);
            loader.reader.report(fault);
            return None;
        }
        self.last.0 = edges.last().copied().unwrap_or(self.last.0);
        let reply = replies.as_ref().and_then(|replies| replies.last().copied());
        self.last.1 = reply.unwrap_or(f64::NAN);
        if let Some((_, captures)) = &mut self.beside {
            for name in &self.shared {
                if let Some(values) = data.values_mut(name) {
                    captures.copy(name, values);
                }
            }
        }
        if let Some(replies) = &replies {
            let inputs = self.inputs.iter().filter_map(|input| Moved::of(data, input));
            self.replied.see(&data.lines, &edges, replies, &inputs.collect::<Vec<_>>());
        }
        if let Some(times) = data.values_mut(TIME) {
            times.clear();
            times.extend(edges.iter().map(|edge| edge + self.shift));
        }
        for input in &self.inputs {
            move_columns(data, input, self.shift);
        }
        Some(())
    }

    /// After the last row of the data: no capture may be left. The time from request to reply, if
    /// replies were captured.
    pub(crate) fn end(
        &mut self,
        loader: &mut Loader<'_>,
        data: &Table,
    ) -> Option<Option<RequestToReply>> {
        if let Some((name, captures)) = &mut self.beside {
            let more = loader.more(name, captures, 1)?;
            skipped(loader, captures);
            skipped(loader, data);
            if more {
                let place = first_cell(captures, 0);
                let fault =
                    Diagnostic::error("this capture has no reading").at_maybe(place.as_ref());
                loader.reader.report(fault.help(pairing(captures, data)));
                return None;
            }
        }
        self.replied.end();
        Some(Some(self.replied.clone()).filter(|replied| replied.count > 0))
    }

    fn fault(&self, edges: &[f64], replies: Option<&[f64]>) -> Option<Fault> {
        let mut last = self.last;
        for (row, edge) in edges.iter().enumerate() {
            let reply = replies.map_or(f64::NAN, |replies| replies[row]);
            let (column, message, help) = if edge.is_nan() {
                let help = "every sample has its edge; leave out the reading, not the capture";
                (self.edge, format!("the row has no `{}`", self.edge), help)
            } else if edge.abs() > self.largest {
                let spacing = edge.abs() * f64::EPSILON;
                let message = format!(
                    "{} s is so large a number that its neighbours are {} ns apart",
                    decimals(*edge, 0),
                    decimals(1e9 * spacing, 0)
                );
                (self.edge, message, "count from a later zero, say the start of the day")
            } else if *edge <= last.0 {
                let help = "rows are in the order of their edges, each later than the one before";
                (self.edge, "the edges are out of order here".to_owned(), help)
            } else if last.1 >= *edge {
                let help = "requests and replies alternate: is a capture missing?";
                let message = "this request comes before the reply to the one before";
                (self.edge, message.to_owned(), help)
            } else if reply <= *edge {
                let message = "the reply comes before its request".to_owned();
                (REPLY, message, "are the two columns exchanged?")
            } else if reply < edge + self.length {
                let message = format!(
                    "the reply comes {} µs after its request began, which is {} µs long",
                    decimals(1e6 * (reply - edge), 2),
                    decimals(1e6 * self.length, 2)
                );
                let help =
                    "check `baud` and `bits`: nothing can reply before the request is complete";
                (REPLY, message, help)
            } else {
                last = (*edge, reply);
                continue;
            };
            return Some((row, column, message, help.to_owned()));
        }
        None
    }
}

/// Faults a table that left a row out: pairs would shift.
fn skipped(loader: &mut Loader<'_>, table: &Table) {
    if let Some(row) = table.skipped.first() {
        let message = format!(
            "row {} of `{}` is bad, and captures belong to readings row by row",
            row.row, table.file
        );
        let known = loader.reader.faults().iter().any(|fault| fault.message == message);
        if !known {
            let help = "mend the row: leaving it out would shift all that follow; a reading that is not there is an empty cell";
            loader.reader.report(Diagnostic::error(message).help(help));
        }
    }
}

fn pairing(captures: &Table, data: &Table) -> String {
    format!(
        "the rows of `{}` and `{}` belong together one by one; a reading that is not there is an empty cell",
        captures.file, data.file
    )
}

fn first_cell(table: &Table, row: usize) -> Option<Place> {
    table.columns.first().map(|column| table.cell_place(row, column))
}

/// Moves a captured input along its rate. Without a rate it stands still.
fn move_columns(table: &mut Table, input: &str, by: f64) {
    let [name, rate, acceleration] = columns_of(input);
    let Some(mut rates) = table.values(&rate).map(<[f64]>::to_vec) else { return };
    let accelerations = table.values(&acceleration).map(<[f64]>::to_vec);
    let Some(values) = table.values_mut(&name) else { return };
    for (row, (value, rate)) in values.iter_mut().zip(&mut rates).enumerate() {
        let bend = accelerations.as_ref().map_or(0.0, |column| column[row]);
        (*value, *rate) = moved(*value, *rate, bend, by);
    }
    if let Some(values) = table.values_mut(&rate) {
        *values = rates;
    }
}
