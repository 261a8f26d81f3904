//! Whether an effect has a slope where it is switched off: a fit that begins there finds no way to go
//! where the readings are the same with either sign of a parameter, as of `constant^2`.

use super::{Outputs, differ, off, outputs};
use crate::diagnostic::Diagnostics;
use crate::graph::{Graph, Kind};
use crate::model::{Model, Override};
use crate::system::{Selected, System};

/// The size (SI) at which both signs are compared.
const SIZE: f64 = 0.1;

/// The first free parameter of an effect alone with a model that changes readings alike with either sign.
///
/// # Errors
/// As [`System::build`].
pub fn without_slope(
    model: &Model,
    selected: &Selected,
    overrides: &[Override],
) -> Result<Option<String>, Diagnostics> {
    let input_sigma = vec![None; model.inputs.len()];
    let without = System::build(model, &[], overrides, &input_sigma)?;
    let with = System::build(model, std::slice::from_ref(selected), overrides, &input_sigma)?;
    let known = &without.assembly.names.parameters;
    let is_own = |name: &str| known.iter().all(|one| one.name != name);
    for (own, parameter) in with.assembly.names.parameters.iter().enumerate() {
        let is_free = !with.settings[own].fixed && parameter.kind != Kind::Rotation;
        if !is_own(&parameter.name) || !is_free {
            continue;
        }
        for component in 0..parameter.kind.dimension() as u8 {
            let mut graph = Graph::boundless();
            let [less, zero, more] = [-SIZE, 0.0, SIZE].map(|size| {
                let value = |at: usize, of: u8| {
                    let is_it = at == own && of == component;
                    off(&with, at, of) + if is_it { size } else { 0.0 }
                };
                outputs(&with, &without, &mut graph, &value)
            });
            let differ = |one: &[Outputs], other: &[Outputs]| {
                let mut pairs = one.iter().zip(other);
                pairs.any(|(one, other)| differ(&graph, known, &one.reading, &other.reading))
            };
            if differ(&zero, &more) && !differ(&less, &more) {
                return Ok(Some(parameter.name.clone()));
            }
        }
    }
    Ok(None)
}
