//! The unit of a column: as its header says, or as the campaign states.

use crate::campaign::endings;
use crate::campaign::origin::Origin;
use crate::campaign::wanted::{Choice, Stated, TIME, Wanted};
use crate::diagnostic::Diagnostic;
use crate::units::Unit;

/// The unit of stamps, if they can count in it; `since_1970` is the unit of stamps since 1970 that
/// are as large.
pub(super) fn counts(unit: Unit, since_1970: Option<&str>) -> Result<Unit, Box<UnitFault>> {
    match since_1970.and_then(|symbol| Some((symbol, Unit::parse(symbol).ok()?))) {
        Some((symbol, usual)) if unit.factor / usual.factor > 999.0 => {
            let message = format!(
                "stamps as large as these count in {symbol} since 1970, not in `{}`",
                unit.symbol
            );
            let help = format!(
                "write `{TIME} [{symbol}]`, or the unit in the campaign where the file has none"
            );
            Err(Box::new((Diagnostic::error(message).help(help), None)))
        }
        _ => Ok(unit),
    }
}

/// The unit that a name says (`heading_deg`, `nanosec`), where it may be that of a quantity.
pub(super) fn by_name(name: &str, like: &Unit) -> Option<&'static str> {
    let symbol = endings::ending(name).or_else(|| endings::decimals(name))?;
    Unit::parse(symbol).is_ok_and(|unit| like.accepts(&unit)).then_some(symbol)
}

/// That a word in the first row of a column without a unit is none that is known.
pub(super) fn no_unit(word: &str) -> Option<String> {
    let is_word = word.chars().any(char::is_alphabetic);
    let error = Unit::parse(word).err().filter(|_| is_word)?;
    Some(format!("the row below has an {}: {}", error.message, error.help.unwrap_or_default()))
}

/// The columns that are added, as a campaign lists them; `open` has no unit yet.
fn list(stated: &Stated, open: &str) -> String {
    let part = |part: &Stated| {
        let column = part.column.as_ref()?;
        let name = column.to_string();
        let own = part.unit.as_ref().map(|unit| unit.symbol.as_str());
        let usual = own.or_else(|| by_name(&name, &Unit::second()));
        let unit = usual.or((name == open).then_some("..."));
        Some(match (column, unit) {
            (Choice::Name(_), Some(unit)) => format!("\"{name} [{unit}]\""),
            (Choice::Name(_), None) => format!("\"{name}\""),
            (Choice::Number(_), Some(unit)) => format!("{{ column = {name}, unit = \"{unit}\" }}"),
            (Choice::Number(_), None) => format!("{{ column = {name} }}"),
        })
    };
    let parts: Vec<String> = [stated].into_iter().chain(&stated.added).filter_map(part).collect();
    parts.join(", ")
}

/// A fault of a unit, and its bytes in the header cell.
pub(super) type UnitFault = (Diagnostic, Option<(usize, usize)>);

/// The unit of a column: that of the header, or `stated`, which must be one that is wanted.
pub(super) fn read_unit(
    origin: &Origin,
    want: &Wanted,
    like: Option<&Unit>,
    stated: Option<Unit>,
    (name, hint): (&str, Option<&str>),
    found: Option<(&str, usize)>,
) -> Result<Unit, Box<UnitFault>> {
    let wrong = |unit: &Unit| {
        let message = match want.unit.misses(unit) {
            true => format!("`{}` has no angle, `{}` has one", unit.symbol, want.name),
            false => format!("`{}` is not a unit of `{}`", unit.symbol, want.name),
        };
        let help = format!("it is measured in units such as `{}`", want.unit.symbol);
        Diagnostic::error(message).help(help)
    };
    let accepts = |unit: &Unit| like.is_none_or(|like| like.accepts(unit));
    let usable = |stated: Unit| match accepts(&stated) {
        true => Ok(stated),
        false => Err(Box::new((wrong(&stated), None))),
    };
    let Some((text, start)) = found else {
        let Some(stated) = stated else {
            let (own, symbol) = (&want.name, hint.unwrap_or(&want.unit.symbol));
            let error = Diagnostic::error(format!("the column `{name}` has no unit"));
            let help = match want.stated.added.is_empty() {
                true => format!(
                    "write `{name} [{symbol}]`, or in the run: columns = {{ {own} = {{ column = \"{name}\", unit = \"{symbol}\" }} }}"
                ),
                false => format!(
                    "give each part of the list its unit: {own} = [{}]",
                    list(&want.stated, name)
                ),
            };
            return Err(Box::new((error.help(help), None)));
        };
        return usable(stated);
    };
    if let (Some(stated), "") = (&stated, text.trim()) {
        return usable(stated.clone());
    }
    let unit = match Unit::parse(text) {
        // What the campaign states counts where the file writes no unit that is known.
        Err(_) if stated.is_some() => return usable(stated.unwrap_or_else(Unit::one)),
        _ if text.trim().is_empty() => Ok(Unit::one()),
        other => other,
    };
    let unit = unit.map_err(|error| {
        let mut diagnostic = match origin.is_outside {
            true => Diagnostic::error(format!("the unit of the column `{name}` is not known")),
            false => Diagnostic::error(error.message),
        };
        diagnostic.help.extend(error.help.filter(|_| !origin.is_outside));
        Box::new((diagnostic, Some((start + error.start, start + error.end))))
    })?;
    let whole = Some((start, start + text.len()));
    if !accepts(&unit) {
        return Err(Box::new((wrong(&unit), whole)));
    }
    match stated {
        Some(stated) if stated.factor != unit.factor || stated.offset != unit.offset => {
            let message = format!(
                "the campaign says that `{name}` is in `{}`, the file says `{}`",
                stated.symbol, unit.symbol
            );
            let help = contradiction(want, name, (&stated, &unit));
            Err(Box::new((Diagnostic::error(message).help(help), whole)))
        }
        _ => Ok(unit),
    }
}

/// What to do where the campaign states one unit of a column and the header another one.
fn contradiction(want: &Wanted, name: &str, (stated, unit): (&Unit, &Unit)) -> String {
    let symbol = &stated.symbol;
    if want.name == TIME {
        // The time is no formula.
        return format!(
            "where the header is right, leave the unit out of `columns`, which beside a run counts for its data and all its streams; where the header is wrong, write `{name} [{symbol}]` there"
        );
    }
    let is_name = name.chars().all(|c| c.is_alphanumeric() || c == '_');
    let column = if is_name { name } else { "COLUMN" };
    format!(
        "where the header is right, leave the unit out of `columns`; where it is wrong, convert the column: {} = \"{column} * {}\"",
        want.name,
        stated.factor / unit.factor
    )
}
