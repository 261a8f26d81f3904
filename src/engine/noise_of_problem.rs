//! The noise of whole campaigns: the covariance of the readings of one sample after the other, and
//! the standard deviations of random quantities.

use indexmap::IndexMap;

use crate::campaign::Sample;
use crate::engine::noise::{SampleCovariance, active_randoms, covariance_of};
use crate::engine::part::Part;
use crate::engine::point::Point;
use crate::engine::problem::Problem;

/// Samples of a campaign that the rms of the noise is taken over at most.
const MOST_SAMPLES: usize = 5_000;

impl Problem {
    /// Shows every so many samples of a run with the covariance of their readings at a point.
    pub fn visit_covariances(
        &self,
        (part, run): (usize, usize),
        point: &Point,
        stride: usize,
        mut visit: impl FnMut(Sample<'_>, SampleCovariance),
    ) {
        let data = &self.parts[part];
        let active = active_randoms(data);
        let parameters = self.parameters(part, run, point);
        let mut workspace = Vec::new();
        data.runs[run].record.walk(|stretch| {
            for sample in stretch.each().filter(|sample| sample.number % stride == 0) {
                visit(
                    sample,
                    covariance_of(data, run, sample, &parameters, &active, &mut workspace),
                );
            }
        });
    }

    /// rms of the residuals that the noise alone gives at a point, by measurand.
    pub fn noise_rms(&self, point: &Point) -> Vec<(String, f64)> {
        let mut sums: IndexMap<&str, (f64, f64)> = IndexMap::new();
        for (p, part) in self.parts.iter().enumerate() {
            let samples: usize = part.runs.iter().map(|run| run.record.len()).sum();
            let stride = samples.div_ceil(MOST_SAMPLES).max(1);
            let names = &part.system.assembly.names.measurands;
            for run in 0..part.runs.len() {
                self.visit_covariances((p, run), point, stride, |sample, made| {
                    let all = names.iter().zip(part.slots());
                    for (measurand, slot) in all.filter(|(_, slot)| part.is_present(sample, slot)) {
                        let rows = slot.residual..slot.residual + slot.components;
                        let variance: f64 = rows.map(|row| made.covariance[(row, row)]).sum();
                        let (sum, count) = sums.entry(&measurand.name).or_default();
                        *sum += variance;
                        *count += 1.0;
                    }
                });
            }
        }
        let rms =
            |(name, (sum, count)): (&str, (f64, f64))| (name.to_owned(), (sum / count).sqrt());
        sums.into_iter().map(rms).collect()
    }

    /// The standard deviation of a random quantity.
    pub fn random(&self, name: &str) -> Option<f64> {
        let place = |part: &Part| part.system.randoms.iter().position(|one| one.name == name);
        self.parts.iter().find_map(|part| Some(part.random_sigma[place(part)?]))
    }

    /// Gives a random quantity a standard deviation in every campaign that has it.
    pub fn set_random(&mut self, name: &str, value: f64) {
        for part in &mut self.parts {
            for (random, sigma) in part.system.randoms.iter().zip(&mut part.random_sigma) {
                if random.name == name {
                    *sigma = value;
                }
            }
        }
    }
}
