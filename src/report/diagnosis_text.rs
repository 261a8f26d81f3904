//! The result of `diagnose` for people: the verdict first, in a sentence that can be read aloud.

use crate::diagnose::Diagnosis;
use crate::diagnose::evidence::thresholds::LEAST_LAMBDA;
use crate::diagnose::found::{Location, Ranked};
use crate::diagnose::gap::Gap;
use crate::diagnose::library::candidate::NotTestable;
use crate::diagnose::library::prior::Cause;
use crate::diagnose::search::probability::is_implausible;
use crate::diagnose::verdict::answer::{Verdict, Why};
use crate::diagnose::verdict::hidden::Hidden;
use crate::diagnose::verdict::locations::{locations, most_told};
use crate::report::diagnosis::{
    estimates_of, is_of_one_cause, last_stage, members_of, stated_prior, times_usual,
};
use crate::report::figure;
use crate::report::layout::{drawn, table};
use crate::report::noise_text::{alike, noise};
use crate::report::text::{residual_unit, stated, trouble, unit_of};
use crate::report::verdict_text::sentence;
use crate::units::{Dimension, Unit, decimal};

/// Candidates shown unless another number is asked for.
const TOP: usize = 8;
/// Share from which on an effect may be one of several causes.
const PARTLY: f64 = 0.3;

