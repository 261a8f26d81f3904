//! The budget of the gap as a table: rows with their values, and the remainder.

use crate::diagnose::Diagnosis;
use crate::diagnose::budget::answer::{Remainder, Row, StepChange, WellDetermined};
use crate::diagnose::budget::stamp_jumps::{Side, StampJump};
use crate::estimate::calibrate::Estimate;
use crate::estimate::combination::quotient;
use crate::report::figure;
use crate::report::layout::{drawn, table};
use crate::report::text::{residual_unit, unit_of};
use crate::units::{Unit, ratio};

/// Values of a row that stand in the table; the others follow it.
pub(super) const SHORT: usize = 2;
/// Jumps of stamps that are named one by one.
const JUMPS: usize = 3;
/// The clock was set at them from this share on.
const SET: f64 = 0.5;
/// They are shown to this part of their size.
const JUMP_DIGITS: f64 = 1e-2;
/// Parts of the remainder below this share of the gap are counted, not listed, but for a few of so large
/// a noncentrality.
const SMALL: f64 = 0.01;
const LARGE: f64 = 25.0;
const MOST: usize = 6;

/// The parts of the remainder that stand in the table.
pub(super) fn listed(diagnosis: &Diagnosis) -> impl Iterator<Item = &Remainder> {
    let is_listed = |(number, one): &(usize, &Remainder)| {
        let is_large = *number < MOST && one.gain.noncentrality() >= LARGE;
        *number == 0 || one.share >= SMALL || is_large
    };
    diagnosis.remainder.iter().enumerate().filter(is_listed).map(|(_, one)| one)
}

/// The budget of the gap: rows and the remainder.
pub(super) fn budget(diagnosis: &Diagnosis) -> String {
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
    let listed: Vec<&Remainder> = listed(diagnosis).collect();
    let small = diagnosis.remainder.len() - listed.len();
    for one in listed {
        rows.add_row([
            "remainder".to_owned(),
            size(diagnosis, one),
            share(one.share),
            String::new(),
            String::new(),
            remainder_words(one),
        ]);
    }
    let small = match small {
        0 => String::new(),
        1 => "One more part of the remainder is below 1 % of the gap.\n".to_owned(),
        count => format!("{count} more parts of the remainder are below 1 % of the gap each.\n"),
    };
    let free = diagnosis.set_free.as_ref().map_or_else(String::new, |name| {
        format!(
            "All but the first line of the remainder is found with `{name}` free; those shares are of the gap that this leaves.\n"
        )
    });
    format!("\n{}{small}{free}", drawn(&rows))
}

/// A row with the effects that are reported with it.
fn group(row: &Row) -> String {
    let others = row.grouped().map(|other| format!(" ~ {}", other.name));
    let form = row.variant.map_or_else(String::new, |form| format!(", {}", form.words()));
    row.name.clone() + &form + &others.collect::<String>()
}

/// The first values of a row, of those that the readings determine if there are any.
fn short(row: &Row) -> String {
    let of = |one: &Estimate| {
        let is_one_of_several = row.values.iter().filter(|own| own.name == one.name).count() > 1;
        let whose = one.of.as_ref().filter(|_| is_one_of_several);
        whose.map_or_else(String::new, |of| format!(" ({of})"))
    };
    let (known, open): (Vec<_>, Vec<_>) = row.values.iter().partition(|one| one.value.is_some());
    let first = known.into_iter().chain(open).take(SHORT);
    let shown: Vec<String> = first.map(|one| value(one, &of(one))).collect();
    let more = if row.values.len() > SHORT { " …" } else { "" };
    shown.join(", ") + more
}

