//! campaign.toml: what it says, with the place of everything, before any model is known.
//!
//! Reading goes in two steps, because the data are read against the model that the file names:
//! [`CampaignFile::read`], then [`CampaignFile::load`] (see [`super::load`]).

use std::path::{Path, PathBuf};

use indexmap::{IndexMap, IndexSet};

use crate::campaign::declared::{InputOverride, MeasurandOverride, RunEntry};
use crate::campaign::delay_range::DelayRange;
use crate::campaign::output;
use crate::campaign::overrides;
use crate::campaign::plan;
use crate::campaign::run::Role;
use crate::campaign::specification::Specification;
use crate::campaign::statement;
use crate::campaign::timing::{self, Timing};
use crate::campaign::{lines, table_entry, words};
use crate::diagnostic::{Diagnostic, Diagnostics, Source, Span};
use crate::document::entries::{Entry, Item, Named, Reader, Value, get};
use crate::document::files::{Files, Input, reason};
use crate::document::{text, withhold};
use crate::model::Override;
use crate::units::DisplayUnits;

/// Largest campaign.toml that is read, in bytes, unpacked if it is packed.
pub const MOST_BYTES: usize = 1 << 20;

const KEYS: [&str; 16] = [
    "title",
    "model",
    "instrument",
    "rig",
    "effects",
    "metadata",
    "parameters",
    "setups",
    "inputs",
    "measurands",
    "specification",
    "runs",
    "delay_range",
    "output",
    "timing",
    "truth",
];
const RUN_KEYS: [&str; 9] =
    ["name", "setup", "role", "data", "signals", "columns", "inputs", "plan", "timing"];

/// A campaign file, read and checked for form.
#[derive(Clone, Debug)]
pub struct CampaignFile {
    /// Folder of the file; data paths are relative to it.
    pub folder: PathBuf,
    /// The file.
    pub path: PathBuf,
    /// `title` (empty if not said).
    pub title: String,
    /// `model`: a name in the library, or a path relative to [`CampaignFile::folder`].
    pub model: Named,
    /// `instrument`.
    pub instrument: Option<String>,
    /// `rig`.
    pub rig: Option<String>,
    /// `effects`.
    pub effects: Vec<Named>,
    /// `[metadata]`.
    pub metadata: serde_json::Value,
    /// `[parameters]`, then what `[setups.NAME]` say over them.
    pub parameters: Vec<Override>,
    /// `[inputs]`.
    pub inputs: Vec<InputOverride>,
    /// `[measurands]`.
    pub measurands: Vec<MeasurandOverride>,
    /// `[specification]`.
    pub specification: Specification,
    /// `[output]`: units of results.
    pub output: DisplayUnits,
    /// `delay_range`.
    pub delay_range: Option<DelayRange>,
    /// `[timing]`.
    pub timing: Option<Timing>,
    /// `[[runs]]`.
    pub runs: Vec<RunEntry>,
    pub(crate) reader: Reader,
    /// Its files: those read so far.
    pub(crate) files: Files,
}

/// Whether a file is called as the tables of runs are.
fn is_table(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase());
    let ends = |name: &str| [".csv", ".csv.gz", ".parquet"].iter().any(|end| name.ends_with(end));
    path.is_file() && name.is_some_and(|name| ends(&name))
}

impl CampaignFile {
    /// Reads `campaign.toml`, given the file or its folder.
    ///
    /// # Errors
    /// Everything that is wrong with its form: not there, not TOML, unknown keys, wrong types,
    /// units that are none, repeated runs, no run. What needs the model is checked on loading.
    pub fn read(path: &Path) -> Result<Self, Diagnostics> {
        if is_table(path) {
            let message = format!("`{}` is a table of readings, not a campaign", path.display());
            let help = "a campaign.toml beside it names the model and the runs, each with its table: data = \"run.csv\" (docs/formats.md, section 4)";
            return Err(Diagnostic::error(message).help(help).into());
        }
        let path = if path.is_dir() { path.join("campaign.toml") } else { path.to_owned() };
        let mut files = Files::of(path.parent().unwrap_or(Path::new("")));
        let failed = |error: std::io::Error| {
            let named = path.with_extension("toml");
            let help = match named != path && named.is_file() {
                true => format!("did you mean `{}`?", named.display()),
                false => "name a campaign's folder, or its campaign.toml".to_owned(),
            };
            Diagnostics::from(Diagnostic::error(reason(&path, &error)).help(help))
        };
        let Input { file, is_outside, .. } = files.open(&path).map_err(failed)?;
        let bytes = lines::read_bytes(file, MOST_BYTES).map_err(failed)?;
        let source = text(&path, bytes, is_outside, MOST_BYTES)?;
        let help = "name the file itself, not a link to it: then it is shown";
        Self::of(&path, source.clone(), files).map_err(|faults| withhold(&source, faults, help))
    }

