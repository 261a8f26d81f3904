//! The noise scale factors of a budget: which are not as stated, which are far beyond noise, and the
//! problem with the noise that was found.

use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::Level;
use crate::diagnose::library::place::{Of, Place};
use crate::engine::Problem;
use crate::engine::gauss_markov::GaussMarkov;

use crate::diagnose::thresholds::{SCALE, SCALE_DIFFERENCE};

use super::answer::{FAR_BEYOND_STATED, Remainder};
use super::linear::Linear;
use crate::diagnose::price::Gain;

/// Noise scale factors that are not as stated.
pub fn levels(linear: &Linear, scale: &[f64]) -> Vec<Level> {
    let mut found = Vec::new();
    let several = linear.fitted.problem.parts.len() > 1;
    for (part, data) in linear.fitted.problem.parts.iter().enumerate() {
        for (measurand, own) in data.system.assembly.names.measurands.iter().enumerate() {
            let number = linear.sums.first_measurand[part] + measurand;
            let factor = scale[number];
            let score = (factor - 1.0) * (2.0 * linear.sums.readings[number] as f64).sqrt();
            if score.abs() > SCALE && (factor - 1.0).abs() > SCALE_DIFFERENCE {
                let of = data.label.clone().filter(|_| several);
                found.push(Level { measurand: own.name.clone(), of, run: None, factor });
            }
            for (run, levels) in data.run_levels.iter().enumerate() {
                if levels[measurand] != 1.0 {
                    found.push(Level {
                        measurand: own.name.clone(),
                        of: data.label.clone().filter(|_| several),
                        run: Some(data.runs[run].name.clone()),
                        factor: factor * levels[measurand],
                    });
                }
            }
        }
    }
    found
}

/// Noise scale factors of the white part of the noise of each measurand.
pub fn white_scale(linear: &Linear, scale: &[f64]) -> Vec<f64> {
    let mut white = scale.to_vec();
    for (part, data) in linear.fitted.problem.parts.iter().enumerate() {
        for (row, noise) in data.gauss_markov.iter().enumerate() {
            let number = linear.sums.first_measurand[part] + data.measurand_of(row);
            if let Some(noise) = noise {
                white[number] = white[number].min(scale[number] * (1.0 - noise.share).sqrt());
            }
        }
    }
    white
}

/// Scatter far beyond what is stated, as parts of the remainder.
pub fn scatter(linear: &Linear, scale: &[f64]) -> Vec<Remainder> {
    let mut found = Vec::new();
    for (part, data) in linear.fitted.problem.parts.iter().enumerate() {
        for (measurand, own) in data.system.assembly.names.measurands.iter().enumerate() {
            let number = linear.sums.first_measurand[part] + measurand;
            let factor = scale[number];
            if factor > FAR_BEYOND_STATED && linear.sums.readings[number] > 0 {
                let place = Place {
                    of: Of::Measurand(own.name.clone()),
                    covariate: "scatter".to_owned(),
                    words: format!("the scatter of `{}`, {factor:.1} times as stated", own.name),
                    run: None,
                    rows: None,
                };
                let Fitted { problem, fit, .. } = &linear.fitted;
                let sigma = problem.rms_sigma(&fit.point, part, measurand);
                let rms = Some((factor * sigma, own.name.clone()));
                found.push(Remainder {
                    place,
                    gain: Gain::default(),
                    share: 0.0,
                    rms,
                    amplitude: None,
                    change: None,
                    nearest: None,
                });
            }
        }
    }
    found
}

/// Autocorrelated noise that a problem has, by measurand.
pub fn autocorrelation(problem: &Problem) -> Vec<(String, Option<String>, GaussMarkov)> {
    let mut found = Vec::new();
    for part in &problem.parts {
        for (row, own) in part.gauss_markov.iter().enumerate() {
            let Some(own) = own else { continue };
            let measurand = part.measurand_of(row);
            let name = part.system.assembly.names.measurands[measurand].name.clone();
            if found.iter().any(|(known, label, _)| *known == name && *label == part.label) {
                continue;
            }
            found.push((name, part.label.clone(), *own));
        }
    }
    found
}

/// Gives measurands the noise that was found.
pub fn scale_noise(problem: &mut Problem, linear: &Linear, scale: &[f64]) {
    let mut parts = std::mem::take(&mut problem.parts);
    for (number, part) in parts.iter_mut().enumerate() {
        for (measurand, sigma) in part.sigma.iter_mut().enumerate() {
            let number = linear.sums.first_measurand[number] + measurand;
            let factor = scale[number];
            let score = (factor - 1.0) * (2.0 * linear.sums.readings[number] as f64).sqrt();
            if score.abs() > SCALE {
                *sigma *= factor;
            }
        }
    }
    *problem = Problem { progress: problem.progress.clone(), ..Problem::new(parts) };
}
