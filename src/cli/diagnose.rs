//! `homepoint diagnose`: why simulation and reality differ.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::arguments::{CampaignArguments, Format};
use super::{Failure, load, output};
use crate::diagnose::candidates::Wanted;
use crate::diagnose::verdict::Verdict;
use crate::diagnose::{diagnose, judge};
use crate::engine::open::{Opened, Recipe, Request, open};
use crate::estimate::batch::Options;
use crate::report;

#[derive(Debug, Args)]
pub(super) struct Diagnose {
    #[command(flatten)]
    common: CampaignArguments,
    /// Leave an effect out of the library (repeat for more)
    #[arg(long = "without", value_name = "EFFECT")]
    without: Vec<String>,
    /// Test this effect alone (repeat for more)
    #[arg(long = "only", value_name = "EFFECT")]
    only: Vec<String>,
    /// Judge the shrinkage on a campaign that the fit never saw
    #[arg(long, value_name = "CAMPAIGN")]
    holdout: Option<PathBuf>,
    /// List this many candidates
    #[arg(long, value_name = "N")]
    top: Option<usize>,
}

/// Refuses a held-out campaign to which what is found says nothing.
fn same_models(fitted: &[Recipe], held_out: &Opened) -> Result<(), Failure> {
    let names: Vec<&str> = fitted.iter().map(|recipe| recipe.model.name.as_str()).collect();
    let other = held_out.recipes.iter().find(|one| !names.contains(&one.model.name.as_str()));
    other.map_or(Ok(()), |other| {
        Err(Failure::Could(format!(
            "the held-out campaign has the model `{}`, but effects are looked for with `{}`: give a campaign with the same model",
            other.model.name,
            names.join("`, `")
        )))
    })
}

impl Diagnose {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let loaded = load::load(&self.common)?;
        load::refuse_correlated(&loaded.problem)?;
        load::refuse_empty(&loaded.problem)?;
        for name in self.without.iter().chain(&self.only) {
            for recipe in &loaded.recipes {
                recipe.library.effect(name)?;
            }
        }
        let wanted = Wanted::new(&self.only, &self.without);
        let held_out = self.holdout.as_ref().map(|path| self.opened(path)).transpose()?;
        if let Some(other) = &held_out {
            same_models(&loaded.recipes, other)?;
        }
        let mut found = diagnose(loaded.problem, loaded.recipes, &wanted, &Options::default())
            .map_err(|error| Failure::Could(error.to_string()))?;
        if let Some(held_out) = &held_out {
            judge(&mut found, held_out, &wanted, &Options::default())
                .map_err(|error| Failure::Could(error.to_string()))?;
        }
        if let Some(folder) = &self.common.out {
            let table = report::diagnosis::table(&found);
            output::file(&folder.join("candidates.csv"), &table)?;
        }
        match self.common.format {
            Format::Json => {
                let mut value = json!({ "campaigns": loaded.about });
                load::merge(&mut value, report::diagnosis::json(&found, self.top));
                output::json(&value)?;
            }
            Format::Text => {
                output::text(&report::diagnosis_text::text(&loaded.title, &found, self.top))?;
                if held_out.is_some() && found.effects.is_empty() {
                    output::text(
                        "\nNo effect was named: there is nothing to judge on the held-out campaign.\n",
                    )?;
                }
            }
        }
        if found.verdict == Verdict::Unobservable { Err(Failure::Told) } else { Ok(()) }
    }

    /// Another campaign, read as the first ones were.
    fn opened(&self, path: &Path) -> Result<Opened, Failure> {
        let mut request = Request::new([path]);
        request.with.clone_from(&self.common.with);
        request.effects.clone_from(&self.common.effects);
        request.skip_bad_rows = self.common.skip_bad_rows;
        let opened = open(&request)?;
        load::refuse_correlated(&opened.problem)?;
        load::refuse_empty(&opened.problem)?;
        Ok(opened)
    }
}
