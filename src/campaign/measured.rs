//! One measured run: its data file and its streams made into samples.

use crate::campaign::captured::{Captured, columns_of};
use crate::campaign::clock::Intervals;
use crate::campaign::columns::{column_count, reading_columns};
use crate::campaign::declared::{RunEntry, TableEntry};
use crate::campaign::form::Form;
use crate::campaign::header::{TIME, Wanted};
use crate::campaign::loader::Loader;
use crate::campaign::readings::Readings;
use crate::campaign::record::{BLOCK, Record};
use crate::campaign::recorder::Recorder;
use crate::campaign::samples::{Samples, shape};
use crate::campaign::signal::Track;
use crate::campaign::table::Table;
use crate::campaign::time_units::Stamps;
use crate::campaign::timing::COLUMNS;
use crate::campaign::timing::captures::Captures;
use crate::document::entries::Named;

/// The most rows of a stream: it is held in memory as a whole.
const MOST_STREAMED: usize = 20_000_000;

impl Loader<'_> {
    /// The record of a run with data; `None` after a fault.
    pub(crate) fn run(&mut self, entry: &RunEntry) -> Option<Record> {
        let data = entry.data.as_ref()?;
        let every = self.wanted(entry, &data.columns, true);
        let mut own = every.clone();
        let path = |table: &TableEntry| self.folder.join(&table.name.text);
        let is_one_log = entry.signals.iter().any(|stream| path(stream) == path(data));
        // One log of both: inputs that move are a stream of it, all else is a sample's.
        let moves = |this: &Self, name: &str| {
            let mut inputs = this.model.inputs.iter().filter(|input| input.signal);
            inputs.any(|input| columns_of(&input.name).iter().any(|column| column == name))
        };
        if is_one_log {
            let readings = reading_columns(self.model);
            let is_reading = |name: &str| readings.iter().any(|(_, reading)| reading == name);
            own.retain(|want| !moves(self, &want.name) || is_reading(&want.name));
        }
        let beside = entry.timing.captures.as_ref();
        let table = match beside {
            // Times are the captures' business then.
            Some(_) => self.table(&data.name, &data.form, &without_times(&own)),
            None => self.table(&data.name, &data.form, &own),
        };
        let captures = beside.map(|name| self.table(name, &Form::default(), &every));
        let streams: Vec<_> = entry
            .signals
            .iter()
            .map(|stream| {
                let mut wanted = self.wanted(entry, &stream.columns, false);
                if is_one_log {
                    wanted.retain(|want| want.name == TIME || moves(self, &want.name));
                }
                let mut table = self.table(&stream.name, &stream.form, &wanted)?;
                self.whole(&stream.name, &mut table, MOST_STREAMED)?;
                self.note_read(&mut table);
                Some(table)
            })
            .collect();
        let mut table = table?;
        let captures = captures.map_or(Some(None), |captures| captures.map(Some))?;
        let mut streams: Vec<Table> = streams.into_iter().collect::<Option<_>>()?;
        streams.iter_mut().for_each(|stream| self.settle_attitudes(entry, stream));
        let tables: Vec<&Table> = [&table].into_iter().chain(&captures).chain(&streams).collect();
        let of: Vec<_> =
            [(data, &table)].into_iter().chain(entry.signals.iter().zip(&streams)).collect();
        let before = self.reader.count();
        self.check_columns(entry, &every, &tables, &of);
        if self.reader.count() == before {
            self.check_stamps(entry, &streams);
        }
        // What follows of columns that are not there is no fault of its own.
        if self.reader.count() > before {
            return None;
        }
        let data = &data.name;
        let mut captures = match self.timing.clone() {
            Some(timing) => Captures::begin(self, timing, entry, &mut table, captures)?,
            None => None,
        };
        let before = self.reader.count();
        let mut inputs: Vec<Track> = Vec::with_capacity(self.model.inputs.len());
        for index in 0..self.model.inputs.len() {
            let mut track = self.track(index, entry, &table, &streams);
            track.share_knots(inputs.last());
            if matches!(track, Track::Logged(_)) {
                // The curve stands for them: of long streams each column counts.
                streams.iter_mut().for_each(|one| one.forget(&self.model.inputs[index].name));
            }
            inputs.push(track);
        }
        let beside_it: Vec<(String, Intervals)> = streams.iter().map(stream_intervals).collect();
        let stamps: Vec<Stamps> =
            [&table].into_iter().chain(&streams).filter_map(|one| Stamps::of(entry, one)).collect();
        drop(streams);
        if table.column(TIME).is_none() && inputs.iter().any(Track::moves) {
            let message = format!("`{}` has no column `time [s]`", data.text);
            let help = format!("inputs move in this run; columns found: {}", table.names());
            self.reader.fault(data.span, message, help);
        }
        self.check_readings(data, &table);
        let mut readings = Readings::default();
        let record = self.rows(entry, data, &mut table, captures.as_mut(), &inputs, &mut readings);
        if table.column(TIME).is_some() && self.timing.is_none() {
            self.tell_clocks(entry, &mut readings.intervals, &table.name(), beside_it);
        }
        self.note_read(&mut table);
        self.warn_of_empty(entry, &table, &readings);
        let is_within = record.is_none() || self.tell_left_out(entry, &inputs, &readings, stamps);
        record.filter(|_| is_within && self.reader.count() == before)
    }

    /// Faults streams of inputs without stamps.
    fn check_stamps(&mut self, entry: &RunEntry, streams: &[Table]) {
        for (stream, table) in entry.signals.iter().zip(streams) {
            let is_of_input = self.model.inputs.iter().any(|one| table.column(&one.name).is_some());
            if !is_of_input || table.column(TIME).is_some() {
                continue;
            }
            let message = format!("the stream `{}` has no column `time [s]`", stream.name.text);
            let help = format!(
                "say which of its columns holds the stamps: columns = {{ time = \"NAME [s]\" }}; columns found: {}",
                table.names()
            );
            self.reader.fault(stream.name.span, message, help);
        }
    }

    /// Warns of clocks that were set forward in the middle of a run.
    fn tell_clocks(
        &mut self,
        entry: &RunEntry,
        data: &mut Intervals,
        name: &str,
        streams: Vec<(String, Intervals)>,
    ) {
        data.end();
        let mut all = vec![(name.to_owned(), std::mem::take(data))];
        // One log may be data and stream.
        all.extend(streams.into_iter().filter(|(stream, _)| stream != name));
        for number in 0..all.len() {
            let (file, mut own) = all[number].clone();
            let others = all.iter().enumerate().filter(|(other, _)| *other != number);
            let others: Vec<Intervals> = others.map(|(_, (_, one))| one.clone()).collect();
            if let Some(mut told) = own.told(&file, &others) {
                told.message = format!("run `{}`: {}", entry.name.text, told.message);
                self.warnings.push(told);
            }
        }
    }

    /// Takes the rows of a data file block by block.
    fn rows(
        &mut self,
        entry: &RunEntry,
        data: &Named,
        table: &mut Table,
        mut captures: Option<&mut Captures>,
        inputs: &[Track],
        readings: &mut Readings,
    ) -> Option<Record> {
        let begin = |this: &Self| {
            let input = |index: usize| {
                Captured::new(&this.model.inputs[index].name, this.inputs[index].period)
            };
            let recorder = Recorder::new(inputs, column_count(this.model));
            (recorder, (0..inputs.len()).map(input).collect())
        };
        let (mut recorder, mut captured): (_, Vec<Captured>) = begin(self);
        let mut samples = Samples::default();
        shape(&mut samples, inputs, column_count(self.model));
        // The tracks without columns, too, for they say where they have values.
        samples.inputs = inputs.to_vec();
        let is_timed = table.column(TIME).is_some();
        while self.more(data, table, BLOCK)? {
            if table.begins_sorted() {
                // Rows that came before were not in their order.
                (recorder, captured) = begin(self);
                *readings = Readings::default();
            }
            if let Some(captures) = &mut captures {
                captures.refer(self, table)?;
            }
            let count = table.lines.len();
            samples.rows.clone_from(&table.lines);
            samples.is_untimed = !table.copy(TIME, &mut samples.time);
            if samples.is_untimed {
                samples.time.resize(count, 0.0);
            }
            if is_timed {
                readings.intervals.take(&samples.time, &table.lines);
            }
            let mut usable = vec![true; count];
            let tracks = samples.inputs.iter_mut().zip(&self.inputs);
            for (captured, (track, setting)) in captured.iter_mut().zip(tracks) {
                captured.take(table, &samples.time, track, &mut usable);
                if let (Some(corrections), Track::Captured { .. }) = (&setting.corrections, &track)
                {
                    corrections.correct_track(track);
                }
            }
            self.take_readings(table, &mut samples, readings);
            self.leave_out(&mut samples, &usable, readings);
            if let Err(error) = recorder.push(self.store, &samples) {
                self.cannot_keep(entry, &error);
                return None;
            }
        }
        if let Some(captures) = captures {
            let replied = captures.end(self, table)?;
            self.request_to_reply.extend(replied);
        }
        for name in captured.iter().flat_map(|input| input.without_value(table)) {
            let message = format!("run `{}` has no value in column `{name}`", entry.name.text);
            self.reader.fault(entry.name.span, message, "");
        }
        match recorder.finish(self.store) {
            Ok(record) if is_timed => Some(self.without_held(entry, record)),
            Ok(record) => Some(record),
            Err(error) => {
                self.cannot_keep(entry, &error);
                None
            }
        }
    }
}

/// The intervals of a stream, with its name.
fn stream_intervals(stream: &Table) -> (String, Intervals) {
    let mut found = Intervals::default();
    found.take(stream.values(TIME).unwrap_or_default(), &stream.lines);
    found.end();
    (stream.name(), found)
}

/// The same columns but for times.
fn without_times(wanted: &[Wanted]) -> Vec<Wanted> {
    wanted.iter().filter(|want| !COLUMNS.contains(&want.name.as_str())).cloned().collect()
}
