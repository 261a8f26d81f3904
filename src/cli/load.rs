//! What a command works on: campaigns read, warnings told, names for the result.

use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::arguments::{CampaignArguments, Format};
use super::leave_out::leave_out;
use super::{Failure, clean, output, progress, render};
use crate::campaign::declared::RunEntry;
use crate::campaign::load::Campaign;
use crate::convention::Convention;
use crate::diagnostic::{Diagnostic, Span};
use crate::document::files::Files;
use crate::engine::open::{Opened, Recipe, Request, correlated, open};
use crate::engine::{Point, Problem};
use crate::estimate::checks;
use crate::estimate::conventions::{Mistaken, mistaken};
use crate::estimate::minima::{Found, MOST, improved};
use crate::estimate::start::start;
use crate::graph::Kind;
use crate::library::{self, effect_files};
use crate::model::Model;
use crate::report;
use crate::units::decimal;

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

/// Reads campaigns as the arguments say, and tells warnings.
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

/// Reads everything and tells warnings.
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

/// Refuses a standard uncertainty stated as a formula that is no positive number for some reading.
pub(super) fn refuse_impossible_sigma(problem: &Problem, at: &Point) -> Result<(), Failure> {
    let Some((p, run, sample, m, sigma)) = problem.impossible_sigma(at) else {
        return Ok(());
    };
    let part = &problem.parts[p];
    let (run, one) = (&part.runs[run], &part.system.assembly.names.measurands[m]);
    let found = report::figure::size(sigma, &one.unit);
    let message = format!(
        "the standard uncertainty of `{}` is {found} in run `{}`, row {}: expected a number above zero",
        one.name,
        run.name,
        run.record.row(sample)
    );
    let formula = one.sigma.as_ref();
    let place = formula.map(|formula| {
        formula.source.place(Span::new(formula.offset, formula.offset + formula.text.len()))
    });
    let error = Diagnostic::error(message).at_maybe(place.as_ref());
    Err(error.help("see its formula and, where it names a column, that cell; leave the reading empty if it is not to count").into())
}

/// Says that another start than the stated one was taken, of a problem with attitudes to look for or
/// without.
fn started(found: &Found, has_attitudes: bool) -> Diagnostic {
    let [own, best] = found.variance_factors.map(|factor| decimal(factor, 1));
    let [from, to] = found.offsets;
    let tried = match to - from {
        // One offset, in several attitudes.
        0.0 if has_attitudes => {
            format!("tried was one offset, {} s, in {} attitudes", decimal(from, 1), found.tried)
        }
        0.0 => format!("tried was one offset, {} s", decimal(from, 1)),
        width => {
            let attitudes = if has_attitudes { " and several attitudes" } else { "" };
            let [from, to] = [from, to].map(|at| decimal(at, if width < 1.0 { 3 } else { 1 }));
            format!("tried were offsets from {from} to {to} s{attitudes}")
        }
    };
    let offset = decimal(found.offset, 3);
    let of = found.delay.as_ref().map(|delay| format!(" (`{delay}`)")).unwrap_or_default();
    let known = found.variance_factors[0].is_finite();
    let message = if let Some(most) = found.most {
        let [own, best] = most.map(|residual| decimal(residual, 1));
        format!(
            "the stated start fits badly; of {} others the one with clocks {offset} s apart{of} fits {} % of the samples far better (normalized residuals up to {best}, {own} from the stated start): the fit starts there",
            found.tried,
            decimal(100.0 * MOST, 0)
        )
    } else if known {
        format!(
            "the stated start fits badly (variance factor {own}); of {} others the one with clocks {offset} s apart{of} fits far better ({best}): the fit starts there",
            found.tried
        )
    } else {
        format!(
            "of {} starts within `delay_range` the one with clocks {offset} s apart{of} fits best (variance factor {best}): the fit starts there",
            found.tried
        )
    };
    let rotations = if has_attitudes { " and rotations" } else { "" };
    let mut warning = Diagnostic::warning(message).help(format!(
        "{tried}; state a `start` of delays{rotations}, or `delay_range`, to look elsewhere"
    ));
    if found.attitudes_left_out > 0 {
        warning = warning.help(format!(
            "{} combinations of attitudes were not tried, there are too many: state a `start` of those that are known",
            found.attitudes_left_out
        ));
    }
    if found.left_out > 0 {
        warning = warning.help(format!(
            "{} left out, for which no stream is there at this offset",
            match found.left_out {
                1 => "1 sample is".to_owned(),
                several => format!("{several} samples are"),
            }
        ));
    }
    warning
}

