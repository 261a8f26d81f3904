//! Models to begin with, where none of the library fits: columns in pairs.

use crate::campaign::begin::alike::{Pair, alike, identifier, moving, name_of};
use crate::campaign::begin::candidate::{Candidate, base};
use crate::campaign::begin::log::Log;
use crate::campaign::begin::neighbours::Inputs;
use crate::campaign::begin::scatter::Sigma;
use crate::campaign::begin::text::Table;
use crate::campaign::begin::word::{Word, quoted};
use crate::statistics::{robust, upper_median};

/// A model that was made, and the columns that it takes.
pub(super) struct Made {
    pub(super) name: String,
    pub(super) text: String,
    pub(super) tables: Vec<Table>,
    pub(super) sigmas: Vec<Sigma>,
    /// A table that it needs beside: the name of its file, and its text.
    pub(super) file: Option<(String, String)>,
    /// Which columns it takes, in words.
    pub(super) takes: &'static str,
}

/// A table each for data and stream.
pub(super) fn tables(data: (&Log, Vec<Word>), stream: (&Log, Vec<Word>)) -> Vec<Table> {
    let table = |(log, words): (&Log, Vec<Word>)| Table::of(log, words, Vec::new());
    vec![table(data), table(stream)]
}

/// The columns of pairs.
const ALIKE: &str = "columns of one kind that are called alike";

/// Columns of both files that are called alike, or of one log those asked for and those that came.
pub(super) fn pairs(data: &Log, stream: &Log) -> Option<Made> {
    let is_one_log = std::ptr::eq(data, stream);
    let mut made = alike(data, stream);
    let mut takes = ALIKE;
    let note = if made.is_empty() {
        let other_than_number = |one: &&Candidate| one.unit.symbol != "1";
        let first = |log: &Log| {
            let all = moving(log);
            all.iter().find(other_than_number).or(all.first()).cloned()
        };
        if is_one_log {
            return None;
        }
        // Of one kind, or all that there is; between others a scale would say nothing.
        let streams = moving(stream);
        let is_of_kind = |own: &Candidate, other: &Candidate| {
            other.unit.dimension == own.unit.dimension
                && other.unit.is_angle() == own.unit.is_angle()
        };
        let of_kind = |own: Candidate| {
            let mut like = streams.iter().filter(|other| other_than_number(other));
            let other = like.find(|other| is_of_kind(&own, other))?.clone();
            Some((own, other))
        };
        let named = moving(data).into_iter().filter(|one| other_than_number(&one));
        let is_all = [data, stream].iter().all(|log| moving(log).len() == 1);
        let firsts = || first(data).zip(first(stream));
        let (own, other) = (named.into_iter().find_map(of_kind))
            .or_else(|| firsts().filter(|(own, other)| is_all || is_of_kind(own, other)))?;
        let name = identifier(&name_of(data, &own).map_or("reading".to_owned(), |own| base(own).0));
        made.push(Pair { name, own, other });
        takes = "the first two columns of one kind, for none are called alike";
        "# No two columns are called alike: WRITE what the readings of the data have to do with the stream.\n"
    } else {
        ""
    };
    let parts = Parts::of(&made, data, stream, true);
    let names: Vec<String> = made.iter().map(|pair| quoted(&pair.name)).collect();
    let delays = format!(
        "\n[delays]                       # one clock stamps them all\nclock = {{ of = [{}] }}\n",
        names.join(", ")
    );
    let text = format!("{note}{}{delays}", parts.text("Readings of one log against another"));
    let of_data = Word::time(data).into_iter().chain(parts.of_data).collect();
    let of_stream = Word::time(stream).into_iter().chain(parts.of_stream).collect();
    let tables = tables((data, of_data), (stream, of_stream));
    Some(Made { name: "begun".into(), text, tables, sigmas: parts.sigmas, file: None, takes })
}

/// Columns of a table of stops, which has no streams and no delays.
pub(super) fn stops(data: &Log) -> Option<Made> {
    let made = alike(data, data);
    if made.is_empty() {
        return None;
    }
    let mut parts = Parts::of(&made, data, data, false);
    parts.sigmas = made.iter().map(|pair| apart(data, pair)).collect();
    let words = parts.of_data.iter().chain(&parts.of_stream).cloned();
    let words = Word::time_at_rest(data, false).into_iter().chain(words).collect();
    Some(Made {
        name: "begun".into(),
        text: parts.text("Readings at rest against what they are of"),
        tables: vec![Table::of(data, words, Vec::new())],
        sigmas: parts.sigmas,
        file: None,
        takes: ALIKE,
    })
}

