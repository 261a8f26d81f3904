//! A table from its file: the header is read, and no row is at hand yet.

use std::fs::File;
use std::path::Path;

use super::source::Source;
use super::{Table, TableError, whole_line};
use crate::campaign::date_order;
use crate::campaign::form::{Form, HeaderRow};
use crate::campaign::header::faults::{no_header, no_rows};
use crate::campaign::header::{self, Column, Header, Wanted};
use crate::campaign::lines::Lines;
use crate::campaign::origin::Origin;
#[cfg(feature = "parquet")]
use crate::campaign::parquet::Rows;
use crate::campaign::preamble::{head_lines, pass_header};
use crate::campaign::recognise::Head;
use crate::campaign::recognise::layout::Layout;
use crate::campaign::repeated_rows::RepeatedRows;
use crate::campaign::repeats::Repeats;
use crate::campaign::row::Reader;
use crate::diagnostic::Diagnostic;
use crate::document::files::{Files, Input, Refused, open_regular, reason, refused};

impl Table {
    /// Reads the wanted columns of a whole file.
    ///
    /// # Errors
    /// Those of [`Table::open`] and [`Table::more`].
    pub fn read(path: &Path, wanted: &[Wanted], skip_bad_rows: bool) -> Result<Self, TableError> {
        let mut table = Self::open(path, &Form::default(), wanted, skip_bad_rows)?;
        table.more(usize::MAX)?;
        Ok(table)
    }

    /// Reads the header of a file; no row is at hand yet.
    ///
    /// With `skip_bad_rows`, rows of the wrong length, with cells that are no numbers or with a
    /// time that is missing or runs backwards are left out and listed in [`Table::skipped`].
    ///
    /// # Errors
    /// The file cannot be read, or the header is at fault.
    pub fn open(
        path: &Path,
        form: &Form,
        wanted: &[Wanted],
        skip_bad_rows: bool,
    ) -> Result<Self, TableError> {
        Self::open_of(&mut Files::default(), path, form, wanted, skip_bad_rows)
    }

    /// The same of a file that is one of others: messages show nothing of one outside their folder.
    ///
    /// # Errors
    /// As for [`Table::open`]; a file outside the folder where none is allowed.
    pub fn open_of(
        files: &mut Files,
        path: &Path,
        form: &Form,
        wanted: &[Wanted],
        skip_bad_rows: bool,
    ) -> Result<Self, TableError> {
        let unreadable = |error: std::io::Error| match refused(&error) {
            Some(Refused::Outside) => TableError::Refused(reason(path, &error)),
            _ => TableError::Unreadable(reason(path, &error)),
        };
        let Input { file, is_outside, .. } = files.open(path).map_err(unreadable)?;
        let origin = Origin { file: path.display().to_string().into(), is_outside };
        if is_parquet(path) {
            let form = Form { unused: form.unused.clone(), ..Form::default() };
            return Self::open_parquet(path, file, origin, (&form, wanted), skip_bad_rows);
        }
        let content = |faults| TableError::Content(origin.faults(faults));
        let mut source = Lines::of(file).map_err(unreadable)?;
        let head = Head::of(source.head(head_lines(form)).map_err(unreadable)?);
        let nothing = no_rows(&origin, &head);
        let layout = head.layout(form);
        let Some(layout) = layout else {
            // Nothing is there, or the first row is no text.
            let fault = match source.next().map_err(unreadable)? {
                Some((number, line)) => origin.not_utf8(number, line),
                None => nothing,
            };
            return Err(content(fault.into()));
        };
        if let Some(HeaderRow::In(line)) = form.header
            && layout.first.0 != line
        {
            return Err(content(no_row_in(&origin, line).into()));
        }
        let header = header::read(&origin, &layout, form, wanted).map_err(content)?;
        let Header { columns, format, computed } = header;
        let is_used = !computed.is_empty() || columns.iter().any(|column| column.wanted.is_some());
        if layout.header.is_none() && !is_used {
            return Err(content(no_header(&origin, &layout).into()));
        }
        let settled = date_order::settled(path, form, (&origin, &layout), &columns);
        let form = &settled.map_err(unreadable)?.map_err(|fault| content(fault.into()))?;
        pass_header(&mut source, &layout).map_err(unreadable)?;
        let source = Source::Text(source);
        let table = Self::new(path, origin, form, columns, layout, source, skip_bad_rows);
        Ok(Self { format, ..table }.with(computed, wanted))
    }

