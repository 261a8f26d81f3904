//! The mean of the delays of readings beside the joint estimate of the same delay.

use crate::engine::Problem;
use crate::estimate::calibrate::{Calibration, Estimate};
use crate::estimate::delays::Summary;

/// One measurand's delay by both ways.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The measurand.
    pub measurand: String,
    /// Mean of the delays of readings (s).
    pub newton: Option<f64>,
    /// Its standard uncertainty (s).
    pub newton_sigma: Option<f64>,
    /// Joint estimate (s); the mean over its runs or setups where it has several values.
    pub batch: Option<f64>,
    /// Its standard uncertainty (s).
    pub batch_sigma: Option<f64>,
}

impl Comparison {
    /// newton - batch (s).
    pub fn difference(&self) -> Option<f64> {
        Some(self.newton? - self.batch?)
    }

    /// The difference over `√|u_N² - u_B²|`: both use the same readings, and the joint estimate is
    /// the efficient one, so the variance of the difference is the difference of the variances.
    /// `None` where both are so alike that their difference has no scale of its own.
    pub fn normalised(&self) -> Option<f64> {
        let (n, b) = (self.newton_sigma?, self.batch_sigma?);
        let scale = (n * n - b * b).abs().sqrt();
        (scale > 0.0).then_some(self.difference()? / scale)
    }
}

/// Puts both ways side by side for each measurand of one campaign.
pub fn compare(calibration: &Calibration, part: usize, newton: &[Summary]) -> Vec<Comparison> {
    let estimates = calibration.estimates();
    newton
        .iter()
        .map(|summary| {
            let (batch, batch_sigma) =
                joint_delay(calibration, &estimates, part, &summary.measurand);
            Comparison {
                measurand: summary.measurand.clone(),
                newton: summary.mean,
                newton_sigma: summary.sigma_of_mean,
                batch,
                batch_sigma,
            }
        })
        .collect()
}

fn joint_delay(
    calibration: &Calibration,
    estimates: &[Estimate],
    part: usize,
    measurand: &str,
) -> (Option<f64>, Option<f64>) {
    let problem: &Problem = &calibration.problem;
    let names = &problem.parts[part].system.assembly.names;
    let Some(declared) = names.measurands.iter().find(|one| one.name == measurand) else {
        return (None, None);
    };
    let mut instances: Vec<usize> = (0..problem.parts[part].runs.len())
        .map(|run| problem.layout.instance_in(part, run, declared.delay))
        .collect();
    instances.sort_unstable();
    instances.dedup();
    if let [only] = instances.as_slice() {
        let found = estimates.iter().find(|estimate| estimate.instance == Some(*only));
        return found.map_or((None, None), |one| (one.value, one.sigma));
    }
    let weight = 1.0 / instances.len() as f64;
    let (mut mean, mut variance) = (0.0, 0.0);
    for i in &instances {
        mean += weight * calibration.fit.point.values[*i][0];
        for j in &instances {
            for (a, ca) in problem.layout.columns_of(*i, 0) {
                for (b, cb) in problem.layout.columns_of(*j, 0) {
                    variance += weight * weight * ca * cb * calibration.covariance[(a, b)];
                }
            }
        }
    }
    (Some(mean), Some(variance.max(0.0).sqrt()))
}
