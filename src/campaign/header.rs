//! The header of a table: which of its columns are wanted, and in which units they are.

mod column;
pub(super) mod faults;
mod formulas;
mod names;

use std::collections::HashMap;

use crate::campaign::calendar::{FORMS, seeming};
use crate::campaign::column_units::{by_name, counts, no_unit, read_unit};
use crate::campaign::computed::Computation;
use crate::campaign::form::Form;
use crate::campaign::formats::{Format, Role, ahead_of_utc, unit_since_1970};
use crate::campaign::origin::Origin;
use crate::campaign::recognise::layout::Layout;
use crate::campaign::sexagesimal;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::units::Unit;
use faults::{no_header, no_stamp};
use formulas::{computed, sources};
use names::{Chosen, Names};

pub(crate) use crate::campaign::wanted::{ADDED, ONE_COLUMN};
pub use crate::campaign::wanted::{Choice, Stated, TIME, Wanted};
pub use column::{Column, split};

/// The columns of a file, and the format in which it is.
pub(crate) struct Header {
    pub(crate) columns: Vec<Column>,
    pub(crate) format: Option<&'static Format>,
    /// Wanted columns that are computed from others.
    pub(crate) computed: Vec<(String, Computation)>,
}

/// How many faults of a header are reported.
const MOST_FAULTS: usize = 20;

