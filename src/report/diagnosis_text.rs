//! The result of `diagnose` for people: the verdict first, in a sentence that can be read aloud.

use crate::diagnose::Diagnosis;
use crate::diagnose::verdict::Verdict;
use crate::report::diagnosis::estimates_of;
use crate::report::figure;
use crate::report::text::{drawn, table, trouble};

/// Candidates shown unless another number is asked for.
const TOP: usize = 8;

/// The result of `diagnose`, at most `top` candidates.
pub fn text(title: &str, diagnosis: &Diagnosis, top: Option<usize>) -> String {
    let mut text = format!("{title}\n\n{}\n", sentence(diagnosis));
    if diagnosis.verdict == Verdict::Unobservable {
        text.push_str(&trouble(&diagnosis.nominal));
        return text;
    }
    for one in &diagnosis.noise {
        let figure = figure::measured(one.value, one.sigma, &one.unit);
        text.push_str(&format!("\n{}\n  {} = {figure}\n", one.name, one.parameter));
    }
    for one in &diagnosis.effects {
        text.push_str(&format!(
            "\n{}: {}\n",
            one.candidate.name, one.candidate.selected.effect.title
        ));
        for estimate in estimates_of(diagnosis, one) {
            let Some(value) = estimate.value else { continue };
            let figure = figure::measured(value, estimate.sigma.unwrap_or(0.0), &estimate.declared);
            let of = estimate.of.map_or_else(String::new, |of| format!(" ({of})"));
            text.push_str(&format!("  {}{of} = {figure}\n", estimate.name));
        }
    }
    if !diagnosis.locations.is_empty() {
        text.push_str("\nwhere the gap lies\n");
        let mut rows = table(&["", "share of the best"]);
        for one in &diagnosis.locations {
            rows.add_row([one.place.words.clone(), format!("{:.0} %", 100.0 * one.share)]);
        }
        text.push_str(&drawn(&rows));
    }
    text.push_str("\ncandidates, best first\n");
    let mut rows = table(&["effect", "p", "lambda", "share"]);
    for one in diagnosis.candidates.iter().take(top.unwrap_or(TOP)) {
        rows.add_row([
            one.name.clone(),
            probability(one.score.ln_p),
            format!("{:.1}", one.score.lambda()),
            format!("{:.0} %", 100.0 * one.share),
        ]);
    }
    text.push_str(&drawn(&rows));
    if !diagnosis.absorbed.is_empty() {
        text.push_str("\ncannot be seen here: these act as nominal parameters do\n");
        let mut rows = table(&["effect", "acts as"]);
        for one in &diagnosis.absorbed {
            rows.add_row([&one.name, &one.acts_as]);
        }
        text.push_str(&drawn(&rows));
    }
    if !diagnosis.not_testable.is_empty() {
        text.push_str("\ncannot be tested here\n");
        let mut rows = table(&["effect", "why"]);
        for one in &diagnosis.not_testable {
            rows.add_row([&one.name, &one.why]);
        }
        text.push_str(&drawn(&rows));
    }
    text
}

/// The verdict.
fn sentence(diagnosis: &Diagnosis) -> String {
    let noise = diagnosis.noise.iter().map(|one| &one.name);
    let effects = diagnosis.effects.iter().map(|one| &one.candidate.name);
    let names: Vec<String> = effects.chain(noise).map(|name| format!("`{name}`")).collect();
    let names = names.join(" and ");
    let place = diagnosis.locations.first().map_or("", |one| one.place.words.as_str());
    match diagnosis.verdict {
        Verdict::Adequate => {
            "Nothing was found: the readings follow the model as closely as their noise lets them."
                .to_owned()
        }
        Verdict::Explained => format!(
            "The gap between model and readings is explained by {names}; what is left looks like noise."
        ),
        Verdict::ShapeDiffers => format!(
            "Nearly all of the gap is explained by {names}, but its form does not quite fit."
        ),
        Verdict::Unknown => {
            format!("There is a gap that no effect of the library explains. It looks like {place}.")
        }
        Verdict::Unobservable => {
            "No diagnosis: these readings do not determine the model's own parameters.".to_owned()
        }
    }
}

/// A probability from its logarithm, readable far below what a double holds.
fn probability(ln_p: f64) -> String {
    let tenth = ln_p / std::f64::consts::LN_10;
    if tenth > -3.0 {
        return format!("{:.3}", ln_p.exp());
    }
    format!("1e{}", tenth.floor())
}
