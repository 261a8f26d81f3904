//! Readings that hardly vary. A block over such a reading, or over its rate, is no instrument's
//! error: what varies in it is what rows and the parameters of a setup make of it, and the block
//! would be these rows by another name.

use std::collections::BTreeSet;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::thresholds::STILL;

/// The measurands whose prediction varies by less than [`STILL`] standard uncertainties in every run.
pub(super) fn still_readings(fitted: &Fitted) -> BTreeSet<String> {
    let Fitted { problem, fit, .. } = fitted;
    let (mut still, mut varying) = (BTreeSet::new(), BTreeSet::new());
    for (p, part) in problem.parts.iter().enumerate() {
        let names = &part.system.assembly.names.measurands;
        for (measurand, slot) in part.slots().iter().enumerate().filter(|(_, one)| one.width == 1) {
            let least = STILL * problem.rms_sigma(&fit.point, p, measurand);
            let varies = |run: usize| {
                // Count, sum and sum of squares about the first.
                let (mut first, mut sums) = (None, [0.0_f64; 3]);
                problem.visit_residuals(p, run, &fit.point, &mut |sample, residuals| {
                    let reading = sample.samples.readings[slot.column][sample.at];
                    let predicted = reading - residuals[slot.residual];
                    if predicted.is_finite() {
                        let x = predicted - *first.get_or_insert(predicted);
                        sums.iter_mut().zip([1.0, x, x * x]).for_each(|(sum, x)| *sum += x);
                    }
                });
                let [count, sum, squares] = sums;
                count > 0.0 && squares / count - (sum / count).powi(2) > least * least
            };
            let found = if (0..part.runs.len()).any(varies) { &mut varying } else { &mut still };
            found.insert(names[measurand].name.clone());
        }
    }
    &still - &varying
}
