//! The first rows of a table with all of its columns, whatever they are: for guesses alone.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::campaign::calendar::{Calendar, calendar, seeming};
use crate::campaign::date::DateOrder;
use crate::campaign::date_order::{self, Found};
use crate::campaign::dialect::cells;
use crate::campaign::form::Form;
use crate::campaign::formats::Format;
use crate::campaign::header::split;
use crate::campaign::lines::Lines;
use crate::campaign::preamble::{head_lines, pass_header};
use crate::campaign::recognise::Head;
use crate::campaign::repeated_rows::RepeatedRows;
use crate::diagnostic::Diagnostic;
use crate::document::files::{open_regular, reason};
use crate::units::Unit;

/// Rows that are looked at.
const MOST_ROWS: usize = 200_000;
/// Columns that are looked at.
const MOST_COLUMNS: usize = 200;

/// A third difference of so much of the whole way is no curve.
const LEAP: f64 = 0.05;
/// What can be read.
const OF_TEXT: &str = "name text tables: CSV, or of blanks";

/// Clearly more than a turn in radians, and such a part of all values.
const BEYOND_A_TURN: f64 = 7.0;
const MANY: f64 = 0.05;

/// A column of a table.
#[derive(Clone, Debug)]
pub(super) struct Surveyed {
    /// Its name; its number where it has none.
    pub(super) name: String,
    pub(super) is_named: bool,
    /// Its unit, where the header has one that is known.
    pub(super) unit: Option<Unit>,
    /// Why what stands there is no unit.
    pub(super) unknown: Option<String>,
    /// What its first cell is of the calendar, if it is no number.
    pub(super) calendar: Option<Calendar>,
    /// The cell above its name, where a row above the header is as wide: a word for several columns.
    pub(super) above: String,
    /// Its numbers; NaN where a cell is none.
    pub(super) values: Vec<f64>,
}

impl Surveyed {
    /// Whether most of its cells are numbers.
    fn is_of_numbers(&self) -> bool {
        2 * self.values.iter().filter(|value| value.is_finite()).count() > self.values.len()
    }

    /// Whether most of its cells are numbers, and not all of them the same.
    pub(super) fn moves(&self) -> bool {
        if self.calendar.is_some() {
            return false;
        }
        let finite = self.values.iter().filter(|value| value.is_finite());
        let (mut count, mut least, mut most) = (0, f64::INFINITY, f64::NEG_INFINITY);
        for value in finite {
            count += 1;
            (least, most) = (least.min(*value), most.max(*value));
        }
        2 * count > self.values.len() && most > least
    }

    /// Whether it leaps from most rows to the next ones.
    pub(super) fn leaps(&self) -> bool {
        self.leaping(1) > 0.5
    }

    /// The part of rows, of every n-th, from which it leaps: of third differences that are a large part of the
    /// whole way, and so of no curve.
    pub(super) fn leaping(&self, every: usize) -> f64 {
        let rows = self.values.iter().copied().step_by(every.max(1));
        let finite: Vec<f64> = rows.filter(|v| v.is_finite()).collect();
        let most = finite.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let least = finite.iter().copied().fold(f64::INFINITY, f64::min);
        let third = |four: &[f64]| (four[3] - 3.0 * four[2] + 3.0 * four[1] - four[0]).abs();
        let leaps = finite.windows(4).filter(|four| third(four) > LEAP * (most - least)).count();
        leaps as f64 / finite.len().saturating_sub(3).max(1) as f64
    }

    /// The range of its values but for the least and the largest twentieth, which may be outliers.
    pub(super) fn way(&self) -> f64 {
        let mut finite: Vec<f64> =
            self.values.iter().copied().filter(|value| value.is_finite()).collect();
        finite.sort_unstable_by(f64::total_cmp);
        let end = finite.len() / 20;
        match (finite.get(end), finite.iter().rev().nth(end)) {
            (Some(least), Some(most)) => most - least,
            _ => 0.0,
        }
    }

    /// Whether an angle without a unit seems to be in degrees: many of its values are no radians of one turn.
    pub(super) fn seems_in_degrees(&self) -> bool {
        let beyond = self.values.iter().filter(|value| value.abs() > BEYOND_A_TURN).count();
        beyond as f64 > MANY * self.values.len() as f64
    }

    /// The largest difference of two of its values.
    pub(super) fn range(&self) -> f64 {
        let finite = || self.values.iter().copied().filter(|value| value.is_finite());
        finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min)
    }
}

/// A table as far as it was looked at.
#[derive(Clone, Debug)]
pub(super) struct Survey {
    /// Its path as the campaign names it.
    pub(super) path: PathBuf,
    pub(super) columns: Vec<Surveyed>,
    /// The line of its header, where others stand before it.
    pub(super) header: Option<usize>,
    /// In which orders its dates may have day, month and year, where the column does not decide.
    pub(super) dates: Vec<DateOrder>,
    /// The format in which it seems to be.
    pub(super) format: Option<&'static Format>,
    /// Rows with a cell that is no number, in a column of numbers, or with too few cells.
    pub(super) bad_rows: usize,
    /// Rows without any number in these columns: a text among the rows.
    pub(super) text_rows: usize,
    /// Whether there are more rows than were looked at.
    pub(super) is_cut: bool,
}

