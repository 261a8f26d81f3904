//! Estimates that are correlated, and the covariance of all of them.

use serde_json::{Value, json};

use crate::estimate::correlations::{Correlated, Covariance, HIGH};
use crate::report::figure;
use crate::report::json::{combination, number};
use crate::report::sentences::terms;
use crate::report::table::quoted;

/// Pairs that are listed in text.
const MOST: usize = 12;
/// Estimates up to which JSON has the matrix; the table has more.
const MOST_IN_JSON: usize = 200;

/// Pairs that are correlated, a line each, with what is well determined; empty if there are none.
pub fn text(covariance: Option<&Covariance>) -> String {
    let all = covariance.map_or_else(Vec::new, Covariance::correlated);
    if all.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "\nCorrelated beyond {HIGH}: each by itself is known less well than the combination beside it.\n"
    );
    for Correlated { names: [a, b], correlation, combination } in all.iter().take(MOST) {
        let size = figure::measured(combination.value, combination.sigma, &combination.declared);
        text.push_str(&format!(
            "- `{a}` and `{b}`: {correlation:.3}; {} = {size}\n",
            terms(combination)
        ));
    }
    if all.len() > MOST {
        let rest = all.len() - MOST;
        text.push_str(&format!("... and {rest} more: `--out DIR` has the covariance of all\n"));
    }
    text
}

/// The same for programs, with the matrix.
pub fn json(covariance: Option<&Covariance>) -> Value {
    let Some(all) = covariance else {
        return json!({ "correlations": [], "covariance": null });
    };
    let pair = |one: &Correlated| {
        json!({
            "names": one.names,
            "correlation": number(Some(one.correlation)),
            "combination": combination(&one.combination),
        })
    };
    let row = |i: usize| -> Vec<Value> {
        (0..all.names.len()).map(|j| number(Some(all.matrix[(i, j)]))).collect()
    };
    let matrix = (all.names.len() <= MOST_IN_JSON)
        .then(|| (0..all.names.len()).map(row).collect::<Vec<_>>());
    json!({
        "correlations": all.correlated().iter().map(pair).collect::<Vec<_>>(),
        "covariance": matrix.map(|matrix| json!({ "names": all.names, "matrix": matrix })),
    })
}

/// The covariance as a table: a row and a column for each estimate; SI units.
pub fn table(covariance: &Covariance) -> String {
    let names = covariance.names.iter().map(|name| quoted(name));
    let mut text = format!("name,unit,{}\n", names.collect::<Vec<_>>().join(","));
    for (i, (name, one)) in covariance.names.iter().zip(&covariance.estimates).enumerate() {
        text.push_str(&format!("{},{}", quoted(name), quoted(&one.unit)));
        for j in 0..covariance.names.len() {
            text.push_str(&format!(",{:.12e}", covariance.matrix[(i, j)]));
        }
        text.push('\n');
    }
    text
}
