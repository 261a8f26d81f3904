//! `homepoint deviations`: how far the measured points lie from where the arm was.

use clap::Args;
use serde_json::json;

use super::arguments::{CampaignArguments, Format, TransformationChoice};
use super::delays::given_transformation;
use super::joint::Joint;
use super::load::{notices, refusals};
use super::{Failure, load, output};
use crate::estimate::deviations::deviations;
use crate::estimate::intersection::intersection;
use crate::report::deviations::{Shown, Whole, json as result, table, text};

#[derive(Debug, Args)]
pub(super) struct DeviationsCommand {
    #[command(flatten)]
    pub(super) common: CampaignArguments,
    /// Where the transformation is from
    #[arg(long, value_enum, default_value_t)]
    transformation: TransformationChoice,
}

impl DeviationsCommand {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let mut loaded = load::load(&self.common)?;
        if let Some(answer) = notices::nothing_moves(&loaded, self.common.format) {
            return answer;
        }
        loaded.keep_files(self.common.out.as_ref(), loaded.tables("deviations"))?;
        refusals::refuse_correlated(&loaded.problem)?;
        let mut whole = loaded.head.clone();
        let mut printed = String::new();
        let joint = Joint::of(&mut loaded, &self.common.with)?;
        let given = given_transformation(&loaded, &joint, self.transformation, self.common.format)?;
        for (part, given) in given.iter().enumerate() {
            let runs: Vec<Shown> = (0..given.problem.parts[part].runs.len())
                .map(|run| {
                    let (head, found) = deviations(&given.problem, part, run, &given.point);
                    let gap = intersection(&given.problem, part, run, &given.point);
                    Shown { head, found, gap }
                })
                .collect();
            refusals::trust(&given.problem)?;
            let specification = &loaded.campaigns[part].specification;
            let shown = Whole { problem: &given.problem, part, specification, runs: &runs };
            printed.push_str(&text(&loaded.titles[part], given.from, shown));
            let mut value = result(shown);
            load::merge(&mut value, json!({ "transformation": given.from.word() }));
            load::put(&mut whole, &loaded.labels[part], loaded.labels.len(), value);
            if let Some(folder) = &self.common.out {
                let name = load::table_name("deviations", &loaded.labels, part);
                output::file(&folder.join(name), &table(shown), &loaded.files)?;
            }
        }
        printed.push_str(joint.text().trim_start_matches('\n'));
        load::merge(&mut whole, joint.json());
        match self.common.format {
            Format::Json => output::json(&whole),
            Format::Text => output::text(&printed),
        }
    }
}
