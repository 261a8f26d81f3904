//! Writes a campaign of the same form: campaign.toml and a CSV a run, in the model's units.
//!
//! Files are whole or not at all: written beside their place and then renamed. Streams are copied.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::campaign::declared::{ColumnWord, RunEntry, TableEntry};
use crate::campaign::header::{Choice, Column};
use crate::campaign::loaded::Campaign;
use crate::campaign::run::{Role, Run};
use crate::campaign::table::open::columns_in;
use crate::campaign::whole::{WholeFile, write_whole};
use crate::campaign::write_run::RunTable;
use crate::diagnostic::{Diagnostic, Diagnostics, Source};
use crate::document::files::open_regular;
use crate::effect::Effect;
use crate::library::{effect_files, is_model_path, model_file};
use crate::model::parameter::SCOPES;
use crate::model::{Model, Override};
use crate::units::Unit;

/// Writes a campaign with other runs (simulated ones) into a folder, which is made if need be.
///
/// `runs` are in the order of the campaign's own; constants of runs stay in campaign.toml, streams
/// are copied beside it. What the user should look at is returned.
///
/// # Errors
/// The disk's; those of [`check_targets`].
pub fn write_campaign(
    folder: &Path,
    campaign: &Campaign,
    model: &Model,
    runs: &[Run],
) -> io::Result<Vec<Diagnostic>> {
    write_campaign_with(folder, campaign, model, runs, &mut |run, table| {
        runs[run].record.try_walk(|stretch| table.write(stretch, None))
    })
}

/// The same with other readings: `fill` writes the table of each run, by its index.
///
/// # Errors
/// As for [`write_campaign`].
pub fn write_campaign_with(
    folder: &Path,
    campaign: &Campaign,
    model: &Model,
    runs: &[Run],
    fill: &mut dyn FnMut(usize, &mut RunTable) -> io::Result<()>,
) -> io::Result<Vec<Diagnostic>> {
    let targets = Targets::of(folder, campaign, runs).map_err(io::Error::other)?;
    fs::create_dir_all(folder)?;
    for (place, text) in &targets.declarations {
        let place = folder.join(place);
        place.parent().map_or(Ok(()), fs::create_dir_all)?;
        write_whole(&place, text.as_bytes())?;
    }
    let mut warnings = Vec::new();
    for (index, (run, file)) in runs.iter().zip(&targets.tables).enumerate() {
        let timing = campaign.timing.as_ref().zip(campaign.entries.get(index));
        let replies = campaign.request_to_reply.iter().find(|one| one.run == run.name);
        let capturing = timing.map(|(timing, entry)| timing.capturing(&entry.timing, replies));
        let path = folder.join(file);
        let mut table = RunTable::create_captured(&path, model, &run.record, capturing)?;
        table.count_from(campaign.zero);
        fill(index, &mut table)?;
        warnings.extend(table.finish()?.into_iter().map(|gap| gap.warning(&run.name)));
    }
    for (stream, name) in &targets.streams {
        let mut file = WholeFile::create(&folder.join(name))?;
        io::copy(&mut open_regular(&campaign.folder.join(stream))?, &mut file)?;
        file.finish()?;
    }
    let Targets { tables, streams, .. } = &targets;
    write_campaign_toml(&folder.join(CAMPAIGN), campaign, model, runs, tables, streams)?;
    Ok(warnings)
}

/// Whether a campaign can be written into a folder.
///
/// # Errors
/// A file that the campaign reads would be replaced; a file that would be copied is a link that
/// leads out of the campaign's folder.
pub fn check_targets(folder: &Path, campaign: &Campaign, runs: &[Run]) -> Result<(), Diagnostics> {
    Targets::of(folder, campaign, runs).map(drop)
}

const CAMPAIGN: &str = "campaign.toml";

/// The files of a written campaign, by their places in its folder.
struct Targets {
    /// The table of each run.
    tables: Vec<String>,
    /// Streams as the campaign names them, with their names there.
    streams: Vec<(String, String)>,
    /// The campaign's own model and the effects beside it, with their texts.
    declarations: Vec<(PathBuf, Arc<str>)>,
}

