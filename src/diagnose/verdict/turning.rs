//! Oscillations that are waves of what turns as well: at a steady rate a wave of an arm's turn has
//! a frequency, too, and where samples are even and far apart, one of many frequencies falls
//! together with that of each rate.
//!
//! What grows with the rate is so told as an oscillation, by the fast runs that hold most of it. It
//! says less of where the gap lies than any other place.

use std::f64::consts::TAU;

use crate::campaign::{Run, Track};
use crate::diagnose::evidence::sampling::Sampling;
use crate::diagnose::library::structure::turns;
use crate::diagnose::stage::Stage;
use crate::engine::Part;

/// Waves a turn that are looked at.
const ORDERS: u32 = 5;
/// The part of what it explains that lies in runs where it is one of them.
const MOST: f64 = 0.5;

/// Whether an oscillation explains most in runs in which it is a wave of what turns.
pub(super) fn goes_round(stage: &Stage, block: usize) -> bool {
    let Some(frequency) = stage.candidates[block].selected.member.values().next() else {
        return false;
    };
    let (problem, own) = (&stage.fitted.problem, stage.entry(block));
    let sampling = Sampling::of(problem);
    let runs = problem.parts.iter().flat_map(|part| part.runs.iter().map(move |run| (part, run)));
    let (mut all, mut round) = (0.0, 0.0);
    for (number, (part, run)) in runs.enumerate() {
        let entry = stage.evidence.tied_over(own, |one| one == number);
        let gain = (entry.gain() - entry.degrees() as f64).max(0.0);
        let is_wave = |rate: &f64| {
            (1..=ORDERS).any(|order| sampling.is_one(number, *frequency, f64::from(order) * rate))
        };
        all += gain;
        round += if rates(part, run).iter().any(is_wave) { gain } else { 0.0 };
    }
    round > MOST * all
}

/// The mean rates (turns per second) of what turns in a run; none of what stands still.
fn rates(part: &Part, run: &Run) -> Vec<f64> {
    let inputs = part.system.assembly.names.inputs.iter().enumerate();
    let turning = inputs.filter(|(_, input)| input.signal && turns(&input.unit));
    let rate = |(input, _)| {
        let (mut sum, mut count) = (0.0, 0.0);
        run.record.walk(|stretch| {
            for sample in stretch.each() {
                let track: &Track = &sample.samples.inputs[input];
                sum += track.at(sample.at, sample.time(), 0.0, 1);
                count += 1.0;
            }
        });
        (sum / count / TAU).abs()
    };
    turning.map(rate).filter(|rate| *rate > 0.0).collect()
}
