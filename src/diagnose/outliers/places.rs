//! Whether stretches of wrong readings come back at the same place: of an input, of its rate, or at
//! the same time of a run.
//!
//! Samples are put in the order of a covariate instead of time. Where wrong ones stand together
//! there, and in fewer stretches than in time, the covariate decides when readings are wrong: a bad
//! sector of an encoder, a sense of motion, the start of each run. That is structure.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use crate::campaign::record::Record;
use crate::engine::Problem;

use super::left_out::OfSamples;

/// Samples that are looked at together, at least, and most such groups.
const TOGETHER: usize = 4;
const GROUPS: usize = 200;
/// Part of the variance of *wrong or right* that the groups explain where wrong ones stand together.
const EXPLAINED: f64 = 0.7;
/// Stretches in time are so many times as many as those over the covariate.
const FEWER: usize = 2;

/// Whether the stretches of a campaign's measurand do, in the runs that have some.
pub(super) fn comes_back(problem: &Problem, of: (usize, usize), found: &[OfSamples]) -> bool {
    let own: Vec<&OfSamples> = found.iter().filter(|one| one.0.of() == of).collect();
    let runs: BTreeSet<usize> = own.iter().map(|(of, _)| of.run).collect();
    let (mut wrong, mut covariates) = (Vec::new(), Vec::new());
    for run in &runs {
        let record = &problem.parts[of.0].runs[*run].record;
        let first = wrong.len();
        wrong.resize(first + record.len(), false);
        for (_, samples) in own.iter().filter(|(of, _)| of.run == *run) {
            wrong[first..][samples.clone()].fill(true);
        }
        add_covariates(record, &mut covariates);
    }
    // From a place that was passed once nothing follows.
    own.len() > 1 && covariates.iter().any(|one| stands_together(one, &wrong, 2 * own.len()))
}

/// Adds the time of a run, and each input with its rate; angles beyond a turn as they come back, too.
fn add_covariates(record: &Record, all: &mut Vec<Vec<f64>>) {
    all.resize(1 + 3 * record.inputs().len(), Vec::new());
    record.walk(|stretch| {
        for sample in stretch.each() {
            let samples = sample.samples;
            all[0].push(samples.run_time[sample.at]);
            for (input, columns) in samples.inputs.iter().zip(all[1..].chunks_mut(3)) {
                let at = |order| input.at(sample.at, sample.time(), 0.0, order);
                let value: f64 = at(0);
                columns[0].push(value);
                columns[1].push(at(1));
                columns[2].push(value.rem_euclid(TAU));
            }
        }
    });
}

/// Whether wrong samples stand together over a covariate, in fewer stretches than they have in time;
/// `changes` are those between right and wrong in time.
fn stands_together(covariate: &[f64], wrong: &[bool], changes: usize) -> bool {
    let mut order: Vec<usize> =
        (0..covariate.len()).filter(|at| covariate[*at].is_finite()).collect();
    order.sort_by(|a, b| covariate[*a].total_cmp(&covariate[*b]));
    let ends = order.first().zip(order.last());
    if ends.is_none_or(|(first, last)| covariate[*first] == covariate[*last]) {
        return false;
    }
    let share =
        |group: &[usize]| group.iter().filter(|at| wrong[**at]).count() as f64 / group.len() as f64;
    let mean = share(&order);
    let groups = order.chunks(TOGETHER.max(order.len() / GROUPS));
    let explained: f64 =
        groups.clone().map(|group| group.len() as f64 * (share(group) - mean).powi(2)).sum();
    let of_groups: Vec<bool> = groups.map(|group| share(group) > 0.5).collect();
    let over = of_groups.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let all = order.len() as f64 * mean * (1.0 - mean);
    explained >= EXPLAINED * all && FEWER * over <= changes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sector_of_a_turn_comes_back() {
        let angle: Vec<f64> = (0..1000).map(|k| (0.02 * f64::from(k)).rem_euclid(TAU)).collect();
        let sector: Vec<bool> = angle.iter().map(|angle| (2.0..2.5).contains(angle)).collect();
        assert!(stands_together(&angle, &sector, 6));
        // Stretches anywhere; a covariate that passes each of its values once.
        let anywhere = |k: usize| [100..130, 390..420, 777..800].iter().any(|one| one.contains(&k));
        let anywhere: Vec<bool> = (0..1000).map(anywhere).collect();
        assert!(!stands_together(&angle, &anywhere, 6));
        let time: Vec<f64> = (0..1000).map(f64::from).collect();
        assert!(!stands_together(&time, &sector, 6) && !stands_together(&time, &anywhere, 6));
    }
}
