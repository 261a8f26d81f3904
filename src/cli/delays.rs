//! `homepoint delays`: each reading solved for its own delay.

use std::convert::Infallible;
use std::io::Write;

use clap::Args;
use serde_json::json;

use super::arguments::{CampaignArguments, Format};
use super::calibrate::{estimate, unsound};
use super::{Failure, load, output};
use crate::estimate::budget::budgets;
use crate::estimate::newton::ReadingDelay;
use crate::estimate::systematic::Widening;
use crate::estimate::transformation::Transformation;
use crate::report::{self, table};

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
            let data = &calibration.problem.parts[part];
            let mut widening = Widening::new(&calibration.problem, part, &taken.fit().fit.point);
            let mut delays = match &self.common.out {
                None => {
                    let see = &mut |reading: &ReadingDelay| {
                        widening.see(reading);
                        Ok::<_, Infallible>(())
                    };
                    let Ok(delays) = taken.delays(part, None, see);
                    delays
                }
                Some(folder) => {
                    let name = match loaded.labels.len() {
                        1 => "delays.csv".to_owned(),
                        _ => {
                            format!("delays_{}.csv", loaded.labels[part].replace(['/', '\\'], "_"))
                        }
                    };
                    output::written(&folder.join(name), |file| {
                        file.write_all(table::DELAYS.as_bytes())?;
                        let row = &mut |reading: &ReadingDelay| {
                            table::delay(data, &widening.see(reading), file)
                        };
                        let found = taken.delays(part, None, row)?;
                        load::read_back(&loaded.problem)?;
                        Ok(found)
                    })?
                }
            };
            load::trust(&loaded.problem)?;
            widening.widen(&mut delays);
            text.push_str(&report::text::delays(&loaded.titles[part], &taken.from(), &delays));
            text.push_str(&report::timing::text(campaign));
            let mut value = report::json::delays(&delays.measurands);
            load::merge(&mut value, json!({ "transformation": taken.from().word() }));
            if self.budget {
                let budgets = budgets(&taken, part, campaign);
                text.push_str(&report::budget::text(&budgets));
                for budget in &budgets {
                    let one = json!({ "budget": report::budget::json(budget) });
                    load::merge(&mut value["measurands"][&budget.measurand], one);
                }
            }
            load::put(&mut whole, &loaded.labels[part], loaded.labels.len(), value);
        }
        match self.common.format {
            Format::Json => output::json(&whole),
            Format::Text => output::text(&text),
        }
    }
}
