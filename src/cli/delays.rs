//! `homepoint delays`: each reading solved for its own delay, the means under changed conditions,
//! and their agreement between campaigns.

use std::convert::Infallible;
use std::io::Write;

use clap::Args;
use serde_json::json;

use super::arguments::{CampaignArguments, Format, TransformationChoice};
use super::calibrate::unsound;
use super::joint::Joint;
use super::load::{Loaded, notices, refusals};
use super::{Failure, doubts, load, output};
use crate::estimate::bias::bias;
use crate::estimate::blind::ArmAngle;
use crate::estimate::budget::budgets;
use crate::estimate::conditions::self_calibration;
use crate::estimate::newton::ReadingDelay;
use crate::estimate::repeatability;
use crate::estimate::systematic::Widening;
use crate::estimate::transformation::{
    Choice, From, NoTransformation, Transformation, transformation,
};
use crate::report::{self, table};

#[derive(Debug, Args)]
pub(super) struct DelaysCommand {
    #[command(flatten)]
    pub(super) common: CampaignArguments,
    /// Where the transformation is from
    #[arg(long, value_enum, default_value_t)]
    transformation: TransformationChoice,
    /// Show what the uncertainty of the delays is made of
    #[arg(long)]
    budget: bool,
}

impl DelaysCommand {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let mut loaded = load::load(&self.common)?;
        if let Some(answer) = notices::nothing_moves(&loaded, self.common.format) {
            return answer;
        }
        let tables = loaded.tables("delays").chain(loaded.tables("replies"));
        loaded.keep_files(self.common.out.as_ref(), tables)?;
        refusals::refuse_correlated(&loaded.problem)?;
        notices::tell_not_put_in(&loaded, false);
        let mut whole = loaded.head.clone();
        let mut text = String::new();
        let joint = Joint::of(&mut loaded, &self.common.with)?;
        let given = given_transformation(&loaded, &joint, self.transformation, self.common.format)?;
        let mut solved = Vec::new();
        for (part, given) in given.iter().enumerate() {
            let runs = given.wanted(part);
            let campaign = &loaded.campaigns[part];
            let mut widening = Widening::new(&given.problem, part, &given.point);
            let mut found = match &self.common.out {
                None => {
                    let see = &mut |reading: &ReadingDelay| {
                        widening.see(reading);
                        Ok::<_, Infallible>(())
                    };
                    let Ok(found) = given.each_delay(part, &runs, see);
                    found
                }
                Some(folder) => {
                    let name = load::table_name("delays", &loaded.labels, part);
                    let data = &given.problem.parts[part];
                    output::written(&folder.join(name), &loaded.files, |file| {
                        file.write_all(table::DELAYS.as_bytes())?;
                        let mut arm = ArmAngle::of(data);
                        let row = &mut |reading: &ReadingDelay| {
                            table::delay(data, &widening.see(reading), &mut arm, file)
                        };
                        let found = given.each_delay(part, &runs, row)?;
                        refusals::read_back(&given.problem)?;
                        Ok(found)
                    })?
                }
            };
            if let Some(folder) = &self.common.out {
                let replies = report::timing::replies(campaign, &loaded.models[part]);
                if !replies.is_empty() {
                    let name = load::table_name("replies", &loaded.labels, part);
                    output::file(&folder.join(name), &replies, &loaded.files)?;
                }
            }
            refusals::trust(&given.problem)?;
            widening.widen(&mut found);
            text.push_str(&report::text::delays(&loaded.titles[part], &given.from, &found));
            text.push_str(&report::timing::text(campaign, &loaded.models[part]));
            let mut value = report::json::delays(&found.measurands);
            if self.budget {
                let budgets = budgets(given, part, campaign);
                text.push_str(&report::budget::text(&budgets));
                for budget in &budgets {
                    let one = json!({ "budget": report::budget::json(budget) });
                    load::merge(&mut value["measurands"][&budget.measurand], one);
                }
            }
            load::merge(&mut value, report::conditions::transformation_json(given));
            text.push_str(&report::conditions::transformation_text(given, part));
            if given.from == From::Paper {
                let iterated = given.iterated(&loaded.problem, part);
                let iterated = iterated.map_err(|why| Failure::Could(why.to_string()))?;
                let list = bias(given, &iterated, part);
                text.push_str(&report::conditions::bias_text(given, part, &list));
                load::merge(&mut value, report::conditions::bias_json(given, part, &list));
            }
            let conditions = self_calibration(given, part);
            text.push_str(&report::conditions::text(given, part, &conditions));
            load::merge(&mut value, report::conditions::json(given, part, &conditions));
            load::put(&mut whole, &loaded.labels[part], loaded.labels.len(), value);
            solved.push(found);
        }
        let agreement = repeatability::of_campaigns(&given, &solved);
        // Delays of unlike instruments need not agree.
        let named: Vec<_> = loaded.problem.parts.iter().map(|part| &part.instrument).collect();
        let one_instrument = named.iter().all(|name| name.is_some() && *name == named[0]);
        if one_instrument && !agreement.is_empty() {
            text.push_str(&report::conditions::repeatability_text(&loaded.labels, &agreement));
            let value = report::conditions::repeatability_json(&loaded.labels, &agreement);
            load::merge(&mut whole, value);
        }
        text.push_str(joint.text().trim_start_matches('\n'));
        load::merge(&mut whole, joint.json());
        let all = solved.iter().flat_map(|found| &found.measurands);
        let (good, failed) =
            all.fold((0, 0), |(good, failed), one| (good + one.solved, failed + one.failed));
        if failed > good {
            text.push_str(&format!(
                "\nMost delays failed ({failed} readings, {good} solved): these are no result. `homepoint calibrate` estimates the joint delay; state its `start` or `delay_range`.\n"
            ));
            load::merge(&mut whole, json!({ "most_failed": true }));
        }
        match self.common.format {
            Format::Json => output::json(&whole)?,
            Format::Text => output::text(&text)?,
        }
        if failed > good { Err(Failure::Reported) } else { Ok(()) }
    }
}

/// The transformation of each campaign, as asked for; where it needs the joint fit, that must be
/// sound.
pub(super) fn given_transformation(
    loaded: &Loaded,
    joint: &Joint,
    choice: TransformationChoice,
    format: Format,
) -> Result<Vec<Transformation>, Failure> {
    let choice = Choice::from(choice);
    let joint = &joint.fit;
    if !joint.is_sound() && matches!(choice, Choice::Best | Choice::Joint) {
        unsound(joint, &loaded.about, format)?;
    }
    doubts::tell_beside_delays(joint, loaded.quiet);
    (0..loaded.problem.parts.len())
        .map(|part| {
            let found = transformation(&loaded.problem, Some(joint), part, choice);
            found.map_err(|why| not_there(&why, loaded))
        })
        .collect()
}

/// Why there is no transformation, for programs, too.
fn not_there(why: &NoTransformation, loaded: &Loaded) -> Failure {
    let result = json!({
        "campaigns": loaded.about,
        "measurands": {},
        "unobservable": [{ "words": why.to_string(), "direction": {}, "remedy": "choose another --transformation", "determined": [] }],
    });
    Failure::NoAnswer(why.to_string(), result)
}
