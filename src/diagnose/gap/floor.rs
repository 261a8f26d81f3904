//! rms of the residuals that noise alone gives, by measurand. It judges nothing.

use indexmap::IndexMap;

use crate::diagnose::fitted::Fitted;
use crate::engine::noise::{active_randoms, covariance_of};

/// Samples looked at at most.
const MOST_SAMPLES: usize = 5_000;

/// rms that the noise alone gives, by measurand.
pub fn floor(fitted: &Fitted) -> Vec<(String, f64)> {
    let mut sums: IndexMap<&str, (f64, f64)> = IndexMap::new();
    let problem = &fitted.problem;
    for (p, part) in problem.parts.iter().enumerate() {
        let samples: usize = part.runs.iter().map(|run| run.record.len()).sum();
        let stride = samples.div_ceil(MOST_SAMPLES).max(1);
        let active = active_randoms(part);
        let mut memory = Vec::new();
        for (run, data) in part.runs.iter().enumerate() {
            let parameters = problem.parameters(p, run, &fitted.fit.point);
            data.record.walk(|stretch| {
                for sample in stretch.each().filter(|sample| sample.number % stride == 0) {
                    let made = covariance_of(part, run, sample, &parameters, &active, &mut memory);
                    let names = &part.system.assembly.names.measurands;
                    let all = names.iter().zip(part.slots());
                    for (measurand, slot) in all.filter(|(_, slot)| part.is_present(sample, slot)) {
                        let rows = slot.residual..slot.residual + slot.components;
                        let variance: f64 = rows.map(|row| made.covariance[(row, row)]).sum();
                        let (sum, count) = sums.entry(&measurand.name).or_default();
                        *sum += variance;
                        *count += 1.0;
                    }
                }
            });
        }
    }
    let rms = |(name, (sum, count)): (&str, (f64, f64))| (name.to_owned(), (sum / count).sqrt());
    sums.into_iter().map(rms).collect()
}