/// The result of `diagnose`, at most `top` candidates.
pub fn text(title: &str, diagnosis: &Diagnosis, top: Option<usize>) -> String {
    let mut text = format!("{title}\n\n{}\n", sentence(diagnosis));
    if diagnosis.verdict == Verdict::Unobservable {
        text.push_str(&trouble(&diagnosis.nominal));
        return text;
    }
    if !diagnosis.suspected.is_empty() {
        let names = diagnosis.suspected.join("`, `");
        text.push_str(&format!("Suspected, but not declared (lambda below {LEAST_LAMBDA:.0}, evidence that is too uneven along the runs, or no fit beside what was found): `{names}`.\n"));
    }
    text.push_str(&noise(diagnosis));
    // A value that may be wrong comes before the effect that would be there if it were right.
    let (values, effects) = (stated(&diagnosis.contradicted), effects(diagnosis));
    let is_first = diagnosis.rests_on_stated_values();
    let told = if is_first { [values, effects] } else { [effects, values] };
    text.push_str(&told.concat());
    let last = diagnosis.search.as_ref().and_then(|search| search.stages.last());
    let is_more = last.is_some_and(|last| !last.blocks_found().is_empty());
    if diagnosis.verdict == Verdict::Unknown && is_more && !diagnosis.contradicted.is_empty() {
        text.push_str("As long as a gap has no name, that may be its doing.\n");
    }
    if !diagnosis.contradicted.is_empty() && diagnosis.search.is_none() {
        text.push_str("Beside it nothing else can be judged: state it right and diagnose again.\n");
    }
    if let Some(found) = &diagnosis.gap {
        text.push_str(&gap(diagnosis, found));
    }
    text.push_str(&unexplained(diagnosis));
    text.push_str(&untried(diagnosis));
    text.push_str(&places(diagnosis));
    text.push_str(&candidates(diagnosis, top.unwrap_or(TOP)));
    text.push_str(&could_hide(diagnosis));
    let absorbed = diagnosis.absorbed.iter().map(|one| [one.name.as_str(), &one.acts_as]);
    text.push_str(&listed(
        "cannot be seen here: these act as nominal parameters do",
        ["effect", "acts as"],
        absorbed.collect(),
    ));
    let (others, here): (Vec<_>, Vec<_>) =
        diagnosis.not_testable.iter().partition(|one| one.of_other_models);
    let here = by_reason(&here);
    let here = here.iter().map(|(names, why)| [names.as_str(), *why]);
    text.push_str(&listed("cannot be tested here", ["effects", "why"], here.collect()));
    let told = match others.len() {
        0 => String::new(),
        1 => format!("\n`{}` acts on what this model does not have.\n", others[0].name),
        count => format!(
            "\n{count} effects of the library act on what this model does not have (`homepoint effects MODEL` lists them).\n"
        ),
    };
    text.push_str(&told);
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

/// An alias that is less probable is told why.
const HARDLY: f64 = 0.01;

/// The named effects with their values and what cannot be told from them.
fn effects(diagnosis: &Diagnosis) -> String {
    let mut text = String::new();
    let is_improbable = |name: &String| {
        let listed = diagnosis.candidates.iter().find(|one| one.name == *name);
        listed.is_some_and(|one| one.probability < HARDLY)
    };
    for one in &diagnosis.effects {
        let candidate = &one.candidate;
        text.push_str(&format!("\n{}: {}\n", candidate.name, candidate.selected.effect.title));
        for (family, value) in &candidate.selected.member {
            let unit = candidate.selected.effect.shape.get(family).map(|shape| &shape.unit);
            let known = members_of(diagnosis, one).find(|known| known.family == *family);
            let shown = unit.map_or_else(String::new, |unit| match known {
                Some(known) => figure::measured(*value, known.sigma, unit),
                None => figure::value(*value, None, unit),
            });
            text.push_str(&format!("  {family} {shown}\n"));
        }
        for estimate in estimates_of(diagnosis, one) {
            let of = estimate.of.map_or_else(String::new, |of| format!(" ({of})"));
            let Some(value) = estimate.value else {
                let name = estimate.name;
                text.push_str(&format!("  {name}{of} is not determined by these readings\n"));
                continue;
            };
            let figure = match (estimate.sigma, estimate.bound) {
                (None, Some(bound)) => {
                    let value = figure::value(value, None, &estimate.declared);
                    format!("{value} (at its {} bound)", bound.word())
                }
                (sigma, _) => figure::measured(value, sigma.unwrap_or(0.0), &estimate.declared),
            };
            text.push_str(&format!("  {}{of} = {figure}\n", estimate.name));
        }
        if let Some(times) = times_usual(diagnosis, one).filter(|times| is_implausible(*times)) {
            text.push_str(&format!(
                "  That is {} times its usual size, which is implausible: look at units, signs and setups.\n",
                decimal(times, 0)
            ));
        }
        text.push_str(&alike(&one.aliases));
        if diagnosis.effects.len() == 1 && one.aliases.iter().any(is_improbable) {
            text.push_str(
                "  What sets their probabilities apart is mostly which sizes are usual, hardly what these readings say.\n",
            );
        }
        let which = if one.aliases.is_empty() { "this effect" } else { "one of these" };
        let probability = percent(one.probability);
        let is_last =
            diagnosis.effects.last().is_some_and(|last| last.candidate.name == candidate.name);
        if is_last && diagnosis.verdict == Verdict::Explained {
            let unless =
                if one.evidence() == "prior" { ", if what is stated is right" } else { "" };
            text.push_str(&format!(
                "  Probability that {which} is the cause{unless}: {probability}.\n"
            ));
            if one.probability < 0.5 {
                text.push_str(
                    "  The rest is that of other effects, of chance and of what nobody wrote down.\n",
                );
            }
        } else {
            text.push_str(&format!(
                "  Probability that it is {which}, of all effects that could be tested here: {probability}.\n"
            ));
        }
        if one.evidence() == "prior" {
            text.push_str("  Its evidence lies in stated values that the readings contradict: state them right, or not at all, before it is put into the model.\n");
        }
    }
    text
}

/// How far the gap shrinks.
fn gap(diagnosis: &Diagnosis, gap: &Gap) -> String {
    let mut text = String::new();
    if let (Some(closed), Some([low, high])) = (gap.closed, gap.closed_interval) {
        let on = match &gap.held_out {
            Some(name) => format!("On the held-out campaign `{name}`"),
            None => "On readings that it was not fitted to".to_owned(),
        };
        text.push_str(&format!(
            "\n{on}, this closes {:.0} % of the gap ({:.0} to {:.0} %, {} fold{}).\n",
            100.0 * closed,
            100.0 * low,
            100.0 * high,
            gap.folds,
            if gap.folds == 1 { "" } else { "s" }
        ));
    }
    if gap.left_out > 0 {
        text.push_str(&format!(
            "{} of those readings {} left out: lost or gross.\n",
            gap.left_out,
            if gap.left_out == 1 { "is" } else { "are" }
        ));
    }
    if let (Some(times), None) = (gap.missed(), gap.is_borne_out()) {
        text.push_str(&format!(
            "Every measurand is off there by {} times its noise and more, with it and without: the values that are held for rig and instrument do not fit that campaign, so it neither confirms nor refutes this.\n",
            decimal(times, 0)
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
            figure::size(value, &residual_unit(value, &unit_of(&diagnosis.nominal, name)))
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
    let stage = last_stage(diagnosis);
    let left = stage.map(locations).unwrap_or_default();
    match (diagnosis.verdict, left.first().or(diagnosis.rings.as_ref())) {
        (Verdict::ShapeDiffers, Some(first)) => {
            // Of a place in the campaign that was fitted: what a held-out one shows may be another.
            let own = stage.filter(|_| !left.is_empty()).map(most_told);
            let of_ringing = if gap.held_out.is_none() { gap.leftover } else { 0.0 };
            let length = match own.unwrap_or(of_ringing).sqrt() {
                length if length >= 0.5 => {
                    format!(", {} units of the noise long", decimal(length, 0))
                }
                _ => String::new(),
            };
            format!("What is left looks like {}{length}.\n", first.place.words)
        }
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
            format!(
                "\nThe nearest effect by itself, `{}`, explains {share:.0} % of it.\n",
                nearest.name
            )
        };
        text.push_str(&share);
        if let Some(place) = beside(diagnosis, nearest) {
            text.push_str(&format!(
                "If it is a cause, then beside another, which looks like {place}.\n"
            ));
        }
    }
    let mut rows = table(&["rms", "of the residuals", "noise alone"]);
    for (name, rms) in &diagnosis.nominal.rms {
        let unit = residual_unit(*rms, &unit_of(&diagnosis.nominal, name));
        let noise = noise.iter().find(|(other, _)| other == name);
        rows.add_row([
            name.clone(),
            figure::size(*rms, &unit),
            noise.map_or_else(String::new, |(_, noise)| figure::size(*noise, &unit)),
        ]);
    }
    text + &drawn(&rows)
}

/// What would be tried if a constant were stated, where something is left to be explained.
fn untried(diagnosis: &Diagnosis) -> String {
    let wanting = diagnosis.not_testable.iter().filter(|one| !one.wants.is_empty());
    let wanting: Vec<String> =
        wanting.map(|one| format!("`{}` ({})", one.name, one.wants.join(", "))).collect();
    let is_left = matches!(diagnosis.verdict, Verdict::Unknown | Verdict::ShapeDiffers);
    if wanting.is_empty() || !is_left || diagnosis.search.is_none() {
        return String::new();
    }
    format!(
        "\nNot tried, for want of a constant that `--set NAME=VALUE` or [parameters] states: {}.\n",
        wanting.join(", ")
    )
}

/// What is left beside the nearest effect where it was tried first, and something else is there as
/// well.
fn beside(diagnosis: &Diagnosis, nearest: &Ranked) -> Option<String> {
    let search = diagnosis.search.as_ref()?;
    let is_first = search.adopted.first()?.candidate.name == nearest.name;
    let is_open = matches!(diagnosis.why, Some((Why::NoneFits, _))) && nearest.share >= PARTLY;
    let left = (is_first && is_open).then(|| locations(&search.stages[1]))?;
    // What it leaves of its own place is its form.
    let is_other =
        |one: &&Location| diagnosis.locations.first().is_none_or(|first| first.place != one.place);
    Some(left.first().filter(is_other)?.place.words.clone())
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
    let single = is_of_one_cause(diagnosis);
    header.extend(single.then_some("probability"));
    let mut rows = table(&header);
    if diagnosis.candidates.is_empty() || top == 0 {
        return String::new();
    }
    let is_nearest =
        |one: &Ranked| diagnosis.nearest.as_ref().is_some_and(|own| own.name == one.name);
    let all = diagnosis.candidates.iter().enumerate();
    for (_, one) in all.filter(|(number, one)| *number < top || is_nearest(one)) {
        let mut row =
            vec![one.name.clone(), by_chance(one.score.ln_p), format!("{:.1}", one.score.lambda())];
        row.extend(shares.then(|| format!("{:.0} %", 100.0 * one.share)));
        row.extend(single.then(|| percent(one.probability)));
        rows.add_row(row);
    }
    let causes = if single { causes(diagnosis) } else { String::new() };
    format!("\ncandidates, best first\n{}{causes}", drawn(&rows))
}

/// What is left of the candidates' probabilities, and what they are made from.
fn causes(diagnosis: &Diagnosis) -> String {
    let (Some([nothing, _, unknown]), Some(prior)) = (diagnosis.causes, stated_prior(diagnosis))
    else {
        return String::new();
    };
    let before = |cause| match (1000.0 * prior.of(cause)).round() / 10.0 {
        rounded if rounded > 0.0 => format!("{rounded} %"),
        _ => percent(prior.of(cause)),
    };
    let times = |(name, times)| format!(" (`{name}` {times} times as probable as another)");
    let unequal: String = prior.unequal().map(times).collect();
    format!(
        "That nothing is there has {}, that something is there that nobody wrote down {}.\n\
         Before the readings: nothing {}, an effect of the library {}{unequal}, something that nobody wrote down {} (`--prior` states others).\n",
        percent(nothing),
        percent(unknown),
        before(Cause::Nothing),
        before(Cause::Library),
        before(Cause::Unknown),
    )
}

/// The largest shift of a delay that could go unnoticed, by an effect of a size that can be.
fn could_hide(diagnosis: &Diagnosis) -> String {
    let can_be = |one: &&Hidden| !one.times_usual.is_some_and(is_implausible);
    let worst = diagnosis.hidden.iter().find(can_be).or(diagnosis.hidden.first());
    let Some(worst) = worst else { return String::new() };
    let second = Unit::coherent(Dimension::TIME);
    let times = worst
        .times_usual
        .map_or_else(String::new, |times| format!(", {} times as large as usual", rounded(times)));
    format!(
        "\nWhat could still hide: were `{}` there, just too small to be declared{times}, `{}` would be off by {}.\n",
        worst.name,
        worst.delay,
        figure::uncertainty(worst.bias, &second)
    )
}

/// A ratio in two digits.
fn rounded(ratio: f64) -> String {
    let digits = (1.0 - ratio.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{ratio:.digits$}")
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
    if tenth > -5.0 {
        return format!("{:.0e}", ln_p.exp());
    }
    format!("1e{}", tenth.round())
}
