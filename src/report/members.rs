//! Members of families that were chosen because nobody stated one.

use serde_json::{Value, json};

use crate::diagnose::evidence::members::Chosen;
use crate::report::figure;
use crate::report::json::number;
use crate::units::decimal;

/// In sentences; empty where none was chosen.
pub fn text(all: &[Chosen]) -> String {
    let each = all.iter().map(|one| {
        let Chosen { name, value, unit, tried, is_of_range, gains } = one;
        // As many digits as to state it again.
        let size = if *is_of_range { figure::exact(*value, unit) } else { figure::size(*value, unit) };
        let of = if *is_of_range { "values of its range" } else { "members" };
        let next = match gains {
            [Some(own), Some(next)] => format!(
                " (it takes {} off chi squared, the next {})",
                decimal(*own, 1),
                decimal(*next, 1)
            ),
            _ => String::new(),
        };
        format!(
            "\nNo member of the family is stated: `{name}` = {size} fits best of {tried} {of}{next}. Uncertainties do not count the choice; `--set {name}=VALUE` states another.\n"
        )
    });
    each.collect()
}

/// The same for programs.
pub fn json(all: &[Chosen]) -> Value {
    let each = all.iter().map(|one| {
        json!({
            "name": one.name,
            "value": number(Some(one.value)),
            "unit": one.unit.si_symbol(),
            "tried": one.tried,
            "gain": number(one.gains[0]),
            "next": number(one.gains[1]),
        })
    });
    json!({ "members": each.collect::<Vec<_>>() })
}
