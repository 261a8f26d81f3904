//! What could still hide: for each effect that was not found, how far off it could make a delay
//! without being noticed.
//!
//! At the size that is declared every other time ([`bar`]) its signature has a length of 5 or, with
//! many unknowns or members of a family, more; the nominal parameters then move by `H_nn⁻¹ H_ne`
//! times its values. A variance factor near one says little: some effects raise it hardly and move
//! delays by many standard uncertainties.

use crate::diagnose::evidence::detection::bar;
use crate::diagnose::evidence::thresholds::level;
use crate::diagnose::stage::Stage;

/// The largest shift that an effect could cause unnoticed.
#[derive(Clone, Debug)]
pub struct Hidden {
    /// The effect.
    pub name: String,
    /// The delay.
    pub delay: String,
    /// How far off it could be (s).
    pub bias: f64,
    /// The largest of its values then, over its usual size; `None` where it has none.
    pub times_usual: Option<f64>,
}

/// For each testable effect of a stage, the delay that it could shift most, largest first.
pub fn hidden(stage: &Stage) -> Vec<Hidden> {
    let layout = &stage.fitted.problem.layout;
    let delays: Vec<(usize, &str)> = layout
        .instances
        .iter()
        .enumerate()
        .filter(|(_, instance)| instance.name.ends_with(".delay"))
        .flat_map(|(index, instance)| {
            layout.own_columns(index).map(|(_, column)| (column, instance.name.as_str()))
        })
        .collect();
    let mut all: Vec<Hidden> = (0..stage.effects)
        .filter(|n| stage.entry(*n).degrees() > 0)
        .filter_map(|n| {
            let entry = stage.entry(n);
            let moves = &entry.coupling * &entry.basis;
            let degrees = entry.degrees();
            let bar = bar(degrees, stage.members[n], level(stage.effects), stage.support());
            let length = (bar - degrees as f64).max(0.0).sqrt();
            let bias = |column: usize| length * moves.row(column).norm();
            let (column, name) =
                delays.iter().copied().max_by(|a, b| bias(a.0).total_cmp(&bias(b.0)))?;
            // Of all values of that length those that move the delay most.
            let worst = moves.row(column).transpose();
            let values = &entry.basis * &worst * (length / worst.norm());
            let typical = |parameter: &str| stage.candidates[n].typical(parameter);
            let times = entry.owners.iter().zip(values.iter());
            let times =
                times.filter_map(|(own, value)| Some(value.abs() / typical(&own.parameter)?));
            let (delay, name) = (name.to_owned(), stage.candidates[n].name.clone());
            let times_usual = times.filter(|times| times.is_finite()).reduce(f64::max);
            Some(Hidden { name, delay, bias: bias(column), times_usual })
        })
        .collect();
    all.sort_by(|a, b| b.bias.total_cmp(&a.bias));
    all
}
