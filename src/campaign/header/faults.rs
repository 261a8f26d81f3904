//! The faults of files whose header is missing, or whose first row has no stamp.

use crate::campaign::calendar::seeming;
use crate::campaign::form::{Form, is_missing};
use crate::campaign::origin::Origin;
use crate::campaign::recognise::Head;
use crate::campaign::recognise::layout::Layout;
use crate::diagnostic::Diagnostic;

/// The first cell of a column, where it is neither a number nor a date, a time of day or a reading
/// that is missing.
pub(super) fn no_stamp<'a>(layout: &'a Layout, form: &Form, column: usize) -> Option<&'a str> {
    let cell = layout.first_cell(column)?;
    let is_number = form.decimal.clone().number(cell, layout.separator).is_some();
    let is_known = is_number || seeming(cell).is_some() || is_missing(&form.missing, cell);
    Some(cell).filter(|cell| !cell.is_empty() && !is_known)
}

/// The fault of a file that does not say what its columns are.
pub(in crate::campaign) fn no_header(origin: &Origin, layout: &Layout) -> Diagnostic {
    let (line, text) = &layout.first;
    Diagnostic::error("the file has no header row")
        .at(origin.place(*line, text, (0, text.len())))
        .help("the first row names the columns, each with its unit: `time [s],distance [m]`")
        .help("where the row of names is in another line, write its number beside `file`: header = 4")
        .help("where there is none, count the columns: header = false, columns = { time = { column = 1, unit = \"s\" } }")
}

/// The fault of a file of which no line is a row.
pub(in crate::campaign) fn no_rows(origin: &Origin, head: &Head<'_>) -> Diagnostic {
    let is_list = |(_, text): &&(usize, &str)| text.contains([',', ';', '\t']);
    match head.comments.iter().find(is_list) {
        Some((number, text)) => {
            let begin = text.chars().next().unwrap_or('#');
            let help = format!(
                "rows of numbers come behind it; a line that begins with `{begin}` is a comment"
            );
            Diagnostic::error("the file has no rows: all of its lines are comments")
                .at(origin.place(*number, text, (0, text.len())))
                .help(help)
        }
        None => Diagnostic::error("the file has no header row")
            .at(origin.place(1, "", (0, 0)))
            .help("start the file with a row of column names, `name [unit]`, separated by commas"),
    }
}
