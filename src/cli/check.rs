//! `homepoint check`: models, effects and campaigns are read and checked; nothing is computed.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::arguments::Memory;
use super::{Failure, clean, output, progress, render};
use crate::campaign::file::MOST_BYTES;
use crate::convention::Convention;
use crate::diagnostic::{Diagnostic, Diagnostics, Source, counted};
use crate::document::files::Files;
use crate::effect::Effect;
use crate::engine::Part;
use crate::engine::open::{Recipe, Request, open};
use crate::engine::switched_off::{remains_alone, without_slope};
use crate::estimate::checks;
use crate::library::Library;
use crate::model::{Model, Override};
use crate::report;
use crate::system::{Selected, System, candidates, missing_names, stand_ins};
use misfits::misfits;
use own_models::own_models;
use testable::testable_in;

mod misfits;
mod own_models;
mod testable;

#[derive(Debug, Args)]
pub(super) struct Check {
    /// Model files, effect files, campaign folders, or names in the library; nothing: the library
    #[arg(value_name = "WHAT")]
    what: Vec<String>,
    /// Look for effects in this folder, too (repeat for more)
    #[arg(long = "effects", value_name = "DIR")]
    effects: Vec<PathBuf>,
    /// Leave bad rows of data files out, count and list them
    #[arg(long)]
    skip_bad_rows: bool,
    /// Read no file outside a campaign's folder: for campaigns of strangers
    #[arg(long)]
    confined: bool,
    /// Show in messages what stands in files outside a campaign's folder, too
    #[arg(long, conflicts_with = "confined")]
    show_outside: bool,
    /// No warnings, no progress
    #[arg(long)]
    pub(super) quiet: bool,
    #[command(flatten)]
    memory: Memory,
}

impl Check {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let mut library = Library::builtin()?.confined(self.confined);
        for folder in &self.effects {
            library = library.with_effects_dir(folder)?;
        }
        let mut faults = Vec::new();
        let mut said = String::new();
        let everything = library
            .models()
            .iter()
            .map(|(name, _)| (*name).to_owned())
            .chain(library.effects().map(|effect| effect.name.clone()))
            .collect();
        let what = if self.what.is_empty() { &everything } else { &self.what };
        let own = own_models(&library, what);
        for one in what {
            match self.one(&library, &own, one) {
                Ok(words) => said.push_str(&format!("{one}: {words}\n")),
                Err(found) => faults.extend(found.0),
            }
        }
        output::text(&said)?;
        Diagnostics(faults).into_result(()).map_err(Failure::from)
    }

    fn one(
        &self,
        library: &Library,
        own: &[(String, Model)],
        what: &str,
    ) -> Result<String, Diagnostics> {
        let path = Path::new(what);
        if path.is_dir() || path.file_name().is_some_and(|name| name == "campaign.toml") {
            return self.campaign(path);
        }
        if path.extension().is_some_and(|extension| extension == "toml") {
            let source = Source::read_of(&mut Files::default(), path, MOST_BYTES)?;
            return if is_campaign(&source) {
                self.campaign(path)
            } else if is_convention(&source) {
                Convention::parse(source).map(|_| "a convention".to_owned())
            } else if is_effect(&source) {
                effect(library, own, &Arc::new(Effect::parse(source)?))
            } else {
                model(&Model::parse(source)?)
            };
        }
        if path.is_file() {
            return self.campaign(path);
        }
        if let Ok(found) = library.effect(what) {
            return effect(library, own, &found);
        }
        model(&library.model(what, Path::new("."))?)
    }

    fn campaign(&self, path: &Path) -> Result<String, Diagnostics> {
        let mut request = Request::new([path]);
        request.effects.clone_from(&self.effects);
        request.skip_bad_rows = self.skip_bad_rows;
        request.confined = self.confined;
        request.show_outside = self.show_outside;
        request.progress = progress::shown(self.quiet);
        request.memory = Some(self.memory.for_samples());
        let opened = open(&request)?;
        if !self.quiet {
            render::all(&opened.warnings);
            render::all(&checks::check(&opened.problem));
            render::all(&checks::repeated(&opened.problem));
            let misfits = opened.recipes.iter().flat_map(Recipe::own_that_do_not_fit);
            render::all(&misfits.map(|(_, misfit)| misfit).collect::<Vec<_>>());
        }
        let part = &opened.problem.parts[0];
        let timing = report::timing::text(&opened.campaigns[0], &opened.models[0]);
        let recognised = opened.campaigns[0].recognised.iter().map(String::as_str);
        let timing = timing.lines().chain(recognised);
        let timing = timing.map(|line| format!("\n  {}", clean::line(line))).collect::<String>();
        Ok(format!(
            "a campaign of `{}`, {} in {}, {}, {}{}{timing}",
            opened.models[0].name,
            counted(part.runs.len(), "run"),
            counted(part.setups.len(), "setup"),
            counted(opened.problem.reading_count(), "reading"),
            counted(opened.problem.layout.columns.len(), "unknown"),
            without_target(&opened.models[0]) + &unread(part) + &testable_in(&opened.recipes[0])
        ))
    }
}

