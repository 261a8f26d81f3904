//! The result of `diagnose` for people: the verdict, the budget of the gap, the noise, and what
//! could not be tested.

use crate::diagnose::Diagnosis;
use crate::diagnose::budget::answer::{Remainder, Row, Size};
use crate::diagnose::budget::judge::Objection;
use crate::diagnose::library::candidate::NotTestable;
use crate::diagnose::library::variant::Variant;
use crate::estimate::calibrate::Estimate;
use crate::report::figure;
use crate::report::layout::{drawn, table};
use crate::report::linear_range;
use crate::report::noise_text::noise;
use crate::report::text::{residual_unit, stated, trouble, unit_of};
use crate::report::verdict_text::sentence;
use crate::units::Unit;

/// Candidates shown unless another number is asked for.
const TOP: usize = 8;
/// Values of a row that stand in the table; the others follow it.
const SHORT: usize = 2;

/// The result of `diagnose`, at most `top` candidates.
pub fn text(title: &str, diagnosis: &Diagnosis, top: Option<usize>) -> String {
    let mut text = format!("{title}\n\n{}\n", sentence(diagnosis));
    if !diagnosis.verdict.is_made() {
        text.push_str(&trouble(&diagnosis.nominal));
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
    text.push_str(&next(diagnosis));
    text.push_str(&candidates(diagnosis, top.unwrap_or(TOP)));
    let absorbed = diagnosis.absorbed.iter().map(|one| [one.name.as_str(), &one.acts_as]);
    text.push_str(&listed(
        "not visible here: these are absorbed by nominal parameters",
        ["effect", "acts as"],
        absorbed.collect(),
    ));
    text.push_str(&not_tested(diagnosis));
    text
}

/// The budget of the gap: rows, the remainder, the noise.
fn budget(diagnosis: &Diagnosis) -> String {
    if diagnosis.rows.is_empty() && diagnosis.remainder.is_empty() {
        return String::new();
    }
    let mut rows = table(&["effect", "value (k = 1)", "closes", "alone", "posterior", "remarks"]);
    for one in &diagnosis.rows {
        rows.add_row([
            group(one),
            short(one),
            share(one.closes),
            share(one.alone),
            percent(one.posterior),
            remarks(one),
        ]);
    }
    for one in &diagnosis.remainder {
        rows.add_row([
            "remainder".to_owned(),
            size(diagnosis, one),
            share(one.share),
            String::new(),
            String::new(),
            remainder_words(one),
        ]);
    }
    format!("\n{}", drawn(&rows))
}

/// A row with the effects that are reported with it.
fn group(row: &Row) -> String {
    let others = row.grouped().map(|other| format!(" ~ {}", other.name));
    let form = row.variant.map_or_else(String::new, |form| format!(", {}", form.words()));
    row.name.clone() + &form + &others.collect::<String>()
}

/// The first values of a row.
fn short(row: &Row) -> String {
    let shown: Vec<String> = row.values.iter().take(SHORT).map(value).collect();
    let more = if row.values.len() > SHORT { " …" } else { "" };
    shown.join(", ") + more
}

fn value(one: &Estimate) -> String {
    let name = one.name.rsplit_once('.').map_or(one.name.as_str(), |(_, last)| last);
    match one.value {
        None => format!("{name} not determined"),
        Some(value) => format!("{name} {}", measured(one, value)),
    }
}

fn measured(one: &Estimate, value: f64) -> String {
    match (one.sigma, one.bound) {
        (None, Some(bound)) => {
            let value = figure::value(value, None, &one.declared);
            format!("{value} (at its {} bound)", bound.word())
        }
        (sigma, _) => figure::measured(value, sigma.unwrap_or(f64::NAN), &one.declared),
    }
}

/// Aliases and confounded rows.
fn remarks(row: &Row) -> String {
    let mut remarks = Vec::new();
    if !row.aliases.is_empty() {
        remarks.push(format!("alias: {}", row.aliases.join(", ")));
    }
    if let Some(words) = &row.unmodelled_alias {
        remarks.push(format!("{words} would fit as well"));
    }
    let rows = row.confounded.iter().filter(|other| other.is_row);
    for other in rows.chain(row.grouped()) {
        let (name, correlation) = (&other.name, other.correlation);
        remarks.push(format!("confounded with {name} (r = {correlation:.3})"));
    }
    remarks.join("; ")
}

/// How large a part of the remainder is.
fn size(diagnosis: &Diagnosis, one: &Remainder) -> String {
    let Some((rms, measurand)) = &one.rms else { return String::new() };
    let declared = unit_of(&diagnosis.nominal, measurand);
    let of = |size: f64| figure::size(size, &residual_unit(size, &declared));
    match one.amplitude {
        Some(amplitude) => format!("amplitude {}, rms {}", of(amplitude), of(*rms)),
        None => format!("rms {} in {measurand}", of(*rms)),
    }
}

fn remainder_words(one: &Remainder) -> String {
    let nearest = one.nearest.as_ref().map_or_else(String::new, |(name, share)| {
        format!("; nearest: {name}, {:.0} %", 100.0 * share)
    });
    format!("{}{nearest}", one.place.words)
}

/// All values of rows that have more than the table shows, and members of families.
fn values(diagnosis: &Diagnosis) -> String {
    let mut text = String::new();
    for row in &diagnosis.rows {
        let is_grouped = row.grouped().any(|other| !other.joint.is_empty());
        if row.values.len() <= SHORT && row.member.is_empty() && !is_grouped {
            continue;
        }
        text.push_str(&format!("\n{}\n", row.name));
        for (family, value) in &row.member {
            let unit = family_unit(diagnosis, &row.name, family);
            let shown = match row.member_sigma.get(family) {
                Some(sigma) => figure::measured(*value, *sigma, &unit),
                None => figure::value(*value, None, &unit),
            };
            text.push_str(&format!("  {family} {shown}\n"));
        }
        for one in &row.values {
            let of = one.of.as_ref().map_or_else(String::new, |of| format!(" ({of})"));
            let shown = one.value.map_or_else(
                || "is not determined by these readings".to_owned(),
                |value| format!("= {}", measured(one, value)),
            );
            text.push_str(&format!("  {}{of} {shown}\n", one.name));
        }
        text.push_str(&joint(row));
    }
    text
}

/// The values of a row and of effects that are reported with it, where both are in the fit.
fn joint(row: &Row) -> String {
    let mut text = String::new();
    for other in row.grouped().filter(|other| !other.joint.is_empty()) {
        text.push_str(&format!("  with {} in the fit, too:\n", other.name));
        for (size, sigma) in &other.joint {
            let of = size.of.as_ref().map_or_else(String::new, |of| format!(" ({of})"));
            let shown = figure::measured(size.value, *sigma, &size.unit);
            text.push_str(&format!("    {}{of} = {shown}\n", size.parameter));
        }
    }
    text
}

/// The unit in which a family of an effect is declared.
fn family_unit(diagnosis: &Diagnosis, effect: &str, family: &str) -> Unit {
    let steps = diagnosis.steps.iter();
    let recipes = steps.flat_map(|steps| &steps.last().recipes);
    let mut effects = recipes.flat_map(|recipe| &recipe.effects);
    let own = effects.find(|one| effect.split('.').next() == Some(one.effect.name.as_str()));
    let shape = own.and_then(|one| one.effect.shape.get(family));
    shape.map_or_else(Unit::one, |shape| shape.unit.clone())
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
        let shown =
            |value: Option<f64>| value.map_or_else(String::new, |value| figure::size(value, &unit));
        rows.add_row([
            name.clone(),
            figure::size(*before, &unit),
            shown(of(&gap.after)),
            shown(of(&gap.floor)),
        ]);
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
        Objection::HeldOut(drop) => {
            format!("it fails on held-out readings (drop of squared residuals {drop:.0})")
        }
        Objection::Small(_) => "it is too small for a name beside the rest".to_owned(),
        Objection::Borrowed => "it only corrects the form of the remainder".to_owned(),
        Objection::WithinRemainder(share) => {
            format!("its form lies within the remainder ({:.0} % are its own)", 100.0 * share)
        }
        Objection::Apart(label, _) => format!("its values differ by {}", label.words()),
        Objection::Replaced(_) => "unmodelled effects in its place fit as well".to_owned(),
        Objection::Pair(other, _) => {
            format!("one unmodelled effect in the place of it and `{other}` fits as well")
        }
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

/// The command that goes on from here.
fn next(diagnosis: &Diagnosis) -> String {
    let wanting = diagnosis.not_testable.iter().filter(|one| !one.wants.is_empty());
    let wanting: Vec<String> =
        wanting.map(|one| format!("`{}` ({})", one.name, one.wants.join(", "))).collect();
    let mut text = String::new();
    if !wanting.is_empty() && diagnosis.verdict.has_remainder() {
        text.push_str(&format!(
            "\nNot tried, because a constant is missing that `--set NAME=VALUE` or [parameters] states: {}.\n",
            wanting.join(", ")
        ));
    }
    if !diagnosis.rows.is_empty() {
        let with: Vec<String> =
            diagnosis.rows.iter().map(|one| format!("--with {}", one.name)).collect();
        text.push_str(&format!("\nNext: `homepoint calibrate CAMPAIGN {}`\n", with.join(" ")));
        text.push_str(&diagnosis.rows.iter().filter_map(relaxed).collect::<String>());
    }
    text
}

/// How an effect is estimated in the relaxed form in which it stands.
fn relaxed(row: &Row) -> Option<String> {
    let name = &row.name;
    Some(match row.variant? {
        Variant::EachSetup => {
            format!(
                "      with scope = \"setup\" for the parameters of `{name}`, in [parameters]\n"
            )
        }
        Variant::EachAngle => format!(
            "      with a copy of `{name}` in effects/ whose parameters have per = \"measurand\"\n"
        ),
    })
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
    let here = by_reason(&here);
    let here = here.iter().map(|(names, why)| [names.as_str(), *why]);
    let mut text = listed("cannot be tested here", ["effects", "why"], here.collect());
    text.push_str(&match others.len() {
        0 => String::new(),
        1 => format!("\n`{}` acts on what this model does not have.\n", others[0].name),
        count => format!(
            "\n{count} effects of the library act on what this model does not have (`homepoint effects MODEL` lists them).\n"
        ),
    });
    text
}

/// The names of effects that have the same reason, with it, in the order in which they come.
fn by_reason<'d>(effects: &[&'d NotTestable]) -> Vec<(String, &'d str)> {
    let mut all: Vec<(String, &str)> = Vec::new();
    for one in effects {
        match all.iter_mut().find(|(_, why)| *why == one.why) {
            Some((names, _)) => names.push_str(&format!(", {}", one.name)),
            None => all.push((one.name.clone(), &one.why)),
        }
    }
    all
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

fn share(part: f64) -> String {
    format!("{:.0} %", 100.0 * part)
}

/// A probability: no certainty.
fn percent(probability: f64) -> String {
    match 100.0 * probability {
        most if most > 99.9 => "> 99.9 %".to_owned(),
        least if least < 0.1 => "< 0.1 %".to_owned(),
        between => format!("{between:.1} %"),
    }
}
