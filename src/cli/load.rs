//! What a command works on: campaigns read, warnings printed, names for the result.

pub(super) mod notices;
pub(super) mod refusals;
mod started;

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::arguments::CampaignArguments;
use super::leave_out::leave_out;
use super::{Failure, clean, progress, render};
use crate::campaign::declared::RunEntry;
use crate::campaign::load::Campaign;
use crate::convention::Convention;
use crate::diagnostic::Diagnostic;
use crate::document::files::Files;
use crate::engine::open::{Opened, Recipe, Request, open};
use crate::engine::{Point, Problem};
use crate::estimate::checks;
use crate::estimate::conventions::{Mistaken, mistaken};
use crate::estimate::minima::improved;
use crate::estimate::start::start;
use crate::graph::Kind;
use crate::library::{self, effect_files};
use crate::model::Model;
use crate::report;
use refusals::refuse_impossible_sigma;
use started::started;

/// Campaigns, ready.
pub(super) struct Loaded {
    pub(super) problem: Problem,
    pub(super) campaigns: Vec<Campaign>,
    pub(super) models: Vec<Model>,
    /// Name of each campaign in the result.
    pub(super) labels: Vec<String>,
    /// Title of each campaign.
    pub(super) titles: Vec<String>,
    /// One line for all of them.
    pub(super) title: String,
    /// What programs may want to know of them.
    pub(super) about: Value,
    /// Parameters that `--set` stated.
    pub(super) stated: Vec<String>,
    /// From what each campaign's model with effects was put together.
    pub(super) recipes: Vec<Recipe>,
    /// What a result for programs begins with: that, and what was warned of.
    pub(super) head: Value,
    /// Whether warnings are to be left out.
    pub(super) quiet: bool,
    /// All files that were read.
    pub(super) files: Files,
    /// The conventions that may have been mistaken.
    conventions: Vec<Convention>,
    /// The problem before another start was looked for, if one was found.
    as_opened: Option<Problem>,
}

/// The runs of the first campaign as its file has them.
pub(super) fn runs(campaigns: &[Campaign]) -> &[RunEntry] {
    campaigns.first().map_or(&[], |campaign| &campaign.entries)
}

impl Loaded {
    /// Refuses, before anything is computed, to write tables over files that were read.
    pub(super) fn keep_files<T: AsRef<Path>>(
        &self,
        out: Option<&PathBuf>,
        tables: impl IntoIterator<Item = T>,
    ) -> Result<(), Failure> {
        let Some(folder) = out else { return Ok(()) };
        for table in tables {
            self.files.refuse_replacing(&folder.join(table))?;
        }
        Ok(())
    }

    /// The names of the tables of all campaigns.
    pub(super) fn tables(&self, what: &str) -> impl Iterator<Item = String> {
        (0..self.labels.len()).map(move |part| table_name(what, &self.labels, part))
    }
}

/// Reads campaigns as the arguments say, and prints warnings.
pub(super) fn read(
    arguments: &CampaignArguments,
    campaigns: &[PathBuf],
) -> Result<Opened, Failure> {
    let mut request = Request::new(campaigns);
    request.with.clone_from(&arguments.with);
    request.effects.clone_from(&arguments.effects);
    request.beside.clone_from(&arguments.campaigns);
    request.set.clone_from(&arguments.set);
    request.start.clone_from(&arguments.start);
    request.skip_bad_rows = arguments.skip_bad_rows;
    request.confined = arguments.confined;
    request.show_outside = arguments.show_outside;
    request.progress = progress::shown(arguments.quiet);
    request.memory = Some(arguments.memory.for_samples());
    let mut opened = open(&request)?;
    opened.warnings.extend(checks::check(&opened.problem));
    if !arguments.quiet {
        render::all(&opened.warnings);
    }
    Ok(opened)
}

