//! The result of `diagnose` for people: the verdict, the budget of the gap, the noise, and what
//! could not be tested.

use crate::diagnose::Diagnosis;
use crate::diagnose::budget::answer::Size;
use crate::diagnose::budget::judge::Objection;
use crate::report::figure;
use crate::report::layout::{by_reason, drawn, table};
use crate::report::linear_range;
use crate::report::next::{mistaken, next};
use crate::report::noise_text::noise;
use crate::report::rows_text::{SHORT, budget, share, values};
use crate::report::text::{residual_unit, stated, trouble, unit_of};
use crate::report::verdict_text::sentence;

pub use crate::report::next::Asked;

/// Candidates shown unless another number is asked for.
const TOP: usize = 8;

/// The result of `diagnose`.
pub fn text(title: &str, diagnosis: &Diagnosis, asked: &Asked<'_>) -> String {
    let mut text = format!("{title}\n\n{}\n", sentence(diagnosis));
    if !diagnosis.verdict.is_made() {
        text.push_str(&trouble(&diagnosis.nominal));
    }
    text.push_str(&mistaken(diagnosis, asked));
    if !diagnosis.verdict.is_made() || diagnosis.is_misread() {
        return text;
    }
    text.push_str(&budget(diagnosis));
    text.push_str(&values(diagnosis));
    text.push_str(&noise(diagnosis));
    text.push_str(&stated(&diagnosis.contradicted));
    text.push_str(&linear_range::text(&diagnosis.beyond_range));
    text.push_str(&gap(diagnosis));
    text.push_str(&doubtful(diagnosis));
    text.push_str(&unexplained(diagnosis));
    text.push_str(&next(diagnosis, asked));
    text.push_str(&candidates(diagnosis, asked.top.unwrap_or(TOP)));
    let absorbed = diagnosis.absorbed.iter().map(|one| [one.name.as_str(), &one.acts_as]);
    text.push_str(&listed(
        "not visible here: these are absorbed by nominal parameters",
        ["effect", "acts as"],
        absorbed.collect(),
    ));
    text.push_str(&not_tested(diagnosis));
    text
}

/// How far the gap shrinks.
fn gap(diagnosis: &Diagnosis) -> String {
    let Some(gap) = &diagnosis.gap else { return String::new() };
    let mut rows = table(&["rms", "before", "after", "noise alone"]);
    for (name, before) in &gap.before {
        let of = |list: &[(String, f64)]| {
            list.iter().find(|(other, _)| other == name).map(|(_, value)| *value)
        };
        let unit = residual_unit(*before, &unit_of(&diagnosis.nominal, name));
        let all = [Some(*before), of(&gap.after), of(&gap.floor)];
        let [before, after, floor] = figure::sizes(all, &unit);
        rows.add_row([name.clone(), before, after, floor]);
    }
    let of = match &gap.held_out {
        Some(name) => format!("on the held-out campaign `{name}`"),
        None => "on held-out readings".to_owned(),
    };
    let [part, low, high] =
        [gap.closed, gap.closed_interval[0], gap.closed_interval[1]].map(|one| 100.0 * one);
    let closed =
        format!("\nexplained fraction {of}: {part:.0} % (95 % interval {low:.0} to {high:.0} %)\n");
    let missed = gap.missed().map_or_else(String::new, |times| {
        format!(
            "The held-out campaign is missed by {times:.0} times its noise with and without the effects: is it another rig, or are held values wrong?\n"
        )
    });
    let left_out = if gap.left_out > 0 {
        format!(
            "{} of its readings are left out of the comparison: lost or outliers.\n",
            gap.left_out
        )
    } else {
        String::new()
    };
    format!("{closed}{}{missed}{left_out}", drawn(&rows))
}

