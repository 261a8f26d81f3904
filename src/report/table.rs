//! Results reading by reading, as CSV in the same form as campaign data: `name [unit]` a column.

use crate::engine::Problem;
use crate::estimate::calibrate::Calibration;
use crate::estimate::delays::Delays;

/// One row a reading: run, row of its data file, measurand, time, state, delay and uncertainties.
pub fn delays(problem: &Problem, part: usize, delays: &Delays) -> String {
    let data = &problem.parts[part];
    let mut text = String::from(
        "run,row,measurand,time [s],state,delay [s],standard_uncertainty [s],expanded_uncertainty [s],random_part [s],common_part [s]\n",
    );
    for reading in &delays.readings {
        let run = &data.runs[reading.run];
        let measurand = &data.system.assembly.names.measurands[reading.measurand].name;
        let row = run.held().rows.get(reading.sample).copied().unwrap_or(reading.sample + 1);
        let time = run.held().time[reading.sample];
        let state = reading.state.word();
        let numbers = [
            reading.delay,
            reading.standard_uncertainty(),
            reading.expanded_uncertainty(),
            reading.random,
            reading.common,
        ]
        .map(|value| if value.is_finite() { format!("{value:.9e}") } else { String::new() })
        .join(",");
        text.push_str(&format!(
            "{},{row},{measurand},{time},{state},{numbers}\n",
            quoted(&run.name)
        ));
    }
    text
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

/// One row a reading component: campaign, run, row of its data file, time, measurand, residual (SI).
pub fn residuals(result: &Calibration) -> String {
    let mut text = String::from("campaign,run,row,time [s],measurand,component,residual\n");
    let problem = &result.problem;
    for (p, part) in problem.parts.iter().enumerate() {
        let label = quoted(part.label.as_deref().unwrap_or_default());
        for (r, run) in part.runs.iter().enumerate() {
            for (sample, values) in problem.residuals(p, r, &result.fit.point).iter().enumerate() {
                let row = run.held().rows.get(sample).copied().unwrap_or(sample + 1);
                for (measurand, slot) in
                    part.system.assembly.names.measurands.iter().zip(part.slots())
                {
                    for component in 0..slot.components {
                        let value = values[slot.residual + component];
                        if value.is_finite() {
                            text.push_str(&format!(
                                "{label},{},{row},{},{},{component},{value:.9e}\n",
                                quoted(&run.name),
                                run.held().time[sample],
                                measurand.name
                            ));
                        }
                    }
                }
            }
        }
    }
    text
}
