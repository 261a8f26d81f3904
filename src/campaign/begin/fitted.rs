//! A model that is stated or in the library, with the columns of two files that it may want.

use crate::campaign::begin::NamedModel;
use crate::campaign::begin::candidate::{Candidate, base};
use crate::campaign::begin::guess::Guess;
use crate::campaign::begin::log::Log;
use crate::campaign::begin::neighbours::Inputs;
use crate::campaign::begin::scatter::Sigma;
use crate::campaign::begin::text::Table;
use crate::campaign::begin::word::{Word, quoted};
use crate::campaign::columns::reading_columns;
use crate::campaign::formats::Role;
use crate::campaign::roles::roles;
use crate::graph::MeasurandKind;
use crate::model::name::is_time;
use crate::model::{Model, Process};
use crate::units::Unit;

/// A model with the columns of two files that it may want.
pub(super) struct Fitted {
    pub(super) name: String,
    data: Vec<Word>,
    stream: Vec<Word>,
    /// Lines to fill in for readings and for inputs that no column is.
    open: [Vec<String>; 2],
    /// How many inputs no column is.
    missing: usize,
    pub(super) readings: usize,
    pub(super) sigmas: Vec<Sigma>,
    is_swapped: bool,
    /// Whether their columns decide which file is the stream.
    pub(super) by_columns: bool,
    /// Whether the model has inputs that are streams.
    pub(super) has_streams: bool,
    /// Whether the model depends on the stamps of rows at rest, too.
    pub(super) needs_time: bool,
}

impl Fitted {
    pub(super) fn is_whole(&self) -> bool {
        self.missing == 0 && self.readings > 0
    }

    pub(super) fn tables(&self, data: &Log, stream: &Log) -> Vec<Table> {
        let (data, stream) = if self.is_swapped { (stream, data) } else { (data, stream) };
        let table = |log: &Log, words: &[Word], open: &[String]| {
            Table::of(log, words.to_vec(), open.to_vec())
        };
        let [of_data, of_stream] = &self.open;
        vec![table(data, &self.data, of_data), table(stream, &self.stream, of_stream)]
    }
}

/// Which columns a model may want, whichever file is the data. One that is stated takes columns of other
/// names, too, that are the only ones of their kind.
pub(super) fn fitted(model: &NamedModel, data: &Log, stream: &Log, is_stated: bool) -> Fitted {
    let one = try_fit(model, data, stream, (false, is_stated));
    let other = try_fit(model, stream, data, (true, is_stated));
    let score = |fitted: &Fitted| (fitted.is_whole(), fitted.readings, usize::MAX - fitted.missing);
    let by_columns = score(&other) != score(&one);
    let better = if score(&other) > score(&one) { other } else { one };
    Fitted { by_columns, ..better }
}

