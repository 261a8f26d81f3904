//! The score of trials for people: rates with the bound that they exceed at 95 %.

use crate::report::layout::{drawn, table};
use crate::trials::bound::Count;
use crate::trials::tally::mixtures::{LARGE, Mixtures, SEEN};
use crate::trials::tally::{Cell, Tally};

/// Lines of the table of what went wrong.
const WRONG: usize = 15;

/// The score; with `each` the table has a line for each effect.
pub fn text(title: &str, tally: &Tally, each: bool) -> String {
    let mut text = format!("{title}\n\n{} trials", tally.trials);
    if tally.failed > 0 {
        text.push_str(&format!(", {} without a diagnosis", tally.failed));
    }
    text.push_str(&format!("\n\n{}", overall(tally)));
    text.push_str(&rates(&tally.cells, each));
    if let Some(score) = &tally.mixtures {
        text.push_str(&mixtures(score));
    }
    if !tally.confusion.is_empty() {
        let mut rows = table(&["what was true", "what was said", "times"]);
        for one in tally.confusion.iter().take(WRONG) {
            rows.add_row([one.truth.clone(), one.said.clone(), one.trials.to_string()]);
        }
        text.push_str("\nwhat went wrong (no effects, or effects of lambda 12 and more)\n");
        text.push_str(&drawn(&rows));
    }
    text
}

fn overall(tally: &Tally) -> String {
    let mut rows = table(&["", "measured", "95 % bound", "trials"]);
    let mut rate = |name: String, count: Count| {
        if let Some(share) = count.rate() {
            let bound = format!("below {}", percent(count.upper()));
            rows.add_row([name, percent(share), bound, count.trials.to_string()]);
        }
    };
    rate("false alarms".to_owned(), tally.false_alarms);
    for (name, count) in &tally.noise_alarms {
        rate(format!("false alarms, {name}"), *count);
    }
    let mut figure = |name: &str, value: Option<f64>, trials: usize| {
        if let Some(value) = value {
            rows.add_row([
                name.to_owned(),
                format!("{value:.3}"),
                String::new(),
                if trials > 0 { trials.to_string() } else { String::new() },
            ]);
        }
    };
    figure("Brier score of the probabilities", tally.brier, 0);
    figure("calibration error of the probabilities", tally.calibration_error, 0);
    figure("median error of the shrinkage", tally.shrinkage_error, tally.shrinkages);
    format!("{}\n", drawn(&rows))
}

/// A line a cell; the bound beside each rate.
fn rates(cells: &[Cell], each: bool) -> String {
    let header = ["what was true", "form", "lambda", "trials", "detected", "first", "first three"];
    let header: Vec<&str> = header.into_iter().chain(["declared", "exactly", "unknown"]).collect();
    let mut rows = table(&header);
    let is_shown = |cell: &&Cell| each || cell.effect.is_none() || cell.kind == "situation";
    for cell in cells.iter().filter(is_shown) {
        let truth = cell
            .effect
            .as_ref()
            .map_or_else(|| cell.kind.clone(), |effect| format!("{}: {effect}", cell.kind));
        let form = match cell.own_form {
            Some(true) => "own",
            Some(false) => "library's",
            None => "",
        };
        let lambda = match cell.band {
            Some((from, to)) => format!("{from}-{to}"),
            None if cell.lambda > 0.0 => format!("{}", cell.lambda),
            None => String::new(),
        };
        let effects = matches!(cell.kind.as_str(), "one" | "two");
        let named = |count: Count| if effects { with_bound(count) } else { String::new() };
        rows.add_row([
            truth,
            form.to_owned(),
            lambda,
            cell.exact.trials.to_string(),
            with_bound(cell.detected),
            named(cell.top1),
            named(cell.top3),
            named(cell.declared),
            with_bound(cell.exact),
            with_bound(cell.unknown),
        ]);
    }
    format!("rates, and what each exceeds at 95 %\n{}", drawn(&rows))
}

/// What was identified in mixtures.
fn mixtures(score: &Mixtures) -> String {
    let mut rows = table(&["mixtures", "rate", "95 % bound", "of"]);
    let rates = [
        ("effects named".to_owned(), score.effects),
        (format!("effects of lambda {LARGE} and more named"), score.large),
        ("names right".to_owned(), score.names),
        (format!("remainder seen, outside cause of lambda {SEEN} and more"), score.remainder),
    ];
    let mut row = |name: String, count: Count, bound: String| {
        if let Some(rate) = count.rate() {
            rows.add_row([name, percent(rate), bound, count.trials.to_string()]);
        }
    };
    for (name, count) in rates {
        row(name, count, format!("above {}", percent(count.lower())));
    }
    let wrong = score.false_remainder;
    let name = "remainder reported without an outside cause".to_owned();
    row(name, wrong, format!("below {}", percent(wrong.upper())));
    format!("\n{}", drawn(&rows))
}

fn with_bound(count: Count) -> String {
    let Some(rate) = count.rate() else { return String::new() };
    format!("{} ({})", percent(rate), percent(count.lower()))
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
