//! From what a user names (campaigns, effects, values) to a problem that can be evaluated.

use std::path::{Path, PathBuf};

use crate::campaign::calibration::InputSpread;
use crate::campaign::file::CampaignFile;
use crate::campaign::load::{Campaign, LoadOptions, MEMORY};
use crate::campaign::recorder::Store;
use crate::campaign::timing::enter::EFFECT;
use crate::diagnostic::{Diagnostic, Diagnostics, counted};
use crate::engine::part::Part;
use crate::engine::problem::Problem;
use crate::library::Library;
use crate::model::{Model, Override, Process};
use crate::progress::Progress;
use crate::system::Selected;

use self::agree::agree;
use self::elsewhere::refuse_elsewhere;
use self::set::{has_setup, held, in_setups, started, stated};

mod agree;
mod elsewhere;
mod recipe;
mod set;
mod still;

pub use recipe::Recipe;
pub use still::held_that_act;

/// What a user asks for.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Campaigns: folders or files.
    pub campaigns: Vec<PathBuf>,
    /// Effects over those that the campaigns name: `NAME`, or `NAME.HEAD`.
    pub with: Vec<String>,
    /// Folders with further effects.
    pub effects: Vec<PathBuf>,
    /// Campaigns that are read by themselves: effects beside them may be meant.
    pub beside: Vec<PathBuf>,
    /// `NAME=VALUE`, a value with its unit that holds exactly, or `NAME=VALUE~SIGMA`, one with its
    /// standard uncertainty; a vector's components separated by commas, or one of them as
    /// `NAME.z=VALUE`. `NAME@SETUP=VALUE` in one setup.
    pub set: Vec<String>,
    /// `NAME=VALUE`: where iteration starts.
    pub start: Vec<String>,
    /// Leave bad rows of data files out.
    pub skip_bad_rows: bool,
    /// Bytes of memory for the samples of all campaigns, see [`LoadOptions::memory`].
    pub memory: Option<u64>,
    /// Refuse files outside a campaign's folder, see [`LoadOptions::confined`].
    pub confined: bool,
    /// Show in messages what stands in such files, see [`LoadOptions::show_outside`].
    pub show_outside: bool,
    /// Who is told how far reading and estimates have come.
    pub progress: Progress,
}

impl Request {
    /// Just these campaigns.
    pub fn new<P: AsRef<Path>>(campaigns: impl IntoIterator<Item = P>) -> Self {
        let campaigns = campaigns.into_iter().map(|path| path.as_ref().to_path_buf()).collect();
        Self { campaigns, ..Self::default() }
    }
}

/// Campaigns with their models, ready for estimation.
#[derive(Clone, Debug)]
pub struct Opened {
    /// What is to be explained.
    pub problem: Problem,
    /// The campaigns, in the order asked for (their runs are in the problem).
    pub campaigns: Vec<Campaign>,
    /// Their models.
    pub models: Vec<Model>,
    /// What the user should look at.
    pub warnings: Vec<Diagnostic>,
    /// Names of the parameters that `set` stated everywhere.
    pub stated: Vec<String>,
    /// From what each campaign's model with effects was put together.
    pub recipes: Vec<Recipe>,
}

/// What to say of a campaign that was given before.
fn given_before(path: &Path, before: &[PathBuf], file: &CampaignFile) -> Option<Diagnostic> {
    let folder = |path: &Path| {
        let path = if path.is_dir() { path } else { path.parent()? };
        std::fs::canonicalize(path).ok()
    };
    let own = folder(path)?;
    before.iter().any(|other| folder(other).as_ref() == Some(&own)).then(|| {
        let message =
            format!("the campaign `{}` is given twice: its readings count twice", path.display());
        Diagnostic::warning(message).at(file.model.place.clone()).help("name each campaign once")
    })
}