fn try_fit(
    (name, model): &NamedModel,
    data: &Log,
    stream: &Log,
    (is_swapped, is_stated): (bool, bool),
) -> Fitted {
    let reading = |(index, name): (usize, String)| {
        let one = &model.measurands[index];
        let is_rotation = one.kind == MeasurandKind::Rotation;
        (name, if is_rotation { Unit::one() } else { one.unit.clone() })
    };
    let readings: Vec<(String, Unit)> = reading_columns(model).into_iter().map(reading).collect();
    let inputs: Vec<(String, Unit)> =
        model.inputs.iter().map(|input| (input.name.clone(), input.unit.clone())).collect();
    let wanted = |names: &[(String, Unit)], log: &Log, are_readings: bool| {
        let mut words = wanted(names, log, &roles(model, are_readings));
        // One column of a single file could be both.
        if is_stated && !std::ptr::eq(data, stream) {
            words.extend(of_their_kind(names, log, &words));
        }
        words
    };
    let (of_data, of_stream) = (wanted(&readings, data, true), wanted(&inputs, stream, false));
    // An input that is sampled with the readings stands beside them.
    let is_sampled = |name: &str| {
        let mut own = model.inputs.iter().filter(|input| !input.signal);
        !std::ptr::eq(data, stream)
            && own.any(|input| input.name == name)
            && of_stream.iter().all(|word| word.name != name)
    };
    let (sampled, streamed): (Vec<_>, Vec<_>) =
        inputs.into_iter().partition(|(name, _)| is_sampled(name));
    let is_free =
        |word: &Word| of_data.iter().all(|known| known.candidate.column != word.candidate.column);
    let beside: Vec<Word> = self::wanted(&sampled, data, &[]).into_iter().filter(is_free).collect();
    let is_open = |(name, _): &(String, Unit)| beside.iter().all(|word| word.name != *name);
    let inputs: Vec<(String, Unit)> =
        streamed.into_iter().chain(sampled.into_iter().filter(is_open)).collect();
    let open = [open(&readings, &of_data, data), open(&inputs, &of_stream, stream)];
    let sources = Inputs { log: stream, words: &of_stream, is_whole: open[1].is_empty() };
    let sigmas = model
        .measurands
        .iter()
        .filter(|one| of_data.iter().any(|word| word.name.starts_with(&one.name)))
        .map(|one| Sigma::of_columns(&one.name, &of_data, data, &one.unit, sources))
        .collect();
    Fitted {
        name: name.clone(),
        readings: of_data.len(),
        data: Word::time(data).into_iter().chain(of_data).chain(beside).collect(),
        stream: Word::time(stream).into_iter().chain(of_stream).collect(),
        missing: open[1].len(),
        open,
        sigmas,
        is_swapped,
        by_columns: false,
        has_streams: model.inputs.iter().any(|input| input.signal),
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
            quoted(&unit.symbol),
            log.column_list()
        )
    };
    missing.map(line).collect()
}

/// Columns for names that no column of `known` is: each the only one with a unit of that kind which is free,
/// for the only such name.
fn of_their_kind(names: &[(String, Unit)], log: &Log, known: &[Word]) -> Vec<Word> {
    let columns = &log.survey.columns;
    let is_time = |at: usize| log.guess.time.as_ref().is_some_and(|time| time.has(at));
    let is_known = |at: usize| known.iter().any(|word| word.candidate.column == at);
    let free = (0..columns.len()).filter(|at| !is_time(*at) && !is_known(*at));
    let free: Vec<(usize, Unit)> = free
        .filter_map(|at| Some((at, columns[at].unit.clone().or(base(&columns[at].name).1)?)))
        .collect();
    let open: Vec<&(String, Unit)> =
        names.iter().filter(|(name, _)| known.iter().all(|word| word.name != *name)).collect();
    let of = |(name, like): &&(String, Unit)| {
        let is_of_kind = |unit: &Unit| like.symbol != "1" && like.accepts(unit);
        let mut own = free.iter().filter(|(_, unit)| is_of_kind(unit));
        let (Some((column, unit)), None) = (own.next(), own.next()) else { return None };
        let rivals = open.iter().filter(|(_, other)| other.accepts(unit)).count();
        let why = format!("the only column in units such as `{}`", like.symbol);
        let candidate = Candidate { column: *column, unit: unit.clone(), why };
        Word::of(name, log, Some(&candidate)).filter(|_| rivals == 1)
    };
    open.iter().filter_map(of).collect()
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
        let plain = |name: &str| name.to_lowercase().replace([' ', '-'], "_");
        let alike = || called(&|own| plain(&base(own).0) == plain(name));
        let by_name = same.or_else(alike).and_then(|column| {
            let unit = columns[column].unit.clone();
            let known = guessed(column);
            let known = known.or(unit.map(|unit| Candidate { column, unit, why: String::new() }));
            // A column without a unit has that of the model; angles beyond a turn are no radians.
            known.map(|known| {
                if like.accepts(&known.unit) {
                    return known;
                }
                let are_radians = like.is_angle() && like.factor == 1.0;
                let degrees = Unit::parse("deg").ok();
                let degrees = degrees.filter(|_| are_radians && columns[column].seems_in_degrees());
                let (unit, because) = match degrees {
                    Some(degrees) => (degrees, " and its values go beyond a turn in rad"),
                    None => (like.clone(), ""),
                };
                let why =
                    format!("its name; the file has no unit{because}, CHECK `{}`", unit.symbol);
                Candidate { unit, why, ..known }
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
