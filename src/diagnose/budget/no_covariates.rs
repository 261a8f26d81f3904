//! What a block may not be over.
//!
//! Readings that hardly vary: a block over such a reading, or over its rate, is no instrument's error.
//! What varies in it is what rows and the parameters of a setup make of it, and the block would be these
//! rows by another name. Inputs that were taken from a reading, such as the row of an image in which a
//! point was seen: they have the reading's own noise, and a block of it over them would explain that.

use std::collections::BTreeSet;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::place::{Of, Place};
use crate::diagnose::thresholds::STILL;

/// Correlation of what an input and a reading differ from the prediction by, from which the input is a
/// copy of the reading.
const COPY: f64 = 0.5;

/// Words that are no covariate of a block.
#[derive(Clone, Debug, Default)]
pub struct NoCovariates {
    /// Measurands whose prediction varies by less than [`STILL`] standard uncertainties in every run.
    still: BTreeSet<String>,
    /// Measurands with an input that is a copy of it to less than its noise.
    copies: BTreeSet<(String, String)>,
}

impl NoCovariates {
    /// Of a fit.
    pub fn of(fitted: &Fitted) -> Self {
        let Fitted { problem, fit, .. } = fitted;
        let (mut still, mut varying) = (BTreeSet::new(), BTreeSet::new());
        let (mut copies, mut others) = (BTreeSet::new(), BTreeSet::new());
        for (p, part) in problem.parts.iter().enumerate() {
            let names = &part.system.assembly.names;
            for (measurand, slot) in
                part.slots().iter().enumerate().filter(|(_, one)| one.width == 1)
            {
                let own = &names.measurands[measurand];
                let sigma = problem.rms_sigma(&fit.point, p, measurand);
                let mut inputs = vec![Pairs::default(); names.inputs.len()];
                let mut varies = false;
                for run in 0..part.runs.len() {
                    let mut predicted = Pairs::default();
                    problem.visit_residuals(p, run, &fit.point, &mut |sample, residuals| {
                        let reading = sample.samples.readings[slot.column][sample.at];
                        let residual = residuals[slot.residual];
                        if !residual.is_finite() {
                            return;
                        }
                        predicted.add(reading - residual, 0.0);
                        let time = sample.samples.time[sample.at];
                        for (track, of) in sample.samples.inputs.iter().zip(&mut inputs) {
                            of.add(track.at(sample.at, time, 0.0_f64, 0) - reading, residual);
                        }
                    });
                    varies |= predicted.covariances()[0] > (STILL * sigma).powi(2);
                }
                let of = if varies { &mut varying } else { &mut still };
                of.insert(own.name.clone());
                for (input, of) in names.inputs.iter().zip(&inputs) {
                    let is_copy = input.unit.dimension == own.unit.dimension && of.is_copy(sigma);
                    let of = if is_copy { &mut copies } else { &mut others };
                    of.insert((own.name.clone(), input.name.clone()));
                }
            }
        }
        Self { still: &still - &varying, copies: &copies - &others }
    }

    /// Whether a block is over one of them.
    pub(super) fn has(&self, place: &Place) -> bool {
        let mut words = place.covariate.split(' ');
        let is_copy = |word: &str| match &place.of {
            Of::Measurand(name) => self.copies.contains(&(name.clone(), word.to_owned())),
            Of::Channel(_) => false,
        };
        words.any(|word| self.still.contains(word) || is_copy(word))
    }
}

/// Sums of two numbers about the first ones.
#[derive(Clone, Copy, Debug, Default)]
struct Pairs {
    count: f64,
    first: Option<[f64; 2]>,
    sums: [f64; 2],
    products: [f64; 3],
}

impl Pairs {
    fn add(&mut self, a: f64, b: f64) {
        let [first_a, first_b] = *self.first.get_or_insert([a, b]);
        let (a, b) = (a - first_a, b - first_b);
        self.count += 1.0;
        self.sums.iter_mut().zip([a, b]).for_each(|(sum, own)| *sum += own);
        self.products.iter_mut().zip([a * a, a * b, b * b]).for_each(|(sum, own)| *sum += own);
    }

    /// The variance of the first number, the covariance, and the variance of the second.
    fn covariances(&self) -> [f64; 3] {
        let count = self.count.max(1.0);
        let [a, b] = self.sums.map(|sum| sum / count);
        let [aa, ab, bb] = self.products.map(|sum| sum / count);
        [aa - a * a, ab - a * b, bb - b * b]
    }

    /// Of an input less a reading, and the reading's residual: whether they differ by less than the noise,
    /// and both differ alike from the prediction.
    fn is_copy(&self, sigma: f64) -> bool {
        let [aa, ab, bb] = self.covariances();
        let of_input = aa + 2.0 * ab + bb;
        self.count > 2.0 && aa < sigma * sigma && ab + bb > COPY * (of_input * bb).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_has_the_noise_of_its_reading() {
        let noise = |row: i32| f64::from(row * 7919 % 101) / 50.0 - 1.0;
        let is_copy = |input: fn(f64, f64) -> f64| {
            let mut pairs = Pairs::default();
            for row in 0..200 {
                let (predicted, residual) = (0.37 * f64::from(row), noise(row));
                pairs.add(input(predicted, residual) - predicted - residual, residual);
            }
            pairs.is_copy(1.0)
        };
        assert!(is_copy(|predicted, residual| (predicted + residual).round()));
        // What is commanded, with a scale that the model has; and what another instrument reads.
        assert!(!is_copy(|predicted, _| 1.001 * predicted));
        assert!(!is_copy(|predicted, _| predicted + 0.3 * (40.0 * predicted).sin()));
    }
}
