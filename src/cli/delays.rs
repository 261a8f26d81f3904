//! `homepoint delays`: each reading solved for its own delay.

use clap::Args;
use serde_json::json;

use super::arguments::{CampaignArguments, Format};
use super::calibrate::{estimate, unsound};
use super::{Failure, load, output};
use crate::engine::Problem;
use crate::estimate::calibrate::Calibration;
use crate::estimate::delays::Delays;
use crate::estimate::transformation::{self, From};
use crate::report;

#[derive(Debug, Args)]
pub(super) struct DelaysCommand {
    #[command(flatten)]
    common: CampaignArguments,
}

/// The delays of one campaign, and where its transformation is from.
pub(super) struct Found {
    pub(super) from: From,
    pub(super) delays: Delays,
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
            let found = newton(&loaded.problem, &calibration, part)?;
            text.push_str(&report::text::delays(&loaded.titles[part], &found.from, &found.delays));
            text.push_str(&report::timing::text(&loaded.campaigns[part]));
            let mut value = report::json::delays(&found.delays.measurands);
            load::merge(&mut value, json!({ "transformation": found.from.word() }));
            load::put(&mut whole, &loaded.labels[part], loaded.labels.len(), value);
            if let Some(folder) = &self.common.out {
                let name = match loaded.labels.len() {
                    1 => "delays.csv".to_owned(),
                    _ => format!("delays_{}.csv", loaded.labels[part].replace(['/', '\\'], "_")),
                };
                let table = report::table::delays(&calibration.problem, part, &found.delays);
                output::file(&folder.join(name), &table)?;
            }
        }
        match self.common.format {
            Format::Json => output::json(&whole),
            Format::Text => output::text(&text),
        }
    }
}

/// Takes the transformation from reference runs, else from the joint fit, and solves every reading.
pub(super) fn newton(
    problem: &Problem,
    joint: &Calibration,
    part: usize,
) -> Result<Found, Failure> {
    let (from, delays) = transformation::delays_of(problem, joint, part);
    Ok(Found { from, delays })
}
