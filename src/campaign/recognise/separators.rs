//! What separates the cells of a table's rows, and whether its first row is one of numbers.

use super::layout::dated;
use crate::campaign::calendar::seeming;
use crate::campaign::dialect::{Decimal, SEPARATORS, Separator, cells, names};
use crate::campaign::form::{Form, is_missing};

/// A row: its line, from 1, and its text.
type Row<'a> = (usize, &'a str);

/// Whether all cells of the first row are numbers, or empty, between some separator.
pub(super) fn begins_with_readings(rows: &[Row<'_>], form: &Form) -> bool {
    let Some((_, first)) = rows.first() else { return false };
    candidates(form).any(|separator| {
        let mut decimal = form.decimal;
        let mut all = cells(first, separator);
        all.all(|(cell, _)| is_reading(cell, &mut decimal, separator, form))
    }) && first.contains(|c: char| c.is_ascii_digit())
}

/// Whether the first row holds numbers among texts, and is cut like the rows behind it: names are
/// no numbers.
pub(super) fn begins_with_numbers(rows: &[Row<'_>], form: &Form) -> bool {
    let Some(((_, first), others)) = rows.split_first() else { return false };
    let (separator, _) = separators(rows, form, false);
    let width = cells(first, separator).count();
    let alike = others.iter().filter(|(_, row)| cells(row, separator).count() == width).count();
    numbers(first, separator, form) > 0 && 2 * alike >= others.len()
}

/// What separates the cells of rows, and the names of the header: what splits most rows alike.
pub(super) fn separators(all: &[Row<'_>], form: &Form, has_header: bool) -> (Separator, Separator) {
    let count = |line: &str, separator| cells(line, separator).count();
    let Some((_, first)) = all.first() else { return Default::default() };
    let rows = &all[usize::from(has_header)..];
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

/// The separators that may be a file's.
pub(in crate::campaign) fn candidates(form: &Form) -> impl Iterator<Item = Separator> + use<> {
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
pub(in crate::campaign) fn numbers(row: &str, separator: Separator, form: &Form) -> usize {
    let mut decimal = form.decimal;
    let all = cells(row, separator);
    let mut is_number = |cell| decimal.number(cell, separator).is_some() || seeming(cell).is_some();
    all.filter(|(cell, _)| is_number(cell)).count()
}

#[cfg(test)]
mod tests {
    use crate::campaign::dialect::Separator;
    use crate::campaign::recognise::tests::{found, named};

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
    fn what_stands_in_one_column_is_not_split() {
        assert_eq!(found("x [m]\n1\n2\n"), (Separator::Comma, named(&["x [m]"]), 1));
        assert_eq!(found("my column\n1\n2\n").0, Separator::Comma);
    }
}
