//! What messages say of a table: names of its columns, places of its cells, its layout in words.

use crate::campaign::dialect::{Separator, cells};
use crate::campaign::header::{Choice, Column, TIME};
use crate::campaign::lines::Lines;
use crate::campaign::recognise::ROWS;
use crate::campaign::recognise::layout::Layout;
use crate::campaign::table::Table;
use crate::campaign::table::open::is_parquet;
use crate::diagnostic::Place;
use crate::document::files::open_regular;

impl Table {
    /// What is unusual in the layout of the file, in words.
    pub(crate) fn layout_told(&self) -> Option<String> {
        let Layout { separator, header, .. } = &self.layout;
        let mut words = Vec::new();
        let time = self.column(TIME).map(|time| format!(", stamps in {}", time.unit.symbol));
        let time = time.unwrap_or_default();
        words.extend(self.format.map(|format| format!("in the format `{}`{time}", format.name)));
        if *separator != Separator::Comma {
            words.push(format!("cells between {}", separator.words()));
        }
        if self.reader.has_decimal_commas() {
            words.push("decimal commas".to_owned());
        }
        words.extend(self.encoding().map(|encoding| encoding.words().to_owned()));
        match header {
            None => words.push("no header row".to_owned()),
            Some(header) if header.start > 0 => {
                words.push(format!("the comment in line {} as header row", header.line));
            }
            Some(header) if self.layout.preamble > 0 => {
                words.push(format!("header row in line {}", header.line));
            }
            Some(_) => {}
        }
        (!words.is_empty()).then(|| format!("`{}`: {}", self.name(), words.join(", ")))
    }

    /// What to do where the file holds no rows of numbers, or the header seems to be in another line: most rows
    /// have another number of cells.
    pub(crate) fn header_help(&self) -> Option<String> {
        let header = self.layout.header.as_ref()?;
        let width = |row: &String| cells(row, self.layout.separator).count();
        let is_off = |count: usize| count != self.width && count != self.width + 1;
        let rows = &self.layout.rows;
        let mut decimal = self.form.decimal;
        let mut is_number = |cell: &str| decimal.number(cell, self.layout.separator).is_some();
        let mut holds_number =
            |row: &String| cells(row, self.layout.separator).any(|(cell, _)| is_number(cell));
        if rows.len() < ROWS && !rows.iter().any(&mut holds_number) {
            return Some(format!(
                "no row of the file holds a number: the row of names is taken to be line {}, and rows of numbers come behind it",
                header.line
            ));
        }
        let off = rows.iter().filter(|row| is_off(width(row))).count();
        (2 * off > rows.len()).then(|| {
            format!(
                "the row of names in line {} has other cells than most rows: if the names are in another line, write its number beside `file`, as `header = 4`; `header = false` where there are none",
                header.line
            )
        })
    }

    /// The name of its file without its folder.
    pub(crate) fn name(&self) -> String {
        self.path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// Names of the columns, for messages: of many the first.
    pub fn names(&self) -> String {
        let own = self.columns[..self.width].iter().map(|column| &column.name);
        let named = own.map(|name| match self.form.is_unused(name) {
            true => format!("{name} (`unused`)"),
            false => name.clone(),
        });
        let named: Vec<String> = named.collect();
        self.origin.names(named.iter().map(String::as_str))
    }

    /// Whether messages show nothing of the file.
    pub(crate) fn is_outside(&self) -> bool {
        self.origin.is_outside
    }

    /// Whether the file has a column that a campaign calls so; `wanted` is what the model calls it.
    pub(crate) fn has(&self, wanted: &str, choice: &Choice) -> bool {
        let by_digits = || {
            let is_open = self.layout.header.as_ref().is_none_or(|header| header.start > 0);
            let is_number = matches!(choice, Choice::Name(name) if name.parse::<usize>().is_ok());
            is_open && is_number && self.column(wanted).is_some()
        };
        choice.is_among(&self.columns[..self.width]) || by_digits()
    }

    /// Line and text of the header, or of the first row.
    pub(super) fn header(&self) -> (usize, &str) {
        match &self.layout.header {
            Some(header) => (header.line, &header.text),
            None => (self.layout.first.0, &self.layout.first.1),
        }
    }

    /// The place of a header cell.
    pub fn header_place(&self, column: &Column) -> Place {
        let (line, text) = self.header();
        let names = match &self.layout.header {
            Some(header) => header.names(),
            None => cells(text, self.layout.separator).collect(),
        };
        let span = names.get(column.index).map_or((0, 0), |cell| cell.1);
        self.origin.place(line, text, span)
    }

    /// The place of a cell by its row (index into [`Table::lines`]) and column. The file is read
    /// once more; where that fails, the place has no excerpt.
    pub fn cell_place(&self, row: usize, column: &Column) -> Place {
        let wanted = self.lines.get(row).copied().unwrap_or(1);
        let mut text = String::new();
        if is_parquet(&self.path) {
            let mut place = self.origin.place(wanted, "", (0, 0));
            place.column = column.index + 1;
            return place;
        }
        if let Ok(mut lines) = open_regular(&self.path).and_then(Lines::of) {
            while let Ok(Some((number, line))) = lines.next() {
                if number >= wanted {
                    text = String::from_utf8_lossy(line).into_owned();
                    break;
                }
            }
        }
        self.origin.cell(wanted, &text, self.layout.separator, column.index)
    }
}
