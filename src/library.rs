//! The models and effects that are there: those of the project and those of the user's folders.
//!
//! Answers: which model or effect a name means. A model is named by its name here, by the name of a
//! file in `models/` beside the campaign, or by a path. Effects of a folder join the project's; one
//! name means one effect, so a second file with a name that is taken is an error unless it is the
//! same text: results name effects, and must mean the same thing everywhere.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::diagnostic::{Diagnostic, Diagnostics, Source, nearest};
use crate::document::files::Files;
use crate::document::{MAXIMUM_LENGTH, withhold};
use crate::effect::Effect;
use crate::graph::Kind;
use crate::model::parameter::component_count;
use crate::model::{Model, Override};
use crate::system::{Selected, known_names};

mod conventions;
mod template;
mod unknown;

pub use conventions::conventions;
pub use template::template;
pub(crate) use unknown::unknown_parameter;

/// The files of `models/` and `models/effects/`, as text.
pub mod embedded {
    include!(concat!(env!("OUT_DIR"), "/embedded.rs"));
}

/// Names that an unknown one may have stood for, at most.
const MOST_NEAR: usize = 4;
/// Most files a folder of effects may hold.
const MAXIMUM_FILES: usize = 1000;

/// Every effect by name, and the models of the project.
#[derive(Clone, Debug, Default)]
pub struct Library {
    effects: BTreeMap<String, Arc<Effect>>,
    /// Files outside the folder that they are read for are refused.
    confined: bool,
}

impl Library {
    /// What the project brings along.
    ///
    /// # Errors
    /// A fault in one of its files.
    pub fn builtin() -> Result<Self, Diagnostics> {
        let mut library = Self::default();
        let mut faults = Vec::new();
        for (stem, text) in embedded::EFFECTS {
            let source = Source::new(format!("models/effects/{stem}.toml"), *text);
            if let Err(fault) = library.add(source) {
                faults.extend(fault.0);
            }
        }
        Diagnostics(faults).into_result(library)
    }

    /// The same; if `confined`, files outside the folder for which models and effects are read are
    /// refused from then on.
    #[must_use]
    pub fn confined(self, confined: bool) -> Self {
        Self { confined, ..self }
    }

    /// The same with every effect of a folder (`*.toml`).
    ///
    /// # Errors
    /// A folder that cannot be read, every fault of its files, a name that is taken.
    pub fn with_effects_dir(self, folder: &Path) -> Result<Self, Diagnostics> {
        self.with_effects(folder, Files::of(folder))
    }

    fn with_effects(mut self, folder: &Path, mut belonging: Files) -> Result<Self, Diagnostics> {
        belonging.confine(self.confined);
        let mut faults = Vec::new();
        for file in effect_files(folder)? {
            let source = Source::read_of(&mut belonging, &file, MAXIMUM_LENGTH);
            let added = source.and_then(|source| {
                let added = self.add(source.clone());
                added.map_err(|faults| withhold(&source, faults, &check_alone(&file)))
            });
            if let Err(fault) = added {
                faults.extend(fault.0);
            }
        }
        Diagnostics(faults).into_result(self)
    }

    /// The same with the effects in `effects/` of the campaign's folder, if there is such a folder.
    ///
    /// # Errors
    /// As [`Self::with_effects_dir`].
    pub fn with_effects_beside(self, base: &Path) -> Result<Self, Diagnostics> {
        let folder = base.join("effects");
        if folder.is_dir() { self.with_effects(&folder, Files::of(base)) } else { Ok(self) }
    }

    /// The same with one more effect.
    ///
    /// # Errors
    /// Every fault of its text, a name that is taken.
    pub fn with_effect(mut self, source: Source) -> Result<Self, Diagnostics> {
        self.add(source)?;
        Ok(self)
    }

    fn add(&mut self, source: Source) -> Result<(), Diagnostics> {
        let effect = Effect::parse(source)?;
        if let Some(other) = self.effects.get(&effect.name) {
            if other.source.text == effect.source.text {
                return Ok(());
            }
            let message = format!(
                "`{}`: the effect `{}` is already in `{}`",
                effect.source.file, effect.name, other.source.file
            );
            return Err(Diagnostic::error(message).help("choose another name for it").into());
        }
        self.effects.insert(effect.name.clone(), Arc::new(effect));
        Ok(())
    }

    /// All effects, in the order of their names.
    pub fn effects(&self) -> impl Iterator<Item = &Arc<Effect>> {
        self.effects.values()
    }

    /// The effects of the user's folders.
    pub fn own_effects(&self) -> impl Iterator<Item = &Arc<Effect>> {
        let brought = |one: &Arc<Effect>| {
            embedded::EFFECTS.iter().any(|(_, text)| *text == &*one.source.text)
        };
        self.effects().filter(move |one| !brought(one))
    }

    /// The effect of this name.
    ///
    /// # Errors
    /// No such effect, with the nearest name.
    pub fn effect(&self, name: &str) -> Result<Arc<Effect>, Diagnostics> {
        self.effects.get(name).cloned().ok_or_else(|| {
            let error = Diagnostic::error(format!("there is no effect `{name}`"));
            let known = self.effects.keys().map(String::as_str);
            // An effect of one's own is more probable than the name of another one that is like it.
            let has_word = |own: &&str| own.split('_').any(|word| word == name);
            let own = self.own_effects().map(|own| own.name.as_str()).find(has_word);
            let near: Vec<&str> = match own.or_else(|| nearest(name, known.clone())) {
                Some(near) => vec![near],
                None => known.filter(has_word).take(MOST_NEAR).collect(),
            };
            match near.is_empty() {
                false => error.help(format!("did you mean `{}`?", near.join("` or `"))),
                true => error.help("`homepoint effects` lists them"),
            }
            .into()
        })
    }

