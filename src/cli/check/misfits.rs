//! Why an effect fits no model.

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::effect::Effect;

/// What is wrong with an effect that fits no model: what those say that lack the fewest names.
/// `all` are these numbers with the models and what they say, `are_own` whether the models are beside it.
pub(super) fn misfits(
    effect: &Effect,
    all: Vec<(usize, &str, Diagnostics)>,
    are_own: bool,
) -> Diagnostics {
    let fewest = all.iter().map(|(missing, ..)| *missing).min().unwrap_or(0);
    let leaves_out = all.iter().any(|(missing, ..)| *missing > fewest);
    // Heads and models that miss the same thing say it with their own names: the shortest is reported.
    let mut said: Vec<(Diagnostic, Vec<&str>)> = Vec::new();
    for (_, model, faults) in all.into_iter().filter(|(missing, ..)| *missing == fewest) {
        for fault in faults.0 {
            let alike = |known: &Diagnostic| match (&known.place, &fault.place) {
                (Some(known), Some(fault)) => known == fault,
                _ => known.message == fault.message,
            };
            match said.iter_mut().find(|(known, _)| alike(known)) {
                Some((known, models)) => {
                    if fault.message.len() < known.message.len() {
                        *known = fault;
                    }
                    models.push(model);
                    models.dedup();
                }
                None => said.push((fault, vec![model])),
            }
        }
    }
    let name = &effect.name;
    let which = if are_own { "none of the models beside it" } else { "no model of the library" };
    let faults = said.into_iter().map(|(fault, models)| {
        let message = format!("the effect `{name}` fits {which}: {}", fault.message);
        Diagnostic { message, ..fault }.help(format!("this is so with {}", models.join(", ")))
    });
    let mut faults: Vec<Diagnostic> = faults.collect();
    if let Some(last) = faults.last_mut() {
        if leaves_out {
            last.help.push("other models lack more of the names in it".to_owned());
        }
        if !are_own {
            last.help.push(
                "an effect for a model of your own is checked beside it: homepoint check MODEL.toml EFFECT.toml"
                    .to_owned(),
            );
        }
    }
    Diagnostics(faults)
}
