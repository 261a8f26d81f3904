//! How a text table is laid out, recognised from its first rows.
//!
//! Of all separators the one is taken that splits most of the rows into as many cells as the header
//! has names. Without any numbers the first row is the header; where it holds numbers
//! the last comment before it with as many names is the header, if there is one. What comes before
//! the header is [`super::preamble`]'s business.

use crate::campaign::calendar::{Calendar, seeming};
use crate::campaign::dialect::{Cell, Decimal, SEPARATORS, Separator, cells, names};
use crate::campaign::form::{Form, HeaderRow, MOST_LINE, is_missing};
use crate::units::Unit;

/// Rows by which a file's form is recognised.
pub(crate) const ROWS: usize = 20;
/// Characters with which a comment begins.
pub(crate) const COMMENT: [char; 2] = ['#', '%'];

/// The header row of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    /// Its line (from 1) and its text, as written.
    pub(crate) line: usize,
    pub(crate) text: String,
    /// Byte at which its names begin, and what separates them.
    pub(crate) start: usize,
    pub(crate) separator: Separator,
    /// The column without a name: the time of day behind a date, where one name stands for both.
    pub(crate) unnamed: Option<usize>,
}

impl Header {
    /// The names of all columns, each with its bytes in the text.
    pub(crate) fn names(&self) -> Vec<Cell<'_>> {
        let moved = |(name, (from, to))| (name, (from + self.start, to + self.start));
        let all = names(&self.text[self.start..], self.separator).into_iter().map(moved);
        let mut all: Vec<Cell<'_>> = all.collect();
        if let Some(at) = self.unnamed.filter(|at| (1..=all.len()).contains(at)) {
            let end = all[at - 1].1.1;
            all.insert(at, ("", (end, end)));
        }
        all
    }

    /// The same for a row with one cell more than there are names, where one of them stands for a date
    /// and the time of day behind it.
    fn over(self, row: &str, separator: Separator) -> Self {
        let count = self.names().len();
        let days = dated(row, separator);
        match days.as_slice() {
            [day] if cells(row, separator).count() == count + 1 && *day < count => {
                Self { unnamed: Some(day + 1), ..self }
            }
            _ => self,
        }
    }
}

/// How a file is laid out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) separator: Separator,
    /// `None`: the first row holds readings.
    pub(crate) header: Option<Header>,
    /// Cells of the first row.
    pub(crate) width: usize,
    /// Line and text of the first row, the header where it is one.
    pub(crate) first: (usize, String),
    /// Rows before the header.
    pub(crate) preamble: usize,
    /// Whether the row behind the header holds the units of its names, which stand in the header then.
    pub(crate) has_units: bool,
    /// The first rows behind the header, long ones left out.
    pub(crate) rows: Vec<String>,
}

/// The longest row (bytes) that is kept.
const LONGEST_ROW: usize = 4096;

impl Layout {
    /// The header row as it stands in a text file, if there is one that is no comment.
    pub(crate) fn header_row(&self) -> Option<String> {
        let header = self.header.as_ref().filter(|header| header.line == self.first.0);
        header.map(|_| self.first.1.clone())
    }

    /// The numbers of the first rows; NaN for a cell that is none.
    pub(crate) fn numbers(&self, form: &Form) -> Vec<Vec<f64>> {
        let number = |(cell, _): (&str, _)| {
            let mut decimal = form.decimal;
            decimal.number(cell, self.separator).unwrap_or(f64::NAN)
        };
        let row = |row: &String| cells(row, self.separator).map(number).collect();
        self.rows.iter().map(row).collect()
    }

    /// A cell of the first row.
    pub(crate) fn first_cell(&self, index: usize) -> Option<&str> {
        cells(self.rows.first()?, self.separator).nth(index).map(|(cell, _)| cell)
    }

    /// The time of day behind a date, or the date before a time of day, by the first row.
    pub(crate) fn beside(&self, index: usize) -> Option<usize> {
        let days = dated(self.rows.first()?, self.separator);
        let day = days.into_iter().find(|day| *day == index || *day + 1 == index)?;
        Some(2 * day + 1 - index)
    }
}

