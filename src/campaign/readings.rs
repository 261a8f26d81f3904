//! The readings of one measured run: which are there, and which may be used.

use crate::campaign::clock::Intervals;
use crate::campaign::columns::reading_columns;
use crate::campaign::declared::RunEntry;
use crate::campaign::delay_range;
use crate::campaign::loaded::LeftOut;
use crate::campaign::loader::Loader;
use crate::campaign::samples::Samples;
use crate::campaign::signal::Track;
use crate::campaign::spline::Spline;
use crate::campaign::streamed::Streamed;
use crate::campaign::table::Table;
use crate::campaign::time_units::Stamps;
use crate::diagnostic::{Diagnostic, decimals};
use crate::document::entries::Named;
use crate::graph::MeasurandKind;

/// A quaternion whose norm is further from 1 is not one.
const NORM_TOLERANCE: f64 = 1e-2;

/// What is known of a run's readings from the blocks before.
#[derive(Debug, Default)]
pub(crate) struct Readings {
    /// Samples with readings.
    read: usize,
    /// Those of them that lack an input; those that lie outside a stream.
    lacking: usize,
    outside: usize,
    /// Time of the first and the last sample (s).
    span: Option<(f64, f64)>,
    /// Measurands of which a quaternion was found to be none.
    faulty: Vec<usize>,
    /// Columns of readings that hold any.
    filled: Vec<bool>,
    /// Intervals of the stamps.
    pub(crate) intervals: Intervals,
}