    /// Reads the text of a campaign file that stands (or will stand) at `path`.
    ///
    /// # Errors
    /// As for [`CampaignFile::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, Diagnostics> {
        let source = Source::new(path.display().to_string(), text);
        Self::of(path, source, Files::of(path.parent().unwrap_or(Path::new(""))))
    }

    fn of(path: &Path, source: Source, files: Files) -> Result<Self, Diagnostics> {
        let (mut reader, entries) = Reader::parse(source)?;
        for (key, what) in [("quantities", "a model"), ("patch", "an effect")] {
            if let (Some(item), None) = (get(&entries, key), get(&entries, "model")) {
                let told = format!("`{}` is {what}, not a campaign", path.display());
                let help = "a campaign names its model and its runs (docs/formats.md, section 4); `homepoint check` reads models and effects";
                return Err(Diagnostic::error(told).at(reader.place(item.span)).help(help).into());
            }
        }
        reader.only(&entries, &KEYS);
        let text = |reader: &mut Reader, key| {
            get(&entries, key).and_then(|item| reader.text(item, &format!("{key} = \"...\"")))
        };
        let model = get(&entries, "model").and_then(|item| named(&mut reader, item));
        let model = model.unwrap_or_else(|| {
            if get(&entries, "model").is_none() {
                let help = "name a model of the library or a file: model = \"polar_one_rotation\"";
                reader.fault(Span::default(), "the campaign names no model", help);
            }
            Named {
                text: String::new(),
                span: Span::default(),
                place: reader.place(Span::default()),
            }
        });
        let table = |reader: &mut Reader, key: &str| match get(&entries, key) {
            Some(item) => reader.table(item, &format!("[{key}]")).to_vec(),
            None => Vec::new(),
        };
        let effects = get(&entries, "effects").map(|item| {
            let texts = reader.texts(item, "effects = [\"encoder_eccentricity\"]");
            texts.into_iter().map(|(text, span)| place(&reader, text, span)).collect()
        });
        let delay_range =
            get(&entries, "delay_range").and_then(|item| DelayRange::read(&mut reader, item));
        let timing =
            get(&entries, "timing").and_then(|item| timing::read::timing(&mut reader, item));
        let parameters = table(&mut reader, "parameters");
        let setups = table(&mut reader, "setups");
        let inputs = table(&mut reader, "inputs");
        let measurands = table(&mut reader, "measurands");
        let metadata = table(&mut reader, "metadata");
        let specification = table(&mut reader, "specification");
        let timed = get(&entries, "timing").is_some();
        let output = table(&mut reader, "output");
        let runs = runs(&mut reader, get(&entries, "runs"), timed);
        let mut parameters = overrides::read(&mut reader, &parameters);
        let known: IndexSet<&str> = runs.iter().map(|run| run.setup.as_str()).collect();
        let known: Vec<&str> = known.into_iter().collect();
        parameters.extend(overrides::of_setups(&mut reader, &setups, &known));
        overrides::hand_on(&mut parameters, &known);
        let this = Self {
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            path: path.to_owned(),
            title: text(&mut reader, "title").unwrap_or_default(),
            model,
            instrument: text(&mut reader, "instrument"),
            rig: text(&mut reader, "rig"),
            effects: effects.unwrap_or_default(),
            metadata: metadata
                .iter()
                .map(|entry| (entry.key.clone(), entry.item.to_json()))
                .collect::<serde_json::Map<_, _>>()
                .into(),
            parameters,
            inputs: inputs.iter().map(|entry| input(&mut reader, entry)).collect(),
            measurands: measurands.iter().map(|entry| measurand(&mut reader, entry)).collect(),
            specification: Specification::read(&mut reader, &specification),
            output: output::read(&mut reader, &output),
            delay_range,
            timing,
            runs,
            reader: Reader::new(reader.source.clone()),
            files,
        };
        reader.result()?;
        Ok(this)
    }
}

fn place(reader: &Reader, text: String, span: Span) -> Named {
    Named { text, span, place: reader.place(span) }
}

fn named(reader: &mut Reader, item: &Item) -> Option<Named> {
    let text = reader.text(item, "\"...\"")?;
    Some(place(reader, text, item.span))
}

fn key(reader: &Reader, entry: &Entry) -> Named {
    place(reader, entry.key.clone(), entry.span)
}

fn input(reader: &mut Reader, entry: &Entry) -> InputOverride {
    let entries = reader.table(&entry.item, "arm_angle = { sigma = \"0.2 arcsec\" }");
    reader.only(entries, &["sigma", "resolution", "calibration", "smooth", "period"]);
    InputOverride {
        name: key(reader, entry),
        sigma: get(entries, "sigma").cloned(),
        resolution: get(entries, "resolution").cloned(),
        calibration: get(entries, "calibration").cloned(),
        smooth: get(entries, "smooth").cloned(),
        period: get(entries, "period").cloned(),
    }
}