impl Targets {
    fn of(folder: &Path, campaign: &Campaign, runs: &[Run]) -> Result<Self, Diagnostics> {
        let tables = file_names(runs);
        let mut streams: Vec<(String, String)> = Vec::new();
        for stream in campaign.entries.iter().flat_map(|entry| &entry.signals) {
            let stream = &stream.name;
            if streams.iter().any(|(from, _)| *from == stream.text) {
                continue;
            }
            let base = Path::new(&stream.text)
                .file_name()
                .map_or("stream.csv".into(), |n| n.to_string_lossy());
            let taken = |name: &str| {
                tables.iter().any(|f| f == name) || streams.iter().any(|(_, to)| to == name)
            };
            let name = free_name(&base, taken);
            refuse_link(campaign, &campaign.folder.join(&stream.text))?;
            streams.push((stream.text.clone(), name));
        }
        let declarations = declarations(campaign)?;
        let places = declarations.iter().map(|(place, _)| folder.join(place));
        let names = tables.iter().chain(streams.iter().map(|(_, name)| name));
        let all = places.chain(names.map(|name| folder.join(name)));
        for target in all.chain([folder.join(CAMPAIGN)]) {
            campaign.files.refuse_replacing(&target)?;
        }
        Ok(Self { tables, streams, declarations })
    }
}

/// Refuses to copy what a link shows of a place outside the campaign's folder.
fn refuse_link(campaign: &Campaign, path: &Path) -> Result<(), Diagnostic> {
    if !campaign.files.is_linked_outside(path) {
        return Ok(());
    }
    let message = format!("`{}` is a link that leads out of the campaign's folder", path.display());
    Err(Diagnostic::error(message)
        .help("no such file is copied: put the file itself in the place of the link"))
}

/// Writes campaign.toml for runs that stand in `files`; `copies` says where streams went.
///
/// # Errors
/// The disk's.
pub fn write_campaign_toml(
    path: &Path,
    campaign: &Campaign,
    model: &Model,
    runs: &[Run],
    files: &[String],
    copies: &[(String, String)],
) -> io::Result<()> {
    let mut text = String::new();
    let mut line = |words: String| {
        text.push_str(&words);
        text.push('\n');
    };
    line(format!("title = {}", quoted(&campaign.title)));
    line(format!("model = {}", quoted(&model_reference(campaign).0)));
    for (key, value) in [("instrument", &campaign.instrument), ("rig", &campaign.rig)] {
        if let Some(value) = value {
            line(format!("{key} = {}", quoted(value)));
        }
    }
    if !campaign.effects.is_empty() {
        let names: Vec<_> = campaign.effects.iter().map(|effect| quoted(&effect.text)).collect();
        line(format!("effects = [{}]", names.join(", ")));
    }
    if campaign.delay_range.is_stated() {
        line(format!("delay_range = {}", campaign.delay_range.written(quoted)));
    }
    let timing = campaign.timing.as_ref().map(|timing| &timing.written);
    for (head, table) in [("metadata", Some(&campaign.metadata)), ("timing", timing)] {
        if let Some(serde_json::Value::Object(entries)) = table
            && !entries.is_empty()
        {
            line(format!("\n[{head}]"));
            for (key, value) in entries {
                line(format!("{} = {}", quoted(key), free(value)));
            }
        }
    }
    // Those of all setups first, then those of each, as they were read.
    for said in campaign.parameters.chunk_by(|one, next| one.setup == next.setup) {
        match said.first().and_then(|first| first.setup.as_ref()) {
            None => line("\n[parameters]".into()),
            Some(setup) => line(format!("\n[setups.{}]", quoted(setup))),
        }
        said.iter().for_each(|parameter| line(parameter_line(parameter)));
    }
    let inputs: Vec<String> = model
        .inputs
        .iter()
        .zip(&campaign.input_spread)
        .filter_map(|(input, spread)| {
            let noise = spread.noise.iter();
            let mut words: Vec<_> = noise.map(|value| sigma(&input.unit, *value)).collect();
            let over = campaign.inputs.iter().find(|over| over.name.text == input.name);
            for (key, item) in over.into_iter().flat_map(|over| {
                [
                    ("resolution", &over.resolution),
                    ("calibration", &over.calibration),
                    ("smooth", &over.smooth),
                    ("period", &over.period),
                ]
            }) {
                words.extend(item.as_ref().map(|item| {
                    let mut value = item.to_json();
                    // What is written is corrected already.
                    value.as_object_mut().and_then(|table| table.remove("corrections"));
                    format!("{key} = {}", free(&value))
                }));
            }
            (!words.is_empty()).then(|| format!("{} = {{ {} }}", input.name, words.join(", ")))
        })
        .collect();
    if !inputs.is_empty() {
        line("\n[inputs]".into());
        inputs.into_iter().for_each(&mut line);
    }
    line("\n[measurands]".into());
    let known = campaign.measurand_sigma.iter().zip(&campaign.measurand_degrees_of_freedom);
    for (measurand, (value, degrees)) in model.measurands.iter().zip(known) {
        let mut words = vec![sigma(&measurand.unit, *value)];
        words.extend(degrees_of_freedom(*degrees));
        line(format!("{} = {{ {} }}", measurand.name, words.join(", ")));
    }
    campaign.specification.lines(quoted).into_iter().for_each(&mut line);
    for ((run, file), entry) in runs.iter().zip(files).zip(&campaign.entries) {
        line("\n[[runs]]".into());
        line(format!("name = {}", quoted(&run.name)));
        if let Some(setup) = campaign.setups.get(run.setup) {
            line(format!("setup = {}", quoted(setup)));
        }
        if run.role == Role::Reference {
            line("role = \"reference\"".into());
        }
        line(format!("data = {}", quoted(file)));
        run_extras(campaign, entry, copies).into_iter().for_each(&mut line);
    }
    write_whole(path, text.as_bytes())
}

