//! The result of `power` for people: one sentence for each effect, under its figures.

use crate::diagnose::power::sight::CAUGHT;
use crate::diagnose::power::{Power, Row, State};
use crate::report::figure;
use crate::report::layout::{align_right, by_reason, drawn, table};
use crate::report::text::trouble;
use crate::units::{Dimension, Unit};

/// The result of `power`.
pub fn text(title: &str, power: &Power) -> String {
    let mut text = format!("{title}\n");
    if !power.nominal.is_sound() {
        text.push_str("\nThis design cannot determine the model's own parameters.\n");
        text.push_str(&trouble(&power.nominal));
        return text;
    }
    text.push_str(&delays(power));
    text.push_str(&format!(
        "\nMDB (minimal detectable bias): the size from which an effect enters the budget of `diagnose` in {0:.0} of\n\
         100 campaigns. MIB (minimal identifiable bias): the size from which it is identified as a row of its own\n\
         in {0:.0} of 100. A cosine and sine pair counts by its amplitude. The shift is the bias of a delay by an\n\
         unmodelled effect at its MDB.\n",
        100.0 * CAUGHT,
    ));
    text.push_str(&sizes(power, State::Visible, "detectable and identifiable"));
    text.push_str(&sizes(power, State::Alias, "detectable, with an alias"));
    text.push_str(&listed(power, State::Absorbed, "absorbed by nominal parameters"));
    text.push_str(&listed(power, State::NotTestable, "not testable"));
    text
}

fn delays(power: &Power) -> String {
    // Where nothing moves all of them are held.
    if power.delays.iter().all(|one| one.sigma == Some(0.0)) {
        return String::new();
    }
    let second = Unit::coherent(Dimension::TIME);
    let mut rows = table(&["delay of", "u (k=1)"]);
    for shared in power.delays.chunk_by(|a, b| a.parameter == b.parameter) {
        let sigma = shared[0].sigma.map_or_else(String::new, |u| figure::uncertainty(u, &second));
        let of: Vec<&str> = shared.iter().map(|one| one.measurand.as_str()).collect();
        rows.add_row([of.join(", "), sigma]);
    }
    align_right(&mut rows, &[1]);
    format!("\n{}", drawn(&rows))
}

fn sizes(power: &Power, state: State, line: &str) -> String {
    let second = Unit::coherent(Dimension::TIME);
    let of_state: Vec<&Row> = power.rows.iter().filter(|row| row.state == state).collect();
    if of_state.is_empty() {
        return String::new();
    }
    let mut rows = table(&["effect", "typical", "MDB", "MIB", "shifts a delay by"]);
    for row in &of_state {
        let sizes = [row.typical, row.detectable, row.identifiable];
        let [typical, detectable, identifiable] = figure::sizes(sizes, &row.unit);
        let worst = row.shifts.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let shift = worst.map_or_else(
            || "-".to_owned(),
            |(delay, shift)| format!("{} ({delay})", figure::size(*shift, &second)),
        );
        rows.add_row([row.name.clone(), typical, detectable, identifiable, shift]);
    }
    align_right(&mut rows, &[1, 2, 3]);
    let drawn = drawn(&rows);
    let mut lines = drawn.lines();
    let mut text = format!("\n{line}\n{}\n", lines.next().unwrap_or_default());
    for (line, row) in lines.zip(&of_state) {
        text.push_str(&format!("{line}\n    {}\n", row.words));
    }
    text
}

fn listed(power: &Power, state: State, line: &str) -> String {
    let of_state = power.rows.iter().filter(|row| row.state == state);
    let lines = by_reason(of_state.map(|row| (row.name.as_str(), row.words.as_str())));
    if lines.is_empty() { String::new() } else { format!("\n{line}\n{lines}") }
}