impl Survey {
    /// Looks at a file.
    pub(super) fn of(path: &Path, named: &Path) -> Result<Self, Diagnostic> {
        let unreadable = |error: std::io::Error| {
            let fault = Diagnostic::error(reason(path, &error));
            match error.kind() {
                ErrorKind::NotFound => fault,
                _ => fault.help(OF_TEXT),
            }
        };
        let mut lines = open_regular(path).and_then(Lines::of).map_err(unreadable)?;
        let form = Form::default();
        let first = lines.head(head_lines(&form)).map_err(unreadable)?;
        let is_empty = first.trim_ascii().is_empty();
        let head = Head::of(first);
        let layout = head.layout(&form);
        let above = layout.as_ref().and_then(|layout| {
            let row = head.rows.get(layout.preamble.checked_sub(1)?)?.1;
            let all = cells(row, layout.separator).map(|(cell, _)| cell.to_lowercase());
            Some(all.collect::<Vec<_>>()).filter(|all| all.len() == layout.width)
        });
        let above = above.unwrap_or_default();
        let Some(layout) = layout else {
            if is_empty {
                return Err(Diagnostic::error(format!("the file `{}` is empty", path.display())));
            }
            let message = format!("`{}` holds no table of text", path.display());
            return Err(Diagnostic::error(message).help(OF_TEXT));
        };
        let header = layout.header.as_ref();
        let heads: Vec<&str> = match header {
            Some(header) => header.names().into_iter().map(|(name, _)| name).collect(),
            None => vec![""; layout.width],
        };
        let plain: Vec<&str> = heads.iter().map(|head| split(head).0).collect();
        let format = match header {
            Some(_) => Format::with_names(&plain),
            None => Format::with_rows(&layout.numbers(&form)),
        };
        let column = |(number, head): (usize, &&str)| {
            let (name, unit) = split(head);
            let is_named = !name.is_empty();
            let name = if is_named { name.to_owned() } else { (number + 1).to_string() };
            let unit = unit.map(|(unit, _)| match unit.trim() {
                "" => Ok(Unit::one()),
                unit => Unit::parse(unit),
            });
            let (unit, unknown) = match unit {
                Some(Ok(unit)) => (Some(unit), None),
                Some(Err(fault)) => (None, Some(fault.message)),
                None => (None, None),
            };
            let calendar = layout.first_cell(number).and_then(seeming);
            let above = above.get(number).cloned().unwrap_or_default();
            Surveyed { name, is_named, unit, unknown, calendar, above, values: Vec::new() }
        };
        let mut columns: Vec<Surveyed> =
            heads.iter().take(MOST_COLUMNS).enumerate().map(column).collect();
        let dated = (0..columns.len()).filter(|at| columns[*at].calendar.is_some());
        let (orders, order) =
            match date_order::in_file(path, &form, &layout, dated).map_err(unreadable)?.1 {
                Found::Open { orders, .. } => (orders.clone(), orders.first().copied()),
                Found::Order(order) => (Vec::new(), Some(order)),
                Found::None => (Vec::new(), None),
            };
        pass_header(&mut lines, &layout).map_err(unreadable)?;
        let mut decimal = form.decimal;
        // For each row the columns whose cells are no numbers, though something stands there.
        let mut words: Vec<Vec<usize>> = Vec::new();
        let mut repeated = RepeatedRows::of(&[], layout.header_row());
        for _ in 0..MOST_ROWS {
            let Some((number, line)) = lines.next().map_err(unreadable)? else { break };
            if repeated.is_header(number, line) {
                continue;
            }
            let Ok(text) = std::str::from_utf8(line) else { continue };
            let mut row = cells(text, layout.separator);
            let mut own = Vec::new();
            for (at, column) in columns.iter_mut().enumerate() {
                let cell = row.next().map(|(cell, _)| cell);
                let number = cell.and_then(|cell| decimal.number(cell, layout.separator));
                let number = number.filter(|number| number.is_finite());
                let dated = || match calendar(cell?, order)? {
                    Calendar::Moment(time) | Calendar::Day(time) | Calendar::Clock(time) => {
                        time.since(0)
                    }
                };
                let number = number.or_else(dated);
                if number.is_none() && cell.is_none_or(|cell| !cell.is_empty()) {
                    own.push(at);
                }
                column.values.push(number.unwrap_or(f64::NAN));
            }
            words.push(own);
        }
        let is_cut = lines.next().map_err(unreadable)?.is_some();
        let of_numbers: Vec<bool> = columns.iter().map(Surveyed::is_of_numbers).collect();
        let is_bad = |(row, words): &(usize, &Vec<usize>)| {
            let of_text = words.iter().any(|at| of_numbers[*at]);
            of_text.then_some(*row)
        };
        let bad: Vec<usize> = words.iter().enumerate().filter_map(|one| is_bad(&one)).collect();
        let has_number = |row: usize| {
            let numbers =
                columns.iter().zip(&of_numbers).filter(|(_, is_of_numbers)| **is_of_numbers);
            numbers.into_iter().any(|(column, _)| column.values[row].is_finite())
        };
        let text_rows = bad.iter().filter(|row| !has_number(**row)).count();
        let bad_rows = bad.len() - text_rows;
        let header = header.filter(|_| layout.preamble > 0).map(|header| header.line);
        let path = named.to_owned();
        Ok(Self { path, columns, header, dates: orders, format, bad_rows, text_rows, is_cut })
    }

    /// How many rows were looked at.
    pub(super) fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }
}