/// Effects that explain something but do not stand as rows, with the reason.
fn doubtful(diagnosis: &Diagnosis) -> String {
    let mut rows =
        table(&["candidate for the remainder", "size", "noncentrality", "not a row because"]);
    if diagnosis.doubtful.is_empty() {
        return String::new();
    }
    for one in &diagnosis.doubtful {
        rows.add_row([
            one.name.clone(),
            sizes(&one.values),
            format!("{:.1}", one.gain.noncentrality()),
            because(&one.objection),
        ]);
    }
    format!("\n{}", drawn(&rows))
}

/// The first values of an effect that is not in the fit.
fn sizes(values: &[Size]) -> String {
    let shown = values.iter().take(SHORT).map(|one| {
        let name = one.parameter.rsplit_once('.').map_or(one.parameter.as_str(), |(_, last)| last);
        let has_several =
            values.iter().any(|o| o.parameter == one.parameter && o.component != one.component);
        let axis = if has_several { [".x", ".y", ".z"][one.component.min(2)] } else { "" };
        let of = one.of.as_ref().map_or_else(String::new, |of| format!(" ({of})"));
        let sign = if one.value < 0.0 { "-" } else { "" };
        format!("{name}{axis}{of} {sign}{}", figure::size(one.value.abs(), &one.unit))
    });
    shown.collect::<Vec<_>>().join(", ")
}

/// Why an effect does not stand as a row.
fn because(objection: &Objection) -> String {
    match objection {
        Objection::HeldOut(gain) => {
            format!("it fails on held-out readings (predictive gain {gain:.0})")
        }
        Objection::Small(_) => "it is too small for a name beside the rest".to_owned(),
        Objection::MayBeZero(_) => {
            "beside the whole remainder its value is consistent with zero".to_owned()
        }
        Objection::Apart(label, _) => format!("its values differ by {}", label.words()),
        Objection::Replaced(_) => "unmodelled effects in its place fit about as well".to_owned(),
        Objection::NotConverged => "the fit with it does not converge".to_owned(),
    }
}

/// Where no row stands: the nearest effect, and how large the gap is.
fn unexplained(diagnosis: &Diagnosis) -> String {
    let Some(nearest) = diagnosis.nearest() else { return String::new() };
    let sizes = match sizes(&nearest.values) {
        none if none.is_empty() => none,
        some => format!(" ({some})"),
    };
    format!(
        "\nThe nearest effect by itself, `{}`, explains {:.0} % of the gap{sizes}.\n",
        nearest.name,
        100.0 * nearest.share
    )
}

fn candidates(diagnosis: &Diagnosis, top: usize) -> String {
    if diagnosis.candidates.is_empty() || top == 0 {
        return String::new();
    }
    let mut rows = table(&["effect", "ln Bayes factor", "noncentrality", "share of the gap"]);
    for one in diagnosis.candidates.iter().take(top) {
        rows.add_row([
            one.name.clone(),
            format!("{:.1}", one.ln_bayes),
            format!("{:.1}", one.gain.noncentrality()),
            share(one.share),
        ]);
    }
    format!("\ncandidates alone, against the nominal model\n{}", drawn(&rows))
}

/// Effects that cannot be tested, by reason.
fn not_tested(diagnosis: &Diagnosis) -> String {
    let (others, here): (Vec<_>, Vec<_>) =
        diagnosis.not_testable.iter().partition(|one| one.of_other_models);
    let mut text = String::new();
    if !here.is_empty() {
        text.push_str("\ncannot be tested here\n");
    }
    text.push_str(&by_reason(here.iter().map(|one| (one.name.as_str(), one.why.as_str()))));
    text.push_str(&match others.len() {
        0 => String::new(),
        1 => format!("\n`{}` acts on what this model does not have.\n", others[0].name),
        count => format!(
            "\n{count} effects of the library act on what this model does not have (`homepoint effects MODEL` lists them, `homepoint check CAMPAIGN` the roles with which more can be tested).\n"
        ),
    });
    text
}

/// A table of two columns under a line; nothing where there are no rows.
fn listed(line: &str, header: [&str; 2], rows: Vec<[&str; 2]>) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let mut made = table(&header);
    for row in rows {
        made.add_row(row);
    }
    format!("\n{line}\n{}", drawn(&made))
}
