//! Inputs that are no covariates: sensitivities of a simulator, logged for effects of the user's own. A
//! function of one of them is the effect itself, as far as it is linear, and describes no other cause.

use std::borrow::Cow;
use std::collections::BTreeSet;

use crate::effect::Effect;
use crate::formula::ast::{BinaryOperator, Expression, ExpressionKind};
use crate::library::Library;
use crate::model::Model;

/// A model without them: inputs that effects which hold for small values only have as a factor, and that
/// nothing else reads.
pub(super) fn without_sensitivities<'m>(model: &'m Model, library: &'m Library) -> Cow<'m, Model> {
    let formulas = |effect: &'m Effect| effect.patches.iter().map(|patch| &patch.formula.root);
    let mut factors: BTreeSet<&str> = BTreeSet::new();
    let mut read: BTreeSet<&str> = BTreeSet::new();
    for effect in library.own_effects() {
        for formula in formulas(effect) {
            let names = formula.names();
            let (is_factor, others): (Vec<&str>, Vec<&str>) = names
                .iter()
                .map(|(name, _)| *name)
                .partition(|name| is_linearised(effect) && is_factor_of_a_term(formula, name));
            factors.extend(is_factor);
            read.extend(others);
        }
    }
    let measured = model.measurands.iter().map(|one| &one.formula);
    let of_model = model.quantities.values().chain(measured);
    read.extend(of_model.flat_map(|one| one.root.names()).map(|(name, _)| name));
    let is_sensitivity = |name: &str| factors.contains(name) && !read.contains(name);
    if !model.inputs.iter().any(|input| is_sensitivity(&input.name)) {
        return Cow::Borrowed(model);
    }
    let mut without = Model::clone(model);
    without.inputs.retain(|input| !is_sensitivity(&input.name));
    Cow::Owned(without)
}

/// Whether an effect holds for small values only, as one does that is made of a derivative.
fn is_linearised(effect: &Effect) -> bool {
    effect.parameters.iter().any(|one| one.setting.linear_range.is_some())
}

/// Whether a name is in a sum as a factor of its terms: not in a bracket with other terms, nor in a function.
fn is_factor_of_a_term(sum: &Expression, name: &str) -> bool {
    use BinaryOperator::{Add, Subtract};
    match &sum.kind {
        ExpressionKind::Binary(Add | Subtract, left, right) => {
            [left, right].iter().all(|part| !has(part, name) || is_factor_of_a_term(part, name))
        }
        _ => is_factor(sum, name),
    }
}

/// Whether a name is a factor of a product.
fn is_factor(product: &Expression, name: &str) -> bool {
    use BinaryOperator::{Divide, Multiply};
    match &product.kind {
        ExpressionKind::Negate(part) => is_factor(part, name),
        ExpressionKind::Binary(Multiply, left, right) => {
            let is_in = |part, other| !has(other, name) && is_factor(part, name);
            is_in(left, right) || is_in(right, left)
        }
        ExpressionKind::Binary(Divide, left, right) => !has(right, name) && is_factor(left, name),
        ExpressionKind::Name(own) => own == name,
        _ => false,
    }
}

fn has(part: &Expression, name: &str) -> bool {
    part.names().iter().any(|(own, _)| *own == name)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use crate::diagnostic::Source;

    /// What a model reads is a covariate, and what another effect reads, or one with a range in another form
    /// than as a factor: its error may have any form.
    #[test]
    fn an_input_that_is_a_factor_of_a_linearised_effect_alone_is_no_covariate() {
        let inputs: String = ["simulated", "by_friction", "by_load", "temperature", "pressure"]
            .map(|name| format!("{name} = {{ unit = \"m\", signal = true }}\n"))
            .concat();
        let text = format!(
            "name = \"drive\"\ntitle = \"Drive\"\n[inputs]\n{inputs}[quantities]\n\
             predicted = 'simulated'\n[measurands]\nposition = {{ value = 'predicted', unit = \"m\" }}\n"
        );
        let model = Model::parse(Source::new("drive.toml", text)).unwrap();
        let mut library = Library::builtin().unwrap();
        for (name, read, range) in [
            ("friction", "(-by_friction) / 2 - change * by_load", ", linear_range = \"0.1 1\""),
            ("expansion", "(temperature - 2 m)", ", linear_range = \"0.1 1\""),
            ("bending", "by_load * pressure", ""),
        ] {
            let effect = format!(
                "name = \"{name}\"\ntitle = \"{name}\"\nacts = \"arm\"\n[parameters]\n\
                 change = {{ unit = \"1\", typical = \"1\"{range} }}\n[patch]\npredicted = 'predicted + change * {read}'\n"
            );
            library = library.with_effect(Source::new("effect.toml", effect)).unwrap();
        }
        let names = |model: &Model| -> Vec<String> {
            model.inputs.iter().map(|one| one.name.clone()).collect()
        };
        let without = without_sensitivities(&model, &library);
        assert_eq!(names(&without), ["simulated", "by_load", "temperature", "pressure"]);
        let builtin = Library::builtin().unwrap();
        assert_eq!(names(&without_sensitivities(&model, &builtin)), names(&model));
    }
}