/// Warns of values that are stated of effects which are not in the model. Where the library is
/// tried, constants and members of families say what to look for: of other values those that are
/// found count.
pub(super) fn tell_not_put_in(loaded: &Loaded, tries: bool) {
    let Some(recipe) = loaded.recipes.first().filter(|_| !loaded.quiet) else { return };
    let told = loaded.stated.iter().filter_map(|name| {
        let (owner, value) = name.split_once('.')?;
        let effect = recipe.library.effects().find(|effect| effect.name == owner)?;
        let value = value.rsplit('.').next()?;
        let is_free = effect.parameters.iter().any(|one| one.name == value && !one.setting.fixed);
        if recipe.effects.iter().any(|one| one.effect.name == owner) || (tries && !is_free) {
            return None;
        }
        let message = format!("`{name}` is stated, but that effect is not put in");
        let help = format!("put it into the model: --with {owner}");
        Some(Diagnostic::warning(message).help(help))
    });
    render::all(&told.collect::<Vec<_>>());
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

/// Whether all samples could be read back from where they were kept: results are good for nothing
/// otherwise.
pub(super) fn read_back(problem: &Problem) -> io::Result<()> {
    let mut runs = problem.parts.iter().flat_map(|part| &part.runs);
    let lost = runs.find_map(|run| Some((&run.name, run.record.fault()?)));
    lost.map_or(Ok(()), |(name, why)| {
        let message = format!("run `{name}` cannot be read back from its temporary file: {why}");
        Err(io::Error::other(message))
    })
}

/// The same, as the end of a command.
pub(super) fn trust(problem: &Problem) -> Result<(), Failure> {
    read_back(problem).map_err(|error| Failure::Could(error.to_string()))
}

/// Says that nothing moves, for a command that asks for delays; `None` where something does.
pub(super) fn nothing_moves(loaded: &Loaded, format: Format) -> Option<Result<(), Failure>> {
    if loaded.problem.moves() {
        return None;
    }
    Some(match format {
        Format::Json => {
            let mut whole = loaded.head.clone();
            merge(&mut whole, json!({ "nothing_moves": true }));
            output::json(&whole)
        }
        Format::Text => output::text(&format!(
            "{}\n\n{} `homepoint calibrate` estimates everything else.\n",
            loaded.title,
            report::text::NOTHING_MOVES
        )),
    })
}

/// Refuses what estimators cannot take account of.
pub(super) fn refuse_correlated(problem: &Problem) -> Result<(), Failure> {
    let names = correlated(problem);
    if names.is_empty() {
        return Ok(());
    }
    let names = names.join("`, `");
    Err(Diagnostic::error(format!(
        "`{names}` is correlated from reading to reading, which this estimate does not take account of"
    ))
    .help("leave the effect out; `simulate` can put it in")
    .into())
}

/// The file name of a campaign's table.
pub(super) fn table_name(what: &str, labels: &[String], part: usize) -> String {
    match labels.len() {
        1 => format!("{what}.csv"),
        _ => format!("{what}_{}.csv", labels[part].replace(['/', '\\'], "_")),
    }
}

/// Refuses campaigns without readings.
pub(super) fn refuse_empty(problem: &Problem) -> Result<(), Failure> {
    if problem.reading_count() > 0 {
        return Ok(());
    }
    Err(Diagnostic::error("there are no readings to estimate from: all runs are planned or empty")
        .help("`homepoint simulate` draws readings from a plan")
        .into())
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
