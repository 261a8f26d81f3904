//! Where stamps jump, of effects that act there. How jumps are found is for the campaign to say.

use crate::engine::Problem;
use crate::system::Selected;

/// The clock of formulas that steps where stamps jump.
const JUMP_TIME: &str = "jump_time";

/// A jump of the stamps of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct StampJump {
    /// The run.
    pub run: String,
    /// The first row of its data file after the jump.
    pub row: usize,
    /// By how much longer than the others the interval before it is (s).
    pub size: f64,
}

/// The jumps at which an effect that is in the fit acts.
pub fn stamp_jumps(problem: &Problem, selected: Option<&Selected>) -> Vec<StampJump> {
    let patches = selected.into_iter().flat_map(|one| &one.effect.patches);
    if !patches.flat_map(|patch| patch.formula.root.names()).any(|(name, _)| name == JUMP_TIME) {
        return Vec::new();
    }
    let mut jumps = Vec::new();
    let runs = problem.parts.iter().flat_map(|part| &part.runs);
    for (run, name) in runs.zip(problem.run_names()) {
        let mut last: Option<f64> = None;
        run.record.walk(|stretch| {
            for sample in stretch.each() {
                let Some(jumped) = sample.samples.jump_time.get(sample.at).copied() else { return };
                let size = last.replace(jumped).map_or(0.0, |last| jumped - last);
                if size != 0.0 {
                    jumps.push(StampJump { run: name.clone(), row: sample.row(), size });
                }
            }
        });
    }
    jumps
}