#[cfg(feature = "parquet")]
impl Layout {
    /// Of a file that names its columns, but is no text.
    pub(crate) fn of_names(names: &[String]) -> Self {
        let quoted = names.iter().map(|name| format!("\"{}\"", name.replace('"', "\u{2033}")));
        let text = quoted.collect::<Vec<_>>().join(",");
        let separator = Separator::Comma;
        Self {
            separator,
            header: Some(Header {
                line: 1,
                text: text.clone(),
                start: 0,
                separator,
                unnamed: None,
            }),
            width: names.len(),
            first: (1, text),
            preamble: 0,
            has_units: false,
            rows: Vec::new(),
        }
    }
}

/// The first lines of a file that hold something: numbers from 1, and texts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Head<'a> {
    /// Comments before the first row.
    pub(crate) comments: Vec<(usize, &'a str)>,
    /// Rows, the header included.
    pub(crate) rows: Vec<(usize, &'a str)>,
}

impl<'a> Head<'a> {
    /// Of the beginning of a text, as far as it is UTF-8.
    pub(crate) fn of(bytes: &'a [u8]) -> Self {
        let mut head = Self::default();
        for (number, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
            let Ok(text) = std::str::from_utf8(line) else { break };
            let text = text.strip_suffix('\r').unwrap_or(text);
            let first = text.trim_start().chars().next();
            let own = match first {
                None => continue,
                Some(first) if COMMENT.contains(&first) => {
                    if !head.rows.is_empty() {
                        continue;
                    }
                    &mut head.comments
                }
                Some(_) => &mut head.rows,
            };
            own.push((number + 1, text));
            if head.rows.len() > MOST_LINE + ROWS {
                break;
            }
        }
        head
    }

    /// How the file is laid out; `None` without any row.
    pub(crate) fn layout(&self, form: &Form) -> Option<Layout> {
        // Where a stated header is beyond the end, the first row shows that it is another one.
        let preamble =
            Some(self.preamble(form)).filter(|rows| *rows < self.rows.len()).unwrap_or(0);
        let rows = self.rows[preamble..].iter().take(ROWS + 1).copied().collect();
        let layout = Self { comments: self.comments.clone(), rows }.without_preamble(form)?;
        Some(Layout { preamble, ..layout })
    }

    fn without_preamble(&self, form: &Form) -> Option<Layout> {
        let (line, text) = *self.rows.first()?;
        let first = (line, text.to_owned());
        let is_row = || self.begins_with_readings(form) || self.begins_with_numbers(form);
        let has_header = form.header.map_or_else(|| !is_row(), |one| one != HeaderRow::None);
        let (separator, of_names) = self.separators(form, has_header);
        let width = cells(text, separator).count();
        let mut has_units = false;
        let (header, width) = if has_header {
            let with_units =
                self.rows.get(1).and_then(|(_, units)| joined(text, units, of_names, separator));
            has_units = with_units.is_some();
            let text = with_units.unwrap_or_else(|| text.to_owned());
            let header = Header { line, text, start: 0, separator: of_names, unnamed: None };
            let row = self.rows.get(1 + usize::from(has_units));
            let header = header.over(row.map_or("", |(_, row)| *row), separator);
            let width = header.names().len();
            (Some(header), width)
        } else if form.header == Some(HeaderRow::None) {
            (None, width)
        } else {
            (self.commented(separator, text), width)
        };
        let heads = usize::from(has_header) + usize::from(has_units);
        let rows = self.rows.iter().skip(heads).map(|(_, row)| *row);
        let rows = rows.filter(|row| row.len() <= LONGEST_ROW).map(str::to_owned).collect();
        Some(Layout { separator, header, width, first, preamble: 0, has_units, rows })
    }

    /// Whether all cells of the first row are numbers, or empty, between some separator.
    fn begins_with_readings(&self, form: &Form) -> bool {
        let Some((_, first)) = self.rows.first() else { return false };
        candidates(form).any(|separator| {
            let mut decimal = form.decimal;
            let mut all = cells(first, separator);
            all.all(|(cell, _)| is_reading(cell, &mut decimal, separator, form))
        }) && first.contains(|c: char| c.is_ascii_digit())
    }

    /// Whether the first row holds numbers among texts, and is cut like the rows behind it: names are
    /// no numbers.
    fn begins_with_numbers(&self, form: &Form) -> bool {
        let Some(((_, first), others)) = self.rows.split_first() else { return false };
        let (separator, _) = self.separators(form, false);
        let width = cells(first, separator).count();
        let alike = others.iter().filter(|(_, row)| cells(row, separator).count() == width).count();
        numbers(first, separator, form) > 0 && 2 * alike >= others.len()
    }

    /// What separates the cells of rows, and the names of the header: what splits most rows alike.
    fn separators(&self, form: &Form, has_header: bool) -> (Separator, Separator) {
        let count = |line: &str, separator| cells(line, separator).count();
        let Some((_, first)) = self.rows.first() else { return Default::default() };
        let rows = &self.rows[usize::from(has_header)..];
        let width = |separator| match has_header {
            true => names(first, separator).len(),
            false => count(first, separator),
        };
        let score = |separator: Separator| {
            let width = width(separator);
            let alike = rows.iter().filter(|(_, row)| {
                let found = count(row, separator);
                let is_more = || ends_empty(row, separator) || !dated(row, separator).is_empty();
                found == width || found == width + 1 && is_more()
            });
            let numbers: usize = rows.iter().map(|(_, row)| numbers(row, separator, form)).sum();
            (alike.count(), numbers)
        };
        // Of those that do equally well the first.
        let mut best: Option<((usize, usize), Separator)> = None;
        for separator in candidates(form).filter(|separator| width(*separator) > 1) {
            let own = score(separator);
            if own.0 > 0 && best.is_none_or(|(known, _)| own > known) {
                best = Some((own, separator));
            }
        }
        // One column, or no row like another: as the header falls into names.
        let of_header = || {
            let usual = [Separator::Comma, Separator::Semicolon, Separator::Tab];
            let usual = usual.into_iter().filter(|usual| candidates(form).any(|own| own == *usual));
            usual.clone().find(|own| width(*own) > 1).or_else(|| usual.clone().next())
        };
        let found = best.map(|(_, separator)| separator).or_else(of_header);
        let found = found.or(form.separator).unwrap_or_default();
        // The names of a header may be separated otherwise than the cells of its rows.
        if let (None, true, Some((_, row))) = (best, has_header, rows.first()) {
            for own in candidates(form) {
                let cells = count(row, own);
                let fits = |of_names: &Separator| names(first, *of_names).len() == cells;
                if let Some(of_names) = SEPARATORS.into_iter().find(fits).filter(|_| cells > 1) {
                    return (own, of_names);
                }
            }
        }
        let fits = |own: &Separator| names(first, *own).len() == width(found);
        let of_names = match found {
            Separator::Blanks => SEPARATORS.into_iter().find(fits).unwrap_or(found),
            _ => found,
        };
        (found, of_names)
    }

    /// The last comment before the first row that holds a name for each of its cells, or of a date and
    /// the time of day behind it one.
    fn commented(&self, separator: Separator, row: &str) -> Option<Header> {
        let by = separator;
        let width = cells(row, by).count();
        let fewer = width - usize::from(dated(row, by).len() == 1).min(width);
        let mut units: Option<&str> = None;
        self.comments.iter().rev().find_map(|(line, text)| {
            let bare = text.trim_start().trim_start_matches(COMMENT);
            let start = text.len() - bare.len();
            let fits = |own: &Separator| {
                let names = names(bare, *own);
                let is_name = |(name, _): &(&str, _)| name.parse::<f64>().is_err();
                [width, fewer].contains(&names.len()) && names.iter().all(is_name)
            };
            // Between blanks a comma would be part of a name.
            let first = Some(separator).filter(|own| *own != Separator::Blanks);
            let separator = first.into_iter().chain(SEPARATORS).find(fits)?;
            if units.is_none() && are_units(bare, separator) {
                units = Some(bare);
                return None;
            }
            let with_units = units.and_then(|units| joined(bare, units, separator, separator));
            let (text, start) =
                with_units.map_or(((*text).to_owned(), start), |joined| (joined, 0));
            Some(Header { line: *line, text, start, separator, unnamed: None }.over(row, by))
        })
    }
}

/// The cells of a row that hold dates, with a time of day behind them.
fn dated(row: &str, separator: Separator) -> Vec<usize> {
    let kinds: Vec<_> = cells(row, separator).map(|(cell, _)| seeming(cell)).collect();
    let is_dated = |pair: &[Option<Calendar>]| {
        matches!(pair, [Some(Calendar::Day(_)), Some(Calendar::Clock(_))])
    };
    let all = kinds.windows(2).enumerate();
    all.filter(|(_, pair)| is_dated(pair)).map(|(day, _)| day).collect()
}

/// What a cell of a row of units holds.
enum Measure<'a> {
    None,
    Unit(String),
    /// A word that is no unit that is known.
    Word(&'a str),
    /// What stands in no row of units.
    Other,
}

/// Whether a row holds units, one or none for each name, and no numbers. Words may stand among them
/// where most are units that no column is likely to be called.
pub(super) fn are_units(row: &str, separator: Separator) -> bool {
    let all: Vec<Measure<'_>> = unit_cells(row, separator).into_iter().map(measure).collect();
    let count = |is: fn(&&Measure<'_>) -> bool| all.iter().filter(is).count();
    let words = count(|one| matches!(one, Measure::Word(_)));
    let units = count(|one| matches!(one, Measure::Unit(unit) if unit != "1"));
    let is_sure = |one: &&Measure<'_>| matches!(one, Measure::Unit(unit) if unit.len() > 1);
    all.len() > 1
        && units > words
        && (words == 0 || count(is_sure) > 0)
        && !all.iter().any(|one| matches!(one, Measure::Other))
}

/// The cells of a row of units: a quote is a unit there (seconds of arc), which a separator ends.
fn unit_cells(row: &str, separator: Separator) -> Vec<&str> {
    let Some(byte) = separator.byte() else {
        return cells(row, separator).map(|(cell, _)| cell).collect();
    };
    let cells = row.split(char::from(byte)).map(str::trim);
    let bare = cells.map(|cell| {
        let quoted = cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"'));
        quoted.map_or(cell, str::trim)
    });
    bare.collect()
}

/// The unit in a cell of a row of units: with or without brackets, nothing for none.
fn measure(cell: &str) -> Measure<'_> {
    let bare = cell.strip_prefix('[').and_then(|cell| cell.strip_suffix(']'));
    let bare = bare.or(cell.strip_prefix('(').and_then(|cell| cell.strip_suffix(')')));
    let text = bare.unwrap_or(cell).trim();
    let is_number = text.parse::<f64>().is_ok() && bare.is_none();
    match Unit::parse(text) {
        _ if text.is_empty() || text == "-" => Measure::None,
        Ok(unit) if !is_number => Measure::Unit(unit.symbol),
        Err(_) if !text.contains(|c: char| c.is_ascii_digit() || "\"[]".contains(c)) => {
            Measure::Word(text)
        }
        _ => Measure::Other,
    }
}

/// A header with the row of units behind it: `name [unit]` for each of its names; `None` where that row
/// holds no units, or names have units already.
fn joined(header: &str, row: &str, of_names: Separator, separator: Separator) -> Option<String> {
    let heads = names(header, of_names);
    let units = unit_cells(row, separator);
    if !are_units(row, separator) || heads.len() != units.len() || header.contains('[') {
        return None;
    }
    let cell = |((head, _), cell): (&(&str, _), &str)| match measure(cell) {
        Measure::Unit(unit) => format!("\"{head} [{unit}]\""),
        Measure::Word(word) => format!("\"{head} [{word}]\""),
        Measure::None | Measure::Other => format!("\"{head}\""),
    };
    let cells: Vec<String> = heads.iter().zip(units).map(cell).collect();
    Some(cells.join(of_names.character()))
}

/// The separators that may be a file's.
pub(super) fn candidates(form: &Form) -> impl Iterator<Item = Separator> + use<> {
    let (stated, decimal) = (form.separator, form.decimal);
    SEPARATORS.into_iter().filter(move |separator| {
        stated.is_none_or(|stated| stated == *separator)
            && (stated.is_some() || (*separator, decimal) != (Separator::Comma, Decimal::Comma))
    })
}

fn ends_empty(row: &str, separator: Separator) -> bool {
    cells(row, separator).last().is_some_and(|(cell, _)| cell.is_empty())
}

fn is_reading(cell: &str, decimal: &mut Decimal, separator: Separator, form: &Form) -> bool {
    cell.is_empty() || decimal.number(cell, separator).is_some() || is_missing(&form.missing, cell)
}

/// How many cells of a row are numbers, dates or times of day.
pub(super) fn numbers(row: &str, separator: Separator, form: &Form) -> usize {
    let mut decimal = form.decimal;
    let all = cells(row, separator);
    let mut is_number = |cell| decimal.number(cell, separator).is_some() || seeming(cell).is_some();
    all.filter(|(cell, _)| is_number(cell)).count()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    fn found(text: &str) -> (Separator, Option<Vec<String>>, usize) {
        let layout = Head::of(text.as_bytes()).layout(&Form::default()).unwrap();
        let header = layout
            .header
            .map(|header| header.names().into_iter().map(|(name, _)| name.to_owned()).collect());
        (layout.separator, header, layout.width)
    }

    fn named(names: &[&str]) -> Option<Vec<String>> {
        Some(names.iter().map(|name| (*name).to_owned()).collect())
    }

    #[test]
    fn separators_are_recognised_with_points_and_commas_as_decimals() {
        use Separator::{Blanks, Comma, Semicolon, Tab};
        for (text, separator) in [
            ("t [s],x [m]\n0,1\n", Comma),
            ("t [s];x [m]\n0,5;1,5\n1,5;2,5\n", Semicolon),
            ("t [s]\tx [m]\n0,5\t1,5\n", Tab),
            ("t [s]   x [m]\n 0.5   1\n10.5   2\n", Blanks),
            ("t [s] x [m]\n0,5 1,5\n", Blanks),
            ("t [s], x [m]\n0, 1\n", Comma),
            ("t [s] , x [m]\n0 , 1\n", Comma),
        ] {
            assert_eq!(found(text), (separator, named(&["t [s]", "x [m]"]), 2), "{text}");
        }
    }

    #[test]
    fn a_header_may_be_a_comment_or_not_there() {
        use Separator::{Blanks, Comma};
        let asl = "#timestamp [ns],p_x [m]\n1403,0.5\n";
        assert_eq!(found(asl), (Comma, named(&["timestamp [ns]", "p_x [m]"]), 2));
        let tum = "# ground truth\n# t x y\n1 2 3\n4 5 6\n";
        assert_eq!(found(tum), (Blanks, named(&["t", "x", "y"]), 3));
        // Names between commas over cells between blanks.
        assert_eq!(found("# t, x, y\n1 2 3\n"), (Blanks, named(&["t", "x", "y"]), 3));
        assert_eq!(found("t,x,y\n1 2 3\n"), (Blanks, named(&["t", "x", "y"]), 3));
        assert_eq!(found("# made on a Monday\n1 2 3\n"), (Blanks, None, 3));
        assert_eq!(found("1,2,nan\n"), (Comma, None, 3));
        // Numbers among texts; a text that holds a number is a name.
        assert_eq!(found("7,0,cam,1.5\n7,5,cam,2.5\n"), (Comma, None, 4));
        assert_eq!(found("7,x,1.5\n"), (Comma, None, 3));
        assert_eq!(found("t,Sensor 2\n0,1\n1,2\n"), (Comma, named(&["t", "Sensor 2"]), 2));
        // A comment before a header is none.
        assert_eq!(found("# a, b\nt,x\n1,2\n"), (Comma, named(&["t", "x"]), 2));
    }

    #[test]
    fn a_row_of_units_behind_the_header_belongs_to_it() {
        let header = named(&["t [s]", "x [mm]", "n"]);
        for text in [
            "t,x,n\ns,mm,-\n0,1,2\n1,2,3\n",
            "t,x,n\n[s],[mm],\n0,1,2\n",
            "# t, x, n\n# s, mm, -\n0,1,2\n",
        ] {
            assert_eq!(found(text), (Separator::Comma, header.clone(), 3), "{text}");
            let layout = Head::of(text.as_bytes()).layout(&Form::default()).unwrap();
            assert_eq!(layout.rows[0], "0,1,2");
        }
        let blanks = "t x n\n[s] [mm] [1]\n0 1 2\n";
        let layout = Head::of(blanks.as_bytes()).layout(&Form::default()).unwrap();
        assert!(layout.has_units && layout.separator == Separator::Blanks, "{layout:?}");
        // Seconds of arc as quotes, and a unit that is not known; a row of words is none.
        for (row, units) in [
            (";\";\u{2033};\'", ["t", "x [arcsec]", "y [arcsec]", "z [arcmin]"]),
            ("s;\"\"\"\";\"mm\";-", ["t [s]", "x [arcsec]", "y [mm]", "z"]),
            ("s;mm;foo;", ["t [s]", "x [mm]", "y [foo]", "z"]),
        ] {
            let text = format!("made on a Monday\n\nt;x;y;z\n{row}\n{}", "0;1,5;2;3\n".repeat(6));
            assert_eq!(found(&text), (Separator::Semicolon, named(&units), 4), "{row}");
            let text = format!("t;x;y;z\n{row}\n0;1,5;2;3\n1;1,5;2;3\n");
            assert_eq!(found(&text), (Separator::Semicolon, named(&units), 4), "{row}");
        }
        assert_eq!(found("t;x;y\ns;up;down\n0;1;2\n").1, named(&["t", "x", "y"]));
        assert_eq!(found("log;log;log\nt;V;axis\n0;1;2\n").1, named(&["log", "log", "log"]));
        // Names that are units, and numbers, are none.
        assert_eq!(found("t,x\n0,1\n").1, named(&["t", "x"]));
        assert_eq!(found("s,m\n0,1\n").1, named(&["s", "m"]));
    }

    #[test]
    fn one_name_over_a_date_and_a_time_of_day_counts_for_both() {
        let rows = "2025/03/26 12:00:00.5 1.5 7\n2025/03/26 12:00:01.0 1.6 8\n";
        for head in ["% made by a receiver\n%  GPST   x-ecef(m) Q\n", "GPST x-ecef(m) Q\n"] {
            let text = format!("{head}{rows}");
            let header = named(&["GPST", "", "x-ecef(m)", "Q"]);
            assert_eq!(found(&text), (Separator::Blanks, header, 4), "{head}");
            let layout = Head::of(text.as_bytes()).layout(&Form::default()).unwrap();
            assert_eq!(
                (layout.beside(0), layout.beside(1), layout.beside(2)),
                (Some(1), Some(0), None)
            );
        }
        let header = named(&["date", "clock", "x", "Q"]);
        assert_eq!(found(&format!("# date clock x Q\n{rows}")).1, header);
        assert_eq!(found(&format!("date clock x Q\n{rows}")).1, header);
        assert_eq!(found(rows).1, None);
    }

    #[test]
    fn what_stands_in_one_column_is_not_split() {
        assert_eq!(found("x [m]\n1\n2\n"), (Separator::Comma, named(&["x [m]"]), 1));
        assert_eq!(found("my column\n1\n2\n").0, Separator::Comma);
    }
}
