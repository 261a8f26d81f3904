//! The readings of one measured run: which are there, and which may be used.

use crate::campaign::columns::reading_columns;
use crate::campaign::declared::RunEntry;
use crate::campaign::delay_range;
use crate::campaign::loaded::LeftOut;
use crate::campaign::loader::Loader;
use crate::campaign::samples::Samples;
use crate::campaign::signal::Track;
use crate::campaign::spline::Spline;
use crate::campaign::table::Table;
use crate::campaign::time_units::{read_in, unit_of};
use crate::diagnostic::{Diagnostic, decimals};
use crate::document::entries::Named;
use crate::graph::MeasurandKind;
use crate::units::decimal;

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
        for ((_, name), column) in columns.iter().zip(&mut samples.readings) {
            if !table.copy(name, column) {
                column.resize(samples.time.len(), f64::NAN);
            }
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

    /// Tells what was left out of a run; a fault where most of it was.
    pub(crate) fn tell_left_out(&mut self, entry: &RunEntry, inputs: &[Track], known: &Readings) {
        let Readings { read: all, lacking, outside, .. } = *known;
        let run = entry.name.text.clone();
        if lacking > 0 {
            let why = "an input is missing".to_owned();
            self.left_out.push(LeftOut { run: run.clone(), samples: lacking, why });
        }
        if outside > 0 {
            let why = delay_range::words(self.delay_range.hull());
            self.left_out.push(LeftOut { run: run.clone(), samples: outside, why });
        }
        if 2 * outside > all {
            let zero = if self.timing.is_none() { self.store.zero(None) as f64 } else { 0.0 };
            let spans: Vec<String> = inputs
                .iter()
                .zip(&self.model.inputs)
                .filter_map(|(track, input)| match track {
                    Track::Logged(spline) => Some(held(&input.name, spline, zero)),
                    _ => None,
                })
                .take(3)
                .collect();
            let has_gaps = |track: &Track| matches!(track, Track::Logged(one) if one.gaps().0 > 0);
            let even = if inputs.iter().any(has_gaps) {
                "; a stream that is logged only when its value changes has gaps: log it at an even rate"
            } else {
                ""
            };
            let (first, last) = known.span.unwrap_or_default();
            let message = format!(
                "{outside} of {all} samples of run `{run}` lie outside its streams, or in gaps of them"
            );
            let help = format!(
                "the samples go from {} s to {} s, the streams hold {}; a margin of delay_range = {} is kept{even}{}",
                decimals(first + zero, 3),
                decimals(last + zero, 3),
                spans.join(", "),
                self.delay_range.written(|text| format!("\"{text}\"")),
                proposed(inputs, (first, last), outside == all)
            );
            let span = entry.signals.first().map_or(entry.name.span, |stream| stream.name.span);
            self.reader.fault(span, message, help);
        }
    }
}

/// Half the range of delays (s) that is proposed where clocks are far apart, at least, or this part of
/// how long the samples last.
const LEAST_APART: f64 = 5.0;
const PART_APART: f64 = 0.125;
/// Time zones are halves of an hour (s) apart, so many at most; recordings of one motion begin within
/// so much (s) of each other.
const HALF_AN_HOUR: f64 = 1800.0;
const MOST_HALVES: f64 = 28.0;
const ALIKE: f64 = 60.0;

/// What to write where samples and streams last so differently that their times are in different
/// units, where clocks are so far apart that no sample lies within the streams, and where the margin
/// is larger than that of some that do.
fn proposed(inputs: &[Track], (first, last): (f64, f64), are_all_outside: bool) -> String {
    let spans = inputs.iter().filter_map(|track| match track {
        Track::Logged(spline) => Some(spline.span()),
        _ => None,
    });
    let Some((from, to)) = spans.reduce(|a, b| (a.0.max(b.0), a.1.min(b.1))) else {
        return String::new();
    };
    let times = (last - first) / (to - from);
    let longer = if times > 1.0 { "samples" } else { "streams" };
    if let Some(unit) = unit_of(times.max(times.recip())).filter(|_| times > 0.0) {
        return format!(
            "; the {longer} last {:.0} times as long: are their times in {unit}? {}",
            times.max(times.recip()),
            read_in(unit)
        );
    }
    // Most of the samples would be within the streams.
    if 2.0 * (last.min(to) - first.max(from)) > last - first {
        return "; a smaller delay_range keeps a smaller margin, and a pair for clocks that differ to one side, as in [\"0 s\", \"2 s\"], one at one end".to_owned();
    }
    if !are_all_outside || (last >= from && first <= to) {
        return String::new();
    }
    let (low, high) = ((from - first).min(to - last), (from - first).max(to - last));
    let middle = 0.5 * (low + high);
    let least = LEAST_APART.min(PART_APART * (last - first));
    let half = (0.5 * (high - low)).max(least);
    let places = if half >= 1.0 { 0 } else { 2 };
    let [low, high] = [middle - half, middle + half].map(|at| decimal(at, places));
    let halves = (middle / HALF_AN_HOUR).round();
    let zone = (middle - halves * HALF_AN_HOUR).abs() <= half.max(ALIKE)
        && halves != 0.0
        && halves.abs() <= MOST_HALVES;
    let zone = match zone {
        true => format!(" ({} h: a time zone?)", 0.5 * halves.abs()),
        false => String::new(),
    };
    format!("; if their clocks are apart{zone}, write delay_range = [\"{low} s\", \"{high} s\"]")
}

/// What a stream holds of an input, in words.
fn held(name: &str, spline: &Spline, zero: f64) -> String {
    let ((from, to), (gaps, longest)) = (spline.span(), spline.gaps());
    let (from, to) = (from + zero, to + zero);
    let [from, to, longest] = [from, to, longest].map(|time| decimals(time, 3));
    let gaps = match gaps {
        0 => String::new(),
        1 => format!(" with a gap of {longest} s"),
        _ => format!(" with {gaps} gaps of up to {longest} s"),
    };
    format!("`{name}` from {from} s to {to} s{gaps}")
}
