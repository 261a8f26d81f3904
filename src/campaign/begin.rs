//! A campaign to begin with, from logs alone: which file is the data and which the stream, what their
//! columns are, and a model that fits, each guess marked as one.
//!
//! | file | answers |
//! |---|---|
//! | `pairing` | which of several logs are of one recording |
//! | `kinds` | what a column without a unit measures, as its name says |
//! | `stamps`, `stamp_column` | which columns are the stamps; which column of numbers |
//! | `candidate` | a column with the unit that it seems to have |
//! | `survey` | the first rows of a table with all of its columns |
//! | `axis_columns` | which columns are the axes of one thing |
//! | `guess`, `log` | what the columns seem to be; a file with that |
//! | `models`, `planar` | models to begin with, where none of the library fits |
//! | `text` | lines of the campaign |

mod axis_columns;
mod candidate;
mod guess;
mod kinds;
mod log;
mod models;
mod pairing;
mod planar;
mod stamp_column;
mod stamps;
mod survey;
mod text;

use std::path::PathBuf;

use crate::campaign::columns::reading_columns;
use crate::campaign::formats::Role;
use crate::campaign::header::TIME;
use crate::campaign::roles::roles;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::graph::MeasurandKind;
use crate::model::name::is_time;
use crate::model::{Model, Process};
use crate::units::Unit;

use candidate::{Candidate, base};
use guess::Guess;
use log::Log;
use survey::Survey;
use text::{Rest, Table, Word};

/// A campaign to begin with.
#[derive(Clone, Debug)]
pub struct Begun {
    /// The text of campaign.toml.
    pub campaign: String,
    /// A model that was written for it: the name of its file, and its text.
    pub model: Option<(String, String)>,
    /// A table that was computed for that model, likewise.
    pub table: Option<(String, String)>,
    /// What is to be said of the logs.
    pub notes: Vec<String>,
}

/// A model with the name under which a campaign knows it.
pub type NamedModel = (String, Model);

/// Begins a campaign of one or more logs: each with its path, and how the campaign names it. `model` is the model that is wanted, else one of `known`
/// is taken that fits, or one is written.
///
/// # Errors
/// A file that cannot be read as a table, that has no stamps, or nothing that moves.
pub fn begin(
    files: &[(PathBuf, PathBuf)],
    model: Option<&NamedModel>,
    known: &[NamedModel],
) -> Result<Begun, Diagnostics> {
    let mut logs = Vec::new();
    let mut faults = Vec::new();
    for (path, named) in files {
        match Survey::of(path, named) {
            Ok(survey) => logs.push(Log { guess: Guess::of(&survey), survey }),
            Err(fault) => faults.push(fault),
        }
    }
    let is_alone = files.len() == 1;
    for log in &logs {
        if log.guess.time.is_none() && !is_alone {
            let message = format!(
                "`{}` has no column of stamps: none of numbers in order",
                log.survey.path.display()
            );
            let help = match stamp_column::counter(&log.survey) {
                Some(name) => format!(
                    "`{name}` counts rows: where they come at a known rate, name it with the time from row to row: time = {{ column = {}, unit = \"10 ms\" }}",
                    text::quoted(name)
                ),
                None => "name the column in the campaign yourself (docs/files-as-they-are.md)"
                    .to_owned(),
            };
            let of_stops = "of a table of stops name one alone: each further one is a run, [[runs]], of its own";
            faults.push(Diagnostic::error(message).help(help).help(of_stops));
        }
    }
    let logs = Diagnostics(faults).into_result(logs)?;
    let recordings = match logs.len() {
        0 => return Err(Diagnostic::error("no file is named").help("--from a.csv b.csv").into()),
        1 => vec![[0, 0]],
        _ => pairing::recordings(&logs),
    };
    let Some([data, stream]) = recordings.first().map(|own| own.map(|at| &logs[at])) else {
        let message = "no two of the logs belong together";
        return Err(Diagnostic::error(message).help("name two logs: --from a.csv b.csv").into());
    };
    let notes: Vec<String> = logs.iter().flat_map(Log::bad_rows).collect();
    let rest = Rest::of(&logs, &recordings, &notes);
    let is_static = is_alone && data.stands_still();
    let own = match model {
        Some(own) => Some(fitted(own, data, stream)),
        None => {
            let all = known.iter().map(|own| fitted(own, data, stream));
            all.filter(Fitted::is_whole).max_by_key(|fitted| fitted.readings)
        }
    };
    if let Some(fitted) = own {
        let mut tables = fitted.tables(data, stream);
        if is_static && let [of_data, of_stream] = tables.as_mut_slice() {
            // Rows at rest have no streams: inputs are columns of the data.
            let time = Word::time_at_rest(data, fitted.needs_time);
            let words = of_data.words.iter().chain(&of_stream.words);
            let words = words.filter(|word| word.name != TIME).cloned();
            of_data.words = time.into_iter().chain(words).collect();
            of_data.open.append(&mut of_stream.open);
            tables.truncate(1);
        }
        let campaign = text::campaign(&fitted.name, &tables, &fitted.sigmas, &rest);
        return Ok(Begun { campaign, model: None, table: None, notes });
    }
    let made = match is_static {
        true => models::stops(data),
        false => planar::planar(data, stream).or_else(|| models::pairs(data, stream)),
    };
    let Some(made) = made else {
        let message = match is_alone {
            true => {
                "the columns of this one table do not say which are inputs and which are readings of them"
            }
            false => "no two columns that move go together",
        };
        let help =
            "write a model first (`homepoint new my_rig.toml`), then add `--model my_rig.toml`";
        let stops = "of rows that stand still (poses, stars) all columns go into `data`: docs/static-rigs.md";
        let fault = Diagnostic::error(message);
        let fault = match is_alone {
            true => fault.help(help).help(stops),
            false => fault.help(data.column_list()).help(stream.column_list()).help(help),
        };
        return Err(fault.into());
    };
    let file = format!("{}.toml", made.name);
    let campaign = text::campaign(&format!("./{file}"), &made.tables, &made.sigmas, &rest);
    Ok(Begun { campaign, model: Some((file, made.text)), table: made.file, notes })
}

