//! `homepoint power`: what a campaign can see, before there are any data.

use clap::Args;

use super::arguments::{CampaignArguments, Format};
use super::calibrate::{estimate_measured, verdict};
use super::load::{notices, refusals};
use super::wanted::WantedArguments;
use super::{Failure, load, output, render};
use crate::diagnose::power::power;
use crate::diagnostic::Diagnostic;
use crate::engine::{Point, Problem};
use crate::estimate::planned;
use crate::report;

/// Said where effects are left out.
const NARROWED: &str = "\nEffects that `--only` or `--without` leave out were not weighed: the MIB separates an effect from those\n\
     above, not from the whole library.\n";

#[derive(Debug, Args)]
pub(super) struct PowerCommand {
    #[command(flatten)]
    pub(super) common: CampaignArguments,
    #[command(flatten)]
    library: WantedArguments,
}

/// The table that `--out` asks for.
const EFFECTS: &str = "effects.csv";

impl PowerCommand {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let loaded = load::load(&self.common)?;
        loaded.keep_files(self.common.out.as_ref(), [EFFECTS])?;
        refusals::refuse_correlated(&loaded.problem)?;
        notices::tell_not_put_in(&loaded, true);
        let wanted = self.library.wanted(&loaded.recipes)?;
        let point = self.point(&loaded.problem)?;
        let found = power(loaded.problem, loaded.recipes, point, &wanted)
            .map_err(|error| Failure::Could(error.to_string()))?;
        if let Some(folder) = &self.common.out {
            output::file(&folder.join(EFFECTS), &report::power::table(&found), &loaded.files)?;
        }
        match self.common.format {
            Format::Json => {
                let mut value = loaded.head.clone();
                load::merge(&mut value, report::power::json(&found));
                output::json(&value)?;
            }
            Format::Text => {
                output::text(&report::power_text::text(&loaded.title, &found))?;
                if self.library.narrows() {
                    output::text(NARROWED)?;
                }
            }
        }
        verdict(&found.nominal)
    }

    /// Where the design stands: at a fit of its readings, else at what is stated.
    fn point(&self, problem: &Problem) -> Result<Point, Failure> {
        if problem.reading_count() > 0 {
            let measured = estimate_measured(problem)?;
            if measured.fit.is_sound() {
                self.tell_of_places(&measured.unplaced);
                return Ok(measured.point);
            }
        }
        self.tell_of_places(&planned::unplaced(problem, None));
        Ok(Point::stated(&problem.layout))
    }

    /// Warns of what has no stated place.
    fn tell_of_places(&self, unplaced: &[String]) {
        if !unplaced.is_empty() && !self.common.quiet {
            let message = format!(
                "no file states where {} stand: they are taken as zero",
                unplaced.join(", ")
            );
            let help = "state them: what a campaign can see depends on where things are, as in position = { value = [\"2 m\", \"0 m\", \"0.5 m\"] }";
            render::all(&[Diagnostic::warning(message).help(help)]);
        }
    }
}
