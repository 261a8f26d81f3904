//! A sentence for each row of the table that a person can act on.

use super::alias_words::{alias_words, listed};
use super::design::Prospect;
use super::{Row, State};

/// More readings than that are no advice.
const MOST_TIMES: f64 = 200.0;

/// So many times the readings are simpler than anything else.
const FEW_TIMES: f64 = 3.0;

/// What to do about an effect; `tried` are designs with one thing more each.
pub(super) fn words(row: &Row, stage: &Prospect, tried: &[(String, Vec<Row>)]) -> String {
    let visible = |other: &Row| other.state == State::Visible;
    let seen = |other: &Row| matches!(other.state, State::Visible | State::Alias);
    let helps = |good: fn(&Row) -> bool| helps(row, tried, good);
    match row.state {
        State::NotTestable => match helps(seen) {
            Some(remedy) => format!("{}; {remedy} would detect it", row.words),
            None => row.words.clone(),
        },
        State::Absorbed => {
            let help = match (helps(visible), helps(seen)) {
                (Some(remedy), _) => format!("{remedy} would detect it"),
                (None, Some(remedy)) => format!("{remedy} would detect it, with an alias"),
                (None, None) => "nothing tried here would detect it".to_owned(),
            };
            format!("absorbed by {}; {help}", listed(&row.with))
        }
        State::Alias => alias_words(row, tried),
        State::Visible => of_visible(row, stage, tried),
    }
}

/// The first remedy that makes the row of the same effect good.
fn helps(row: &Row, tried: &[(String, Vec<Row>)], good: impl Fn(&Row) -> bool) -> Option<String> {
    let same = |other: &Row| other.name == row.name && good(other);
    let found = tried.iter().find(|(_, rows)| rows.iter().any(same));
    found.map(|(remedy, _)| remedy.clone())
}

fn of_visible(row: &Row, stage: &Prospect, tried: &[(String, Vec<Row>)]) -> String {
    let (Some(seen), Some(named)) = (row.detectable, row.identifiable) else {
        return String::new();
    };
    let Some(typical) = row.typical else { return "it is detected and identified".to_owned() };
    let times = |size: f64| (size / typical).powf(row.root);
    let readings = stage.fitted.problem.reading_count() as f64;
    let more = |size: f64| {
        let times = times(size);
        (times <= MOST_TIMES)
            .then(|| format!("{} readings instead of {readings:.0}", round(times * readings)))
    };
    if named <= typical {
        return "the typical magnitude is detected and identified".to_owned();
    }
    let enough = |other: &Row| other.identifiable.is_some_and(|size| size <= typical);
    let found = |other: &Row| other.detectable.is_some_and(|size| size <= typical);
    if seen <= typical {
        let taken = if row.with.is_empty() {
            "the typical magnitude is detected, but not always identified".to_owned()
        } else {
            format!(
                "the typical magnitude is detected, but may be identified as {}",
                listed(&row.with)
            )
        };
        return match helps(row, tried, enough).or_else(|| more(named)) {
            Some(help) => format!("{taken}; {help} would identify it"),
            None => taken,
        };
    }
    let cheap = more(seen).filter(|_| times(seen) <= FEW_TIMES);
    match cheap.or_else(|| helps(row, tried, found)).or_else(|| more(seen)) {
        Some(help) => format!("the typical magnitude is not detected; {help} would detect it"),
        None => "the typical magnitude is not detected, and is far too small for such a campaign"
            .to_owned(),
    }
}

/// Two significant digits, upwards.
fn round(number: f64) -> String {
    let digits = 10_f64.powf(number.log10().floor() - 1.0);
    format!("{:.0}", (number / digits).ceil() * digits)
}
