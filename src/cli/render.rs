//! Diagnostics as compilers draw them: `file:line:column`, the line, a mark below it, help.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use super::clean;
use crate::diagnostic::{Diagnostic, Place, Severity};

/// Longest piece of a line that is shown; data files may have lines without end.
const WIDTH: usize = 20_000;

/// Draws messages on standard error.
pub(super) fn all(diagnostics: &[Diagnostic]) {
    for diagnostic in diagnostics {
        one(diagnostic);
    }
}

/// Draws one message on standard error; a closed pipe is no reason to stop.
pub(super) fn one(diagnostic: &Diagnostic) {
    use std::io::Write;
    super::progress::clear();
    let text = drawn(diagnostic);
    let _ = writeln!(anstream::stderr(), "{text}\n");
}

fn drawn(diagnostic: &Diagnostic) -> String {
    let diagnostic = &cleaned(diagnostic);
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = level.primary_title(diagnostic.message.as_str());
    let mut group;
    if let Some(place) = &diagnostic.place {
        let (excerpt, start) = cut(place.excerpt(), place.column.saturating_sub(1));
        let from = excerpt.char_indices().nth(start).map_or(excerpt.len(), |(at, _)| at);
        let to = excerpt
            .char_indices()
            .nth(start + place.length.max(1))
            .map_or(excerpt.len(), |(at, _)| at);
        let mut annotation = AnnotationKind::Primary.span(from..to.max(from));
        if !diagnostic.label.is_empty() {
            annotation = annotation.label(diagnostic.label.as_str());
        }
        // A shortened line would show a wrong column: the place is then said in the path.
        let whole = excerpt == place.excerpt();
        let path = if whole {
            place.file.to_string()
        } else {
            format!("{}:{}:{}, shown in part", place.file, place.line, place.column)
        };
        let snippet =
            Snippet::source(excerpt).line_start(place.line).path(path).annotation(annotation);
        group = title.element(snippet);
    } else {
        group = Group::with_title(title);
    }
    for help in &diagnostic.help {
        group = group.element(Level::HELP.message(help.as_str()));
    }
    Renderer::styled().render(&[group])
}

/// The same without characters that act on a terminal.
fn cleaned(diagnostic: &Diagnostic) -> Diagnostic {
    let Diagnostic { severity, message, place, label, help } = diagnostic;
    Diagnostic {
        severity: *severity,
        message: clean::text(message).into_owned(),
        place: place.as_ref().map(|place| {
            let (file, excerpt) = (clean::line(&place.file), clean::line(place.excerpt()));
            Place::new(file.into(), place.line, place.column, place.length, &excerpt)
        }),
        label: clean::text(label).into_owned(),
        help: help.iter().map(|help| clean::text(help).into_owned()).collect(),
    }
}

/// The part of a line around a column (in characters), and the column in it.
fn cut(line: &str, column: usize) -> (String, usize) {
    if line.chars().count() <= WIDTH {
        return (line.to_owned(), column);
    }
    let from = column.saturating_sub(WIDTH / 2);
    (line.chars().skip(from).take(WIDTH).collect(), column - from)
}
