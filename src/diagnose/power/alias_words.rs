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
    let visible =
        |rows: &Vec<Row>| find(rows, &row.name).is_some_and(|one| one.state == State::Visible);
    if let Some((remedy, rows)) = tried.iter().find(|(_, rows)| visible(rows)) {
        let is_open = |other: &&String| is_taken_for(rows, other, &row.name);
        if !row.with.iter().any(|other| is_open(&other)) {
            return format!("{does}; {remedy} separates them");
        }
        let lasts =
            |other: &&String| tried.iter().all(|(_, rows)| is_taken_for(rows, other, &row.name));
        let lasting: Vec<String> = row.with.iter().filter(lasts).cloned().collect();
        let but = match lasting.len() {
            0 => String::new(),
            1 => format!(", nothing tried here where {} is", listed(&lasting)),
            _ => format!(", nothing tried here where {} are", listed(&lasting)),
        };
        return format!("{does}; {remedy} separates them where it is the cause{but}");
    }
    let left = |rows: &Vec<Row>| -> Vec<String> {
        let all = row.with.iter();
        all.filter(|other| is_taken_for(rows, &row.name, other)).cloned().collect()
    };
    let each = tried.iter().map(|(remedy, rows)| (remedy, left(rows)));
    let fewer = each.filter(|(_, left)| left.len() < row.with.len() && !left.is_empty());
    if let Some((remedy, left)) = fewer.min_by_key(|(_, left)| left.len()) {
        let gone: Vec<String> =
            row.with.iter().filter(|other| !left.contains(other)).cloned().collect();
        return format!(
            "{does}; {remedy} separates it from {}, but not from {}: {EITHER}",
            listed(&gone),
            listed(&left)
        );
    }
    // Another row says that something separates them, where that effect is the cause.
    let is_named = |other: &String| {
        let named =
            |rows: &Vec<Row>| find(rows, other).is_some_and(|one| one.state == State::Visible);
        tried.iter().any(|(_, rows)| named(rows))
    };
    let here = if row.with.iter().any(is_named) { ", where it is the cause" } else { "" };
    format!("{does}; nothing tried here separates them{here}: {EITHER}")
}

fn find<'r>(rows: &'r [Row], name: &str) -> Option<&'r Row> {
    rows.iter().find(|one| one.name == name)
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
