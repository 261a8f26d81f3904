//! Measurands whose readings scatter far less than their stated standard uncertainty, as they do where
//! a unit is wrong. The global test pools all measurands, so it passes where one of several is so: its
//! small residuals hardly change the sum, and its readings hardly weigh in the fit.

use crate::engine::{Point, Problem};
use crate::estimate::calibrate::Calibration;
use crate::estimate::noise::Noise;

/// Residuals so many times as small as stated are no matter of a careful statement.
const FACTOR: f64 = 5.0;
/// Readings beyond the unknowns from which the scatter of a measurand is known.
const LEAST_REDUNDANCY: usize = 10;

/// A measurand with its scatter.
#[derive(Clone, Debug, PartialEq)]
pub struct Overstated {
    /// Its name.
    pub measurand: String,
    /// The campaign, where there are several.
    pub of: Option<String>,
    /// Standard deviation of its residuals (SI).
    pub scatter: f64,
    /// rms of its stated standard uncertainty (SI).
    pub stated: f64,
}

impl Overstated {
    /// How many times smaller the residuals are than stated.
    pub fn times(&self) -> f64 {
        self.stated / self.scatter
    }
}

/// The measurands whose residuals are far smaller than stated; none where the fit is no solution.
pub fn overstated(result: &Calibration) -> Vec<Overstated> {
    let problem = &result.problem;
    if !result.has_settled() || result.noise != Noise::Stated {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        let names = &part.system.assembly.names.measurands;
        for (m, (sum, count)) in squares(problem, &result.fit.point, p).into_iter().enumerate() {
            // Unknowns take residuals away: each of them at most one reading's share.
            let redundancy = count.saturating_sub(result.unknowns());
            if redundancy < LEAST_REDUNDANCY.max(result.unknowns()) {
                continue;
            }
            let one = Overstated {
                measurand: names[m].name.clone(),
                of: part.label.clone().filter(|_| problem.parts.len() > 1),
                scatter: (sum / redundancy as f64).sqrt(),
                stated: problem.rms_sigma(&result.fit.point, p, m),
            };
            // Readings all of one value, which the model hits, are no scatter.
            if one.scatter > 0.0 && one.times() > FACTOR {
                found.push(one);
            }
        }
    }
    found
}

/// Sum of squares and number of the residual components of each measurand of a campaign.
fn squares(problem: &Problem, point: &Point, part: usize) -> Vec<(f64, usize)> {
    let own = &problem.parts[part];
    let mut sums = vec![(0.0, 0); own.slots().len()];
    for run in 0..own.runs.len() {
        problem.visit_residuals(part, run, point, &mut |_, residuals| {
            for (slot, (sum, count)) in own.slots().iter().zip(&mut sums) {
                let rows = &residuals[slot.residual..slot.residual + slot.components];
                for value in rows.iter().filter(|value| !value.is_nan()) {
                    *sum += value * value;
                    *count += 1;
                }
            }
        });
    }
    sums
}
