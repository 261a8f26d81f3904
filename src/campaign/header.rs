//! The header of a table: `name [unit]`, a column each, and how a line falls into cells.

use std::collections::HashSet;

use crate::campaign::origin::Origin;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::units::Unit;

/// The column that must be there in every row and must not run backwards.
pub const TIME: &str = "time";

/// A column that somebody needs.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// What the model calls it.
    pub name: String,
    /// What the file calls it, if the campaign says so: name and unit.
    pub header: Option<(String, Option<Unit>)>,
    /// A unit it may be written in.
    pub unit: Unit,
}

/// A column of a table.
#[derive(Clone, Debug)]
pub struct Column {
    /// Its name in the file.
    pub name: String,
    /// Its header as written.
    pub header: String,
    /// The wanted column it is, if any.
    pub wanted: Option<String>,
    /// Its unit in the file (`1` where it is not wanted).
    pub unit: Unit,
    /// Line of the header.
    pub line: usize,
    /// Number of the column, from 0.
    pub index: usize,
    /// Values in SI, NaN where missing; empty where it is not wanted.
    pub values: Vec<f64>,
}

/// Splits a header cell into its name and its unit with the unit's bytes within the cell.
pub fn split(cell: &str) -> (&str, Option<(&str, usize)>) {
    match (cell.find('['), cell.ends_with(']')) {
        (Some(open), true) => {
            (cell[..open].trim(), Some((&cell[open + 1..cell.len() - 1], open + 1)))
        }
        _ => (cell.trim(), None),
    }
}

/// How many faults of a header are reported.
const MOST_FAULTS: usize = 20;

/// Reads a header.
pub(crate) fn read(
    origin: &Origin,
    line: usize,
    text: &str,
    wanted: &[Wanted],
) -> Result<Vec<Column>, Diagnostics> {
    let mut faults = Vec::new();
    let all: Vec<(&str, (usize, usize))> = cells(text).collect();
    let names: HashSet<&str> = all.iter().map(|(cell, _)| split(cell).0).collect();
    let at = |span| origin.place(line, text, span);
    if all.len() == 1 && text.contains([';', '\t']) {
        return Err(Diagnostic::error("columns are separated by commas")
            .at(at((0, text.len())))
            .help("write `time [s],distance [m]`, and numbers with a decimal point")
            .into());
    }
    if names.iter().any(|name| name.parse::<f64>().is_ok()) {
        return Err(Diagnostic::error("the file has no header row")
            .at(at((0, text.len())))
            .help("the first row names the columns, each with its unit: `time [s],distance [m]`")
            .into());
    }
    let mut columns = Vec::with_capacity(all.len());
    let mut before = HashSet::with_capacity(all.len());
    for (index, (cell, span)) in all.iter().enumerate() {
        if faults.len() == MOST_FAULTS {
            break;
        }
        let (name, unit) = split(cell);
        if name.is_empty() {
            faults
                .push(Diagnostic::error(format!("column {} has no name", index + 1)).at(at(*span)));
        } else if !before.insert(name) {
            let message = format!("the column `{}` is here twice", origin.word(name));
            faults.push(Diagnostic::error(message).at(at(*span)));
        }
        let mut column = Column {
            name: name.to_owned(),
            header: (*cell).to_owned(),
            wanted: None,
            unit: Unit::one(),
            line,
            index,
            values: Vec::new(),
        };
        if let Some(want) = find(name, &names, wanted) {
            column.wanted = Some(want.name.clone());
            match read_unit(origin, want, name, unit) {
                Ok(unit) => column.unit = unit,
                Err(fault) => {
                    let (diagnostic, inside) = *fault;
                    let inside = inside.map_or(*span, |(a, b)| (span.0 + a, span.0 + b));
                    faults.push(diagnostic.at(at(inside)));
                }
            }
        }
        columns.push(column);
    }
    Diagnostics(faults).into_result(columns)
}

/// The wanted column that a name of the header stands for: by the campaign's word first.
fn find<'a>(name: &str, names: &HashSet<&str>, wanted: &'a [Wanted]) -> Option<&'a Wanted> {
    let by_word = |want: &&Wanted| want.header.as_ref().is_some_and(|(header, _)| header == name);
    wanted.iter().find(by_word).or_else(|| {
        wanted.iter().find(|want| {
            let renamed =
                want.header.as_ref().is_some_and(|(header, _)| names.contains(header.as_str()));
            want.name == name && !renamed
        })
    })
}

type UnitFault = (Diagnostic, Option<(usize, usize)>);

fn read_unit(
    origin: &Origin,
    want: &Wanted,
    name: &str,
    found: Option<(&str, usize)>,
) -> Result<Unit, Box<UnitFault>> {
    let stated = want.header.as_ref().filter(|(header, _)| header == name);
    let stated = stated.and_then(|(_, unit)| unit.clone());
    let wrong = |unit: &Unit| {
        let message = match want.unit.misses(unit) {
            true => format!("`{}` has no angle, `{}` has one", unit.symbol, want.name),
            false => format!("`{}` is not a unit of `{}`", unit.symbol, want.name),
        };
        let help = format!("it is measured in units such as `{}`", want.unit.symbol);
        Diagnostic::error(message).help(help)
    };
    let Some((text, start)) = found else {
        let Some(stated) = stated else {
            let help = format!("write `{name} [{}]`", want.unit.symbol);
            let error = Diagnostic::error(format!("the column `{name}` has no unit")).help(help);
            return Err(Box::new((error, None)));
        };
        let is_right = want.unit.accepts(&stated);
        return if is_right { Ok(stated) } else { Err(Box::new((wrong(&stated), None))) };
    };
    let unit = Unit::parse(text).map_err(|error| {
        let mut diagnostic = match origin.is_outside {
            true => Diagnostic::error(format!("the unit of the column `{name}` is none")),
            false => Diagnostic::error(error.message),
        };
        diagnostic.help.extend(error.help.filter(|_| !origin.is_outside));
        Box::new((diagnostic, Some((start + error.start, start + error.end))))
    })?;
    let whole = Some((start, start + text.len()));
    if !want.unit.accepts(&unit) {
        return Err(Box::new((wrong(&unit), whole)));
    }
    match stated {
        Some(stated) if stated.factor != unit.factor || stated.offset != unit.offset => {
            let message = format!(
                "the campaign says that `{name}` is in `{}`, the file says `{}`",
                stated.symbol, unit.symbol
            );
            Err(Box::new((Diagnostic::error(message), whole)))
        }
        _ => Ok(unit),
    }
}

/// The cells of a line: text without blanks and quotes, and its bytes in the line. A cell in double
/// quotes may hold commas.
pub(crate) fn cells(line: &str) -> impl Iterator<Item = (&str, (usize, usize))> {
    let mut at = Some(0);
    std::iter::from_fn(move || {
        let start = at?;
        let rest = &line[start..];
        let lead = rest.len() - rest.trim_start().len();
        let comma = match rest[lead..].strip_prefix('"') {
            Some(quoted) => {
                let close = quoted.find('"').map_or(quoted.len(), |close| close + 1);
                let after = lead + 1 + close;
                rest[after..].find(',').map(|comma| after + comma)
            }
            None => rest.find(','),
        };
        at = comma.map(|comma| start + comma + 1);
        let raw = &rest[..comma.unwrap_or(rest.len())];
        let cell = raw.trim();
        let begin = start + (raw.len() - raw.trim_start().len());
        let bare = cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"'));
        Some(match bare {
            Some(bare) => (bare.trim(), (begin + 1, begin + 1 + bare.len())),
            None => (cell, (begin, begin + cell.len())),
        })
    })
}
