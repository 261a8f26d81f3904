//! What to type in `columns` for a convention that was mistaken, in the names of the campaign's files:
//! entries that are there already are kept under another name, and formulas take that.

use serde_json::{Map, Value};

use crate::campaign::declared::{ColumnWord, RunEntry};
use crate::diagnostic::Source;
use crate::formula::{Expression, ExpressionKind, Formula};
use crate::formula::{isolate::replaced, show::text};

/// Relative rounding of formulas.
const SAME: f64 = 1e-9;

/// The entries of `columns`, and where they belong.
#[derive(Debug)]
pub(super) struct TypedColumns {
    pub(super) entries: Map<String, Value>,
    /// In words: in which table.
    pub(super) place: String,
}

impl TypedColumns {
    /// Of formulas in the model's names, for the runs of a campaign. Of numbers `in_headers` the header of a
    /// file states the unit, beside which no other one may be stated.
    pub(super) fn of(
        formulas: &[(String, String)],
        runs: &[RunEntry],
        in_headers: &[String],
    ) -> Self {
        let words = |run: &RunEntry| -> Vec<ColumnWord> {
            let tables = run.data.iter().chain(&run.signals).flat_map(|table| &table.columns);
            tables.chain(&run.columns).cloned().collect()
        };
        let known: Vec<ColumnWord> = runs.first().map(words).unwrap_or_default();
        let mut entries = Map::new();
        let mut is_there = false;
        for (name, formula) in formulas {
            is_there |= known.iter().any(|word| word.name.text == *name);
            let own = known.iter().find(|word| word.name.text == *name);
            let own = own.filter(|_| !in_headers.contains(name));
            let value = own
                .and_then(|word| in_other_unit(formula, word))
                .unwrap_or_else(|| in_names_of_files(formula, &known, &mut entries));
            entries.insert(name.clone(), value);
        }
        let place = match (is_there, runs.len() > 1) {
            (false, false) => "in [[runs]]",
            (false, true) => "in each of [[runs]]",
            (true, false) => {
                "among the `columns` that are there, in the place of those of the same name"
            }
            (true, true) => {
                "among the `columns` that are there, in each of [[runs]] likewise, in the place of those of the same name"
            }
        };
        Self { entries, place: place.to_owned() }
    }

    /// As TOML.
    pub(super) fn line(&self) -> String {
        let each = self.entries.iter().map(|(name, value)| format!("{name} = {}", toml(value)));
        format!("columns = {{ {} }}", each.collect::<Vec<_>>().join(", "))
    }
}

/// The entry of a column with another unit, where that is all that a formula of it says.
fn in_other_unit(formula: &str, word: &ColumnWord) -> Option<Value> {
    let unit = word.unit.as_ref().filter(|_| word.formula.is_none() && word.added.is_empty())?;
    let mut entry = word.written.as_object()?.clone();
    let parsed = Formula::parse(Source::new("columns", formula), 0, formula).ok()?;
    let at = |value: f64| parsed.root.value(&|name| (name == word.name.text).then_some(value));
    let times = at(1.0)?;
    let is_scale = at(0.0)? == 0.0 && (at(-2.0)? / times + 2.0).abs() < SAME;
    let other = unit.times(times).filter(|_| is_scale)?;
    entry.insert("unit".to_owned(), other.symbol.into());
    Some(entry.into())
}

/// A formula in which what files call otherwise has a name of its own, with its entry.
fn in_names_of_files(
    formula: &str,
    known: &[ColumnWord],
    entries: &mut Map<String, Value>,
) -> Value {
    let Ok(parsed) = Formula::parse(Source::new("columns", formula), 0, formula) else {
        return formula.into();
    };
    let word_of = |name: &str| known.iter().find(|word| word.name.text == name);
    // A column alone is no formula.
    if let ExpressionKind::Name(name) = &parsed.root.kind
        && let Some(word) = word_of(name)
    {
        return word.written.clone();
    }
    let names: Vec<String> =
        parsed.root.names().into_iter().map(|(name, _)| name.to_owned()).collect();
    for name in &names {
        if let Some(word) = word_of(name).filter(|word| word.formula.is_none()) {
            entries.insert(as_read(name), word.written.clone());
        }
    }
    let of = |name: &str| -> Option<Expression> {
        let word = word_of(name)?;
        Some(match &word.formula {
            Some(formula) => formula.root.clone(),
            None => {
                Expression { kind: ExpressionKind::Name(as_read(name)), span: parsed.root.span }
            }
        })
    };
    text(&replaced(&parsed.root, &of)).into()
}

/// What a column is called before a convention is set right.
fn as_read(name: &str) -> String {
    format!("{name}_as_read")
}

/// A value of JSON as TOML in one line.
fn toml(value: &Value) -> String {
    match value {
        Value::Object(entries) => {
            let each = entries.iter().map(|(key, value)| format!("{key} = {}", toml(value)));
            format!("{{ {} }}", each.collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}
