//! Whether a row holds the units of the names above it, and the header with both.

use crate::campaign::dialect::{Separator, cells, names};
use crate::units::Unit;

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
pub(in crate::campaign) fn are_units(row: &str, separator: Separator) -> bool {
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
pub(super) fn joined(
    header: &str,
    row: &str,
    of_names: Separator,
    separator: Separator,
) -> Option<String> {
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

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use crate::campaign::dialect::Separator;
    use crate::campaign::form::Form;
    use crate::campaign::recognise::Head;
    use crate::campaign::recognise::tests::{found, named};

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
}
