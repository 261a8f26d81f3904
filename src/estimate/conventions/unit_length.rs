//! Inputs that together have the length one: the components of a quaternion that a model multiplies out,
//! of a direction, or a sine beside its cosine. No unit stands in the place of theirs; smaller numbers
//! would fit any reading that is small, for then nothing is predicted.

use std::collections::BTreeSet;

use crate::engine::Problem;
use crate::units::Unit;

/// Part of the samples in which the square of the length is one within a part of it: a tracker that has
/// lost its target logs zeros.
const MOST: f64 = 0.9;
const WITHIN: f64 = 0.02;

/// The indices of such inputs, which follow each other among those of the unit 1.
pub(super) fn of_unit_length(problem: &Problem) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let Some(first) = problem.parts.first() else { return found };
    let inputs = first.system.assembly.names.inputs.iter().enumerate();
    let plain = inputs.filter(|(_, input)| input.unit.symbol == Unit::one().symbol);
    let plain: Vec<usize> = plain.map(|(index, _)| index).collect();
    let groups = (2..=4).flat_map(|count| plain.windows(count));
    found.extend(groups.filter(|group| are_of_unit_length(problem, group)).flatten());
    found
}

fn are_of_unit_length(problem: &Problem, inputs: &[usize]) -> bool {
    let (mut all, mut own) = (0, 0);
    for run in problem.parts.iter().flat_map(|part| &part.runs) {
        let samples = run.record.whole();
        for (at, time) in samples.time.iter().enumerate() {
            let value = |input: &usize| -> f64 { samples.inputs[*input].at(at, *time, 0.0, 0) };
            let square: f64 = inputs.iter().map(|input| value(input).powi(2)).sum();
            all += usize::from(!square.is_nan());
            own += usize::from((square - 1.0).abs() < WITHIN);
        }
    }
    all > 0 && own as f64 >= MOST * all as f64
}
