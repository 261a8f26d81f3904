//! Conventions that were mistaken.

use serde_json::{Value, json};

use crate::campaign::declared::RunEntry;
use crate::estimate::conventions::{ChangedFormula, Instead, Mistaken};
use crate::report::typed_columns::TypedColumns;
use crate::units::decimal;

/// How many times larger outliers make a variance factor that is reported without them, too.
const OUTLIERS: f64 = 2.0;

/// Variance factors without outliers, where these are most of what is left.
fn of_most(found: &Mistaken) -> String {
    if found.without_outliers[1] * OUTLIERS > found.variance_factors[1] {
        return String::new();
    }
    let [before, after] = found.without_outliers.map(|factor| decimal(factor, 2));
    format!(", without outliers from {before} to {after}")
}

/// A paragraph, with what to type in these runs; empty if none was mistaken.
pub fn text_for(found: Option<&Mistaken>, runs: &[RunEntry]) -> String {
    let Some(found) = found else { return String::new() };
    let [before, after] = found.variance_factors.map(|factor| decimal(factor, 2));
    let what = if found.what.len() == 1 { "A convention" } else { "Conventions" };
    let place = found.run.as_ref().map_or(String::new(), |run| format!(" in run `{run}`"));
    let mut text = format!(
        "\n{what} may have been mistaken{place}; set right, the variance factor falls from {before} to {after}{} ({} ways to read columns and formulas tried{}):\n",
        of_most(found),
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
        text.push_str(&format!("  or, about as well: {}{}\n", line(one), opposite(one)));
    }
    if let Some(name) = &found.stated {
        text.push_str(&format!("  or, about as well: a wrong stated value of `{name}`\n"));
    }
    if !found.alike.is_empty() || found.stated.is_some() {
        let stated = found.stated.as_ref();
        let by = stated.map_or_else(String::new, |name| format!(", and by where `{name}` is from"));
        text.push_str(&format!("The readings do not distinguish them, but parameters depend on the choice: choose by the programs that wrote the logs{by}.\n"));
    }
    if found.is_doubtful() {
        let after = decimal(found.without_outliers[1], 2);
        text.push_str(&format!("The variance factor is still {after}: another error remains, or this convention imitates one.\n"));
    }
    if !found.columns.is_empty() {
        let typed = typed(found, runs);
        text.push_str(&format!("To use it, write {}: {}\n", typed.place, typed.line()));
    }
    for one in &found.formulas {
        text.push_str(&format!(
            "To use it, write in [{}] of the model, as the formula of `{}`: '{}'\n",
            one.table, one.name, one.formula
        ));
    }
    text
}

/// What to type, in the runs in which it was mistaken.
fn typed(found: &Mistaken, runs: &[RunEntry]) -> TypedColumns {
    let Some(name) = &found.run else {
        return TypedColumns::of(&found.columns, runs, &found.in_headers);
    };
    let own = runs.iter().find(|run| run.name.text == *name).map_or(&[][..], std::slice::from_ref);
    let mut typed = TypedColumns::of(&found.columns, own, &found.in_headers);
    typed.place = format!("{} of run `{name}`", typed.place);
    typed
}

fn line(one: &Instead) -> String {
    format!("{}: {} (`{}`)", one.numbers.join(", "), one.title, one.name)
}

/// Which parameters have the other sign with a choice.
fn opposite(one: &Instead) -> String {
    let names: Vec<String> = one.opposite.iter().map(|name| format!("`{name}`")).collect();
    match names.len() {
        0 => String::new(),
        1 => format!("; then {} has the other sign", names[0]),
        _ => format!("; then {} have the other sign", names.join(", ")),
    }
}

/// The same for programs: null if none was mistaken.
pub fn json_for(found: Option<&Mistaken>, runs: &[RunEntry]) -> Value {
    let one =
        |one: &Instead| json!({ "convention": one.name, "title": one.title, "of": one.numbers });
    let alike = |other: &Instead| {
        let mut value = one(other);
        value["opposite"] = json!(other.opposite);
        value
    };
    let formula = |one: &ChangedFormula| json!({ "table": one.table, "name": one.name, "formula": one.formula });
    let whole = found.map(|found| {
        let columns = typed(found, runs).entries;
        json!({
            "run": found.run,
            "mistaken": found.what.iter().map(one).collect::<Value>(),
            "alike": found.alike.iter().map(alike).collect::<Value>(),
            "stated": found.stated,
            "columns": columns,
            "formulas": found.formulas.iter().map(formula).collect::<Value>(),
            "variance_factors": found.variance_factors,
            "without_outliers": found.without_outliers,
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
