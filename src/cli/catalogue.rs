//! `homepoint models` and `homepoint effects`: what the library holds.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use serde_json::{Value, json};

use super::arguments::Format;
use super::{Failure, output};
use crate::campaign::file::CampaignFile;
use crate::diagnostic::Diagnostics;
use crate::effect::Effect;
use crate::engine::switched_off::remains_alone;
use crate::library::Library;
use crate::model::Model;
use crate::report::layout::{drawn, table};
use crate::system::candidates;

#[derive(Debug, Args)]
pub(super) struct Models {
    /// How the list is written
    #[arg(long, value_enum, default_value_t)]
    pub(super) format: Format,
    /// No warnings, no progress
    #[arg(long)]
    pub(super) quiet: bool,
}

#[derive(Debug, Args)]
pub(super) struct Effects {
    /// Say of each effect whether this model (a name, a file, or that of a campaign's folder) can test it
    #[arg(value_name = "MODEL")]
    model: Option<String>,
    /// Look for effects in this folder, too (repeat for more)
    #[arg(long = "effects", value_name = "DIR")]
    effects: Vec<PathBuf>,
    /// How the list is written
    #[arg(long, value_enum, default_value_t)]
    pub(super) format: Format,
    /// No warnings, no progress
    #[arg(long)]
    pub(super) quiet: bool,
}

impl Models {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = Library::builtin()?;
        let models = library
            .models()
            .iter()
            .map(|(name, _)| library.model(name, Path::new(".")))
            .collect::<Result<Vec<_>, _>>()?;
        if self.format == Format::Json {
            let list: Vec<Value> = models
                .iter()
                .map(|model| json!({ "name": model.name, "title": model.title }))
                .collect();
            return output::json(&json!({ "models": list }));
        }
        let mut table = table(&["model", "what it is"]);
        for model in &models {
            table.add_row([model.name.as_str(), model.title.as_str()]);
        }
        output::text(&format!("{}\n`homepoint show MODEL` prints the equations\n", drawn(&table)))
    }
}

impl Effects {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let mut library = Library::builtin()?;
        for folder in &self.effects {
            library = library.with_effects_dir(folder)?;
        }
        let model = match self.model.as_deref() {
            Some(folder) if Path::new(folder).is_dir() => {
                let folder = Path::new(folder);
                let campaign = CampaignFile::read(folder)?;
                library = library.with_effects_beside(folder)?;
                Some(library.model(&campaign.model.text, folder)?)
            }
            Some(name) => Some(library.model(name, Path::new("."))?),
            None => None,
        };
        let mut rows = Vec::new();
        for effect in library.effects() {
            // Built-in detectors look at the readings of any model.
            let asked = model.as_ref().filter(|_| !effect.builtin);
            let is_own = library.own_effects().any(|one| one.name == effect.name);
            rows.push((effect, asked.and_then(|model| why_not(model, effect, is_own))));
        }
        rows.sort_by(|a, b| (a.0.acts, &a.0.name).cmp(&(b.0.acts, &b.0.name)));
        if self.format == Format::Json {
            let list: Vec<Value> = rows
                .iter()
                .map(|(effect, why)| {
                    json!({
                        "name": effect.name,
                        "title": effect.title,
                        "acts": effect.acts.word(),
                        "not_testable": why,
                    })
                })
                .collect();
            return output::json(&json!({ "effects": list }));
        }
        let mut table = table(&["effect", "acts on", "what it is"]);
        for (effect, why) in &rows {
            let title = match why {
                Some(why) => format!("{} (not testable here: {why})", effect.title),
                None => effect.title.clone(),
            };
            table.add_row([effect.name.clone(), effect.acts.word().to_owned(), title]);
        }
        output::text(&drawn(&table))
    }
}

/// Why a model cannot test an effect. Those of the library are known to be absent at zero.
fn why_not(model: &Model, effect: &Arc<Effect>, is_own: bool) -> Option<String> {
    let ways = match candidates(model, effect, &[]) {
        Err(why) => return Some(why.messages()),
        Ok(ways) => ways,
    };
    let there = |way| remains_alone(model, way, &[]).ok().flatten();
    // It is tested at the heads where it is absent.
    let remaining: Vec<_> = ways.iter().filter(|_| is_own).map_while(there).collect();
    (!remaining.is_empty() && remaining.len() == ways.len())
        .then(|| Diagnostics(remaining).messages())
}
