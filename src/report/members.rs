//! Members of families that were chosen because nobody stated one.

use serde_json::{Value, json};

use crate::diagnose::evidence::members::Chosen;
use crate::report::figure;
use crate::report::json::number;
use crate::units::decimal;

/// In sentences; empty where none was chosen.
pub fn text(all: &[Chosen]) -> String {
    let each = all.iter().map(|one| {
        let Chosen { name, value, unit, tried, is_of_range, meaning, gains } = one;
        // As many digits as to state it again.
        let is_exact = *is_of_range || meaning.is_some();
        let size = if is_exact { figure::exact(*value, unit) } else { figure::size(*value, unit) };
        let of = if *is_of_range { "values of its range" } else { "members" };
        let next = match gains {
            [Some(own), Some(next)] => format!(
                " (it takes {} off chi squared, the next {})",
                decimal(*own, 1),
                decimal(*next, 1)
            ),
            [Some(_), None] if *tried > 1 => " (the others fit as well)".to_owned(),
            _ => String::new(),
        };
        let meaning = meaning.as_ref().filter(|_| gains[1].is_some());
        let meaning = meaning.map_or_else(String::new, |words| format!(": {words}"));
        format!(
            "\nNo member of the family is stated: `{name}` = {size} fits best of {tried} {of}{next}{meaning}. Uncertainties do not count the choice; `--set {name}=VALUE` states another.\n"
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