/// Reads a header.
pub(crate) fn read(
    origin: &Origin,
    layout: &Layout,
    form: &Form,
    wanted: &[Wanted],
) -> Result<Header, Diagnostics> {
    let all = Names::of(layout, form);
    let header = layout.header.as_ref();
    let (line, text) =
        header.map_or((layout.first.0, &layout.first.1), |header| (header.line, &header.text));
    let at = |span| origin.place(line, text, span);
    let is_number = |(cell, _): &(&str, _)| split(cell).0.parse::<f64>().is_ok();
    let is_mixed = header.is_some() && form.header.is_none() && all.cells.iter().any(is_number);
    let mut chosen: HashMap<usize, Chosen<'_>> = HashMap::new();
    let mut faults = Vec::new();
    // What the campaign states comes before what is called like it.
    let is_stated = |want: &&Wanted| want.stated.column.is_some();
    for want in wanted.iter().filter(is_stated).chain(wanted.iter().filter(|w| !is_stated(w))) {
        let Some((index, other, unit)) = all.place(want) else { continue };
        if let Some(other) = other.filter(|_| !chosen.contains_key(&index)) {
            let (cell, span) = all.cells[other];
            let message = format!("the column `{}` is here twice", origin.word(split(cell).0));
            let help = format!(
                "say which one by its number: columns = {{ {} = {{ column = {} }} }}",
                want.name,
                index + 1
            );
            faults.push(Diagnostic::error(message).at(at(span)).help(help));
        }
        chosen.entry(index).or_insert(Chosen { want, stated: unit, usual: None, is_added: false });
    }
    if is_mixed {
        return Err(no_header(origin, layout).into());
    }
    let format = all.format(layout, form, &mut chosen, wanted);
    if let Some(format) = format.filter(|_| form.format.is_some()) {
        let lacks =
            format.columns.iter().all(|(role, ..)| format.place(*role, &all.plain()).is_none());
        if lacks {
            let message = format!("the file is not in the format `{}`", format.name);
            let help = format!("expected: {}", format.about);
            let fault = Diagnostic::error(message).at(at((0, text.len()))).help(help);
            return Err(fault.into());
        }
    }
    let taken = all.add_to_stamp(layout, format, &mut chosen);
    let is_sum = chosen.values().any(|one| one.is_added);
    let sources = sources(wanted, &all, &chosen);
    let mut of_formulas = Vec::new();
    for (own, want) in sources.iter().flat_map(|(own, all)| all.iter().map(move |one| (*own, one)))
    {
        if let Some((index, _, unit)) = all.place(want) {
            // The parts of a sum have no values of their own.
            if chosen.get(&index).is_some_and(|known| is_sum && known.want.name == TIME) {
                of_formulas.push((index, own));
            }
            chosen.entry(index).or_insert(Chosen {
                want,
                stated: unit,
                usual: None,
                is_added: false,
            });
        }
    }
    for (index, other) in taken.into_iter().chain(of_formulas) {
        let (cell, span) = all.cells[index];
        let name = match split(cell).0 {
            "" => (index + 1).to_string(),
            name => origin.word(name).into_owned(),
        };
        let (message, help) = match other.name.as_str() {
            TIME => (format!("the list has the column `{name}` twice"), "keep one of them"),
            other => (format!("`{TIME}` and `{other}` name the same column, `{name}`"), ONE_COLUMN),
        };
        faults.push(Diagnostic::error(message).at(at(span)).help(help));
    }
    let first_stamp =
        |index: usize| form.decimal.clone().number(layout.first_cell(index)?, layout.separator);
    let is_dated = |index| layout.first_cell(index).and_then(seeming).is_some();
    let mut columns = Vec::with_capacity(all.cells.len());
    for (index, (cell, span)) in all.cells.iter().enumerate() {
        if faults.len() >= MOST_FAULTS {
            break;
        }
        let (name, unit) = split(cell);
        let is_named = !name.is_empty();
        let name = if is_named { name.to_owned() } else { (index + 1).to_string() };
        let is_known = |text: &str| !text.trim().is_empty() && Unit::parse(text).is_ok();
        let mut column = Column {
            name,
            is_named,
            wanted: None,
            unit: Unit::one(),
            is_unit_in_header: unit.is_some_and(|(text, _)| is_known(text)),
            is_sexagesimal: false,
            index,
            values: Vec::new(),
        };
        if let Some(Chosen { want, stated, usual, is_added }) = chosen.get(&index) {
            let is_source = !wanted.iter().any(|own| std::ptr::eq(own, *want));
            column.wanted = Some(match (is_source, is_added) {
                (true, _) => format!("{} of a formula", want.name),
                (_, true) => ADDED.to_owned(),
                _ => want.name.clone(),
            });
            let since_1970 = match want.role {
                Some(Role::Time(_)) if !is_added => first_stamp(index).and_then(unit_since_1970),
                _ => None,
            };
            let usual =
                usual.clone().filter(|_| unit.is_none_or(|(unit, _)| unit.trim().is_empty()));
            let usual = usual.map(|usual| {
                since_1970.and_then(|symbol| Unit::parse(symbol).ok()).unwrap_or(usual)
            });
            let stated = stated.cloned().or(usual);
            // A date has no unit, whatever stands there.
            let is_dated = want.role == Some(Role::Time(0)) && is_dated(index);
            if let Some(hours) = ahead_of_utc(&column.name).filter(|_| is_dated) {
                let message =
                    format!("stamps in `{}` are {hours} h ahead of UTC", origin.word(&column.name));
                let help = "let the program that writes the file write UTC or GPST";
                faults.push(Diagnostic::error(message).at(at(*span)).help(help));
            }
            let (stated, unit) =
                if is_dated { (Some(Unit::second()), None) } else { (stated, unit) };
            let may_be_angle = is_source || want.unit.is_angle();
            column.is_sexagesimal = may_be_angle && layout.has_degrees(index);
            let (stated, unit) = match column.is_sexagesimal {
                true => {
                    let name = origin.word(&column.name);
                    match sexagesimal::unit_of(&name, unit.map(|one| one.0), stated.as_ref()) {
                        Ok(degree) => (Some(degree), None),
                        Err(fault) => {
                            faults.push(fault.at(at(*span)));
                            columns.push(column);
                            continue;
                        }
                    }
                }
                false => (stated, unit),
            };
            let is_without = !is_source && stated.is_none() && unit.is_none();
            let is_stamp = want.role == Some(Role::Time(0)) && is_without;
            if let Some(word) = no_stamp(layout, form, index).filter(|_| is_stamp) {
                let message = format!(
                    "expected a number, a date or a time of day in column `{}`, found `{}`",
                    origin.word(&column.name),
                    origin.word(word)
                );
                faults.push(Diagnostic::error(message).at(at(*span)).help(FORMS));
                columns.push(column);
                continue;
            }
            let hint = since_1970.or_else(|| by_name(&column.name, &want.unit));
            let accepts = (!is_source).then_some(&want.unit);
            let below = layout.first_cell(index).filter(|_| stated.is_none() && unit.is_none());
            let read = read_unit(origin, want, accepts, stated, (&column.name, hint), unit);
            match read.and_then(|unit| counts(unit, since_1970)) {
                Ok(unit) => column.unit = unit,
                Err(fault) => {
                    let (mut diagnostic, inside) = *fault;
                    diagnostic.help.extend(below.and_then(|cell| no_unit(&origin.word(cell))));
                    let inside = inside.map_or(*span, |(a, b)| (span.0 + a, span.0 + b));
                    faults.push(diagnostic.at(at(inside)));
                }
            }
        }
        columns.push(column);
    }
    let computed = match faults.is_empty() {
        true => computed(&sources, &all, &columns, &mut faults),
        false => Vec::new(),
    };
    Diagnostics(faults).into_result(Header { columns, format, computed })
}
