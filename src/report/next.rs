//! What to do after a diagnosis: the command that goes on from it, or what is to be set right before.

use std::collections::HashSet;

use crate::campaign::declared::RunEntry;
use crate::diagnose::Diagnosis;
use crate::diagnose::budget::answer::{Remainder, Row};
use crate::diagnose::library::variant::Variant;
use crate::report::conventions::text_for;
use crate::report::figure;
use crate::report::left_out;
use crate::report::rows_text::{family_unit, listed};

/// What was asked for, as it was typed, and what is known beside the diagnosis.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// The campaigns.
    pub campaigns: &'a str,
    /// The options that an estimate needs, too.
    pub options: &'a [String],
    /// The options beside them that a diagnosis alone needs.
    pub beside: &'a [String],
    /// The options that state what was held.
    pub held: &'a [String],
    /// The folder into which tables are written, if one was named.
    pub out: Option<&'a str>,
    /// Candidates that are shown at most.
    pub top: Option<usize>,
    /// The runs as they were written.
    pub runs: &'a [RunEntry],
}

impl Default for Asked<'_> {
    fn default() -> Self {
        Self {
            campaigns: "CAMPAIGN",
            options: &[],
            beside: &[],
            held: &[],
            out: None,
            top: None,
            runs: &[],
        }
    }
}

/// The convention that was mistaken. It stands before all else: a diagnosis of numbers that were misread
/// is worth little.
pub(super) fn mistaken(diagnosis: &Diagnosis, asked: &Asked<'_>) -> String {
    let next = match diagnosis.is_misread() {
        true => "\nNext: set this right and diagnose again.\n",
        false => "",
    };
    text_for(diagnosis.mistaken.as_ref(), asked.runs) + next
}

/// The command that goes on from here.
pub(super) fn next(diagnosis: &Diagnosis, asked: &Asked<'_>) -> String {
    if let Some(name) = &diagnosis.set_free {
        let is_alike = diagnosis.mistaken.as_ref().is_some_and(|one| one.stated.is_some());
        let convention = if is_alike { "set the convention right, or " } else { "" };
        return format!(
            "\nNext: {convention}correct the stated value of `{name}`, or state none, and diagnose again.\n"
        );
    }
    let campaigns = asked.campaigns;
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
    let leaves_out = left_out::is_any(diagnosis) && diagnosis.verdict.is_made();
    // Beside a remainder such weights would take it for noise, and what rows do with it.
    let noise = weights(diagnosis).filter(|_| !diagnosis.verdict.has_remainder());
    if !diagnosis.rows.is_empty() || leaves_out || noise.is_some() {
        let rows = diagnosis.rows.iter().map(|one| format!("--with {}", one.name));
        let members = diagnosis.rows.iter().flat_map(|row| members(diagnosis, row, asked));
        let folder = asked.out.unwrap_or("DIR");
        let leave_out = leaves_out.then(|| format!("--leave-out {folder}/left_out.csv"));
        let mut members: Vec<String> = members.collect();
        let mut seen = HashSet::new();
        members.retain(|member| seen.insert(member.clone()));
        let options: Vec<String> = asked
            .options
            .iter()
            .chain(asked.held)
            .cloned()
            .chain(rows)
            .chain(members)
            .chain(leave_out)
            .chain(noise.map(str::to_owned))
            .collect();
        let calibrate = format!("`homepoint calibrate {campaigns} {}`\n", options.join(" "));
        if leaves_out && asked.out.is_none() {
            let same: Vec<&str> = [campaigns]
                .into_iter()
                .chain(asked.options.iter().map(String::as_str))
                .chain(asked.beside.iter().map(String::as_str))
                .collect();
            text.push_str(&format!(
                "\nNext: `homepoint diagnose {} --out DIR`, which writes DIR/left_out.csv;\n      then {calibrate}",
                same.join(" ")
            ));
        } else {
            text.push_str(&format!("\nNext: {calibrate}"));
        }
        text.push_str(&diagnosis.rows.iter().filter_map(relaxed).collect::<String>());
    }
    text.push_str(&of_remainder(diagnosis, leaves_out));
    text
}

