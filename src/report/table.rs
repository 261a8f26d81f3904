//! Results reading by reading, as CSV in the same form as campaign data: `name [unit]` a column.

use std::io::{self, Write};

use crate::campaign::Sample;
use crate::campaign::stamps;
use crate::engine::Part;
use crate::estimate::blind::ArmAngle;
use crate::estimate::calibrate::Calibration;
use crate::estimate::newton::ReadingDelay;
use crate::estimate::redundancy::{Checked, visit_checked};

/// The header of a table of delays: one row a reading, its run, row of its data file, measurand,
/// time, state, delay and uncertainties; at last the arm angle at the reference time, in [0, 2π),
/// where the model has one.
pub const DELAYS: &str = "run,row,measurand,time [s],state,delay [s],standard_uncertainty [s],expanded_uncertainty [s],random_part [s],common_part [s],arm_angle [rad]\n";

/// One row of it.
///
/// # Errors
/// Those of `out`.
pub fn delay(
    part: &Part,
    reading: &ReadingDelay,
    arm: &mut ArmAngle,
    out: &mut dyn Write,
) -> io::Result<()> {
    let run = quoted(&part.runs[reading.run].name);
    let measurand = &part.system.assembly.names.measurands[reading.measurand].name;
    let ReadingDelay { row, time, .. } = reading;
    let time = stamps::written(part.zero, *time);
    write!(out, "{run},{row},{measurand},{time},{}", reading.state.word())?;
    let (standard, expanded) = (reading.standard_uncertainty(), reading.expanded_uncertainty());
    for value in [reading.delay, standard, expanded, reading.random, reading.common] {
        if value.is_finite() {
            write!(out, ",{value:.9e}")?;
        } else {
            write!(out, ",")?;
        }
    }
    match arm.at(part, reading) {
        Some(angle) => writeln!(out, ",{angle:.9}"),
        None => writeln!(out, ","),
    }
}

/// A CSV cell, quoted where it must be.
pub(crate) fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}

/// One row a parameter component: name, scope, of, value, standard uncertainty, unit.
pub fn parameters(result: &Calibration) -> String {
    let mut text = String::from("name,scope,of,value,standard_uncertainty,unit\n");
    let cell = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.12e}"));
    for one in result.estimates() {
        let scope = super::json::scope_word(one.scope);
        let of = quoted(one.of.as_deref().unwrap_or_default());
        let (value, sigma) = (cell(one.value), cell(one.sigma));
        text.push_str(&format!("{},{scope},{of},{value},{sigma},{}\n", one.name, one.unit));
    }
    text
}

/// One row a reading component: campaign, run, row of its data file, time, measurand, residual with
/// its unit, the residual over its standard deviation, redundancy number (empty where nothing
/// controls the reading).
///
/// # Errors
/// Those of `out`.
pub fn residuals(result: &Calibration, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "campaign,run,row,time [s],measurand,component,residual,unit,standardised [1],redundancy [1]"
    )?;
    let mut written = Ok(());
    let problem = &result.problem;
    for (p, part) in problem.parts.iter().enumerate() {
        let label = quoted(part.label.as_deref().unwrap_or_default());
        for (r, run) in part.runs.iter().enumerate() {
            let name = quoted(&run.name);
            visit_checked(result, (p, r), &mut |sample, values| {
                if written.is_ok() {
                    written = residual_rows(out, part, &format!("{label},{name}"), sample, values);
                }
            });
        }
    }
    written
}

fn residual_rows(
    out: &mut dyn Write,
    part: &Part,
    labels: &str,
    sample: Sample<'_>,
    values: &[Checked],
) -> io::Result<()> {
    let (row, time) = (sample.row(), stamps::written(part.zero, sample.time()));
    for (measurand, slot) in part.system.assembly.names.measurands.iter().zip(part.slots()) {
        let name = &measurand.name;
        let unit = if slot.components == 3 { "rad".to_owned() } else { measurand.unit.si_symbol() };
        for component in 0..slot.components {
            let Checked { residual, standardised, redundancy } = values[slot.residual + component];
            if !residual.is_finite() {
                continue;
            }
            write!(out, "{labels},{row},{time},{name},{component},{residual:.9e},{unit},")?;
            if standardised.is_finite() {
                write!(out, "{standardised:.6}")?;
            }
            if redundancy.is_finite() {
                writeln!(out, ",{redundancy:.6}")?;
            } else {
                writeln!(out, ",")?;
            }
        }
    }
    Ok(())
}