/// Reads campaigns, models and effects, and puts them together.
///
/// # Errors
/// Every fault found in what the user gave.
pub fn open(request: &Request) -> Result<Opened, Diagnostics> {
    let set = request.set.iter().map(|text| stated(text));
    let set = set.chain(request.start.iter().map(|text| started(text)));
    let set = set.collect::<Result<Vec<_>, _>>()?;
    let mut store = Store::new(request.memory.unwrap_or(MEMORY));
    let mut campaigns = Vec::new();
    let mut warnings = Vec::new();
    let mut recipes = Vec::new();
    let files = request.campaigns.iter().map(|path| CampaignFile::read(path));
    let files = files.collect::<Result<Vec<_>, _>>()?;
    in_setups(&set, &files)?;
    let folders: Vec<PathBuf> = files.iter().map(|file| file.folder.clone()).collect();
    let folders = [folders, request.beside.clone()].concat();
    for (number, (path, file)) in request.campaigns.iter().zip(files).enumerate() {
        warnings.extend(given_before(path, &request.campaigns[..number], &file));
        let mut library =
            Library::builtin()?.confined(request.confined).with_effects_beside(&file.folder)?;
        for folder in &request.effects {
            library = library.with_effects_dir(folder)?;
        }
        let model = library.model(&file.model.text, &file.folder).map_err(|faults| {
            // A fault inside the model's file has its own place; a name that means nothing has not.
            Diagnostics(
                faults
                    .0
                    .into_iter()
                    .map(|fault| {
                        if fault.place.is_none() {
                            fault.at(file.model.place.clone())
                        } else {
                            fault
                        }
                    })
                    .collect(),
            )
        })?;
        let model = file.with_sigmas(model);
        let mut overrides: Vec<Override> = Vec::new();
        if let Some(timing) = &file.timing {
            library = library.with_effect(timing.effect()).map_err(|faults| {
                Diagnostics(
                    faults.0.into_iter().map(|fault| fault.at(timing.place.clone())).collect(),
                )
            })?;
            overrides.extend(timing.overrides(file.runs.iter().map(|run| &run.timing)));
        }
        overrides.extend(file.parameters.iter().cloned());
        let is_here =
            |one: &&Override| one.setup.as_ref().is_none_or(|name| has_setup(&file, name));
        let here: Vec<&Override> = set.iter().filter(is_here).collect();
        overrides.extend(here.iter().map(|one| (*one).clone()));
        refuse_elsewhere((path, &file), &library, &folders, (&request.with, &set))?;
        library.check_overrides(&model, &overrides)?;
        let selected = select(&library, &file, &request.with)?;
        overrides.truncate(overrides.len() - here.len());
        overrides.extend(here.into_iter().map(|one| held(one, &library, &selected)));
        let options = LoadOptions {
            skip_bad_rows: request.skip_bad_rows,
            confined: request.confined,
            show_outside: request.show_outside,
            progress: request.progress.clone(),
            ..LoadOptions::default()
        };
        let mut campaign = file.load_into(&mut store, &model, &options)?;
        warnings.append(&mut campaign.warnings);
        warnings.extend(left_out(&campaign));
        let input_sigma = campaign.input_sigma.clone();
        recipes.push(Recipe {
            library,
            model,
            effects: selected,
            overrides,
            input_sigma,
            held_delays: Vec::new(),
        });
        campaigns.push(campaign);
    }
    still::hold(&mut recipes, &campaigns)?;
    let mut parts = Vec::new();
    for (recipe, campaign) in recipes.iter().zip(&mut campaigns) {
        let system = recipe.with(&[])?;
        let runs = std::mem::take(&mut campaign.runs);
        let mut part =
            Part::new(system, campaign.setups.clone(), runs, campaign.measurand_sigma.clone());
        part.instrument.clone_from(&campaign.instrument);
        part.rig.clone_from(&campaign.rig);
        part.output.clone_from(&campaign.output);
        part.delay_range.clone_from(&campaign.delay_range);
        part.zero = campaign.zero;
        part.head_units.clone_from(&campaign.head_units);
        let left = |spread: &InputSpread| spread.calibration.map_or(0.0, |spread| spread.sigma);
        part.calibration = campaign.input_spread.iter().map(left).collect();
        parts.push(part);
    }
    let models = recipes.iter().map(|recipe| recipe.model.clone()).collect();
    let runs = || parts.iter().flat_map(|part: &Part| &part.runs);
    let first = runs().filter_map(|run| run.record.first_time()).fold(f64::INFINITY, f64::min);
    for run in parts.iter_mut().flat_map(|part| &mut part.runs) {
        run.record.set_start(first);
    }
    if parts.len() > 1 {
        for (part, label) in parts.iter_mut().zip(labels(&campaigns)) {
            part.label = Some(label);
        }
    }
    let everywhere = set.into_iter().filter(|said| said.setup.is_none() && said.value.is_some());
    let stated = everywhere.map(|said| said.name).collect();
    warnings.extend(agree(&parts, &recipes)?);
    let mut problem = Problem::new(parts);
    problem.progress = request.progress.clone();
    Ok(Opened { problem, campaigns, models, warnings, stated, recipes })
}

