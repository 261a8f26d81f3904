//! The text of a written campaign's campaign.toml.

use std::io;
use std::path::Path;

use super::targets::model_reference;
use crate::campaign::declared::{ColumnWord, RunEntry, TableEntry};
use crate::campaign::header::{Choice, Column};
use crate::campaign::loaded::Campaign;
use crate::campaign::run::{Role, Run};
use crate::campaign::table::open::columns_in;
use crate::campaign::whole::write_whole;
use crate::model::parameter::SCOPES;
use crate::model::{Model, Override};
use crate::units::Unit;

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
