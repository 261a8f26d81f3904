//! Absorbed effects that do by their squares what an effect of the library does.
//!
//! What nominal parameters take up to first order may be left beyond it: a low-pass filter
//! `T m' + m = in` delays readings by `T`, which is a delay, and leaves `T² / 2` times their
//! acceleration, which servos do that run ahead. Such an effect has no slope where it is switched
//! off, so no test finds it: the model with it is fitted from its usual size. Effects of more than
//! one value are not looked at.

use crate::diagnose::evidence::thresholds::ALIKE;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::stage::Stage;
use crate::engine::layout::Instance;
use crate::estimate::batch::{FitError, Options};

use super::probability::is_implausible;

/// Rounds of a fit at most: one that nominal parameters take up altogether has nowhere to go.
const MOST_ROUNDS: usize = 15;

/// Effects that a model without an effect takes up at first order, but that explain as much as that
/// effect, which takes `gain` off the sum of squares, at a value (SI) that may be.
///
/// # Errors
/// [`FitError`] where the model cannot be fitted at all.
pub fn alike_by_square(
    stage: &Stage,
    without: &Fitted,
    gain: f64,
    options: &Options,
) -> Result<Vec<(String, f64)>, FitError> {
    let options = Options { max_iterations: MOST_ROUNDS, ..*options };
    let mut alike = Vec::new();
    for number in absorbed(stage) {
        let candidate = &stage.candidates[number];
        let [owner] = &stage.entry(number).owners[..] else { continue };
        let Some(usual) = candidate.typical(&owner.parameter) else { continue };
        let start = [(owner.parameter.clone(), owner.component, owner.of.clone(), usual)];
        let Some(with) = without.with(&candidate.selected, &start, &options)? else { continue };
        let layout = &with.problem.layout;
        let is_own =
            |one: &Instance| one.name == owner.parameter && one.whose() == owner.of.as_deref();
        let own = layout.instances.iter().position(is_own);
        let Some(value) =
            own.map(|index| with.fit.point.components(layout, index)[owner.component])
        else {
            continue;
        };
        let explains = without.cost() - with.cost();
        if explains >= (gain - ALIKE).max(0.5 * gain) && !is_implausible((value / usual).abs()) {
            alike.push((candidate.name.clone(), value));
        }
    }
    Ok(alike)
}

/// The effects of the library that nominal parameters take up.
fn absorbed(stage: &Stage) -> impl Iterator<Item = usize> {
    (0..stage.effects).filter(|number| {
        let entry = stage.entry(*number);
        entry.degrees() == 0 && entry.finite && entry.acts()
    })
}
