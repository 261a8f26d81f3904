//! `homepoint show`: a model's equations as people read them.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::{Failure, output};
use crate::campaign::file::CampaignFile;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::formula::Formula;
use crate::formula::show::latex_name;
use crate::graph::MeasurandKind;
use crate::library::{Library, is_model_path};
use crate::model::Model;
use crate::report::json::scope_word;
use crate::system::{EffectInstance, System};

#[derive(Debug, Args)]
pub(super) struct Show {
    /// A model: a name in the library or a file
    #[arg(value_name = "MODEL")]
    model: String,
    /// Show an effect's patches, too (repeat for more)
    #[arg(long = "with", value_name = "EFFECT")]
    with: Vec<String>,
    /// Look for effects in this folder, too (repeat for more)
    #[arg(long = "effects", value_name = "DIR")]
    effects: Vec<PathBuf>,
    /// Write LaTeX
    #[arg(long)]
    latex: bool,
    /// No warnings, no progress
    #[arg(long)]
    pub(super) quiet: bool,
}

impl Show {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let mut library = Library::builtin()?;
        for folder in &self.effects {
            library = library.with_effects_dir(folder)?;
        }
        let model = library.model(&self.model, Path::new("."));
        let model = model.map_err(|faults| folder(Path::new(&self.model)).unwrap_or(faults))?;
        let selected =
            self.with.iter().map(|name| library.select(name)).collect::<Result<Vec<_>, _>>()?;
        let system = System::build(&model, &selected, &[], &vec![None; model.inputs.len()])?;
        let text = if self.latex { latex(&model, &system) } else { plain(&model, &system) };
        output::text(&text)
    }
}

/// That a folder is no model, with the model of the campaign in it.
fn folder(path: &Path) -> Option<Diagnostics> {
    let fault = path
        .is_dir()
        .then(|| Diagnostic::error(format!("`{}` is a folder, and no model", path.display())))?;
    let campaign = CampaignFile::read(path).ok();
    let help = campaign.map_or_else(
        || "name a model in the library or a file".to_owned(),
        |campaign| {
            let name = &campaign.model.text;
            let name = match is_model_path(name) {
                true => path.join(name).display().to_string(),
                false => name.clone(),
            };
            format!("show the model of its campaign: `homepoint show {name}`")
        },
    );
    Some(fault.help(help).into())
}

/// Names on the left, aligned.
fn aligned(rows: &[(String, String)]) -> String {
    let width = rows.iter().map(|(left, _)| left.chars().count()).max().unwrap_or(0);
    rows.iter().fold(String::new(), |mut text, (left, right)| {
        let line = format!("  {left:width$}  {right}");
        // Writing into a text cannot fail.
        let _ = writeln!(text, "{}", line.trim_end());
        text
    })
}

fn plain(model: &Model, system: &System) -> String {
    let mut text = format!("{}: {}\n", model.name, model.title);
    if let Some(reference) = &model.reference {
        let _ = writeln!(text, "{reference}");
    }
    let inputs: Vec<_> = model
        .inputs
        .iter()
        .map(|one| {
            let moves = if one.signal { "moves" } else { "constant within a sample" };
            (format!("{} [{}]", one.name, one.unit.symbol), join(&[moves, &one.about]))
        })
        .collect();
    section(&mut text, "recorded", &inputs);
    let names = &system.assembly.names;
    let parameters: Vec<_> = names
        .parameters
        .iter()
        .zip(&system.settings)
        .zip(&system.declared)
        .filter(|((parameter, _), declared)| {
            declared.effect.is_none() && !parameter.name.ends_with(".delay")
        })
        .map(|((parameter, setting), declared)| {
            let fixed = if setting.fixed { ", fixed" } else { "" };
            let scope = format!("one for each {}{fixed}", scope_word(setting.scope));
            let unit = &parameter.unit.symbol;
            (format!("{} [{unit}]", parameter.name), join(&[&scope, &declared.about]))
        })
        .collect();
    section(&mut text, "unknown", &parameters);
    let formulas = |list: Vec<(&String, &Formula)>| -> Vec<(String, String)> {
        list.into_iter()
            .map(|(name, formula)| (name.clone(), format!("= {}", formula.to_text())))
            .collect()
    };
    section(&mut text, "with", &formulas(model.quantities.iter().collect()));
    let measurands: Vec<_> = model
        .measurands
        .iter()
        .map(|one| {
            let delay = &names.parameters
                [names.measurands.iter().find(|m| m.name == one.name).map_or(0, |m| m.delay)]
            .name;
            let unit =
                if one.kind == MeasurandKind::Rotation { "rotation" } else { &one.unit.symbol };
            (
                format!("{} [{unit}]", one.name),
                format!("= {}    at time + {delay}", one.formula.to_text()),
            )
        })
        .collect();
    section(&mut text, "read", &measurands);
    for effect in &system.effects {
        section(&mut text, &format!("{} ({})", effect.name, effect.effect.title), &patches(effect));
    }
    text
}

/// An effect's own names, then its patches.
fn patches(effect: &EffectInstance) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    for parameter in &effect.effect.parameters {
        let typical = parameter
            .setting
            .typical
            .map_or_else(String::new, |size| crate::report::figure::size(size, &parameter.unit));
        let scope = match parameter.setting.scope {
            crate::graph::Scope::Sample => "random".to_owned(),
            other => format!("one for each {}", scope_word(other)),
        };
        let typical =
            if typical.is_empty() { String::new() } else { format!("typically {typical}") };
        let left = format!("{} [{}]", parameter.name, parameter.unit.symbol);
        rows.push((left, join(&[&scope, &typical, &parameter.about])));
    }
    for (family, value) in &effect.member {
        rows.push((family.clone(), format!("= {value}    chosen member of its family")));
    }
    for patch in &effect.effect.patches {
        rows.push((patch.name.clone(), format!("<- {}", patch.formula.to_text())));
    }
    rows
}

fn join(parts: &[&str]) -> String {
    parts.iter().filter(|part| !part.is_empty()).copied().collect::<Vec<_>>().join(": ")
}

fn section(text: &mut String, title: &str, rows: &[(String, String)]) {
    if !rows.is_empty() {
        let _ = write!(text, "\n{title}\n{}", aligned(rows));
    }
}

fn latex(model: &Model, system: &System) -> String {
    let mut text = format!("% {}: {}\n\\begin{{align*}}\n", model.name, model.title);
    let mut line = |left: &str, relation: &str, right: &str| {
        let _ = writeln!(text, "  {left} &{relation} {right} \\\\");
    };
    for (name, formula) in &model.quantities {
        line(&latex_name(name), "=", &formula.to_latex());
    }
    for measurand in &model.measurands {
        line(&latex_name(&measurand.name), "=", &measurand.formula.to_latex());
    }
    // At each of several heads an effect has the same patches.
    let mut shown = Vec::new();
    for effect in system.effects.iter().map(|placed| &placed.effect) {
        if shown.contains(&&effect.name) {
            continue;
        }
        shown.push(&effect.name);
        for patch in &effect.patches {
            line(&latex_name(&patch.name), "\\leftarrow", &patch.formula.to_latex());
        }
    }
    text.push_str("\\end{align*}\n");
    text
}
