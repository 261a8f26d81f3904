//! Transients: stretches in which a reading leaves the model and comes back, in a form of their own that no
//! effect, block or change has: wheels that spin, a bump, a hand on the rig. It happens once or a few times;
//! what comes back often is structure.
//!
//! The residuals of rows alone are smoothed by running medians of three, which single outliers do not pass.
//! The stretch is the one with the largest sum of their squares, in robust variances, beyond a constant for
//! each reading. It has a free value for each of its readings, at the price of so many.

use std::ops::Range;

use crate::diagnose::found::{Stretch, Wrong};
use crate::diagnose::library::place::{Extent, Of, Place};
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::{ENTER, TIE};
use crate::engine::Problem;
use crate::statistics::{median_size, robust};

use super::autocorrelation::Component;
use super::linear::{Linear, Measurand};
use super::noise::{ReadingAt, components};
use super::selection::{Ranked, Selection};

/// Transients of a reading at most.
pub const MOST: usize = 3;
/// A smaller one has so many times less gain.
const SMALLER: f64 = 4.0;
/// Readings of one at least, and one in so many of its run's at most.
const SHORTEST: usize = 5;
const LONGEST: usize = 10;
/// Robust standard deviations from which a median of three belongs to it.
const FAR: f64 = 2.0;
/// Correlation of neighbours in it at least.
const CORRELATED: f64 = 0.5;
/// Medians in a row that do not, at most.
const GAP: usize = 8;
/// Each of its ends, with smaller ones, is one in so many of its readings at most.
const PART_OF_AN_END: usize = 4;

/// A transient of a measurand.
#[derive(Clone, Debug)]
pub struct Transient {
    /// The campaign, its run, and the measurand in it.
    pub at: (usize, usize, usize),
    /// Its samples.
    pub samples: Range<usize>,
    /// Sum of squares of its smoothed residuals, in robust variances.
    pub gain: Gain,
    /// Their rms in standard deviations as stated.
    pub rms: f64,
    /// Their median size in robust standard deviations.
    pub deviations: f64,
    /// Where that is, in rows of the file.
    pub place: Place,
}

impl Transient {
    /// Whether a reading is in it.
    pub(super) fn has(&self, linear: &Linear, (run, sample, number): ReadingAt) -> bool {
        let (part, run) = linear.fitted.problem.run_at(run);
        let measurand = number - linear.sums.first_measurand[part];
        self.at == (part, run, measurand) && self.samples.contains(&sample)
    }

    /// Whether another one is of the same reading.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        (self.at.0, self.at.2) == (other.at.0, other.at.2)
    }

    /// As it is listed.
    pub(super) fn stretch(&self, problem: &Problem) -> Stretch {
        let (part, run, measurand) = self.at;
        let data = &problem.parts[part];
        let record = &data.runs[run].record;
        Stretch {
            run: data.run_name(run),
            measurand: data.system.assembly.names.measurands[measurand].name.clone(),
            readings: self.gain.degrees,
            rows: (record.row(self.samples.start), record.row(self.samples.end - 1)),
            deviations: self.deviations,
            how: Wrong::FarOut,
        }
    }
}

