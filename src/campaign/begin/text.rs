//! Lines of a campaign to begin with.

use std::path::PathBuf;

use crate::campaign::begin::log::Log;
use crate::campaign::begin::scatter::Sigma;
use crate::campaign::begin::word::{Word, quoted};

/// A file with its columns.
#[derive(Clone, Debug)]
pub(super) struct Table {
    pub(super) path: PathBuf,
    /// What is stated of its form, behind the name of the file.
    pub(super) form: String,
    pub(super) words: Vec<Word>,
    /// Lines to fill in.
    pub(super) open: Vec<String>,
    /// Columns that the model does not take, with a comment.
    pub(super) unused: Option<String>,
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
        Self { path: survey.path.clone(), form, words, open, unused: None }
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
        let unused =
            self.unused.as_ref().map(|unused| format!("\n{indent}    {unused}\n{indent}}}"));
        let columns = match lines.is_empty() {
            true => String::new(),
            false => format!(" columns = {{\n{}{indent}}}", lines.concat()),
        };
        match (columns.as_str(), self.form.as_str(), unused) {
            ("", "", None) => file,
            (columns, form, None) => format!("{{ file = {file},{form}{columns} }}"),
            (columns, form, Some(unused)) => {
                let comma = if columns.is_empty() { "" } else { "," };
                format!("{{ file = {file},{form}{columns}{comma}{unused}")
            }
        }
    }
}

/// What the campaign does not use, in comments.
#[derive(Clone, Debug)]
pub(super) struct Rest(Vec<String>);

impl Rest {
    /// Of all logs, the recordings that they make, and further lines about them.
    pub(super) fn of(logs: &[Log], recordings: &[[usize; 2]], others: &[String]) -> Self {
        let name = |at: usize| logs[at].survey.path.display().to_string();
        let mut lines: Vec<String> = recordings
            .iter()
            .skip(1)
            .map(|[data, stream]| {
                format!("guessed: `{}` and `{}` are of another recording: a run, or, with clocks of its own, a campaign of its own", name(*data), name(*stream))
            })
            .collect();
        let is_left = |at: &usize| !recordings.iter().flatten().any(|own| own == at);
        let taken = recordings.first().into_iter().flatten();
        let like =
            |at: usize| taken.clone().find(|own| logs[**own].heads() == logs[at].heads()).copied();
        let left: Vec<(usize, Option<usize>)> =
            (0..logs.len()).filter(is_left).map(|at| (at, like(at))).collect();
        for all in left.chunk_by(|a, b| a.1 == b.1) {
            let names: Vec<String> = all.iter().map(|(at, _)| format!("`{}`", name(*at))).collect();
            let names = names.join(", ");
            lines.push(match all[0].1 {
                Some(like) => format!(
                    "not used: {names} with the columns of `{}`; of a recording add it as a run, of a simulator with another parameter see docs/simulated-sensitivities.md",
                    name(like)
                ),
                None => format!("not used: {names}; add it to `signals`, or as a run"),
            });
        }
        lines.extend_from_slice(others);
        Self(lines)
    }
}

/// The whole campaign: data and stream, why they are that, and the uncertainties of its measurands.
pub(super) fn campaign(
    model: &str,
    (tables, why): (&[Table], &str),
    sigmas: &[Sigma],
    rest: &Rest,
) -> String {
    let mut text = format!(
        "# Begun by `homepoint new campaign`. Look at every line with `guessed` or `WRITE`: units,\n\
         # roles and uncertainties are guesses from names and values. Then: `homepoint check` this file.\n\
         title = \"Begun from logs\"\nmodel = {}\n",
        quoted(model)
    );
    if tables.len() > 1 {
        text += "\n# Where the clocks differ by more than a log shows, say from when to when:\n\
                 # delay_range = [\"-8 s\", \"-4 s\"]\n";
    }
    text += "\n[measurands]\n";
    for Sigma { measurand, value, unit, why } in sigmas {
        text += &match value.as_deref().map(quoted) {
            Some(value) => format!(
                "{measurand} = {{ sigma = {value} }}   # guessed: {why}; state what you know\n"
            ),
            None => format!(
                "# {measurand} = {{ sigma = {} }}   # WRITE it: {why}\n",
                quoted(&format!("... {}", unit.of_differences().symbol))
            ),
        };
    }
    text += "\n[[runs]]\nname = \"one\"\n";
    if let [data, streams @ ..] = tables {
        text += &format!("data = {}\n", data.text(""));
        let streams: Vec<String> =
            streams.iter().map(|stream| format!("    {},\n", stream.text("    "))).collect();
        if !streams.is_empty() {
            text += &format!("signals = [   # guessed: {why}\n{}]\n", streams.concat());
        }
    }
    for line in &rest.0 {
        text += &format!("# {line}\n");
    }
    text
}
