//! Writes a campaign of the same form: campaign.toml and a CSV a run, in the model's units.
//!
//! Files are whole or not at all: written beside their place and then renamed. Streams are copied.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::campaign::declared::RunEntry;
use crate::campaign::loaded::Campaign;
use crate::campaign::run::{Role, Run};
use crate::campaign::table::names_in;
use crate::campaign::whole::write_whole;
use crate::campaign::write_run::RunTable;
use crate::library::{is_model_path, model_file};
use crate::model::parameter::SCOPES;
use crate::model::{Model, Override};
use crate::units::Unit;

/// Writes a campaign with other runs (simulated ones) into a folder, which is made if need be.
///
/// `runs` are in the order of the campaign's own; constants of runs stay in campaign.toml, streams
/// are copied beside it.
///
/// # Errors
/// The disk's.
pub fn write_campaign(
    folder: &Path,
    campaign: &Campaign,
    model: &Model,
    runs: &[Run],
) -> io::Result<()> {
    write_campaign_with(folder, campaign, model, runs, &mut |run, table| {
        runs[run].record.try_walk(|stretch| table.write(stretch, None))
    })
}

/// The same with other readings: `fill` writes the table of each run, by its index.
///
/// # Errors
/// The disk's.
pub fn write_campaign_with(
    folder: &Path,
    campaign: &Campaign,
    model: &Model,
    runs: &[Run],
    fill: &mut dyn FnMut(usize, &mut RunTable) -> io::Result<()>,
) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    copy_declarations(folder, campaign)?;
    let files = file_names(runs);
    for (index, (run, file)) in runs.iter().zip(&files).enumerate() {
        let timing = campaign.timing.as_ref().zip(campaign.entries.get(index));
        let replies = campaign.request_to_reply.iter().find(|one| one.run == run.name);
        let capturing = timing.map(|(timing, entry)| timing.capturing(&entry.timing, replies));
        let path = folder.join(file);
        let mut table = RunTable::create_captured(&path, model, &run.record, capturing)?;
        fill(index, &mut table)?;
        table.finish()?;
    }
    let mut copies: Vec<(String, String)> = Vec::new();
    for stream in campaign.entries.iter().flat_map(|entry| &entry.signals) {
        if copies.iter().any(|(from, _)| *from == stream.text) {
            continue;
        }
        let base = Path::new(&stream.text)
            .file_name()
            .map_or("stream.csv".into(), |n| n.to_string_lossy());
        let taken =
            |name: &str| files.iter().any(|f| f == name) || copies.iter().any(|(_, to)| to == name);
        let name = free_name(&base, taken);
        let bytes = fs::read(campaign.folder.join(&stream.text))?;
        write_whole(&folder.join(&name), &bytes)?;
        copies.push((stream.text.clone(), name));
    }
    write_campaign_toml(&folder.join("campaign.toml"), campaign, model, runs, &files, &copies)
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
    line(format!("delay_range = \"{:?} s\"", campaign.delay_range));
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
        let names: Vec<_> = entry.signals.iter().map(|s| quoted(&copied(&s.text))).collect();
        found.push(format!("signals = [{}]", names.join(", ")));
        let headers: Vec<String> = entry
            .signals
            .iter()
            .flat_map(|stream| names_in(&campaign.folder.join(&stream.text)))
            .collect();
        // The data file is written in the model's names; only streams keep their own.
        let words: Vec<_> = entry
            .columns
            .iter()
            .filter(|word| headers.contains(&word.header))
            .map(|word| format!("{} = {}", quoted(&word.name.text), quoted(&word.written)))
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

/// Copies a model of the campaign's own and the effects beside it.
fn copy_declarations(folder: &Path, campaign: &Campaign) -> io::Result<()> {
    if let (Some(path), (_, Some(place))) =
        (model_file(&campaign.model.text, &campaign.folder), model_reference(campaign))
    {
        let place = folder.join(place);
        place.parent().map_or(Ok(()), fs::create_dir_all)?;
        write_whole(&place, &fs::read(path)?)?;
    }
    let effects = campaign.folder.join("effects");
    if effects.is_dir() {
        fs::create_dir_all(folder.join("effects"))?;
        for entry in fs::read_dir(effects)? {
            let path = entry?.path();
            if let (Some(name), true) = (path.file_name(), path.is_file()) {
                write_whole(&folder.join("effects").join(name), &fs::read(&path)?)?;
            }
        }
    }
    Ok(())
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
    words.extend(parameter.plausible.as_ref().map(|one| format!("plausible = {}", text(one))));
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
