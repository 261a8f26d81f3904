//! What separates an effect from its aliases, so that the rows of both say the same.
//!
//! A row is of the campaigns in which its effect is the cause. An effect with a value for each run may
//! be named there where its values differ, while one with a value common to all runs never is: the
//! first can do all that the second does. So it counts in which of both rows an alias is gone.

use super::sight::NEAREST;
use super::{Row, State};

/// What becomes of a value that an alias may have.
const EITHER: &str =
    "either will do for this rig, but its value is not to be carried over to another";

/// The sentence for a row with aliases; `tried` are designs with one thing more each.
pub(super) fn alias_words(row: &Row, tried: &[(String, Vec<Row>)]) -> String {
    let does = format!("it does what {} can do", listed(&row.with));
    let with = |is: &dyn Fn(&String) -> bool| -> Vec<String> {
        row.with.iter().filter(|other| is(other)).cloned().collect()
    };
    if let Some((remedy, rows)) = tried.iter().find(|(_, rows)| is_visible(rows, &row.name)) {
        if with(&|other| is_taken_for(rows, other, &row.name)).is_empty() {
            return format!("{does}; {remedy} separates them");
        }
        let lasting =
            with(&|other| tried.iter().all(|(_, rows)| is_taken_for(rows, other, &row.name)));
        let but = match lasting.len() {
            0 => String::new(),
            1 => format!(", nothing tried here where {} is", listed(&lasting)),
            _ => format!(", nothing tried here where {} are", listed(&lasting)),
        };
        return format!("{does}; {remedy} separates them where it is the cause{but}");
    }
    let left = tried
        .iter()
        .map(|(remedy, rows)| (remedy, with(&|other| is_taken_for(rows, &row.name, other))));
    let fewer = left.filter(|(_, left)| left.len() < row.with.len() && !left.is_empty());
    if let Some((remedy, left)) = fewer.min_by_key(|(_, left)| left.len()) {
        let (gone, left) = (listed(&with(&|other| !left.contains(other))), listed(&left));
        return format!("{does}; {remedy} separates it from {gone}, but not from {left}: {EITHER}");
    }
    // Another row says that something separates them, where that effect is the cause.
    let is_named = |other: &String| tried.iter().any(|(_, rows)| is_visible(rows, other));
    let here = if row.with.iter().any(is_named) { ", where it is the cause" } else { "" };
    format!("{does}; nothing tried here separates them{here}: {EITHER}")
}

fn find<'r>(rows: &'r [Row], name: &str) -> Option<&'r Row> {
    rows.iter().find(|one| one.name == name)
}

fn is_visible(rows: &[Row], name: &str) -> bool {
    find(rows, name).is_some_and(|one| one.state == State::Visible)
}

/// Whether an effect may be taken for another one in a design. Of many aliases only the nearest are
/// listed: then it is not known that it may not.
fn is_taken_for(rows: &[Row], name: &str, other: &str) -> bool {
    find(rows, name).is_none_or(|one| match one.state {
        State::Visible => false,
        State::Alias => one.with.len() >= NEAREST || one.with.iter().any(|known| known == other),
        State::Absorbed | State::NotTestable => true,
    })
}

/// `a`, `b` and `c`.
pub(super) fn listed(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        None => "others".to_owned(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
    }
}
