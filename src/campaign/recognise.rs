//! How a text table is laid out, recognised from its first rows.
//!
//! Of all separators the one is taken that splits most of the rows into as many cells as the header
//! has names. Without any numbers the first row is the header; where it holds numbers
//! the last comment before it with as many names is the header, if there is one. What comes before
//! the header is [`super::preamble`]'s business.

pub(super) mod layout;
pub(super) mod separators;
pub(super) mod units;

use crate::campaign::dialect::{SEPARATORS, Separator, cells, names};
use crate::campaign::form::{Form, HeaderRow, MOST_LINE};
use layout::{Header, Layout, dated};
use separators::{begins_with_numbers, begins_with_readings, separators};
use units::{are_units, joined};

/// Rows by which a file's form is recognised.
pub(crate) const ROWS: usize = 20;
/// Characters with which a comment begins.
pub(crate) const COMMENT: [char; 2] = ['#', '%'];

/// The longest row (bytes) that is kept.
const LONGEST_ROW: usize = 4096;

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
        let is_row =
            || begins_with_readings(&self.rows, form) || begins_with_numbers(&self.rows, form);
        let has_header = form.header.map_or_else(|| !is_row(), |one| one != HeaderRow::None);
        let (separator, of_names) = separators(&self.rows, form, has_header);
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

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::Head;
    use crate::campaign::dialect::Separator;
    use crate::campaign::form::Form;

    pub(super) fn found(text: &str) -> (Separator, Option<Vec<String>>, usize) {
        let layout = Head::of(text.as_bytes()).layout(&Form::default()).unwrap();
        let header = layout
            .header
            .map(|header| header.names().into_iter().map(|(name, _)| name.to_owned()).collect());
        (layout.separator, header, layout.width)
    }

    pub(super) fn named(names: &[&str]) -> Option<Vec<String>> {
        Some(names.iter().map(|name| (*name).to_owned()).collect())
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
}
