//! The noise scale factors of a budget: which are not as stated, which are far beyond noise, and the
//! problem with the noise that was found.

use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{AutocorrelatedNoise, Level};
use crate::diagnose::library::place::{Of, Place};
use crate::engine::Problem;

use crate::diagnose::thresholds::{SCALE, SCALE_DIFFERENCE};

use super::answer::{FAR_BEYOND_STATED, Remainder};
use super::linear::{Linear, Measurand};

/// Noise scale factors that are not as stated.
pub fn levels(linear: &Linear, scale: &[f64]) -> Vec<Level> {
    let mut found = Vec::new();
    let several = linear.fitted.problem.parts.len() > 1;
    for Measurand { number, part, measurand, name } in linear.measurands() {
        let data = &linear.fitted.problem.parts[part];
        let factor = scale[number];
        let level = |run, factor| {
            let of = data.label.clone().filter(|_| several);
            Level { measurand: name.to_owned(), of, run, factor }
        };
        if differs(linear, number, factor) {
            found.push(level(None, factor));
        }
        for (run, levels) in data.run_levels.iter().enumerate() {
            if levels[measurand] != 1.0 {
                let run = Some(data.runs[run].name.clone());
                found.push(level(run, factor * levels[measurand]));
            }
        }
    }
    found
}

/// Whether the noise scale factor of a measurand is not as stated.
fn differs(linear: &Linear, number: usize, factor: f64) -> bool {
    let score = (factor - 1.0) * (2.0 * linear.sums.readings[number] as f64).sqrt();
    score.abs() > SCALE && (factor - 1.0).abs() > SCALE_DIFFERENCE
}

/// Part of a noise scale factor that counts where the noise is autocorrelated, at least: it may be far larger
/// than the white noise that is stated, but not by any factor.
const OF_AUTOCORRELATED: f64 = 0.5;

/// Noise scale factors of the white part of the noise of each measurand, and a part of the whole.
pub fn white_scale(linear: &Linear, scale: &[f64]) -> Vec<f64> {
    let mut white = scale.to_vec();
    for (part, data) in linear.fitted.problem.parts.iter().enumerate() {
        for (row, noise) in data.gauss_markov.iter().enumerate() {
            let number = linear.sums.first_measurand[part] + data.measurand_of(row);
            if let Some(noise) = noise {
                let part = (1.0 - noise.share()).sqrt().max(OF_AUTOCORRELATED);
                white[number] = white[number].min(scale[number] * part);
            }
        }
        // A run that is so far from the others is no noise, either.
        for measurand in 0..data.sigma.len() {
            let most = data.run_levels.iter().fold(1.0_f64, |most, one| most.max(one[measurand]));
            if most > FAR_BEYOND_STATED {
                white[linear.sums.first_measurand[part] + measurand] *= most;
            }
        }
    }
    white
}

/// Scatter far beyond what is stated, as parts of the remainder.
pub fn scatter(linear: &Linear, scale: &[f64]) -> Vec<Remainder> {
    let Fitted { problem, fit, .. } = &linear.fitted;
    let is_far = |one: &Measurand<'_>| {
        scale[one.number] > FAR_BEYOND_STATED && linear.sums.readings[one.number] > 0
    };
    let part_of = |Measurand { number, part, measurand, name }: Measurand<'_>| {
        let factor = scale[number];
        let words = format!("the scatter of `{name}`, {factor:.1} times as stated");
        let rms = factor * problem.rms_sigma(&fit.point, part, measurand);
        Remainder {
            rms: Some((rms, name.to_owned())),
            ..Remainder::at(Place::new(Of::Measurand(name.to_owned()), "scatter", words))
        }
    };
    linear.measurands().filter(is_far).map(part_of).collect()
}

/// Autocorrelated noise that a problem has, by measurand.
pub fn autocorrelation(problem: &Problem) -> Vec<AutocorrelatedNoise> {
    let mut found: Vec<AutocorrelatedNoise> = Vec::new();
    for part in &problem.parts {
        for (row, own) in part.gauss_markov.iter().enumerate() {
            let Some(noise) = *own else { continue };
            let name = &part.system.assembly.names.measurands[part.measurand_of(row)].name;
            if found.iter().any(|one| one.measurand == *name && one.of == part.label) {
                continue;
            }
            let (measurand, of) = (name.clone(), part.label.clone());
            let is_over_rows = part.is_untimed();
            found.push(AutocorrelatedNoise { measurand, of, noise, is_over_rows });
        }
    }
    found
}

/// Gives measurands whose noise is not as stated the noise that was found.
pub fn scale_noise(problem: &mut Problem, linear: &Linear, scale: &[f64]) {
    for Measurand { number, part, measurand, .. } in linear.measurands() {
        if differs(linear, number, scale[number]) {
            problem.parts[part].sigma[measurand] *= scale[number];
        }
    }
}