/// A model with the columns of two files that it may want.
struct Fitted {
    name: String,
    data: Vec<Word>,
    stream: Vec<Word>,
    /// Lines to fill in for readings and for inputs that no column is.
    open: [Vec<String>; 2],
    /// How many inputs no column is.
    missing: usize,
    readings: usize,
    sigmas: Vec<(String, String)>,
    is_swapped: bool,
    /// Whether the model depends on the stamps of rows at rest, too.
    needs_time: bool,
}

impl Fitted {
    fn is_whole(&self) -> bool {
        self.missing == 0 && self.readings > 0
    }

    fn tables(&self, data: &Log, stream: &Log) -> Vec<Table> {
        let (data, stream) = if self.is_swapped { (stream, data) } else { (data, stream) };
        let table = |log: &Log, words: &[Word], open: &[String]| {
            Table::of(log, words.to_vec(), open.to_vec())
        };
        let [of_data, of_stream] = &self.open;
        vec![table(data, &self.data, of_data), table(stream, &self.stream, of_stream)]
    }
}

/// Which columns a model may want, whichever file is the data.
fn fitted(model: &NamedModel, data: &Log, stream: &Log) -> Fitted {
    let one = try_fit(model, data, stream, false);
    let other = try_fit(model, stream, data, true);
    let score = |fitted: &Fitted| (fitted.is_whole(), fitted.readings, usize::MAX - fitted.missing);
    if score(&other) > score(&one) { other } else { one }
}