fn sigma(unit: &Unit, sigma: f64) -> String {
    let symbol = if unit.offset == 0.0 { unit.symbol.as_str() } else { "K" };
    format!("sigma = \"{:?} {symbol}\"", sigma / unit.factor)
}

fn degrees_of_freedom(stated: Option<f64>) -> Option<String> {
    stated.map(|stated| format!("degrees_of_freedom = {stated}"))
}

/// Lines of a run for its streams, what they call their columns, and its constants.
fn run_extras(campaign: &Campaign, entry: &RunEntry, copies: &[(String, String)]) -> Vec<String> {
    let mut found = Vec::new();
    if !entry.signals.is_empty() {
        let copied = |name: &str| {
            copies
                .iter()
                .find(|(from, _)| from == name)
                .map_or(name.to_owned(), |(_, to)| to.clone())
        };
        let named = |stream: &TableEntry| {
            let name = quoted(&copied(&stream.name.text));
            if stream.written.is_empty() {
                return name;
            }
            let words = stream
                .written
                .iter()
                .map(|(key, value)| format!("{} = {}", quoted(key), free(value)));
            let words: Vec<String> = [format!("file = {name}")].into_iter().chain(words).collect();
            format!("{{ {} }}", words.join(", "))
        };
        let names: Vec<_> = entry.signals.iter().map(named).collect();
        found.push(format!("signals = [{}]", names.join(", ")));
        let in_stream = |stream: &TableEntry| {
            columns_in(&campaign.folder.join(&stream.name.text), &stream.form)
        };
        let headers: Vec<Vec<Column>> = entry.signals.iter().map(in_stream).collect();
        // The data file is written in the model's names; only streams keep their own.
        let is_of_stream = |word: &&ColumnWord| {
            let column = word.column.clone().unwrap_or(Choice::Name(word.name.text.clone()));
            headers.iter().any(|stream| column.is_among(stream))
        };
        let words: Vec<_> = entry
            .columns
            .iter()
            .filter(is_of_stream)
            .map(|word| format!("{} = {}", quoted(&word.name.text), free(&word.written)))
            .collect();
        if !words.is_empty() {
            found.push(format!("columns = {{ {} }}", words.join(", ")));
        }
    }
    if let Some(bits) = entry.timing.bits {
        found.push(format!("timing = {{ bits = {bits} }}"));
    }
    if !entry.inputs.is_empty() {
        let words: Vec<_> = entry
            .inputs
            .iter()
            .map(|(name, quantity)| format!("{} = {}", quoted(&name.text), quoted(&quantity.text)))
            .collect();
        found.push(format!("inputs = {{ {} }}", words.join(", ")));
    }
    found
}

/// The model as the written campaign names it, and the place of its file there if it is one of the
/// campaign's own: a name stays, a path becomes that of a file beside the campaign.
fn model_reference(campaign: &Campaign) -> (String, Option<PathBuf>) {
    let text = &campaign.model.text;
    let own = model_file(text, &campaign.folder);
    match own.as_ref().and_then(|path| path.file_name()) {
        Some(file) if is_model_path(text) => {
            let name = file.to_string_lossy();
            let said = if is_model_path(&name) { name.into_owned() } else { format!("./{name}") };
            (said, Some(file.into()))
        }
        Some(file) => (text.clone(), Some(Path::new("models").join(file))),
        None => (text.clone(), None),
    }
}