fn value(one: &Estimate, of: &str) -> String {
    let name = one.name.rsplit_once('.').map_or(one.name.as_str(), |(_, last)| last);
    match one.value {
        None => format!("{name}{of} not determined"),
        Some(value) => format!("{name}{of} {}", measured(one, value)),
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
    for jump in row.stamp_jumps.iter().take(JUMPS) {
        let StampJump { run, row: at, size, .. } = jump;
        let size = figure::value(*size, Some(JUMP_DIGITS * size.abs()), &Unit::second());
        let right = right(row, jump)
            .map_or_else(String::new, |side| format!(" (the stamps {} it are right)", side.word()));
        remarks.push(format!("stamps jump by {size} at row {at} of run `{run}`{right}"));
    }
    if row.stamp_jumps.len() > JUMPS {
        remarks.push(format!("{} jumps in all", row.stamp_jumps.len()));
    }
    for other in row.together() {
        let (name, correlation) = (&other.name, other.correlation);
        remarks.push(format!("confounded with {name} (r = {correlation:.3})"));
    }
    remarks.join("; ")
}

/// The stamps beside a jump that are right, where the clock was set there, not the recorder paused.
fn right(row: &Row, jump: &StampJump) -> Option<Side> {
    let is_of = |one: &&Estimate| one.of.as_ref().is_none_or(|of| *of == jump.run);
    let share = row.values.iter().find(is_of)?.value?;
    jump.right.filter(|_| share > SET)
}

/// How large a part of the remainder is.
fn size(diagnosis: &Diagnosis, one: &Remainder) -> String {
    let Some((rms, measurand)) = &one.rms else { return String::new() };
    let declared = unit_of(&diagnosis.nominal, measurand);
    // Of an error of the reading in its unit, of others in their own.
    let unit_of_size = |size: f64, own: &Unit| match own.accepts(&declared) {
        true => residual_unit(size, &declared),
        false => residual_unit(size, own),
    };
    let rms = format!("rms {} in {measurand}", figure::size(*rms, &residual_unit(*rms, &declared)));
    let of_step = |step: &StepChange| {
        figure::measured(step.value, step.sigma, &unit_of_size(step.value, &step.unit))
    };
    let steps: Vec<String> = one.change.iter().chain(&one.turn).map(of_step).collect();
    if !steps.is_empty() {
        return format!("change {}, {rms}", steps.join(" and "));
    }
    let of_order = |unit: &Unit, (order, size): &(usize, f64)| {
        format!("{} ({order} a turn)", figure::size(*size, &unit_of_size(*size, unit)))
    };
    match &one.amplitude {
        Some((_, unit)) if !one.orders.is_empty() => {
            let each: Vec<String> = one.orders.iter().map(|own| of_order(unit, own)).collect();
            format!("amplitude {}, {rms}", each.join(", "))
        }
        Some((size, unit)) => {
            format!("amplitude {}, {rms}", figure::size(*size, &unit_of_size(*size, unit)))
        }
        None => rms,
    }
}

fn remainder_words(one: &Remainder) -> String {
    let nearest = one.nearest.as_ref().map_or_else(String::new, |(name, share)| {
        format!("; nearest: {name}, {:.0} %", 100.0 * share)
    });
    format!("{}{nearest}", one.place.words)
}

/// All values of rows that have more than the table shows, and members of families.
pub(super) fn values(diagnosis: &Diagnosis) -> String {
    let mut text = String::new();
    for row in &diagnosis.rows {
        let is_grouped = row.grouped().any(|other| !other.joint.is_empty());
        // Of jumps the remarks say which stamps are right.
        let members = row.member.iter().filter(|_| row.stamp_jumps.is_empty());
        let is_short = row.values.len() <= SHORT && row.well_determined.is_none();
        if is_short && members.clone().next().is_none() && !is_grouped {
            continue;
        }
        text.push_str(&format!("\n{}\n", row.name));
        for (family, value) in members {
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
        text.push_str(&row.well_determined.as_ref().map_or_else(String::new, well_determined));
        text.push_str(&joint(row));
    }
    text
}

/// A sum that is well determined: `a + 0.84 b = ...`. Factors between unlike units are in SI units.
fn well_determined(found: &WellDetermined) -> String {
    let Some(((_, first), others)) = found.terms.split_first() else { return String::new() };
    let mut sum = format!("  well determined: {}", first.parameter);
    for (factor, one) in others {
        let sign = if *factor < 0.0 { '-' } else { '+' };
        let unit = Some(quotient(&first.unit, &one.unit)).filter(|unit| unit != "1");
        let unit = unit.map_or_else(String::new, |unit| format!(" {unit}"));
        let factor = ratio(factor.abs(), 3);
        sum.push_str(&format!(" {sign} {factor}{unit} * {}", one.parameter));
    }
    let shown = figure::measured(found.value, found.sigma, &first.unit);
    format!("{sum} = {shown}\n")
}

/// The values of a row and of effects that are reported with it, where both are in the fit.
fn joint(row: &Row) -> String {
    let mut text = String::new();
    for other in row.grouped().filter(|other| !other.joint.is_empty()) {
        text.push_str(&format!("  with {} in the fit, too:\n", other.name));
        for (size, sigma) in &other.joint {
            let of = size.of.as_ref().map_or_else(String::new, |of| format!(" ({of})"));
            let shown = figure::measured(size.value, *sigma, &size.unit);
            let has_several = other.joint.iter().any(|(another, _)| {
                another.parameter == size.parameter && another.component != size.component
            });
            let axis = if has_several { [".x", ".y", ".z"][size.component.min(2)] } else { "" };
            text.push_str(&format!("    {}{axis}{of} = {shown}\n", size.parameter));
        }
    }
    text
}

/// The unit in which a family of an effect is declared.
pub(super) fn family_unit(diagnosis: &Diagnosis, effect: &str, family: &str) -> Unit {
    let steps = diagnosis.steps.iter();
    let recipes = steps.flat_map(|steps| &steps.last().recipes);
    let mut effects = recipes.flat_map(|recipe| &recipe.effects);
    let own = effects.find(|one| effect.split('.').next() == Some(one.effect.name.as_str()));
    let shape = own.and_then(|one| one.effect.shape.get(family));
    shape.map_or_else(Unit::one, |shape| shape.unit.clone())
}

/// A share of the gap.
pub(super) fn share(part: f64) -> String {
    match 100.0 * part {
        little if little > 0.0 && little < 0.5 => "< 1 %".to_owned(),
        part => format!("{part:.0} %"),
    }
}

/// A probability: no certainty.
fn percent(probability: f64) -> String {
    match 100.0 * probability {
        most if most > 99.9 => "> 99.9 %".to_owned(),
        least if least < 0.1 => "< 0.1 %".to_owned(),
        between => format!("{between:.1} %"),
    }
}