impl Linear {
    /// The transients of the measurand that has the largest, where they explain more than any term beside a
    /// model, by the noise that the readings have elsewhere: a transient, too, makes it look larger.
    pub(super) fn transients(&self, selection: &Selection<'_>, model: &[usize]) -> Vec<Transient> {
        let mut best: Option<(f64, f64, Vec<Transient>)> = None;
        let residuals = components(self, selection, model, &mut |_, _| {});
        for Measurand { number, part, measurand, name } in self.measurands() {
            let Some(block) = self.error_of_a_run(name) else { continue };
            let of_measurand = residuals.iter().filter(|(at, _)| at.1 == number);
            for (_, runs) in of_measurand {
                let deviation = robust(runs.values().flatten().map(|one| &one.2));
                let Some(deviation) = deviation.filter(|own| *own > 0.0) else { continue };
                let found = stretches(runs, deviation);
                let Some(first) = found.first().filter(|_| found.len() <= MOST) else { continue };
                let ln_bayes = selection.ln_bayes_factor_of_block(first.gain, first.members);
                if ln_bayes < best.as_ref().map_or(ENTER, |best| best.0) {
                    continue;
                }
                let data = &self.fitted.problem.parts[part];
                let transient = |Found { run, samples, gain, deviations, .. }: &Found| {
                    let run = self.fitted.problem.run_at(*run).1;
                    let record = &data.runs[run].record;
                    let rows = Extent::Rows(record.row(samples.start), record.row(samples.end - 1));
                    let place = block.within(&data.run_name(run), rows);
                    let (samples, gain, deviations) = (samples.clone(), *gain, *deviations);
                    let rms = deviation * (gain.gain / gain.degrees as f64).sqrt();
                    let at = (part, run, measurand);
                    Transient { at, samples, gain, rms, deviations, place }
                };
                let noise = (selection.scale[number] / deviation).powi(2);
                best = Some((ln_bayes, noise, found.iter().map(transient).collect()));
            }
        }
        let Some((ln_bayes, noise, found)) = best else { return Vec::new() };
        let all: Vec<usize> = (0..selection.terms.len()).collect();
        let other = |one: Ranked| {
            let gain = Gain { gain: noise * one.gain.gain, ..one.gain };
            selection.ln_bayes_factor(one.term, gain)
        };
        let others = selection.ranked(model, &all).into_iter().map(other);
        if others.fold(0.0, f64::max) + TIE < ln_bayes { found } else { Vec::new() }
    }

    /// The place of an error of a measurand that each run has a value of.
    fn error_of_a_run(&self, name: &str) -> Option<&Place> {
        let mut places = self.candidates.iter().filter_map(|one| one.place.as_ref());
        places.find(|one| one.is_of_runs() && one.of == Of::Measurand(name.to_owned()))
    }
}

/// A stretch of residuals.
#[derive(Clone, Debug)]
struct Found {
    run: usize,
    samples: Range<usize>,
    gain: Gain,
    deviations: f64,
    /// Whether its residuals are correlated.
    is_form: bool,
    /// Stretches that were compared.
    members: usize,
}

/// The stretches of a component that are far out, largest first: those that are not far smaller than it.
fn stretches(runs: &Component, deviation: f64) -> Vec<Found> {
    let mut found: Vec<Found> = Vec::new();
    for (run, values) in runs {
        let smooth = medians(&values.iter().map(|one| one.2).collect::<Vec<_>>());
        let mut rest: Vec<Range<usize>> = std::iter::once(0..smooth.len()).collect();
        while let Some(part) = rest.pop() {
            let Some(own) = largest(&smooth[part.clone()], FAR * deviation) else { continue };
            let own = part.start + own.start..part.start + own.end;
            let square = |value: &f64| (value / deviation).powi(2);
            let gain: f64 = smooth[own.clone()].iter().map(square).sum();
            // What is beside a small one is smaller.
            if gain * SMALLER < found.first().map_or(0.0, |first| first.gain.gain) {
                continue;
            }
            rest.extend([part.start..own.start, own.end..part.end]);
            let own = with_ends(&smooth, own);
            let gain = smooth[own.clone()].iter().map(square).sum();
            found.push(Found {
                run: *run,
                samples: values[own.start].0..values[own.end - 1].0 + 1,
                gain: Gain { gain, degrees: own.len() },
                deviations: median_size(&smooth[own.clone()]).unwrap_or(0.0) / deviation,
                is_form: is_form(values[own.clone()].iter().map(|one| one.2), &smooth[own]),
                members: values.len() * values.len() / 2,
            });
        }
    }
    found.sort_by(|a, b| b.gain.gain.total_cmp(&a.gain.gain));
    let least = found.first().map_or(0.0, |one| one.gain.gain / SMALLER);
    found.retain(|one| one.gain.gain >= least);
    let count = |one: &Found| runs.get(&one.run).map_or(0, Vec::len);
    let is_short = |one: &Found| {
        let readings = one.gain.degrees;
        readings >= SHORTEST && LONGEST * readings <= count(one)
    };
    if found.iter().all(|one| is_short(one) && one.is_form) { found } else { Vec::new() }
}