/// The model of the campaign's own and the effects beside it: their places in a written campaign,
/// and their texts. Of what stands beside effects nothing else is copied.
fn declarations(campaign: &Campaign) -> Result<Vec<(PathBuf, Arc<str>)>, Diagnostics> {
    let read = |path: &Path| {
        refuse_link(campaign, path)?;
        Source::read(path)
    };
    let mut found = Vec::new();
    if let (Some(path), (_, Some(place))) =
        (model_file(&campaign.model.text, &campaign.folder), model_reference(campaign))
    {
        found.push((place, read(&path)?.text));
    }
    let effects = campaign.folder.join("effects");
    if effects.is_dir() {
        for path in effect_files(&effects)? {
            let source = read(&path)?;
            let text = source.text.clone();
            Effect::parse(source)?;
            let name = path.file_name().unwrap_or_default();
            found.push((Path::new("effects").join(name), text));
        }
    }
    Ok(found)
}

fn parameter_line(parameter: &Override) -> String {
    let mut words = Vec::new();
    let text = |(value, unit): &(f64, Unit)| {
        quoted(&format!("{:?} {}", unit.from_si(*value), unit.symbol))
    };
    let list = |quantities: &[(f64, Unit)]| {
        let texts: Vec<_> = quantities.iter().map(text).collect();
        if texts.len() == 1 { texts.join("") } else { format!("[{}]", texts.join(", ")) }
    };
    for (key, value) in [
        ("value", &parameter.value),
        ("sigma", &parameter.sigma),
        ("lower", &parameter.lower),
        ("upper", &parameter.upper),
        ("start", &parameter.start),
    ] {
        words.extend(value.as_ref().map(|value| format!("{key} = {}", list(value))));
    }
    for (key, value) in [
        ("plausible", &parameter.plausible),
        ("linear_range", &parameter.linear_range),
        ("simulated_at", &parameter.simulated_at),
    ] {
        words.extend(value.as_ref().map(|value| format!("{key} = {}", text(value))));
    }
    words.extend(degrees_of_freedom(parameter.degrees_of_freedom));
    words.extend(parameter.fixed.map(|fixed| format!("fixed = {fixed}")));
    words.extend(parameter.scope.map(|scope| {
        let word = SCOPES.iter().find(|(_, known)| *known == scope).map_or("run", |(word, _)| word);
        format!("scope = \"{word}\"")
    }));
    words.extend(parameter.sum_zero.filter(|zero| *zero).map(|_| "sum = \"zero\"".to_owned()));
    format!("{} = {{ {} }}", quoted(&parameter.name), words.join(", "))
}

/// A TOML text; JSON's escapes are TOML's.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007f")
}

fn free(value: &serde_json::Value) -> String {
    use serde_json::Value;
    match value {
        Value::Null => "\"\"".into(),
        Value::String(text) => quoted(text),
        Value::Array(items) => {
            format!("[{}]", items.iter().map(free).collect::<Vec<_>>().join(", "))
        }
        Value::Object(entries) => {
            let words: Vec<_> = entries
                .iter()
                .map(|(key, value)| format!("{} = {}", quoted(key), free(value)))
                .collect();
            format!("{{ {} }}", words.join(", "))
        }
        Value::Bool(_) | Value::Number(_) => value.to_string(),
    }
}

/// A file for each run, by its name; what a file name cannot hold becomes `_`.
fn file_names(runs: &[Run]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for run in runs {
        let safe: String = run
            .name
            .chars()
            .map(|c| if c.is_alphanumeric() || "_-+.".contains(c) { c } else { '_' })
            .collect();
        let safe = safe.trim_start_matches('.');
        let name = free_name(&format!("{safe}.csv"), |name| {
            names.iter().any(|other| other.eq_ignore_ascii_case(name))
        });
        names.push(name);
    }
    names
}

fn free_name(wish: &str, taken: impl Fn(&str) -> bool) -> String {
    let mut name = wish.to_owned();
    let mut count = 1;
    while taken(&name) {
        count += 1;
        name = format!("{count}_{wish}");
    }
    name
}
