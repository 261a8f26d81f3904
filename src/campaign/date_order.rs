//! In which order the dates of a column have day and month, where their form leaves that open.
//!
//! A number above 12 decides, wherever it stands in the column. So do dates that go from one day to
//! the next in one order alone, in a log that goes on over midnight. Else the order has to be stated.

use std::io;
use std::path::Path;

use crate::campaign::calendar::open_date;
use crate::campaign::date::{DateOrder, day_in, written};
use crate::campaign::dialect::{Separator, cells};
use crate::campaign::form::Form;
use crate::campaign::header::Column;
use crate::campaign::lines::Lines;
use crate::campaign::origin::Origin;
use crate::campaign::preamble::pass_header;
use crate::campaign::recognise::layout::Layout;
use crate::campaign::stamp_columns::StampColumns;
use crate::diagnostic::Diagnostic;
use crate::document::files::open_regular;

/// A log goes on over midnight where it has so many rows a day at least.
const ROWS_A_DAY: usize = 3;

/// What a column shows of the order of its dates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    /// No date has an open order.
    None,
    /// They have this one.
    Order(DateOrder),
    /// It is one of these; the line and the text of the first row.
    Open { orders: Vec<DateOrder>, line: usize, text: String },
}

/// An order that may be the one.
#[derive(Clone, Copy)]
struct Possible {
    order: DateOrder,
    last: Option<i64>,
    goes_on: bool,
}

/// The form of a file with the order of the dates in its columns of stamps, as stated or as the column
/// decides; a fault where nothing does.
pub(crate) fn settled(
    path: &Path,
    form: &Form,
    (origin, layout): (&Origin, &Layout),
    columns: &[Column],
) -> io::Result<Result<Form, Diagnostic>> {
    let stamp = StampColumns::of(columns, form.dates);
    let dated = (0..columns.len()).filter(|column| stamp.has(*column));
    Ok(match in_file(path, form, layout, dated)? {
        (_, Found::None) => Ok(form.clone()),
        (_, Found::Order(order)) => Ok(Form { dates: Some(order), ..form.clone() }),
        (column, Found::Open { orders, line, text }) => {
            Err(undecided(origin, (line, &text), (layout.separator, column), &orders))
        }
    })
}

/// Looks for the order in the first of these columns whose dates leave it open, unless it is stated;
/// the column, and what it shows.
pub(crate) fn in_file(
    path: &Path,
    form: &Form,
    layout: &Layout,
    mut columns: impl Iterator<Item = usize>,
) -> io::Result<(usize, Found)> {
    let is_open = |column: &usize| {
        let cell = |row: &String| {
            let (cell, _) = cells(row, layout.separator).nth(*column)?;
            open_date(cell).map(drop)
        };
        form.dates.is_none() && layout.rows.iter().any(|row| cell(row).is_some())
    };
    let Some(column) = columns.find(is_open) else { return Ok((0, Found::None)) };
    let mut lines = Lines::of(open_regular(path)?)?;
    pass_header(&mut lines, layout)?;
    Ok((column, find(&mut lines, layout.separator, column)?))
}

/// Reads rows as far as the order of the dates in a column is open.
fn find(lines: &mut Lines, separator: Separator, column: usize) -> io::Result<Found> {
    let all = DateOrder::ALL;
    let mut possible = all.map(|order| Possible { order, last: None, goes_on: true }).to_vec();
    let (mut first, mut last) = (None, String::new());
    let (mut rows, mut days) = (0, 0);
    while let Some((number, line)) = lines.next()? {
        let Ok(text) = std::str::from_utf8(line) else { continue };
        let Some((cell, _)) = cells(text, separator).nth(column) else { continue };
        let Some(date) = open_date(cell) else { continue };
        rows += 1;
        if date == last {
            continue;
        }
        days += 1;
        first.get_or_insert_with(|| (number, text.to_owned()));
        date.clone_into(&mut last);
        let own: Vec<Possible> =
            possible.iter().filter_map(|one| one.on(day_in(date, one.order)?)).collect();
        match own.as_slice() {
            // No date in any order: a bad row.
            [] => continue,
            [one] => return Ok(Found::Order(one.order)),
            _ => possible = own,
        }
    }
    let Some((line, text)) = first else { return Ok(Found::None) };
    let mut going_on = possible.iter().filter(|one| one.goes_on);
    Ok(match (going_on.next(), going_on.next()) {
        (Some(one), None) if days > 1 && rows >= ROWS_A_DAY * days => Found::Order(one.order),
        _ => Found::Open { orders: possible.iter().map(|one| one.order).collect(), line, text },
    })
}

impl Possible {
    /// With one more day.
    fn on(self, day: i64) -> Option<Self> {
        let is_next = self.last.is_none_or(|last| (0..=1).contains(&(day - last)));
        Some(Self { last: Some(day), goes_on: self.goes_on && is_next, ..self })
    }
}

/// The fault of dates whose order nothing decides.
fn undecided(
    origin: &Origin,
    (line, text): (usize, &str),
    (separator, column): (Separator, usize),
    orders: &[DateOrder],
) -> Diagnostic {
    let cell = cells(text, separator).nth(column).map_or("", |(cell, _)| cell);
    let date = open_date(cell).unwrap_or(cell);
    let read = |order: &DateOrder| {
        let written = day_in(date, *order).map(written).unwrap_or_default();
        format!("{written} ({})", order.words())
    };
    let readings: Vec<String> = match origin.is_outside {
        true => orders.iter().map(|order| order.words().to_owned()).collect(),
        false => orders.iter().map(read).collect(),
    };
    let message = format!("the date `{}` may be {}", origin.word(date), readings.join(" or "));
    let keys: Vec<String> =
        orders.iter().map(|order| format!("dates = \"{}\"", order.words())).collect();
    let help = format!(
        "no date of the column decides; write which one it is beside `file`: {}",
        keys.join(" or ")
    );
    Diagnostic::error(message).at(origin.cell(line, text, separator, column)).help(help)
}