/// Measurands that no run reads, of a campaign with readings: their columns may have other names.
fn unread(part: &Part) -> String {
    let present = part.present();
    let is_read = present.iter().any(|readings| *readings > 0);
    let names = part.system.assembly.names.measurands.iter().zip(present);
    let unread = names.filter(|(_, readings)| is_read && *readings == 0);
    let unread = unread.map(|(one, _)| one.name.as_str());
    let unread = unread.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if unread.is_empty() {
        return unread;
    }
    format!("\n  no readings of {unread}: are their columns named otherwise?")
}

/// Whether a file is a campaign or a plan: it has runs.
fn is_campaign(source: &Source) -> bool {
    source.text.lines().any(|line| line.trim_start().starts_with("[[runs]]"))
}

/// Whether a file is an effect: it patches, or acts.
fn is_effect(source: &Source) -> bool {
    source.text.lines().any(|line| {
        let line = line.trim_start();
        line.starts_with("[patch]")
            || line.split('=').next().is_some_and(|key| key.trim() == "acts")
    })
}

/// Whether a file is a convention: it says what numbers are read as.
fn is_convention(source: &Source) -> bool {
    source.text.lines().any(|line| line.trim_start().starts_with("[as]"))
}

fn model(model: &Model) -> Result<String, Diagnostics> {
    let system = System::build(model, &[], &[], &vec![None; model.inputs.len()])?;
    Ok(format!(
        "a model of {}, {}{}",
        counted(model.measurands.len(), "measurand"),
        counted(system.settings.len(), "parameter"),
        without_target(model)
    ))
}

/// What is not looked for where nothing is called so.
fn without_target(model: &Model) -> String {
    if model.quantities.contains_key(model.called("target")) {
        return String::new();
    }
    "; none of its quantities is called `target` or has that role: `diagnose` looks for no displacement of what is measured".to_owned()
}

/// An effect is sound if it fits at least one model of the library, or of one's own: checked with it, or in the folder above.
fn effect(
    library: &Library,
    own: &[(String, Model)],
    effect: &Arc<Effect>,
) -> Result<String, Diagnostics> {
    if effect.builtin {
        return Ok("a built-in detector".to_owned());
    }
    let (mut fits, mut others, mut flat) = (Vec::new(), Vec::new(), BTreeSet::new());
    let mut models: Vec<(&str, Model)> = Vec::new();
    for (name, _) in library.models() {
        models.push((name, library.model(name, Path::new("."))?));
    }
    models.extend(own.iter().map(|(name, model)| (name.as_str(), model.clone())));
    for (name, candidate) in &models {
        let stated = stand_ins(effect);
        match candidates(candidate, effect, &stated) {
            Ok(ways) => {
                Diagnostics(remaining((name, candidate), &ways, &stated)?).into_result(())?;
                for way in &ways {
                    flat.extend(without_slope(candidate, way, &stated)?);
                }
                fits.push(*name);
            }
            Err(why) => others.push((missing_names(candidate, effect), *name, why)),
        }
    }
    if fits.is_empty() {
        // Models of one's own beside it are those that it is for.
        let is_own = |name: &str| own.iter().any(|(one, _)| one == name);
        others.retain(|(_, name, _)| own.is_empty() || is_own(name));
        Err(misfits(effect, others, !own.is_empty()))
    } else {
        Ok(format!("an effect for {}{}", fits.join(", "), even_in(&flat)))
    }
}

/// What is to be known of parameters that change readings alike with either sign.
fn even_in(flat: &BTreeSet<String>) -> String {
    let names: Vec<String> = flat.iter().map(|name| format!("`{name}`")).collect();
    match names.is_empty() {
        true => String::new(),
        false => format!(
            "; {} has no slope at zero: readings change alike with either sign, and `diagnose` begins at zero. A parameter in place of its square or size has one",
            names.join(", ")
        ),
    }
}

/// What an effect that fits a model does there although its parameters are zero.
fn remaining(
    (name, model): (&str, &Model),
    ways: &[Selected],
    stated: &[Override],
) -> Result<Vec<Diagnostic>, Diagnostics> {
    let mut found = Vec::new();
    for way in ways {
        found.extend(remains_alone(model, way, stated)?.map(|one| {
            let message = format!("`{}` with the model `{name}`: {}", way.effect.name, one.message);
            Diagnostic { message, ..one }
        }));
    }
    Ok(found)
}