    /// The effect `NAME`, or at one head `NAME.HEAD`, with no member chosen.
    ///
    /// # Errors
    /// No such effect.
    pub fn select(&self, text: &str) -> Result<Selected, Diagnostics> {
        let (name, head) = match text.split_once('.') {
            Some((name, head)) => (name, Some(head.to_owned())),
            None => (text, None),
        };
        Ok(Selected { effect: self.effect(name)?, head, member: BTreeMap::new() })
    }

    /// The models of the project: name and text, sorted.
    pub fn models(&self) -> &'static [(&'static str, &'static str)] {
        embedded::MODELS
    }

    /// A model by its name or by a path relative to `base` (the campaign's folder).
    ///
    /// # Errors
    /// No such model, or every fault of its file.
    pub fn model(&self, name: &str, base: &Path) -> Result<Model, Diagnostics> {
        if let Some(file) = model_file(name, base) {
            let mut files = Files::of(base);
            files.confine(self.confined);
            let source = Source::read_of(&mut files, &file, MAXIMUM_LENGTH)?;
            let model = Model::parse(source.clone());
            return model.map_err(|faults| withhold(&source, faults, &check_alone(&file)));
        }
        if let Some((_, text)) = embedded::MODELS.iter().find(|(known, _)| *known == name) {
            return Model::parse(Source::new(format!("models/{name}.toml"), *text));
        }
        let names = embedded::MODELS.iter().map(|(name, _)| *name);
        let error = Diagnostic::error(format!("there is no model `{name}`"));
        let error = match nearest(name, names.clone()) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help(format!("known: {}", names.collect::<Vec<_>>().join(", "))),
        };
        Err(error
            .help("a file of your own is named with its ending, as in model = \"my_model.toml\"")
            .into())
    }

    /// Whether every override names something of the model or of an effect of this library, also of
    /// effects that are not applied: a campaign may state their constants. Those of effects are
    /// looked at, too: one that does not fit would else make the effect untestable, without a word.
    ///
    /// # Errors
    /// Every name that nothing has; quantities of effects of another dimension or number.
    pub fn check_overrides(
        &self,
        model: &Model,
        overrides: &[Override],
    ) -> Result<(), Diagnostics> {
        let known = known_names(model, self.effects());
        let set: HashSet<&str> = known.iter().map(String::as_str).collect();
        let unknown = overrides.iter().filter(|said| !set.contains(said.name.as_str())).take(50);
        let mut faults: Vec<Diagnostic> =
            unknown.map(|said| unknown_parameter(said, &known)).collect();
        faults.extend(overrides.iter().filter_map(|said| self.misstated(said)));
        Diagnostics(faults).into_result(())
    }

    /// What is wrong with what is said of an effect's parameter or family; `None` of others.
    fn misstated(&self, said: &Override) -> Option<Diagnostic> {
        let (owner, rest) = said.name.split_once('.')?;
        let effect = self.effects().find(|effect| effect.name == owner)?;
        let mut names = rest.split('.');
        let family = names.clone().next_back().and_then(|last| effect.shape.get(last));
        let own = |name: &str| effect.parameters.iter().find(|one| one.name == name);
        let (count, unit) = match family {
            Some(family) => (1, &family.unit),
            None => {
                let one = names.find_map(own)?;
                let is_component = one.kind == Kind::Vector
                    && said.component().is_some_and(|(vector, _)| vector.ends_with(&one.name));
                (if is_component { 1 } else { component_count(one.kind) }, &one.unit)
            }
        };
        let (message, help) = said.check(count, unit)?;
        let error = Diagnostic::error(message).at_maybe(said.place.as_ref());
        Some(if help.is_empty() { error } else { error.help(help) })
    }
}

/// How to see what is wrong with a file of which messages show nothing.
fn check_alone(file: &Path) -> String {
    format!("check it by itself, which shows it: homepoint check {}", file.display())
}

/// The files of a folder that are effects by their names (`*.toml`), sorted.
///
/// # Errors
/// A folder that cannot be read, or holds more than [`MAXIMUM_FILES`].
pub(crate) fn effect_files(folder: &Path) -> Result<Vec<PathBuf>, Diagnostics> {
    let failed = |error: std::io::Error| {
        let message = format!("cannot read the folder `{}`: {error}", folder.display());
        Diagnostics::from(Diagnostic::error(message))
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            files.push(path);
        }
    }
    if files.len() > MAXIMUM_FILES {
        let message = format!("`{}` holds more than {MAXIMUM_FILES} files", folder.display());
        return Err(Diagnostic::error(message).into());
    }
    files.sort();
    Ok(files)
}

/// Whether a campaign says a path, not a name.
pub(crate) fn is_model_path(text: &str) -> bool {
    text.ends_with(".toml") || text.contains(['/', '\\'])
}

/// The file of a model that is not one of the project's: a path relative to `base` (the campaign's
/// folder), or a name in `models/` there, if that has such a file.
pub(crate) fn model_file(name: &str, base: &Path) -> Option<PathBuf> {
    if is_model_path(name) {
        return Some(base.join(name));
    }
    let is_of_the_project = embedded::MODELS.iter().any(|(known, _)| *known == name);
    let beside = base.join("models").join(format!("{name}.toml"));
    (!is_of_the_project && beside.is_file()).then_some(beside)
}