/// How far readings at rest are from what they are of, in the middle, beside what all have in common.
fn apart(log: &Log, Pair { name, own, other }: &Pair) -> Sigma {
    let si = |one: &Candidate| {
        let unit = one.unit.clone();
        log.survey.columns[one.column].values.iter().map(move |value| unit.to_si(*value))
    };
    let turn = std::f64::consts::TAU;
    let differences = si(own).zip(si(other)).map(|(own, other)| own - other);
    let mut all: Vec<f64> = differences.filter(|apart| apart.is_finite()).collect();
    if own.unit.is_angle() {
        let first = all.first().copied().unwrap_or(0.0);
        all.iter_mut().for_each(|apart| *apart -= turn * ((*apart - first) / turn).round());
    }
    let common = upper_median(&mut all).unwrap_or(0.0);
    all.iter_mut().for_each(|apart| *apart -= common);
    let why = "the scatter of its differences from what it is read of";
    Sigma::of(name, robust(&all).unwrap_or(0.0), &own.unit, why)
}

/// What a model of pairs consists of.
struct Parts {
    inputs: String,
    parameters: String,
    measurands: String,
    of_data: Vec<Word>,
    of_stream: Vec<Word>,
    sigmas: Vec<Sigma>,
}

impl Parts {
    fn of(pairs: &[Pair], data: &Log, stream: &Log, moves: bool) -> Self {
        let (mut inputs, mut parameters, mut measurands) =
            (String::new(), String::new(), String::new());
        let (mut of_data, mut of_stream) = (Vec::new(), Vec::new());
        for Pair { name, own, other } in pairs {
            let (unit, from) = (&own.unit.symbol, &other.unit.symbol);
            // Angles over more than half a turn may begin anew, and a full turn has no scale.
            let wide = |log: &Log, one: &Candidate| {
                let range = log.survey.columns[one.column].range() * one.unit.factor;
                one.unit.is_angle() && range > std::f64::consts::PI
            };
            let are_angles = own.unit.is_angle() && other.unit.is_angle();
            let is_angle = are_angles && (wide(data, own) || wide(stream, other));
            let period = if is_angle && moves { ", period = \"360 deg\"" } else { "" };
            let signal = if moves { ", signal = true" } else { "" };
            inputs += &format!("ref_{name} = {{ unit = {}{signal}{period} }}\n", quoted(from));
            let (factor, kind) = if is_angle {
                (String::new(), ", kind = \"angle\", period = \"360 deg\"")
            } else {
                let factor = match own.unit.dimension == other.unit.dimension {
                    true => "1".to_owned(),
                    false => format!("({unit})/({from})"),
                };
                parameters += &format!(
                    "{name}_scale  = {{ unit = {}, scope = \"instrument\", start = {} }}\n",
                    quoted(&factor),
                    quoted(&format!("1 {factor}"))
                );
                (format!("{name}_scale * "), "")
            };
            parameters +=
                &format!("{name}_offset = {{ unit = {}, scope = \"setup\" }}\n", quoted(unit));
            measurands += &format!(
                "{name} = {{ value = '{factor}ref_{name} + {name}_offset'{kind}, unit = {} }}\n",
                quoted(unit)
            );
            of_data.extend(Word::of(name, data, Some(own)));
            of_stream.extend(Word::of(&format!("ref_{name}"), stream, Some(other)));
        }
        let sources = Inputs { log: stream, words: &of_stream, is_whole: true };
        let sigma =
            |pair: &Pair| Sigma::of_columns(&pair.name, &of_data, data, &pair.own.unit, sources);
        let sigmas = pairs.iter().map(sigma).collect();
        Self { inputs, parameters, measurands, of_data, of_stream, sigmas }
    }

    fn text(&self, title: &str) -> String {
        format!(
            "# Each reading is its input, scaled and shifted: WRITE the equations of your rig.\n\
             name   = \"begun\"\ntitle  = {}\nsource = \"guessed from names\"\n\n[inputs]\n{}\n[parameters]\n{}\n[measurands]\n{}",
            quoted(title),
            self.inputs,
            self.parameters,
            self.measurands
        )
    }
}
