//! Conventions that were mistaken.

use serde_json::{Value, json};

use crate::campaign::declared::RunEntry;
use crate::estimate::conventions::{Instead, Mistaken};
use crate::report::typed_columns::TypedColumns;
use crate::units::decimal;

/// A paragraph, with what to type in these runs; empty if none was mistaken.
pub fn text_for(found: Option<&Mistaken>, runs: &[RunEntry]) -> String {
    let Some(found) = found else { return String::new() };
    let [before, after] = found.variance_factors.map(|factor| decimal(factor, 2));
    let what = if found.what.len() == 1 { "A convention" } else { "Conventions" };
    let mut text = format!(
        "\n{what} may have been mistaken; set right, the variance factor falls from {before} to {after} ({} ways to read the columns tried{}):\n",
        found.tried,
        if found.not_tried == 0 {
            String::new()
        } else {
            format!(", {} more not", found.not_tried)
        }
    );
    for one in &found.what {
        text.push_str(&format!("  {}\n", line(one)));
    }
    for one in &found.alike {
        text.push_str(&format!("  or, about as well: {}\n", line(one)));
    }
    let typed = TypedColumns::of(&found.columns, runs);
    text.push_str(&format!("To use it, write {}: {}\n", typed.place, typed.line()));
    text
}

fn line(one: &Instead) -> String {
    format!("{}: {} (`{}`)", one.numbers.join(", "), one.title, one.name)
}

/// The same for programs: null if none was mistaken.
pub fn json_for(found: Option<&Mistaken>, runs: &[RunEntry]) -> Value {
    let each = |all: &[Instead]| -> Value {
        let one = |one: &Instead| json!({ "convention": one.name, "title": one.title, "of": one.numbers });
        all.iter().map(one).collect()
    };
    let whole = found.map(|found| {
        let columns = TypedColumns::of(&found.columns, runs).entries;
        json!({
            "mistaken": each(&found.what),
            "alike": each(&found.alike),
            "columns": columns,
            "variance_factors": found.variance_factors,
            "tried": found.tried,
            "not_tried": found.not_tried,
        })
    });
    json!({ "conventions": whole })
}

/// The paragraph in the model's names, for files that have them.
pub fn text(found: Option<&Mistaken>) -> String {
    text_for(found, &[])
}

/// The same for programs.
pub fn json(found: Option<&Mistaken>) -> Value {
    json_for(found, &[])
}
