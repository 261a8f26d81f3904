//! `homepoint delays`: each reading solved for its own delay.

use std::io::Write;

use clap::Args;
use serde_json::json;

use super::arguments::{CampaignArguments, Format};
use super::calibrate::{estimate, unsound};
use super::{Failure, load, output};
use crate::estimate::newton::ReadingDelay;
use crate::estimate::transformation;
use crate::report::{self, table};

#[derive(Debug, Args)]
pub(super) struct DelaysCommand {
    #[command(flatten)]
    common: CampaignArguments,
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
            let found = match &self.common.out {
                None => transformation::delays_of(&loaded.problem, &calibration, part),
                Some(folder) => {
                    let name = match loaded.labels.len() {
                        1 => "delays.csv".to_owned(),
                        _ => {
                            format!("delays_{}.csv", loaded.labels[part].replace(['/', '\\'], "_"))
                        }
                    };
                    let data = &calibration.problem.parts[part];
                    output::written(&folder.join(name), |file| {
                        file.write_all(table::DELAYS.as_bytes())?;
                        let row = &mut |reading: &ReadingDelay| table::delay(data, reading, file);
                        transformation::each_delay_of(&loaded.problem, &calibration, part, row)
                    })?
                }
            };
            let (from, delays) = found;
            text.push_str(&report::text::delays(&loaded.titles[part], &from, &delays));
            let mut value = report::json::delays(&delays.measurands);
            load::merge(&mut value, json!({ "transformation": from.word() }));
            load::put(&mut whole, &loaded.labels[part], loaded.labels.len(), value);
        }
        match self.common.format {
            Format::Json => output::json(&whole),
            Format::Text => output::text(&text),
        }
    }
}