/// Rows listed in one warning.
const MOST_ROWS: usize = 12;

/// What is not used of a campaign's data, counted and listed.
fn left_out(campaign: &Campaign) -> Vec<Diagnostic> {
    let mut told = Vec::new();
    let count = campaign.skipped_count;
    if count > 0 {
        let rows =
            if count == 1 { "1 bad row is".to_owned() } else { format!("{count} bad rows are") };
        let mut warning = Diagnostic::warning(format!("{rows} left out of `{}`", campaign.name));
        for row in campaign.skipped.iter().take(MOST_ROWS) {
            warning = warning.help(format!("{}:{}: {}", row.file, row.row, row.reason));
        }
        if count > MOST_ROWS {
            warning = warning.help(format!("... and {} more", count - MOST_ROWS));
        }
        told.push(warning);
    }
    for one in &campaign.left_out {
        let are = if one.samples == 1 { "is" } else { "are" };
        told.push(Diagnostic::warning(format!(
            "run `{}`: {} {are} left out: {}",
            one.run,
            counted(one.samples, "sample"),
            one.why
        )));
    }
    told
}

/// Names that tell campaigns apart: their folders' names, numbered where they are alike.
fn labels(campaigns: &[Campaign]) -> Vec<String> {
    campaigns
        .iter()
        .enumerate()
        .map(|(index, campaign)| {
            let alike = campaigns.iter().filter(|other| other.name == campaign.name).count() > 1;
            if alike { format!("{}#{}", campaign.name, index + 1) } else { campaign.name.clone() }
        })
        .collect()
}

/// The effects a campaign names and those asked for, each once.
fn select(
    library: &Library,
    file: &CampaignFile,
    with: &[String],
) -> Result<Vec<Selected>, Diagnostics> {
    let mut selected: Vec<Selected> = Vec::new();
    let mut add = |one: Selected| {
        let known = selected
            .iter()
            .any(|other| other.effect.name == one.effect.name && other.head == one.head);
        if !known {
            selected.push(one);
        }
    };
    if file.timing.is_some() {
        add(library.select(EFFECT)?);
    }
    for name in &file.effects {
        add(library.select(&name.text).map_err(|faults| {
            Diagnostics(faults.0.into_iter().map(|fault| fault.at(name.place.clone())).collect())
        })?);
    }
    for name in with {
        add(library.select(name)?);
    }
    Ok(selected)
}

/// Random quantities that are correlated from sample to sample; no estimator here takes account of
/// them.
pub fn correlated(problem: &Problem) -> Vec<String> {
    let mut names: Vec<String> = problem
        .parts
        .iter()
        .flat_map(|part| &part.system.randoms)
        .filter(|random| random.process != Process::White)
        .map(|random| random.name.clone())
        .collect();
    names.dedup();
    names
}