impl Loader<'_> {
    /// The measurands that are rotations, each with its first reading column.
    fn rotations(&self) -> Vec<(usize, usize)> {
        let columns = reading_columns(self.model);
        let rotation = |m: usize| self.model.measurands[m].kind == MeasurandKind::Rotation;
        let first = |k: usize| k == 0 || columns[k - 1].0 != columns[k].0;
        let all = columns.iter().enumerate().map(|(column, (measurand, _))| (*measurand, column));
        all.filter(|(measurand, column)| rotation(*measurand) && first(*column)).collect()
    }

    /// Faults a table without readings, and a part of a quaternion.
    pub(crate) fn check_readings(&mut self, data: &Named, table: &Table) {
        let columns = reading_columns(self.model);
        if columns.iter().all(|(_, name)| table.column(name).is_none()) {
            let names: Vec<_> = columns.iter().map(|(_, name)| name.as_str()).collect();
            let message = format!("`{}` holds no reading", data.text);
            let help = format!("expected columns {}; found {}", names.join(", "), table.names());
            let help = [Some(help), table.header_help()].into_iter().flatten();
            let fault = Diagnostic::error(message).at(data.place.clone());
            self.reader.report(help.fold(fault, Diagnostic::help));
        }
        for (index, first) in self.rotations() {
            let own = &columns[first..first + 4];
            let found = own.iter().filter(|(_, name)| table.column(name).is_some()).count();
            if (1..4).contains(&found) {
                let measurand = &self.model.measurands[index].name;
                let message =
                    format!("`{}` holds {found} of the four columns of `{measurand}`", data.text);
                let help = format!(
                    "a rotation is {measurand}_w, {measurand}_x, {measurand}_y, {measurand}_z"
                );
                self.reader.fault(data.span, message, help);
            }
        }
    }

    /// Takes the readings of the rows at hand in SI; quaternions are normalised.
    pub(crate) fn take_readings(
        &mut self,
        table: &Table,
        samples: &mut Samples,
        known: &mut Readings,
    ) {
        let columns = reading_columns(self.model);
        known.filled.resize(columns.len(), false);
        let filled = samples.readings.iter_mut().zip(&mut known.filled);
        for ((_, name), (column, is_filled)) in columns.iter().zip(filled) {
            if !table.copy(name, column) {
                column.resize(samples.time.len(), f64::NAN);
            }
            *is_filled |= column.iter().any(|reading| !reading.is_nan());
        }
        for (index, first) in self.rotations() {
            if known.faulty.contains(&index) {
                continue;
            }
            let own = &mut samples.readings[first..first + 4];
            for row in 0..samples.time.len() {
                let norm = own.iter().map(|column| column[row] * column[row]).sum::<f64>().sqrt();
                if (norm - 1.0).abs() > NORM_TOLERANCE {
                    let mut fault = Diagnostic::error(format!(
                        "this quaternion has norm {}, not 1",
                        decimals(norm, 4)
                    ));
                    if let Some(column) = table.column(&columns[first].1) {
                        fault = fault.at(table.cell_place(row, column));
                    }
                    self.reader.report(fault);
                    known.faulty.push(index);
                    break;
                }
                own.iter_mut().for_each(|column| column[row] /= norm);
            }
        }
    }

    /// Takes out the readings of samples that lack an input, or lie where a stream says nothing.
    pub(crate) fn leave_out(&self, samples: &mut Samples, usable: &[bool], known: &mut Readings) {
        let Samples { time, inputs, readings, .. } = samples;
        let logged: Vec<(bool, &Spline)> = inputs
            .iter()
            .zip(&self.model.inputs)
            .filter_map(|(track, input)| match track {
                Track::Logged(spline) => Some((input.signal, spline.as_ref())),
                _ => None,
            })
            .collect();
        let covered = |time: f64, [low, high]: [f64; 2]| {
            logged.iter().all(|(moves, spline)| match moves {
                true => spline.covers(time + low, time + high),
                false => spline.covers(time, time),
            })
        };
        let columns = reading_columns(self.model);
        let mut ranges: Vec<[f64; 2]> = Vec::new();
        let own: Vec<usize> = columns
            .iter()
            .map(|(measurand, _)| {
                let range = self.delay_ranges[*measurand];
                ranges.iter().position(|known| *known == range).unwrap_or_else(|| {
                    ranges.push(range);
                    ranges.len() - 1
                })
            })
            .collect();
        let mut is_covered = vec![true; ranges.len()];
        for (row, (time, usable)) in time.iter().zip(usable).enumerate() {
            for (covers, range) in is_covered.iter_mut().zip(&ranges) {
                *covers = covered(*time, *range);
            }
            let (mut read, mut lost) = (false, false);
            for (column, range) in readings.iter_mut().zip(&own) {
                if column[row].is_nan() {
                    continue;
                }
                read = true;
                lost |= !is_covered[*range];
                if !usable || !is_covered[*range] {
                    column[row] = f64::NAN;
                }
            }
            known.read += usize::from(read);
            known.lacking += usize::from(read && !usable);
            known.outside += usize::from(*usable && lost);
        }
        if let (Some(first), Some(last)) = (time.first(), time.last()) {
            known.span = Some((known.span.map_or(*first, |(first, _)| first), *last));
        }
    }

    /// Warns of columns of a run without any reading.
    pub(crate) fn warn_of_empty(&mut self, entry: &RunEntry, table: &Table, known: &Readings) {
        let columns = reading_columns(self.model);
        let empty = columns.iter().zip(&known.filled).filter(|(_, is_filled)| !**is_filled);
        let empty = empty.filter(|((_, name), _)| table.column(name).is_some());
        let names: Vec<String> = empty.map(|((_, name), _)| format!("`{name}`")).collect();
        if !names.is_empty() {
            let message = format!(
                "run `{}`: all readings of {} are missing in `{}`",
                entry.name.text,
                names.join(", "),
                table.name()
            );
            let help = "the file has the column, and no number in it: is it the right one?";
            self.warnings.push(Diagnostic::warning(message).help(help));
        }
    }

    /// Tells what was left out of a run, and notes where its streams lie. Whether enough of it is
    /// within them: a fault otherwise, which waits for the streams of the other runs.
    pub(crate) fn tell_left_out(
        &mut self,
        entry: &RunEntry,
        inputs: &[Track],
        known: &Readings,
        stamps: Vec<Stamps>,
    ) -> bool {
        let Readings { read: all, lacking, outside, .. } = *known;
        let run = entry.name.text.clone();
        if lacking > 0 {
            let why = "an input is missing".to_owned();
            self.left_out.push(LeftOut { run: run.clone(), samples: lacking, why });
        }
        if outside > 0 {
            let why = delay_range::words(self.delay_range.hull());
            self.left_out.push(LeftOut { run, samples: outside, why });
        }
        let zero = if self.timing.is_none() { self.store.zero(None) as f64 } else { 0.0 };
        let mut one = Streamed::new(entry, (inputs, &self.model.inputs), known.span, zero);
        (one.counts, one.stamps) = ((outside, all), stamps);
        self.streamed.push(one);
        2 * outside <= all
    }

    /// Faults runs of which most samples lie outside their streams, when all runs are read, and warns of one
    /// whose streams seem to be in another unit of time.
    pub(crate) fn tell_outside(&mut self) {
        let all = std::mem::take(&mut self.streamed);
        for one in all.iter().filter(|one| one.is_outside()) {
            let (message, help) = one.words(&all, &self.delay_range);
            self.reader.fault(one.span, message, help);
        }
        self.warnings.extend(all.iter().find_map(Streamed::in_smaller_unit));
    }
}
