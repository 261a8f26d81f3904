//! Where stamps jump, of effects that act there, and which stamps are right. How jumps are found is for
//! the campaign to say.

use crate::engine::Problem;
use crate::system::Selected;

/// The family of an effect whose member says from which stamps jumps count: those before the first
/// jump where it is negative, after the last where it is positive, else of the longest stretch.
const RIGHT: &str = "right";
/// Levels of stamps are the same below this part of a jump.
const SAME: f64 = 1e-6;

/// A jump of the stamps of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct StampJump {
    /// The run.
    pub run: String,
    /// The first row of its data file after the jump.
    pub row: usize,
    /// By how much longer than the others the interval before it is (s).
    pub size: f64,
    /// Which stamps beside it are right if the clock was set there; `None` where neither are, or where
    /// no other run has the delay of this one, which follows either.
    pub right: Option<Side>,
}

/// A side of a jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Before it.
    Before,
    /// After it.
    After,
}

impl Side {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Before => "before",
            Self::After => "after",
        }
    }
}

/// The jumps at which an effect that is in the fit acts.
pub fn stamp_jumps(problem: &Problem, selected: Option<&Selected>) -> Vec<StampJump> {
    let Some(selected) = selected.filter(|one| one.effect.acts_at_jumps()) else {
        return Vec::new();
    };
    let member = selected.member.get(RIGHT).copied();
    let mut jumps = Vec::new();
    let parts = problem.parts.iter().enumerate();
    let runs =
        parts.flat_map(|(part, own)| own.runs.iter().enumerate().map(move |run| (part, run)));
    for ((part, (number, run)), name) in runs.zip(problem.run_names()) {
        let is_known = knows_delay(problem, part, number);
        let mut last: Option<f64> = None;
        run.record.walk(|stretch| {
            let [first, end] = stretch.samples.jump_ends;
            let right = member.filter(|_| is_known).map(|member| match member {
                ..0.0 => first,
                0.0 => 0.0,
                _ => end,
            });
            for sample in stretch.each() {
                let Some(after) = sample.samples.jump_time.get(sample.at).copied() else { return };
                let before = last.replace(after).unwrap_or(after);
                let size = after - before;
                if size != 0.0 {
                    let is_right = |level: f64| {
                        right.is_some_and(|right| (level - right).abs() < SAME * size.abs())
                    };
                    let before = is_right(before).then_some(Side::Before);
                    let right = before.or_else(|| is_right(after).then_some(Side::After));
                    jumps.push(StampJump { run: name.clone(), row: sample.row(), size, right });
                }
            }
        });
    }
    jumps
}

/// Whether a delay of a run is held, or that of another run, too.
fn knows_delay(problem: &Problem, part: usize, run: usize) -> bool {
    let layout = &problem.layout;
    let declared = problem.parts[part].system.declared.iter().zip(&layout.used[part][run]);
    let mut delays = declared.filter(|(one, _)| !one.delay_of.is_empty()).map(|(_, index)| *index);
    delays.any(|index| {
        let others = layout.used.iter().flatten().filter(|used| used.contains(&index)).count();
        others > 1 || layout.columns_of(index, 0).is_empty()
    })
}