/// Reads everything and prints warnings.
pub(super) fn load(arguments: &CampaignArguments) -> Result<Loaded, Failure> {
    if let Some(out) = arguments.out.as_ref().filter(|out| out.is_file()) {
        let message = format!("`--out {}` is a file", out.display());
        return Err(Diagnostic::error(message).help("name a folder for the tables").into());
    }
    let mut opened = read(arguments, &arguments.campaigns)?;
    let folders = opened.campaigns.iter().map(|campaign| campaign.folder.as_path());
    let conventions = library::conventions(folders)?;
    for file in &arguments.leave_out {
        leave_out(&mut opened.problem, file)?;
    }
    let repeated = checks::repeated(&opened.problem);
    if !arguments.quiet {
        render::all(&repeated);
    }
    opened.warnings.extend(repeated);
    let as_opened = opened.problem.clone();
    let (problem, found) = improved(opened.problem);
    opened.problem = problem;
    let as_opened = (!found.is_empty()).then_some(as_opened);
    let instances = &opened.problem.layout.instances;
    let turns = instances.iter().any(|one| one.kind == Kind::Rotation && !one.setting.fixed);
    let started: Vec<Diagnostic> = found.iter().map(|found| started(found, turns)).collect();
    if !arguments.quiet {
        render::all(&started);
    }
    opened.warnings.extend(started);
    refuse_impossible_sigma(&opened.problem, &start(&opened.problem).0)?;
    let labels: Vec<String> = opened
        .problem
        .parts
        .iter()
        .zip(&opened.campaigns)
        .map(|(part, campaign)| part.label.clone().unwrap_or_else(|| campaign.name.clone()))
        .collect();
    let mut files = Files::default();
    opened.campaigns.iter().for_each(|campaign| files.extend(&campaign.files));
    arguments.leave_out.iter().for_each(|file| files.note(file));
    for folder in &arguments.effects {
        effect_files(folder)?.iter().for_each(|file| files.note(file));
    }
    let titles: Vec<String> =
        opened.campaigns.iter().map(|campaign| clean::line(&campaign.title)).collect();
    let warnings: Vec<String> = opened.warnings.into_iter().map(|one| one.message).collect();
    let about: Value = labels
        .iter()
        .zip(&opened.campaigns)
        .map(|(label, campaign)| {
            json!({
                "name": label,
                "title": campaign.title,
                "model": campaign.model.text,
                "metadata": campaign.metadata,
                "timing": report::timing::json(campaign),
                "rows_left_out": campaign
                    .skipped
                    .iter()
                    .map(|row| json!({ "file": &*row.file, "row": row.row, "why": row.reason }))
                    .collect::<Vec<_>>(),
            })
        })
        .collect();
    Ok(Loaded {
        title: titles.join("; "),
        problem: opened.problem,
        campaigns: opened.campaigns,
        models: opened.models,
        labels,
        titles,
        head: json!({ "campaigns": about, "warnings": warnings }),
        about,
        stated: opened.stated,
        recipes: opened.recipes,
        quiet: arguments.quiet,
        files,
        conventions,
        as_opened,
    })
}

impl Loaded {
    /// What is needed to ask which conventions were mistaken, apart from the rest.
    pub(super) fn suspicion(&mut self) -> Suspicion {
        let conventions = std::mem::take(&mut self.conventions);
        Suspicion { conventions, as_opened: self.as_opened.take() }
    }
}

/// What is asked where a problem fits badly.
pub(super) struct Suspicion {
    conventions: Vec<Convention>,
    /// The problem before another start was looked for, which a mistaken convention may mislead.
    as_opened: Option<Problem>,
}

impl Suspicion {
    /// The conventions that were mistaken, beside where the fit ended.
    pub(super) fn mistaken(&self, problem: &Problem, fitted: &Point) -> Option<Mistaken> {
        let of = |problem: &Problem| mistaken(problem, Some(fitted), &self.conventions);
        let before = self.as_opened.as_ref().and_then(of);
        let all = before.into_iter().chain(of(problem));
        all.min_by(|a, b| a.without_outliers[1].total_cmp(&b.without_outliers[1]))
    }
}

/// The file name of a campaign's table.
pub(super) fn table_name(what: &str, labels: &[String], part: usize) -> String {
    match labels.len() {
        1 => format!("{what}.csv"),
        _ => format!("{what}_{}.csv", labels[part].replace(['/', '\\'], "_")),
    }
}

/// Adds the keys of one object to another.
pub(super) fn merge(into: &mut Value, from: Value) {
    if let (Value::Object(into), Value::Object(from)) = (into, from) {
        into.extend(from);
    }
}

/// Puts one campaign's result into the whole: at the top if it is the only one, else under
/// `by_campaign`.
pub(super) fn put(whole: &mut Value, label: &str, labels: usize, value: Value) {
    if labels == 1 {
        merge(whole, value);
    } else if let Value::Object(map) = whole {
        let by_campaign = map.entry("by_campaign").or_insert_with(|| json!({}));
        merge(by_campaign, json!({ label: value }));
    }
}
