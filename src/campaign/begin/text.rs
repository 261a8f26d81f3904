//! Lines of a campaign to begin with.

use std::path::PathBuf;

use crate::campaign::begin::candidate::Candidate;
use crate::campaign::begin::log::Log;
use crate::campaign::header::TIME;
use crate::units::Unit;

/// A part of the way that readings go, below which no scatter is guessed.
const OF_WAY: f64 = 2e-3;

/// A column under a name of the model.
#[derive(Clone, Debug)]
pub(super) struct Word {
    pub(super) name: String,
    pub(super) candidate: Candidate,
    /// The column as `columns` names it; nothing where the file says all.
    written: Option<String>,
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

/// A file with its columns.
#[derive(Clone, Debug)]
pub(super) struct Table {
    pub(super) path: PathBuf,
    /// What is stated of its form, behind the name of the file.
    pub(super) form: String,
    pub(super) words: Vec<Word>,
    /// Lines to fill in.
    pub(super) open: Vec<String>,
}

impl Table {
    /// Of a log.
    pub(super) fn of(log: &Log, words: Vec<Word>, open: Vec<String>) -> Self {
        let survey = &log.survey;
        let header = survey.header.map(|line| format!(" header = {line},"));
        let is_dated = log.guess.time.as_ref().is_some_and(|time| time.is_dated);
        let dates = survey.dates.split_first().filter(|_| is_dated).map(|(order, others)| {
            let others: Vec<&str> = others.iter().map(|other| other.words()).collect();
            let others = others.join(" or ");
            let order = quoted(order.words());
            format!(" dates = {order},   # guessed: no date decides; {others}? CHECK\n   ")
        });
        let form = header.into_iter().chain(dates).collect();
        Self { path: survey.path.clone(), form, words, open }
    }

    /// As it stands behind `data =` or in `signals`.
    fn text(&self, indent: &str) -> String {
        let file = quoted(&self.path.display().to_string());
        let open = self.open.iter().map(|line| format!("{indent}    # {line}\n"));
        let words = self.words.iter();
        let lines: Vec<String> = words
            .filter_map(|word| {
                let why = match word.candidate.why.as_str() {
                    "" => String::new(),
                    why => format!("   # guessed: {why}"),
                };
                let written = word.written.as_ref()?;
                Some(format!("{indent}    {} = {written},{why}\n", word.name))
            })
            .chain(open)
            .collect();
        match (lines.is_empty(), self.form.as_str()) {
            (true, "") => file,
            (true, form) => format!("{{ file = {file},{form} }}"),
            (false, form) => {
                format!("{{ file = {file},{form} columns = {{\n{}{indent}}} }}", lines.concat())
            }
        }
    }
}

/// What the campaign does not use, in comments.
#[derive(Clone, Debug)]
pub(super) struct Rest(Vec<String>);

impl Rest {
    /// Of all logs, the recordings that they make, and further lines about them.
    pub(super) fn of(logs: &[Log], recordings: &[[usize; 2]], others: [&[String]; 2]) -> Self {
        let name = |at: usize| logs[at].survey.path.display().to_string();
        let mut lines: Vec<String> = recordings
            .iter()
            .skip(1)
            .map(|[data, stream]| {
                format!("guessed: `{}` and `{}` are of another recording: a run, or, with clocks of its own, a campaign of its own", name(*data), name(*stream))
            })
            .collect();
        let is_left = |at: &usize| !recordings.iter().flatten().any(|own| own == at);
        let left: Vec<String> =
            (0..logs.len()).filter(is_left).map(|at| format!("`{}`", name(at))).collect();
        if !left.is_empty() {
            lines.push(format!("not used: {}; add it to `signals`, or as a run", left.join(", ")));
        }
        lines.extend(others.into_iter().flatten().cloned());
        Self(lines)
    }
}

/// The whole campaign: data and stream, and the uncertainties of its measurands.
pub(super) fn campaign(
    model: &str,
    tables: &[Table],
    sigmas: &[(String, String)],
    rest: &Rest,
) -> String {
    let mut text = format!(
        "# Begun by `homepoint new campaign`. Look at every line with `guessed`: units, roles and\n\
         # uncertainties are guesses from names and values. Then: `homepoint check` this file.\n\
         title = \"Begun from logs\"\nmodel = {}\n",
        quoted(model)
    );
    if tables.len() > 1 {
        text += "\n# Where the clocks differ by more than a log shows, say from when to when:\n\
                 # delay_range = [\"-8 s\", \"-4 s\"]\n";
    }
    text += "\n[measurands]\n";
    for (name, sigma) in sigmas {
        text += &format!(
            "{name} = {{ sigma = {} }}   # guessed: scatter, or 0.2 % of the way; state what you know\n",
            quoted(sigma)
        );
    }
    text += "\n[[runs]]\nname = \"one\"\n";
    if let [data, streams @ ..] = tables {
        text += &format!("data = {}\n", data.text(""));
        let streams: Vec<String> =
            streams.iter().map(|stream| format!("    {},\n", stream.text("    "))).collect();
        if !streams.is_empty() {
            text += &format!(
                "signals = [   # guessed: the file with more rows a second is the stream\n{}]\n",
                streams.concat()
            );
        }
    }
    for line in &rest.0 {
        text += &format!("# {line}\n");
    }
    text
}

/// The scatter of a measurand from reading to reading, in a unit that suits it.
pub(super) fn sigma(measurand: &str, words: &[Word], log: &Log, unit: &Unit) -> String {
    let is_own = |word: &&Word| {
        word.name == measurand
            || word.name.strip_prefix(measurand).is_some_and(|rest| rest.starts_with('_'))
    };
    let own = words.iter().filter(is_own).filter(|word| word.name != TIME);
    let largest = own
        .map(|word| {
            let values = &log.survey.columns[word.candidate.column].values;
            // The angle of a rotation is twice that of its quaternion.
            let twice = if word.name == measurand { 1.0 } else { 2.0 };
            twice * scatter(values) * word.candidate.unit.factor
        })
        .fold(0.0, f64::max);
    let symbol = if unit.offset == 0.0 { unit.symbol.as_str() } else { "K" };
    format!("{:.1e} {symbol}", (largest / unit.factor).max(1e-12))
}

/// The standard deviation of values that change smoothly beside it, by their third differences; at
/// least that of rounding to the smallest step.
fn scatter(values: &[f64]) -> f64 {
    let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    let mut third: Vec<f64> = finite
        .windows(4)
        .map(|four| (four[3] - 3.0 * four[2] + 3.0 * four[1] - four[0]).abs())
        .collect();
    let steps = finite.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let smallest = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let rounding = if smallest.is_finite() { smallest / 12_f64.sqrt() } else { 0.0 };
    let middle = third.len() / 2;
    if third.is_empty() {
        return rounding;
    }
    let median = *third.select_nth_unstable_by(middle, f64::total_cmp).1;
    let (least, most) = finite
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (value.min(a), value.max(b)));
    // What a model leaves out is more than noise: a part of the way, at least.
    (1.4826 * median / 20_f64.sqrt()).max(rounding).max(OF_WAY * (most - least))
}

pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
