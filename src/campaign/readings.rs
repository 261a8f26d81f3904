//! The readings of one measured run: which are there, and which may be used.

use crate::campaign::file::{LeftOut, Named, RunEntry};
use crate::campaign::run::Samples;
use crate::campaign::samples::{Loader, reading_columns};
use crate::campaign::signal::Track;
use crate::campaign::table::Table;
use crate::diagnostic::Diagnostic;
use crate::graph::MeasurandKind;

/// A quaternion whose norm is further from 1 is not one.
const NORM_TOLERANCE: f64 = 1e-2;

impl Loader<'_> {
    /// The reading columns in SI; quaternions are normalised.
    pub(crate) fn readings(&mut self, data: &Named, table: &Table) -> Vec<Vec<f64>> {
        let columns = reading_columns(self.model);
        if columns.iter().all(|(_, name)| table.column(name).is_none()) {
            let names: Vec<_> = columns.iter().map(|(_, name)| name.as_str()).collect();
            let message = format!("`{}` holds no reading", data.text);
            let help = format!("expected columns {}; found {}", names.join(", "), table.names());
            self.reader.fault(data.span, message, help);
        }
        let missing = || vec![f64::NAN; table.lines.len()];
        let mut readings: Vec<Vec<f64>> = columns
            .iter()
            .map(|(_, name)| table.values(name).map_or_else(missing, <[f64]>::to_vec))
            .collect();
        for first in 0..columns.len() {
            let (index, name) = &columns[first];
            let again = first > 0 && columns[first - 1].0 == *index;
            if self.model.measurands[*index].kind != MeasurandKind::Rotation || again {
                continue;
            }
            let found: Vec<_> = columns[first..first + 4]
                .iter()
                .filter_map(|(_, name)| table.column(name))
                .collect();
            if !found.is_empty() && found.len() < 4 {
                let measurand = &self.model.measurands[*index].name;
                let message = format!(
                    "`{}` holds {} of the four columns of `{measurand}`",
                    data.text,
                    found.len()
                );
                let help = format!(
                    "a rotation is {measurand}_w, {measurand}_x, {measurand}_y, {measurand}_z"
                );
                self.reader.fault(data.span, message, help);
                continue;
            }
            for row in 0..table.lines.len() {
                let norm =
                    readings[first..first + 4].iter().map(|c| c[row] * c[row]).sum::<f64>().sqrt();
                if (norm - 1.0).abs() > NORM_TOLERANCE {
                    let mut fault =
                        Diagnostic::error(format!("this quaternion has norm {norm:.4}, not 1"));
                    if let Some(column) = table.column(name) {
                        fault = fault.at(table.cell_place(row, column));
                    }
                    self.reader.faults.push(fault);
                    break;
                }
                readings[first..first + 4].iter_mut().for_each(|column| column[row] /= norm);
            }
        }
        readings
    }

    /// Takes out the readings of samples that lack an input, or lie outside a stream.
    pub(crate) fn leave_out(&mut self, entry: &RunEntry, samples: &mut Samples, usable: &[bool]) {
        let read: Vec<bool> = (0..samples.len())
            .map(|row| samples.readings.iter().any(|column| !column[row].is_nan()))
            .collect();
        let (mut lacking, mut outside) = (0, 0);
        let mut drop = vec![false; samples.len()];
        for row in 0..samples.len() {
            let time = samples.time[row];
            let covered = samples.inputs.iter().zip(&self.model.inputs).all(|(track, input)| {
                let margin = if input.signal { self.delay_range } else { 0.0 };
                match track {
                    Track::Logged(spline) => spline.covers(time - margin, time + margin),
                    _ => true,
                }
            });
            drop[row] = !usable[row] || !covered;
            lacking += usize::from(read[row] && !usable[row]);
            outside += usize::from(read[row] && usable[row] && !covered);
        }
        for column in &mut samples.readings {
            column
                .iter_mut()
                .zip(&drop)
                .filter(|(_, drop)| **drop)
                .for_each(|(value, _)| *value = f64::NAN);
        }
        let run = entry.name.text.clone();
        if lacking > 0 {
            let why = "an input is missing".to_owned();
            self.left_out.push(LeftOut { run: run.clone(), samples: lacking, why });
        }
        if outside > 0 {
            let why =
                format!("within {} s of the end of a stream, or outside it", self.delay_range);
            self.left_out.push(LeftOut { run: run.clone(), samples: outside, why });
        }
        let all = read.iter().filter(|read| **read).count();
        if 2 * outside > all {
            let spans: Vec<String> = samples
                .inputs
                .iter()
                .zip(&self.model.inputs)
                .filter_map(|(track, input)| match track {
                    Track::Logged(spline) => Some(format!(
                        "`{}` from {:.3} s to {:.3} s",
                        input.name,
                        spline.span().0,
                        spline.span().1
                    )),
                    _ => None,
                })
                .take(3)
                .collect();
            let message =
                format!("{outside} of {all} samples of run `{run}` lie outside its streams");
            let help = format!(
                "the samples go from {:.3} s to {:.3} s, the streams hold {}; a margin of delay_range = \"{} s\" is kept",
                samples.time.first().copied().unwrap_or(0.0),
                samples.time.last().copied().unwrap_or(0.0),
                spans.join(", "),
                self.delay_range
            );
            let span = entry.signals.first().map_or(entry.name.span, |name| name.span);
            self.reader.fault(span, message, help);
        }
    }
}
