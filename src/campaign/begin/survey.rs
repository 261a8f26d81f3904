//! The first rows of a table with all of its columns, whatever they are: for guesses alone.

use std::path::{Path, PathBuf};

use crate::campaign::dialect::{cells, names};
use crate::campaign::form::Form;
use crate::campaign::formats::Format;
use crate::campaign::header::split;
use crate::campaign::lines::Lines;
use crate::campaign::recognise::{Head, ROWS};
use crate::diagnostic::Diagnostic;
use crate::document::files::{open_regular, reason};
use crate::units::Unit;

/// Rows that are looked at.
const MOST_ROWS: usize = 20_000;
/// Columns that are looked at.
const MOST_COLUMNS: usize = 200;

/// A column of a table.
#[derive(Clone, Debug)]
pub(super) struct Surveyed {
    /// Its name; its number where it has none.
    pub(super) name: String,
    pub(super) is_named: bool,
    /// Its unit, where the header has one that is known.
    pub(super) unit: Option<Unit>,
    /// Its numbers; NaN where a cell is none.
    pub(super) values: Vec<f64>,
}

impl Surveyed {
    /// Whether most of its cells are numbers, and not all of them the same.
    pub(super) fn moves(&self) -> bool {
        let finite = self.values.iter().filter(|value| value.is_finite());
        let (mut count, mut least, mut most) = (0, f64::INFINITY, f64::NEG_INFINITY);
        for value in finite {
            count += 1;
            (least, most) = (least.min(*value), most.max(*value));
        }
        2 * count > self.values.len() && most > least
    }
}

/// A table as far as it was looked at.
#[derive(Clone, Debug)]
pub(super) struct Survey {
    /// Its path as the campaign names it.
    pub(super) path: PathBuf,
    pub(super) columns: Vec<Surveyed>,
    /// The format in which it seems to be.
    pub(super) format: Option<&'static Format>,
}

impl Survey {
    /// Looks at a file.
    pub(super) fn of(path: &Path, named: &Path) -> Result<Self, Diagnostic> {
        let unreadable = |error: std::io::Error| {
            Diagnostic::error(reason(path, &error)).help("name text tables: CSV, or of blanks")
        };
        let mut lines = open_regular(path).and_then(Lines::of).map_err(unreadable)?;
        let form = Form::default();
        let layout = Head::of(lines.head(ROWS).map_err(unreadable)?).layout(&form);
        let Some(layout) = layout else {
            let message = format!("`{}` holds no table of text", path.display());
            return Err(Diagnostic::error(message).help("name text tables: CSV, or of blanks"));
        };
        let header = layout.header.as_ref();
        let heads: Vec<&str> = match header {
            Some(header) => {
                let all = names(&header.text[header.start..], header.separator);
                all.into_iter().map(|(name, _)| name).collect()
            }
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
            let unit = unit.and_then(|(unit, _)| match unit.trim() {
                "" => Some(Unit::one()),
                unit => Unit::parse(unit).ok(),
            });
            Surveyed { name, is_named, unit, values: Vec::new() }
        };
        let mut columns: Vec<Surveyed> =
            heads.iter().take(MOST_COLUMNS).enumerate().map(column).collect();
        if header.is_some_and(|header| header.line == layout.first.0) {
            lines.next().map_err(unreadable)?;
        }
        let mut decimal = form.decimal;
        for _ in 0..MOST_ROWS {
            let Some((_, line)) = lines.next().map_err(unreadable)? else { break };
            let Ok(text) = std::str::from_utf8(line) else { continue };
            let mut row = cells(text, layout.separator);
            for column in &mut columns {
                let number =
                    row.next().and_then(|(cell, _)| decimal.number(cell, layout.separator));
                column.values.push(number.unwrap_or(f64::NAN));
            }
        }
        Ok(Self { path: named.to_owned(), columns, format })
    }

    /// How many rows were looked at.
    pub(super) fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }
}
