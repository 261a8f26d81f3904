//! Inputs that are no covariates: sensitivities of a simulator, logged for effects of the user's own. A
//! function of one of them is the effect itself, as far as it is linear, and describes no other cause.

use std::borrow::Cow;
use std::collections::BTreeSet;

use crate::effect::Effect;
use crate::library::Library;
use crate::model::Model;

/// A model without them: inputs that it does not read, but effects that hold for small values only.
pub(super) fn without_sensitivities<'m>(model: &'m Model, library: &Library) -> Cow<'m, Model> {
    let of_own = library.own_effects().filter(|effect| is_linearised(effect));
    let patched = of_own.flat_map(|effect| effect.patches.iter().map(|patch| &patch.formula));
    let mut read: BTreeSet<&str> =
        patched.flat_map(|formula| formula.root.names()).map(|(name, _)| name).collect();
    let measured = model.measurands.iter().map(|one| &one.formula);
    for (name, _) in model.quantities.values().chain(measured).flat_map(|one| one.root.names()) {
        read.remove(name);
    }
    let is_sensitivity = |name: &str| read.contains(name);
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

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use crate::diagnostic::Source;

    /// What a model reads is a covariate, and what an effect reads that has no range: it may have another
    /// form than the effect has.
    #[test]
    fn an_input_of_a_linearised_effect_alone_is_no_covariate() {
        let inputs: String = ["commanded", "simulated", "by_friction", "temperature"]
            .map(|name| format!("{name} = {{ unit = \"m\", signal = true }}\n"))
            .concat();
        let text = format!(
            "name = \"drive\"\ntitle = \"Drive\"\n[inputs]\n{inputs}[quantities]\n\
             predicted = 'simulated'\n[measurands]\nposition = {{ value = 'predicted', unit = \"m\" }}\n"
        );
        let model = Model::parse(Source::new("drive.toml", text)).unwrap();
        let mut library = Library::builtin().unwrap();
        for (name, read, range) in [
            ("friction", "by_friction * simulated / commanded", ", linear_range = \"0.1 1\""),
            ("growth", "temperature", ""),
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
        assert_eq!(names(&without), ["simulated", "temperature"]);
        let builtin = Library::builtin().unwrap();
        assert_eq!(names(&without_sensitivities(&model, &builtin)), names(&model));
    }
}
