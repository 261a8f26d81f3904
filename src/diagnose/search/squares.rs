//! Effects that do by their squares what an effect of the library does.
//!
//! What nominal parameters take up to first order may be left beyond it: a low-pass filter delays readings by `T`, which
//! is a delay, and adds `T² / 2` times their acceleration, which is a lag of the servos. Where it is switched off an effect of that
//! kind has no signature of its own; at its usual size `u` it has one, the derivative of its square, with half of `u`
//! the square itself. Effects with more than one value are not looked at.

use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::score::of_gain;
use crate::diagnose::evidence::thresholds::{ALIKE, level};
use crate::diagnose::library::candidates::Candidate;
use crate::diagnose::library::catalogue::sign_at;
use crate::diagnose::stage::Stage;
use crate::engine::signatures::At;

use super::probability::is_implausible;

/// Effects taken up at a stage that cannot be told from one of its candidates beyond what takes them up, of a size that may be.
pub(in crate::diagnose) fn alike_by_square(stage: &Stage, name: &str) -> Vec<String> {
    let Some(number) = stage.effect_named(name) else { return Vec::new() };
    let is_taken_up = |n: &usize| {
        let entry = stage.entry(*n);
        entry.degrees() == 0 && entry.finite && entry.acts() && entry.owners.len() == 1
    };
    let taken_up: Vec<&Candidate> =
        (0..stage.effects).filter(is_taken_up).map(|n| &stage.candidates[n]).collect();
    if taken_up.is_empty() {
        return Vec::new();
    }
    let usual = taken_up.iter().map(|one| (*one, At::Typical));
    let all: Vec<(&Candidate, At)> =
        [(&stage.candidates[number], At::Zero)].into_iter().chain(usual).collect();
    let (problem, fit) = (&stage.fitted.problem, &stage.fitted.fit);
    let signed = sign_at(problem, &all);
    let Some(evidence) = Evidence::with(problem, &fit.normal, &fit.point, all.len(), signed) else {
        return Vec::new();
    };
    let [own, squares @ ..] = &evidence.entries[..] else { return Vec::new() };
    let adds = |gain: (f64, usize)| of_gain(gain.0, gain.1, 1).ln_p <= level(stage.effects);
    let found = taken_up.iter().zip(squares).filter(|(candidate, square)| {
        let usual = square.owners.first().and_then(|one| candidate.typical(&one.parameter));
        let (Some(usual), 1) = (usual, square.degrees()) else { return false };
        let times = 2.0 * square.values()[0] / usual;
        times > 0.0
            && !is_implausible(times.sqrt())
            && square.gain() >= (own.gain() - ALIKE).max(0.5 * own.gain())
            && !adds(evidence.beyond(own, square))
            && !adds(evidence.beyond(square, own))
    });
    found.map(|(candidate, _)| candidate.name.clone()).collect()
}
