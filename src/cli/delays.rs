//! `homepoint delays`: each reading solved for its own delay.

use clap::Args;
use serde_json::json;

use super::arguments::{CampaignArguments, Format};
use super::calibrate::{estimate, unsound};
use super::{Failure, load, output};
use crate::estimate::budget::budgets;
use crate::estimate::systematic;
use crate::estimate::transformation::Transformation;
use crate::report;

#[derive(Debug, Args)]
pub(super) struct DelaysCommand {
    #[command(flatten)]
    common: CampaignArguments,
    /// Show what the uncertainty of the delays is made of
    #[arg(long)]
    budget: bool,
}

impl DelaysCommand {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let loaded = load::load(&self.common)?;
        load::refuse_correlated(&loaded.problem)?;
        let calibration = estimate(loaded.problem.clone())?;
        if !calibration.is_sound() {
            return unsound(&calibration, &loaded.about, self.common.format);
        }
        let mut whole = json!({ "campaigns": loaded.about });
        let mut text = String::new();
        for part in 0..calibration.problem.parts.len() {
            let campaign = &loaded.campaigns[part];
            let taken = Transformation::of(&loaded.problem, &calibration, part);
            let mut delays = taken.delays(part, None);
            systematic::widen(&calibration.problem, part, &taken.fit().fit.point, &mut delays);
            text.push_str(&report::text::delays(&loaded.titles[part], &taken.from(), &delays));
            text.push_str(&report::timing::text(campaign));
            let mut value = report::json::delays(&delays.measurands);
            load::merge(&mut value, json!({ "transformation": taken.from().word() }));
            if self.budget {
                let budgets = budgets(&taken, part, campaign, &delays);
                text.push_str(&report::budget::text(&budgets));
                for budget in &budgets {
                    let one = json!({ "budget": report::budget::json(budget) });
                    load::merge(&mut value["measurands"][&budget.measurand], one);
                }
            }
            load::put(&mut whole, &loaded.labels[part], loaded.labels.len(), value);
            if let Some(folder) = &self.common.out {
                let name = match loaded.labels.len() {
                    1 => "delays.csv".to_owned(),
                    _ => format!("delays_{}.csv", loaded.labels[part].replace(['/', '\\'], "_")),
                };
                let table = report::table::delays(&calibration.problem, part, &delays);
                output::file(&folder.join(name), &table)?;
            }
        }
        match self.common.format {
            Format::Json => output::json(&whole),
            Format::Text => output::text(&text),
        }
    }
}