fn measurand(reader: &mut Reader, entry: &Entry) -> MeasurandOverride {
    let entries = reader.table(&entry.item, "horizontal = { sigma = \"1.5 arcsec\" }");
    reader.only(entries, &statement::KEYS);
    let sigma = get(entries, "sigma").and_then(|item| reader.formula(item));
    MeasurandOverride { name: key(reader, entry), said: entries.to_vec(), sigma }
}

/// The runs; with `timed`, the campaign has a `[timing]`.
fn runs(reader: &mut Reader, item: Option<&Item>, timed: bool) -> Vec<RunEntry> {
    let Some(item) = item else {
        reader.fault(
            Span::default(),
            "the campaign has no run",
            "add one: [[runs]], then name = \"slow\" and data = \"slow.csv\" (or a plan)",
        );
        return Vec::new();
    };
    let Value::List(items) = &item.value else {
        reader.fault(item.span, "expected a list of runs", "write each run as [[runs]]");
        return Vec::new();
    };
    if items.is_empty() {
        reader.fault(item.span, "the campaign has no run", "add one as [[runs]]");
    }
    let mut seen: IndexMap<String, usize> = IndexMap::new();
    let mut found = Vec::new();
    for item in items {
        let Some(run) = run(reader, item) else {
            continue;
        };
        if let (Some(item), false) = (run_timing(item), timed) {
            let help = "write it once for all runs: [timing], then method = \"trigger\"";
            reader.fault(item.span, "the campaign has no [timing]", help);
        }
        let line = run.name.place.line;
        if let Some(before) = seen.insert(run.name.text.clone(), line) {
            let message = format!("two runs are called `{}`", run.name.text);
            reader.fault(run.name.span, message, format!("the other is in line {before}"));
        }
        found.push(run);
    }
    found
}

fn run(reader: &mut Reader, item: &Item) -> Option<RunEntry> {
    let entries = reader.table(item, "[[runs]]");
    if entries.is_empty() {
        if matches!(item.value, Value::Table(_)) {
            reader.fault(item.span, "the run has no name", "write name = \"slow\"");
        }
        return None;
    }
    reader.only(entries, &RUN_KEYS);
    let name = match get(entries, "name") {
        Some(item) => named(reader, item)?,
        None => {
            reader.fault(item.span, "the run has no name", "write name = \"slow\"");
            return None;
        }
    };
    let role = match get(entries, "role")
        .and_then(|item| Some((reader.text(item, "role = \"reference\"")?, item)))
    {
        None => Role::Kinematic,
        Some((text, _)) if text == "kinematic" => Role::Kinematic,
        Some((text, _)) if text == "reference" => Role::Reference,
        Some((text, item)) => {
            reader.unknown(item.span, "role", &text, &["reference", "kinematic"]);
            Role::Kinematic
        }
    };
    let signals = get(entries, "signals").map(|item| table_entry::list(reader, item));
    let plan = get(entries, "plan").map(|item| plan::read(reader, item));
    let data = get(entries, "data")
        .and_then(|item| table_entry::read(reader, item, "data = \"slow.csv\""));
    match (get(entries, "data"), get(entries, "plan")) {
        (None, None) => {
            let message = format!("run `{}` has neither data nor a plan", name.text);
            reader.fault(name.span, message, "write data = \"slow.csv\", or plan = { ... }");
        }
        (Some(_), Some(plan)) => {
            let message = format!("run `{}` has data and a plan", name.text);
            reader.fault(plan.span, message, "a run is measured or planned: keep one");
        }
        _ => {}
    }
    if let (Some(item), Some(_)) = (get(entries, "signals"), get(entries, "plan")) {
        reader.fault(item.span, "a planned run has no streams yet", "leave `signals` out");
    }
    let timing = get(entries, "timing").map(|item| timing::read::run(reader, item));
    if let (Some(item), true) = (
        timing.as_ref().and_then(|timing| timing.captures.as_ref()),
        get(entries, "plan").is_some(),
    ) {
        reader.fault(item.span, "a planned run has no captures yet", "leave `captures` out");
    }
    let setup = get(entries, "setup").and_then(|item| reader.text(item, "setup = \"A\""));
    let columns = get(entries, "columns").map(|item| words::read(reader, item));
    let inputs = get(entries, "inputs").map(|item| {
        let entries = reader.table(item, "inputs = { temperature = \"20.1 degC\" }");
        let read = |entry: &Entry| Some((key(reader, entry), reader.quantity(&entry.item)?));
        entries.iter().filter_map(read).collect::<Vec<_>>()
    });
    Some(RunEntry {
        name,
        setup: setup.unwrap_or_else(|| "A".to_owned()),
        role,
        data,
        signals: signals.unwrap_or_default(),
        columns: columns.unwrap_or_default(),
        inputs: inputs.unwrap_or_default(),
        plan: plan.unwrap_or_default(),
        timing: timing.unwrap_or_default(),
    })
}

/// What a run says of its timing, as written.
fn run_timing(item: &Item) -> Option<&Item> {
    let Value::Table(entries) = &item.value else { return None };
    get(entries, "timing")
}