    fn new(
        path: &Path,
        origin: Origin,
        form: &Form,
        columns: Vec<Column>,
        layout: Layout,
        source: Source,
        skip: bool,
    ) -> Self {
        Self {
            path: path.to_owned(),
            reader: Reader::new(origin.clone(), form, layout.separator, &columns),
            file: origin.file.clone(),
            origin,
            width: columns.len(),
            repeated: RepeatedRows::of(&columns, layout.header_row()),
            columns,
            lines: Vec::new(),
            skipped: Vec::new(),
            skipped_count: 0,
            source,
            skip,
            sorted: None,
            faults: Repeats::default(),
            count: 0,
            layout,
            form: form.clone(),
            format: None,
            computed: Vec::new(),
        }
    }

    #[cfg(not(feature = "parquet"))]
    fn open_parquet(
        path: &Path,
        _: File,
        _: Origin,
        _: (&Form, &[Wanted]),
        _: bool,
    ) -> Result<Self, TableError> {
        Err(TableError::Unreadable(format!(
            "`{}` cannot be read: this program was built without the feature `parquet` (build it with `--features parquet`, or write the table as CSV, plain or .gz)",
            path.display()
        )))
    }

    /// The names of columns are taken as the header of a text file would be.
    #[cfg(feature = "parquet")]
    fn open_parquet(
        path: &Path,
        file: File,
        origin: Origin,
        (form, wanted): (&Form, &[Wanted]),
        skip: bool,
    ) -> Result<Self, TableError> {
        let content = |faults| TableError::Content(origin.faults(faults));
        let mut rows = Rows::of(path, file).map_err(TableError::Unreadable)?;
        let layout = Layout::of_names(&rows.names());
        let Header { columns, .. } =
            header::read(&origin, &layout, form, wanted).map_err(content)?;
        let read = columns.iter().filter(|column| column.wanted.is_some());
        rows.want(read.map(|column| column.index).collect()).map_err(|(column, found)| {
            let message = format!("the column `{}` holds {found}", columns[column].name);
            let place = origin.cell(1, &layout.first.1, layout.separator, column);
            let fault = Diagnostic::error(message).at(place).help("write it as numbers");
            content(fault.into())
        })?;
        let source = Source::Parquet(Box::new(rows));
        Ok(Self::new(path, origin, form, columns, layout, source, skip))
    }
}

/// The columns of a file; none where it cannot be read.
pub(in crate::campaign) fn columns_in(path: &Path, form: &Form) -> Vec<Column> {
    let layout = || {
        let mut lines = open_regular(path).and_then(Lines::of).ok()?;
        let layout = Head::of(lines.head(head_lines(form)).ok()?).layout(form)?;
        let origin = Origin { file: "".into(), is_outside: false };
        header::read(&origin, &layout, form, &[]).ok().map(|header| header.columns)
    };
    match is_parquet(path) {
        true => Table::open(path, form, &[], false).map(|table| table.columns).unwrap_or_default(),
        false => layout().unwrap_or_default(),
    }
}

pub(in crate::campaign) fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "parquet")
}

/// The fault of a stated header that is none.
fn no_row_in(origin: &Origin, line: usize) -> Diagnostic {
    Diagnostic::error(format!("there is no header row in line {line}"))
        .at(whole_line(origin, line, ""))
        .help("it is empty, a comment, or beyond the end: lines count from 1, as an editor shows them")
}