fn try_fit((name, model): &NamedModel, data: &Log, stream: &Log, is_swapped: bool) -> Fitted {
    let reading = |(index, name): (usize, String)| {
        let one = &model.measurands[index];
        let is_rotation = one.kind == MeasurandKind::Rotation;
        (name, if is_rotation { Unit::one() } else { one.unit.clone() })
    };
    let readings: Vec<(String, Unit)> = reading_columns(model).into_iter().map(reading).collect();
    let inputs: Vec<(String, Unit)> =
        model.inputs.iter().map(|input| (input.name.clone(), input.unit.clone())).collect();
    let of_data = wanted(&readings, data, &roles(model, true));
    let of_stream = wanted(&inputs, stream, &roles(model, false));
    let open = [open(&readings, &of_data, data), open(&inputs, &of_stream, stream)];
    let sigmas = model
        .measurands
        .iter()
        .filter(|one| of_data.iter().any(|word| word.name.starts_with(&one.name)))
        .map(|one| (one.name.clone(), text::sigma(&one.name, &of_data, data, &one.unit)))
        .collect();
    Fitted {
        name: name.clone(),
        readings: of_data.len(),
        data: Word::time(data).into_iter().chain(of_data).collect(),
        stream: Word::time(stream).into_iter().chain(of_stream).collect(),
        missing: open[1].len(),
        open,
        sigmas,
        is_swapped,
        needs_time: needs_time(model),
    }
}

/// Whether a formula of a model names a time, or a random parameter depends on it.
fn needs_time(model: &Model) -> bool {
    let names = model.formulas().flat_map(|formula| formula.root.names());
    let mut names = names.map(|(name, _)| name);
    names.any(is_time) || model.parameters.iter().any(|one| one.process != Process::White)
}

/// Lines to fill in for names of a model that no column of a file is.
fn open(names: &[(String, Unit)], words: &[Word], log: &Log) -> Vec<String> {
    let missing = names.iter().filter(|(name, _)| words.iter().all(|word| word.name != *name));
    let line = |(name, unit): &(String, Unit)| {
        format!(
            "{name} = {{ column = \"...\", unit = {} }},   # WRITE its column, or leave it out: none is called so; {}",
            text::quoted(&unit.symbol),
            log.column_list()
        )
    };
    missing.map(line).collect()
}

/// The columns of a file for these names of a model: of the same name, else of the same role. What is
/// of another kind is another quantity.
fn wanted(names: &[(String, Unit)], log: &Log, roles: &[(String, Role)]) -> Vec<Word> {
    let columns = &log.survey.columns;
    let guessed = |column: usize| {
        let Guess { position, attitude, heading, others, .. } = &log.guess;
        let position = position.iter().flatten();
        let all = position.chain(attitude.iter().flatten()).chain(heading).chain(others);
        all.into_iter().find(|guessed| guessed.column == column).cloned()
    };
    let of = |(name, like): &(String, Unit)| {
        let is_of_kind = |column: &usize| {
            let unit = columns[*column].unit.clone().or(base(&columns[*column].name).1);
            unit.is_none_or(|unit| like.accepts(&unit))
        };
        let called = |is: &dyn Fn(&str) -> bool| {
            let all = columns.iter().enumerate().filter(|(_, column)| is(&column.name));
            let all = || all.clone().map(|(at, _)| at).filter(is_of_kind);
            // Of several columns of that name the one that is an axis of the position.
            let is_axis = |at: &usize| {
                let axes = log.guess.position.iter().flatten();
                axes.into_iter().any(|axis| axis.column == *at)
            };
            all().find(is_axis).or_else(|| all().next())
        };
        let same = called(&|own| own == name);
        let alike = || called(&|own| base(own).0 == name.to_lowercase());
        let by_name = same.or_else(alike).and_then(|column| {
            let unit = columns[column].unit.clone();
            let known = guessed(column);
            let known = known.or(unit.map(|unit| Candidate { column, unit, why: String::new() }));
            // A column without a unit has that of the model.
            known.map(|known| match like.accepts(&known.unit) {
                true => known,
                false => Candidate {
                    unit: like.clone(),
                    why: format!("its name; the file has no unit, CHECK `{}`", like.symbol),
                    ..known
                },
            })
        });
        let role = roles.iter().find(|(own, _)| own == name).map(|(_, role)| *role);
        let by_role = || match role? {
            Role::Time(_) | Role::Other => None,
            Role::Position(axis) => Some(log.guess.position.as_ref()?[axis].clone()),
            Role::Attitude(k) => Some(log.guess.attitude.as_ref()?[k].clone()),
        };
        Word::of(name, log, by_name.or_else(by_role).as_ref())
    };
    names.iter().filter_map(of).collect()
}
