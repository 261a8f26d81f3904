//! The result of `diagnose` for people: the verdict first, in a sentence that can be read aloud.

use crate::diagnose::Diagnosis;
use crate::diagnose::gap::Gap;
use crate::diagnose::lost::Lost;
use crate::diagnose::probability::is_implausible;
use crate::diagnose::verdict::{Verdict, displaced, locations};
use crate::diagnose::whiten::{Noise, NoiseEffect};
use crate::diagnose::wild::LeftOut;
use crate::report::diagnosis::{estimates_of, last_noise, times_usual};
use crate::report::figure;
use crate::report::text::{drawn, residual_unit, table, trouble, unit_of};
use crate::units::{Dimension, Unit};

/// Candidates shown unless another number is asked for.
const TOP: usize = 8;
/// Share of the best from which on another place is as good.
const SAME_PLACE: f64 = 0.95;
/// Part of the gap that is closed below which readings contradict what was named.
const BORNE_OUT: f64 = 0.25;
/// Readings left out that are shown.
const SHOWN: usize = 5;

/// The result of `diagnose`, at most `top` candidates.
pub fn text(title: &str, diagnosis: &Diagnosis, top: Option<usize>) -> String {
    let mut text = format!("{title}\n\n{}\n", sentence(diagnosis));
    if diagnosis.verdict == Verdict::Unobservable {
        text.push_str(&trouble(&diagnosis.nominal));
        return text;
    }
    if !diagnosis.suspected.is_empty() {
        let names = diagnosis.suspected.join("`, `");
        text.push_str(&format!("Suspected, but too small to be declared: `{names}`.\n"));
    }
    text.push_str(&noise(diagnosis));
    text.push_str(&effects(diagnosis));
    if let Some(found) = &diagnosis.gap {
        text.push_str(&gap(diagnosis, found));
    }
    text.push_str(&unexplained(diagnosis));
    text.push_str(&places(diagnosis));
    text.push_str(&candidates(diagnosis, top.unwrap_or(TOP)));
    text.push_str(&could_hide(diagnosis));
    let absorbed = diagnosis.absorbed.iter().map(|one| [one.name.as_str(), &one.acts_as]);
    text.push_str(&listed(
        "cannot be seen here: these act as nominal parameters do",
        ["effect", "acts as"],
        absorbed.collect(),
    ));
    let not_testable = diagnosis.not_testable.iter().map(|one| [one.name.as_str(), &one.why]);
    text.push_str(&listed("cannot be tested here", ["effect", "why"], not_testable.collect()));
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

/// The noise as it was found.
fn noise(diagnosis: &Diagnosis) -> String {
    let mut text = String::new();
    for one in diagnosis.noise.iter().filter(|one| one.name != "lost_samples") {
        let figure = figure::measured(one.value, one.sigma, &one.unit);
        text.push_str(&format!("\n{}\n  {} = {figure}", one.name, one.parameter));
        if !one.also.is_empty() {
            text.push_str(&format!(", the same for {}", one.also.join(" and ")));
        }
        if let Some(memory) = one.memory {
            let second = Unit::coherent(Dimension::TIME);
            let memory = figure::uncertainty(memory, &second);
            text.push_str(&format!(", with a memory of {memory}; the weights take account of it"));
        }
        text.push('\n');
        text.push_str(&alike(&one.aliases));
    }
    let Some(found) = last_noise(diagnosis) else { return text };
    for (measurand, factor) in &found.levels {
        let hint = if (0.1..10.0).contains(factor) { "" } else { " Is its unit right?" };
        let factor = if *factor < 0.1 { format!("{factor:.1e}") } else { format!("{factor:.2}") };
        text.push_str(&format!(
            "`{measurand}` scatters {factor} times as much as stated; the fit uses what it finds.{hint}\n"
        ));
    }
    for (measurand, run, factor) in &found.run_levels {
        text.push_str(&format!(
            "`{measurand}` scatters {factor:.2} times as much in run `{run}` as in most; the fit uses that.\n"
        ));
    }
    let is_named = |measurand: &str| {
        let own = |one: &&NoiseEffect| one.parameter == format!("{}.{measurand}", one.name);
        diagnosis.noise.iter().filter(own).any(|one| one.memory.is_some())
    };
    for (measurand, memory) in found.memories.iter().filter(|(name, _)| !is_named(name)) {
        let time = figure::uncertainty(memory.time, &Unit::coherent(Dimension::TIME));
        let share = 100.0 * memory.share;
        text.push_str(&format!(
            "`{measurand}` has a memory of {time} in {share:.0} % of its variance; the weights take account of it.\n"
        ));
    }
    text.push_str(&left_out(diagnosis, found));
    if found.memory > 0.0 {
        text.push_str(&format!(
            "Readings next to each other are alike (correlation {:.2}): what is left has a memory.\n",
            found.memory
        ));
    }
    text
}

/// What is left out, by row, and what that does to the delays.
fn left_out(diagnosis: &Diagnosis, found: &Noise) -> String {
    let mut text = String::new();
    for one in &diagnosis.lost {
        let (Lost { name, rows: (first, last), periods, .. }, side) =
            (one, if one.periods > 0 { "later" } else { "earlier" });
        let plural = if periods.abs() == 1 { "" } else { "s" };
        text.push_str(&format!(
            "Readings in rows {first} to {last} of run `{name}` are those of samples {} row{plural} {side}; they are left out.\n",
            periods.abs()
        ));
    }
    if found.wild > 0 {
        let are = if found.wild == 1 { "reading is" } else { "readings are" };
        text.push_str(&format!("{} wild {are} left out:", found.wild));
        let all = found.left_out.len();
        let shown = if all <= SHOWN + 1 { all } else { SHOWN };
        for one in found.left_out.iter().take(shown) {
            let LeftOut { run, row, measurand, deviations } = one;
            text.push_str(&format!(
                "\n  `{measurand}` in row {row} of run `{run}` ({deviations:.0} deviations)"
            ));
        }
        text.push_str(if all > shown { "\n  ... all with `--format json`\n" } else { "\n" });
        text.push_str(&whole_runs(diagnosis, found));
    }
    let second = Unit::coherent(Dimension::TIME);
    let mut rows = table(&["nominal delay", "with all readings", "without those left out"]);
    for one in &diagnosis.delays {
        let of = one.of.as_ref().map_or_else(String::new, |of| format!(" ({of})"));
        let figure = |value| figure::value(value, one.sigma, &second);
        rows.add_row([format!("{}{of}", one.name), figure(one.with), figure(one.without)]);
    }
    if !diagnosis.delays.is_empty() {
        text.push_str(&drawn(&rows));
    }
    text
}

/// Runs of which most readings of a measurand are left out: their files are to be looked at.
fn whole_runs(diagnosis: &Diagnosis, found: &Noise) -> String {
    let mut text = String::new();
    for part in &diagnosis.nominal.problem.parts {
        let names = &part.system.assembly.names.measurands;
        for (index, run) in part.runs.iter().enumerate() {
            for (one, all) in names.iter().zip(part.present_in(index)) {
                let own = |out: &&LeftOut| out.run == run.name && out.measurand == one.name;
                let out = found.left_out.iter().filter(own).count();
                if 2 * out > all {
                    text.push_str(&format!(
                        "{out} of {all} readings of `{}` in run `{}` are among them: look at its file (units, setup, clock).\n",
                        one.name, run.name
                    ));
                }
            }
        }
    }
    text
}

/// The named effects with their values and what cannot be told from them.
fn effects(diagnosis: &Diagnosis) -> String {
    let mut text = String::new();
    for one in &diagnosis.effects {
        let candidate = &one.candidate;
        text.push_str(&format!("\n{}: {}\n", candidate.name, candidate.selected.effect.title));
        for (family, value) in &candidate.selected.member {
            let unit = candidate.selected.effect.shape.get(family).map(|shape| &shape.unit);
            let shown = unit.map_or_else(String::new, |unit| figure::value(*value, None, unit));
            text.push_str(&format!("  {family} {shown}\n"));
        }
        for estimate in estimates_of(diagnosis, one) {
            let Some(value) = estimate.value else { continue };
            let figure = figure::measured(value, estimate.sigma.unwrap_or(0.0), &estimate.declared);
            let of = estimate.of.map_or_else(String::new, |of| format!(" ({of})"));
            text.push_str(&format!("  {}{of} = {figure}\n", estimate.name));
        }
        if let Some(times) = times_usual(diagnosis, one).filter(|times| is_implausible(*times)) {
            text.push_str(&format!(
                "  That is {times:.0} times its usual size, which is implausible: look at units, signs and setups.\n"
            ));
        }
        text.push_str(&alike(&one.aliases));
        let which = if one.aliases.is_empty() { "this effect" } else { "one of these" };
        let probability = percent(one.probability);
        text.push_str(&format!("  Probability that {which} is the cause: {probability}.\n"));
        if one.evidence() == "prior" {
            text.push_str("  Its evidence lies in stated values that the readings contradict.\n");
        }
    }
    text
}

/// What an effect cannot be told from.
fn alike(aliases: &[String]) -> String {
    if aliases.is_empty() {
        return String::new();
    }
    format!("  These data cannot tell it from `{}`.\n", aliases.join("`, `"))
}

/// How far the gap shrinks.
fn gap(diagnosis: &Diagnosis, gap: &Gap) -> String {
    let mut text = String::new();
    if let (Some(closed), Some([low, high])) = (gap.closed, gap.closed_interval) {
        text.push_str(&format!(
            "\nOn readings that it was not fitted to, this closes {:.0} % of the gap ({:.0} to {:.0} %, {} fold{}).\n",
            100.0 * closed,
            100.0 * low,
            100.0 * high,
            gap.folds,
            if gap.folds == 1 { "" } else { "s" }
        ));
    }
    if gap.closed_interval.is_some_and(|[_, high]| high < BORNE_OUT) {
        text.push_str("They do not bear it out.\n");
    }
    if gap.left_out > 0 {
        text.push_str(&format!(
            "{} of those readings are left out: lost or gross.\n",
            gap.left_out
        ));
    }
    text.push_str(&remains(diagnosis, gap));
    let steps: Vec<String> = match gap.steps.as_slice() {
        [] | [_] => vec!["after".to_owned()],
        [first, more @ ..] => std::iter::once(format!("with {}", first.effect))
            .chain(more.iter().map(|one| format!("and {}", one.effect)))
            .collect(),
    };
    let header = ["rms", "before"].into_iter().chain(steps.iter().map(String::as_str));
    let mut rows = table(&header.chain(["noise alone"]).collect::<Vec<_>>());
    let shown = |list: &[(String, f64)], name: &str| {
        let value = list.iter().find(|(other, _)| other == name).map(|(_, value)| *value);
        value.map_or_else(String::new, |value| {
            figure::uncertainty(value, &residual_unit(value, &unit_of(&diagnosis.nominal, name)))
        })
    };
    for (name, _) in &gap.before {
        let mut row = vec![name.clone(), shown(&gap.before, name)];
        match gap.steps.as_slice() {
            [] => row.push(shown(&gap.after, name)),
            steps => row.extend(steps.iter().map(|step| shown(&step.rms, name))),
        }
        row.push(shown(&gap.floor, name));
        rows.add_row(row);
    }
    text.push_str(&drawn(&rows));
    text
}

/// What an effect leaves whose form does not fit.
fn remains(diagnosis: &Diagnosis, gap: &Gap) -> String {
    let mut stages = diagnosis.search.iter().flat_map(|search| &search.stages);
    let stage = stages.nth(diagnosis.effects.len());
    let left = stage.map(locations).unwrap_or_default();
    match (diagnosis.verdict, left.first()) {
        (Verdict::ShapeDiffers, Some(first)) => format!(
            "What is left looks like {}, {:.0} units of the noise long.\n",
            first.place.words,
            gap.leftover.sqrt()
        ),
        _ => String::new(),
    }
}

/// How large a gap is that nothing explains, and what comes nearest to it.
fn unexplained(diagnosis: &Diagnosis) -> String {
    let Some(noise) = &diagnosis.floor else { return String::new() };
    let mut text = String::new();
    if let Some(nearest) = &diagnosis.nearest {
        let share = if diagnosis.locations.is_empty() {
            format!("\nThe nearest effect is `{}`.\n", nearest.name)
        } else {
            let share = 100.0 * nearest.share;
            format!("\nThe nearest effect, `{}`, explains {share:.0} % of it.\n", nearest.name)
        };
        text.push_str(&share);
    }
    let mut rows = table(&["rms", "of the residuals", "noise alone"]);
    for (name, rms) in &diagnosis.nominal.rms {
        let unit = residual_unit(*rms, &unit_of(&diagnosis.nominal, name));
        let noise = noise.iter().find(|(other, _)| other == name);
        rows.add_row([
            name.clone(),
            figure::uncertainty(*rms, &unit),
            noise.map_or_else(String::new, |(_, noise)| figure::uncertainty(*noise, &unit)),
        ]);
    }
    text + &drawn(&rows)
}

fn places(diagnosis: &Diagnosis) -> String {
    let shares: Vec<String> =
        diagnosis.locations.iter().map(|one| format!("{:.0} %", 100.0 * one.share)).collect();
    let rows = diagnosis.locations.iter().zip(&shares);
    let rows = rows.map(|(one, share)| [one.place.words.as_str(), share]);
    listed("where the gap lies", ["", "share of the best"], rows.collect())
}

fn candidates(diagnosis: &Diagnosis, top: usize) -> String {
    let mut header = vec!["effect", "p", "lambda"];
    // Of nothing there is no share.
    let shares = !diagnosis.locations.is_empty();
    header.extend(shares.then_some("share"));
    // It is the probability of a single cause; where there are more it says nothing.
    let single = diagnosis.effects.len() < 2 && diagnosis.verdict != Verdict::ShapeDiffers;
    header.extend(single.then_some("probability"));
    let mut rows = table(&header);
    for one in diagnosis.candidates.iter().take(top) {
        let mut row =
            vec![one.name.clone(), by_chance(one.score.ln_p), format!("{:.1}", one.score.lambda())];
        row.extend(shares.then(|| format!("{:.0} %", 100.0 * one.share)));
        row.extend(single.then(|| percent(one.probability)));
        rows.add_row(row);
    }
    format!("\ncandidates, best first\n{}", drawn(&rows))
}

/// The largest shift of a delay that could go unnoticed.
fn could_hide(diagnosis: &Diagnosis) -> String {
    let Some(worst) = diagnosis.hidden.first() else { return String::new() };
    let second = Unit::coherent(Dimension::TIME);
    format!(
        "\nWhat could still hide: were `{}` there, just too small to be declared, `{}` would be off by {}.\n",
        worst.name,
        worst.delay,
        figure::uncertainty(worst.bias, &second)
    )
}

/// The verdict.
fn sentence(diagnosis: &Diagnosis) -> String {
    let noise = diagnosis.noise.iter().map(|one| &one.name);
    let effects = diagnosis.effects.iter().map(|one| &one.candidate.name);
    let names: Vec<String> = effects.chain(noise).map(|name| format!("`{name}`")).collect();
    let names = names.join(" and ");
    match diagnosis.verdict {
        Verdict::Adequate
            if last_noise(diagnosis)
                .is_some_and(|noise| noise.levels.iter().any(|(_, factor)| *factor > 1.0)) =>
        {
            "Nothing was found but noise: what is left looks like noise that is larger than stated."
                .to_owned()
        }
        Verdict::Adequate if !diagnosis.suspected.is_empty() => {
            "Nothing can be declared: what is left looks like noise but for what is suspected."
                .to_owned()
        }
        Verdict::Adequate => {
            "Nothing was found: the readings follow the model as closely as their noise lets them."
                .to_owned()
        }
        Verdict::Explained => format!(
            "The gap between model and readings is explained by {names}; what is left looks like noise{}.",
            if last_noise(diagnosis).is_some_and(|noise| noise.memory > 0.0) {
                " with a memory"
            } else {
                ""
            }
        ),
        Verdict::ShapeDiffers if diagnosis.effects.len() > 1 || !diagnosis.noise.is_empty() => {
            format!(
                "Nearly all of the gap is explained by {names}; what is left has a form of its own."
            )
        }
        Verdict::ShapeDiffers => format!(
            "Nearly all of the gap is explained by {names}, but its form does not quite fit."
        ),
        Verdict::Unknown => {
            // Displacements are there together; of blocks one would do.
            let (least, join) = match diagnosis.search.as_ref().and_then(displaced) {
                Some(_) => (0.0, " and "),
                None => (SAME_PLACE, " or "),
            };
            let alike = diagnosis.locations.iter().filter(|one| one.share >= least);
            let places: Vec<&str> = alike.map(|one| one.place.words.as_str()).collect();
            let looks = match places.as_slice() {
                [] => "No place of it stands out".to_owned(),
                places => format!("It looks like {}", places.join(join)),
            };
            format!("There is a gap that no effect of the library explains. {looks}.")
        }
        Verdict::Unobservable => {
            "No diagnosis: these readings do not determine the model's own parameters.".to_owned()
        }
    }
}

/// A probability of causes: certainty is nobody's.
fn percent(probability: f64) -> String {
    match 100.0 * probability {
        most if most > 99.9 => "above 99.9 %".to_owned(),
        least if least < 0.1 => "below 0.1 %".to_owned(),
        between => format!("{between:.1} %"),
    }
}

/// A probability by chance from its logarithm, readable far below what a double holds.
fn by_chance(ln_p: f64) -> String {
    let tenth = ln_p / std::f64::consts::LN_10;
    if tenth > -3.0 {
        return format!("{:.3}", ln_p.exp());
    }
    format!("1e{}", tenth.round())
}
