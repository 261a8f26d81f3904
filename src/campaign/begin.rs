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
//! | `pose` | which columns are a pose in a plane |
//! | `guess`, `log` | what the columns seem to be; a file with that |
//! | `fitted` | the columns that a model of the library, or a stated one, takes |
//! | `alike` | which columns of two logs are called alike |
//! | `models`, `planar` | models to begin with, where none of the library fits |
//! | `reckoned`, `turns` | the bend of a path of dead reckoning; the scale between two headings |
//! | `word` | a column as a campaign names it |
//! | `neighbours` | whether successive rows are neighbours; the scatter of rows with the same inputs |
//! | `scatter` | a standard uncertainty, from the readings |
//! | `text` | lines of the campaign |
//! | `unused` | which columns nothing takes, and why |

mod alike;
mod axis_columns;
mod candidate;
mod fitted;
mod guess;
mod kinds;
mod log;
mod models;
mod neighbours;
mod pairing;
mod planar;
mod pose;
mod reckoned;
mod scatter;
mod stamp_column;
mod stamps;
mod survey;
mod text;
mod turns;
mod unused;
mod word;

use std::path::PathBuf;

use crate::campaign::header::TIME;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::Model;

use fitted::{Fitted, fitted};
use guess::Guess;
use log::Log;
use survey::Survey;
use text::Rest;
use word::{Word, quoted};

/// What a model of the library, or a stated one, takes of a log.
const OF_NAMES: &str = "columns of the names or the roles of its inputs and readings";

/// Why columns of two logs make no pair.
const GO_TOGETHER: &str = "columns go together that are called alike, or are of one kind by their units (both lengths, both angles): a column without a unit needs one, as `L [mm]` in its header";

/// Why a file is the stream.
const BY_COLUMNS: &str = "the file with the columns of the model's inputs is the stream";
const BY_RATE: &str = "the file with more rows a second is the stream";
const OF_ONE_FILE: &str = "the same file is the stream";

/// A campaign to begin with.
#[derive(Clone, Debug)]
pub struct Begun {
    /// The text of campaign.toml.
    pub campaign: String,
    /// A model that was written for it: the name of its file, and its text.
    pub model: Option<(String, String)>,
    /// A table that was computed for that model, likewise.
    pub table: Option<(String, String)>,
    /// Warnings about the logs.
    pub notes: Vec<String>,
    /// The columns that the campaign does not use, file by file.
    pub unused: Vec<String>,
}

/// A model with the name under which a campaign knows it.
pub type NamedModel = (String, Model);

/// Begins a campaign of one or more logs: each with its path, and how the campaign names it. `model` is
/// the model that is wanted, else one of `known` is taken that fits, or one is written. The bend of a path of
/// dead reckoning is computed at `heading_scale`, else at that of the headings of both logs.
///
/// # Errors
/// A file that cannot be read as a table, that has no stamps, or nothing that moves; a scale that no heading has.
pub fn begin(
    files: &[(PathBuf, PathBuf)],
    model: Option<&NamedModel>,
    known: &[NamedModel],
    heading_scale: Option<f64>,
) -> Result<Begun, Diagnostics> {
    let mut logs = Vec::new();
    let mut faults = Vec::new();
    if heading_scale.is_some_and(|scale| !turns::POSSIBLE.contains(&(1.0 + scale))) {
        faults.push(Diagnostic::error("the scale of a heading must be between -0.5 and 1"));
    }
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
                    quoted(name)
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
    let mut notes: Vec<String> = logs.iter().flat_map(Log::faults).collect();
    let own_logs = [data, stream];
    let by_rate = if is_alone { OF_ONE_FILE } else { BY_RATE };
    let own = match model {
        Some(own) => Some(fitted(own, data, stream, true)),
        None => {
            let all = known.iter().map(|own| fitted(own, data, stream, false));
            all.filter(Fitted::is_whole).max_by_key(|fitted| fitted.readings)
        }
    };
    if let Some(fitted) = own {
        let mut tables = fitted.tables(data, stream);
        let is_at_rest = is_alone && (data.stands_still() || !fitted.has_streams);
        if is_at_rest && let [of_data, of_stream] = tables.as_mut_slice() {
            // Rows at rest have no streams: inputs are columns of the data.
            let time = Word::time_at_rest(data, fitted.needs_time);
            let words = of_data.words.iter().chain(&of_stream.words);
            let words = words.filter(|word| word.name != TIME).cloned();
            of_data.words = time.into_iter().chain(words).collect();
            of_data.open.append(&mut of_stream.open);
            tables.truncate(1);
        }
        let unused = unused::list(own_logs, &mut tables, OF_NAMES);
        let rest = Rest::of(&logs, &recordings, &notes);
        let why = if fitted.by_columns { BY_COLUMNS } else { by_rate };
        let campaign = text::campaign(&fitted.name, (&tables, why), &fitted.sigmas, &rest);
        return Ok(Begun { campaign, model: None, table: None, notes, unused });
    }
    let made = match is_alone && data.stands_still() {
        true => models::stops(data),
        false => planar::planar(data, stream, heading_scale, &mut notes).or_else(|| {
            notes.extend(planar::not_used(own_logs));
            models::pairs(data, stream)
        }),
    };
    let Some(mut made) = made else {
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
            false => {
                let logs = [data, stream];
                let fault = logs.iter().fold(fault, |fault, log| fault.help(log.column_list()));
                let fault = logs.iter().fold(fault, |fault, log| fault.help(log.moving_list()));
                fault.help(GO_TOGETHER).help(help)
            }
        };
        return Err(fault.into());
    };
    let file = format!("{}.toml", made.name);
    let unused = unused::list(own_logs, &mut made.tables, made.takes);
    let rest = Rest::of(&logs, &recordings, &notes);
    let campaign =
        text::campaign(&format!("./{file}"), (&made.tables, by_rate), &made.sigmas, &rest);
    Ok(Begun { campaign, model: Some((file, made.text)), table: made.file, notes, unused })
}
