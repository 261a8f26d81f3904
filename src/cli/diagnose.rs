//! `homepoint diagnose`: why simulation and reality differ.

use clap::Args;
use serde_json::json;

use super::arguments::{CampaignArguments, Format};
use super::{Failure, load, output};
use crate::diagnose::candidates::Wanted;
use crate::diagnose::diagnose;
use crate::diagnose::verdict::Verdict;
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
    /// List this many candidates
    #[arg(long, value_name = "N")]
    top: Option<usize>,
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
        let wanted = Wanted { only: self.only.clone(), without: self.without.clone() };
        let found = diagnose(loaded.problem, loaded.recipes, &wanted, &Options::default())
            .map_err(|error| Failure::Could(error.to_string()))?;
        match self.common.format {
            Format::Json => {
                let mut value = json!({ "campaigns": loaded.about });
                load::merge(&mut value, report::diagnosis::json(&found, self.top));
                output::json(&value)?;
            }
            Format::Text => {
                output::text(&report::diagnosis_text::text(&loaded.title, &found, self.top))?;
            }
        }
        if found.verdict == Verdict::Unobservable { Err(Failure::Told) } else { Ok(()) }
    }
}