/// The option of `calibrate` whose uncertainties count noise of another form: in the weights where it is
/// autocorrelated; whatever it is like in each run where it differs between runs.
fn weights(diagnosis: &Diagnosis) -> Option<&'static str> {
    if !diagnosis.autocorrelation.is_empty() {
        return Some("--noise autocorrelated");
    }
    diagnosis.levels.iter().any(|one| one.run.is_some()).then_some("--noise sandwich")
}

/// Options that state the members of a row's families as they were found, but for those that are
/// stated already: `calibrate` looks through a coarser range.
fn members(diagnosis: &Diagnosis, row: &Row, asked: &Asked<'_>) -> Vec<String> {
    let effect = row.name.split('.').next().unwrap_or(&row.name);
    // What no reading tells `calibrate` takes as it was taken here.
    let is_open = row.stamp_jumps.iter().all(|jump| jump.right.is_some());
    let each = row.member.iter().filter(|_| is_open).map(|(family, value)| {
        let size = figure::exact(*value, &family_unit(diagnosis, &row.name, family));
        (format!("--set {effect}.{family}="), size)
    });
    // What a shell would read is in quotation marks.
    let is_stated = |option: &str| {
        let stated = asked.options.iter().map(|one| one.replace('\'', ""));
        stated.into_iter().any(|one| one.starts_with(option))
    };
    let open = each.filter(|(option, _)| !is_stated(option));
    open.map(|(option, size)| format!("{option}\"{size}\"")).collect()
}

/// What to do about the remainder, after what to do with rows and what is left out.
fn of_remainder(diagnosis: &Diagnosis, leaves_out: bool) -> String {
    let has_rows = !diagnosis.rows.is_empty();
    let is_cause = |one: &&Remainder| {
        one.gain.gain > 0.0 && one.change.is_none() && one.place.is_of_an_effect()
    };
    let mut steps = Vec::new();
    if let Some(name) = listed(diagnosis).find_map(|one| one.place.stated()) {
        steps.push(format!(
            "correct the stated value of `{name}`, or let the fit estimate it, and diagnose again"
        ));
    }
    let change = listed(diagnosis).filter(|one| one.change.is_some());
    let change = change.filter_map(|one| Some((one, one.place.run.as_deref()?))).next();
    if let Some((part, run)) = change {
        let rows = match part.place.rows {
            None => String::new(),
            Some((first, None)) => {
                format!("give the rows of run `{run}` from {first} on a run of their own, and ")
            }
            Some((first, Some(last))) => format!(
                "leave rows {first} to {last} of run `{run}` out, or give them a run of their own, and "
            ),
        };
        steps.push(format!(
            "{rows}state scope = \"run\" for the parameters that may differ in run `{run}` (docs/formats.md), and diagnose again"
        ));
    }
    let delayed = diagnosis.remainder.iter().find_map(|one| one.place.delayed_by_run());
    if delayed.is_some() {
        steps
            .push(format!("give {} in [parameters], and diagnose again", delays_by_run(diagnosis)));
    }
    let is_other = |one: &&Remainder| is_cause(one) && one.place.delayed_by_run().is_none();
    if let Some(part) = diagnosis.remainder.iter().find(is_other) {
        steps.push(format!(
            "describe what may cause {} in `effects/NAME.toml` beside the campaign (docs/effects.md), and diagnose again",
            part.place.words
        ));
    }
    if steps.is_empty() {
        return String::new();
    }
    let steps = steps.join("; ");
    match has_rows {
        true => {
            format!("      The remainder is not in that model, and may bias its values: {steps}.\n")
        }
        false if leaves_out => format!("      For the remainder: {steps}.\n"),
        false => format!("\nNext: {steps}.\n"),
    }
}

/// The model's delays with a value for each run, as it is stated.
fn delays_by_run(diagnosis: &Diagnosis) -> String {
    let instances = diagnosis.nominal.problem.layout.instances.iter();
    let mut names: Vec<&str> =
        instances.filter(|one| one.is_delay()).map(|one| one.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    match names[..] {
        [name] => format!("`{name}` a value for each run (`\"{name}\" = {{ scope = \"run\" }}`)"),
        _ => "the delays a value for each run (scope = \"run\")".to_owned(),
    }
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
            "      with a copy of `{name}` in effects/ under a name of its own, given in its place, whose parameters have per = \"measurand\"\n"
        ),
    })
}
