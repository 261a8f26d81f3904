//! Levels of the noise: stated uncertainties that follow how readings scatter.

use crate::diagnose::evidence::thresholds::level;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::Noise;
use crate::diagnose::sequences::{Sequence, sequences};
use crate::diagnose::stage::Stage;
use crate::engine::Part;
use crate::engine::stretches::Left;
use crate::statistics::{ln_below, ln_chi_squared, ln_normal};

use super::given::Given;

/// Standard uncertainties by which a level that is not as stated may differ from the scatter.
const FOLLOWS: f64 = 2.0;

/// Lets stated uncertainties follow the scatter, where they do not.
pub(super) fn levels(
    stage: &Stage,
    given: &Given,
    left: &[Left],
    unknowns: usize,
    noise: &Noise,
) -> Option<Fitted> {
    let mut fitted = stage.fitted.clone();
    let problem = &mut fitted.problem;
    let all = sequences(problem, left);
    let readings: usize = all.iter().map(|one| one.present().count()).sum();
    let freedom = readings.saturating_sub(unknowns).max(1) as f64 / readings.max(1) as f64;
    let tests = all.len() + stage.noise.len();
    let mut found: Vec<(usize, usize, f64)> = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        for measurand in 0..part.slots().len() {
            let own = || all.iter().filter(|one| one.part == p && one.measurand == measurand);
            let count: usize = own().map(|one| one.present().count()).sum();
            let squares: f64 = own().flat_map(Sequence::present).map(|value| value * value).sum();
            if count < 3 {
                continue;
            }
            let variance = squares / (count as f64 * freedom);
            // Readings without any scatter, as of a simulation, say nothing of their noise.
            if variance <= 0.0 {
                continue;
            }
            let effective = noise.alike() * freedom * count as f64;
            let degrees = (effective.floor() as usize).max(1);
            let squares = degrees as f64 * variance;
            let by_chance = if variance > 1.0 {
                ln_chi_squared(squares, degrees)
            } else {
                ln_below(squares, degrees)
            };
            // With the stated one structure looked stronger than it is, and took more of the
            // scatter away.
            let is_stated = part.sigma[measurand] == given.stated[p][measurand];
            let least =
                if is_stated { level(tests) - std::f64::consts::LN_2 } else { ln_normal(FOLLOWS) };
            if by_chance <= least {
                found.push((p, measurand, variance.sqrt()));
            }
        }
    }
    for (p, measurand, factor) in &found {
        let part: &mut Part = &mut problem.parts[*p];
        part.sigma[*measurand] *= factor;
    }
    (!found.is_empty()).then_some(fitted)
}
