//! A column of a log as a campaign names it.

use crate::campaign::begin::candidate::Candidate;
use crate::campaign::begin::log::Log;
use crate::campaign::header::TIME;

/// A column under a name of the model.
#[derive(Clone, Debug)]
pub(super) struct Word {
    pub(super) name: String,
    pub(super) candidate: Candidate,
    /// The column as `columns` names it; nothing where the file says all.
    pub(super) written: Option<String>,
}

impl Word {
    /// Of the stamps of a log.
    pub(super) fn time(log: &Log) -> Option<Self> {
        let time = log.guess.time.as_ref()?;
        let first = Self::of(TIME, log, time.parts.first())?;
        let is_named = |part: &Candidate| log.survey.columns[part.column].is_named;
        let written = match (time.is_dated, time.parts.as_slice()) {
            (false, [_]) => return Some(first),
            (true, [day, clock]) if is_named(clock) || day.column + 1 != clock.column => {
                format!("[{}, {}]", dated(log, day)?, dated(log, clock)?)
            }
            // A date has no unit, and the time of day beside it is found.
            (true, _) => format!("{{ column = {} }}", column(log, &first.candidate)?),
            (false, parts) => {
                let parts: Option<Vec<String>> =
                    parts.iter().map(|part| stated(log, part)).collect();
                format!("[{}]", parts?.join(", "))
            }
        };
        Some(Self { written: Some(written), ..first })
    }

    /// Of the stamps of a table at rest, whose model may need them. A column that is called `time` is
    /// read in any case.
    pub(super) fn time_at_rest(log: &Log, is_needed: bool) -> Option<Self> {
        let is_called = |word: &Self| log.survey.columns[word.candidate.column].name == TIME;
        Self::time(log).filter(|word| is_needed || is_called(word))
    }

    /// Of a column of a log.
    pub(super) fn of(name: &str, log: &Log, candidate: Option<&Candidate>) -> Option<Self> {
        let candidate = candidate?.clone();
        let column = log.survey.columns.get(candidate.column)?;
        let is_said = column.is_named && column.name == name && column.unit.is_some();
        let is_said = is_said && !is_repeated(log, name);
        let written = stated(log, &candidate)?;
        Some(Self { name: name.to_owned(), candidate, written: (!is_said).then_some(written) })
    }
}

/// The column of a log as a campaign names it: by its number where no column or another one, too, is
/// called so.
fn column(log: &Log, candidate: &Candidate) -> Option<String> {
    let column = log.survey.columns.get(candidate.column)?;
    Some(match column.is_named && !is_repeated(log, &column.name) {
        true => quoted(&column.name),
        false => (candidate.column + 1).to_string(),
    })
}

/// Whether several columns of a log are called so.
fn is_repeated(log: &Log, name: &str) -> bool {
    log.survey.columns.iter().filter(|column| column.name == name).count() > 1
}

/// A column of dates or of times of day, as a list names it.
fn dated(log: &Log, part: &Candidate) -> Option<String> {
    let column = column(log, part)?;
    Some(if column.starts_with('"') { column } else { format!("{{ column = {column} }}") })
}

/// The column of a log with its unit, as a campaign states them.
fn stated(log: &Log, candidate: &Candidate) -> Option<String> {
    let unit = quoted(&candidate.unit.symbol);
    Some(format!("{{ column = {}, unit = {unit} }}", column(log, candidate)?))
}

/// A text as TOML writes it.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