/// Whether residuals of a stretch follow each other, as noise that is larger for a while does not; single
/// outliers among them are no larger than what is smooth.
fn is_form(values: impl Iterator<Item = f64>, smooth: &[f64]) -> bool {
    let most = smooth.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let values: Vec<f64> = values.map(|value| value.clamp(-most, most)).collect();
    let squares: f64 = values.iter().map(|value| value * value).sum();
    values.windows(2).map(|two| two[0] * two[1]).sum::<f64>() > CORRELATED * squares
}

/// A range with the values of the same sign beside it: what rises and falls is near zero at its ends.
fn with_ends(values: &[f64], own: Range<usize>) -> Range<usize> {
    let most = own.len() / PART_OF_AN_END;
    let before = values[..own.start].iter().rev().take(most);
    let after = values[own.end..].iter().take(most);
    let is_like = |end: f64| move |value: &&f64| **value * end > 0.0;
    let before = before.take_while(is_like(values[own.start])).count();
    let after = after.take_while(is_like(values[own.end - 1])).count();
    own.start - before..own.end + after
}

/// The median of each value and its neighbours; the ends as they are.
fn medians(values: &[f64]) -> Vec<f64> {
    let mut smooth = values.to_vec();
    for (at, three) in values.windows(3).enumerate() {
        let [a, b, c] = [three[0], three[1], three[2]];
        smooth[at + 1] = a.max(b).min(a.min(b).max(c));
    }
    smooth
}

/// The range with the largest sum of squares beyond a limit for each value, where that is positive; without
/// more than a few values in a row within the limit.
fn largest(values: &[f64], limit: f64) -> Option<Range<usize>> {
    let (mut sum, mut first, mut near) = (0.0, 0, 0);
    let mut best: Option<(f64, Range<usize>)> = None;
    for (at, value) in values.iter().enumerate() {
        near = if value.abs() > limit { 0 } else { near + 1 };
        if sum <= 0.0 || near > GAP {
            (sum, first) = (0.0, at);
        }
        sum += value * value - limit * limit;
        if sum > best.as_ref().map_or(0.0, |(known, _)| *known) {
            best = Some((sum, first..at + 1));
        }
    }
    best.map(|(_, range)| range)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn a_stretch_is_found_beside_single_outliers() {
        let noise = |k: usize| [0.7, -1.0, 1.2, -0.4, 0.2][k % 5];
        let bump = |k: usize| {
            let phase = (k as f64 - 300.0) / 40.0;
            if (0.0..1.0).contains(&phase) {
                20.0 * (std::f64::consts::PI * phase).sin()
            } else {
                0.0
            }
        };
        let value = |k: usize| if k % 211 == 10 { 90.0 } else { noise(k) + bump(k) };
        let of = |value: &dyn Fn(usize) -> f64| {
            let run = (0..1000).map(|k| (k, k as f64, value(k))).collect();
            stretches(&BTreeMap::from([(0, run)]), 1.0)
        };
        let found = of(&value);
        assert_eq!(found.len(), 1);
        let Range { start, end } = found[0].samples;
        assert!((296..306).contains(&start) && (335..345).contains(&end), "{start} {end}");
        // What is far out for long, or often, is none; nor is noise, or noise that is larger for a while.
        assert!(of(&|k| noise(k) + if k < 300 { 20.0 } else { 0.0 }).is_empty());
        let drawn = |k: usize| ((k * 7919 % 1009) as f64 / 504.5 - 1.0) * 1.7;
        let louder = |k: usize| drawn(k) * if (400..450).contains(&k) { 8.0 } else { 1.0 };
        assert!(of(&drawn).is_empty() && of(&louder).is_empty());
        let often = of(&|k| noise(k) + if k % 100 < 8 { 20.0 } else { 0.0 });
        assert!(often.len() > MOST);
    }
}
