//! Standard uncertainties that are stated as formulas: of each reading another one. What they do to the
//! covariance of a sample is for `noise` to say.

use crate::engine::part::{Part, SampleLeaves};
use crate::engine::point::Point;
use crate::engine::problem::Problem;

impl Problem {
    /// A measurand whose standard uncertainty an effect would make negative at a point, with the
    /// factor on it there.
    pub fn negative_noise(&self, point: &Point) -> Option<(&str, f64)> {
        self.parts.iter().enumerate().find_map(|(p, part)| {
            let patched = part.slots().iter().any(|slot| slot.sigma_factor.is_some());
            let mut runs = (0..part.runs.len()).filter(|_| patched);
            let (_, measurand, factor) = runs.find_map(|run| {
                impossible_factor(part, run, &self.parameters(p, run, point), |factor| factor < 0.0)
            })?;
            Some((part.system.assembly.names.measurands[measurand].name.as_str(), factor))
        })
    }

    /// Root mean square of the stated standard uncertainty (SI) of the readings of a measurand at a
    /// point: where it is a formula it has another value for each.
    pub fn rms_sigma(&self, point: &Point, part: usize, measurand: usize) -> f64 {
        let own = &self.parts[part];
        if own.slots()[measurand].sigma_factor.is_none() {
            return own.sigma[measurand];
        }
        let runs = (0..own.runs.len()).flat_map(|run| {
            let all = factors(own, run, &self.parameters(part, run, point), measurand);
            all.into_iter().filter(|factor| !factor.is_nan())
        });
        let (sum, count) = runs.fold((0.0, 0), |all, one| (all.0 + one * one, all.1 + 1));
        own.sigma[measurand] * (sum / count.max(1) as f64).sqrt()
    }

    /// The factors on what is stated as a measurand's standard uncertainty, sample by sample of a run, at
    /// a point; `None` where all are 1.
    pub(crate) fn sigma_factors(
        &self,
        point: &Point,
        (part, run): (usize, usize),
        measurand: usize,
    ) -> Option<Vec<f64>> {
        let own = &self.parts[part];
        let is_formula = own.slots()[measurand].sigma_factor.is_some();
        is_formula.then(|| factors(own, run, &self.parameters(part, run, point), measurand))
    }

    /// The first reading for which a standard uncertainty that is stated as a formula is no positive
    /// number at a point: part, run, sample, measurand and what it is (SI).
    pub fn impossible_sigma(&self, point: &Point) -> Option<(usize, usize, usize, usize, f64)> {
        self.parts.iter().enumerate().find_map(|(p, part)| {
            let names = &part.system.assembly.names.measurands;
            let has_formula = names.iter().any(|one| one.sigma.is_some());
            let mut runs = (0..part.runs.len()).filter(|_| has_formula);
            runs.find_map(|run| {
                let parameters = self.parameters(p, run, point);
                let found = impossible_factor(part, run, &parameters, |factor| {
                    !(factor > 0.0 && factor.is_finite())
                });
                found.map(|(sample, measurand, sigma)| (p, run, sample, measurand, sigma))
            })
        })
    }
}

/// The factors on what is stated as a measurand's standard uncertainty, sample by sample of a run; NaN
/// where there is no reading.
fn factors(part: &Part, run: usize, parameters: &[[f64; 4]], measurand: usize) -> Vec<f64> {
    let randoms = vec![0.0; part.random_sigma.len()];
    let slot = &part.slots()[measurand];
    let (mut workspace, mut factors) = (Vec::new(), Vec::new());
    part.runs[run].record.walk(|stretch| {
        for sample in stretch.each() {
            let leaves =
                SampleLeaves { parameters, randoms: &randoms, columns: part.columns(), sample };
            let is_present = part.is_present(sample, slot);
            let outputs = part.evaluate(&leaves, &mut workspace);
            let factor = slot.sigma_factor.map_or(1.0, |output| outputs[output]);
            factors.push(if is_present { factor } else { f64::NAN });
        }
    });
    factors
}

/// The first reading of a run whose standard uncertainty is below zero, or none where it must be
/// one: sample, measurand and the factor on what is stated.
fn impossible_factor(
    part: &Part,
    run: usize,
    parameters: &[[f64; 4]],
    is_impossible: fn(f64) -> bool,
) -> Option<(usize, usize, f64)> {
    let randoms = vec![0.0; part.random_sigma.len()];
    let (mut workspace, mut found) = (Vec::new(), None);
    part.runs[run].record.walk(|stretch| {
        for sample in stretch.each() {
            if found.is_some() {
                return;
            }
            let leaves =
                SampleLeaves { parameters, randoms: &randoms, columns: part.columns(), sample };
            let outputs = part.evaluate(&leaves, &mut workspace);
            let factors = part.slots().iter().map(|slot| slot.sigma_factor).enumerate();
            found = factors
                .filter_map(|(measurand, output)| {
                    Some((sample.number, measurand, outputs[output?]))
                })
                .find(|(_, measurand, factor)| {
                    let is_read = part.is_present(sample, &part.slots()[*measurand]);
                    is_impossible(*factor) && (is_read || *factor < 0.0)
                });
        }
    });
    found
}
