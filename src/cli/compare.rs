//! `homepoint compare`: each reading's own delay beside the joint estimate.

use clap::Args;

use super::arguments::{CampaignArguments, Format};
use super::calibrate::unsound;
use super::joint::Joint;
use super::load::{notices, refusals};
use super::{Failure, doubts, load, output};
use crate::estimate::compare::compare;
use crate::estimate::transformation::delays_of;
use crate::report;

#[derive(Debug, Args)]
pub(super) struct CompareCommand {
    #[command(flatten)]
    pub(super) common: CampaignArguments,
}

impl CompareCommand {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let mut loaded = load::load(&self.common)?;
        if let Some(answer) = notices::nothing_moves(&loaded, self.common.format) {
            return answer;
        }
        refusals::refuse_correlated(&loaded.problem)?;
        notices::tell_not_put_in(&loaded, false);
        let joint = Joint::of(&mut loaded, &self.common.with)?;
        let calibration = &joint.fit;
        if !calibration.is_sound() {
            return unsound(calibration, &loaded.about, self.common.format);
        }
        doubts::tell_beside_delays(calibration, self.common.quiet);
        let mut whole = loaded.head.clone();
        let mut text = String::new();
        for part in 0..calibration.problem.parts.len() {
            let (from, delays) = delays_of(&loaded.problem, calibration, part);
            refusals::trust(&loaded.problem)?;
            let rows = compare(calibration, part, &delays.measurands);
            text.push_str(&report::text::comparison(&loaded.titles[part], &from, &rows));
            load::put(
                &mut whole,
                &loaded.labels[part],
                loaded.labels.len(),
                report::json::comparison(&rows),
            );
        }
        text.push_str(joint.text().trim_start_matches('\n'));
        load::merge(&mut whole, joint.json());
        match self.common.format {
            Format::Json => output::json(&whole),
            Format::Text => output::text(&text),
        }
    }
}
