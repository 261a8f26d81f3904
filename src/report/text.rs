//! Tables and sentences for the terminal.

use crate::diagnostic::counted;
use crate::engine::Part;
use crate::estimate::batch::Outcome;
use crate::estimate::calibrate::{Calibration, Estimate, Held};
use crate::estimate::compare::Comparison;
use crate::estimate::contradicted::{Contradicted, contradicted};
use crate::estimate::correlations::covariance_of_estimates;
use crate::estimate::delays::Delays;
use crate::estimate::jumps::may_jump;
use crate::estimate::linear_range::beyond_range;
use crate::estimate::noise::Noise;
use crate::estimate::transformation::From;
use crate::report::autocorrelation::{self, correlated};
use crate::report::budget;
use crate::report::correlations;
use crate::report::figure;
use crate::report::global;
use crate::report::json::scope_word;
use crate::report::layout::{align_right, drawn, table};
use crate::report::linear_range;
use crate::report::noise;
use crate::report::sentences::{refused, terms};
use crate::report::smoothing;
use crate::units::{Dimension, Unit, decimal, ratio};

/// Most rows of setup and run parameters that are shown; the rest is in the tables.
const MOST_ROWS: usize = 60;

/// Normalised differences beyond which two estimates of a delay disagree.
const DISAGREE: f64 = 5.0;

/// Said once of campaigns in which nothing moves.
pub const NOTHING_MOVES: &str =
    "No signal moves in these runs: there are no delays, and effects of timing do nothing.";

/// The result of `calibrate`.
pub fn calibration(title: &str, result: &Calibration) -> String {
    calibration_with(title, result, "")
}

/// The same with a paragraph on conventions that may have been mistaken: it comes before the values, which
/// hold only without such a mistake.
pub fn calibration_with(title: &str, result: &Calibration, mistaken: &str) -> String {
    let mut text = format!("{title}\n\n");
    text.push_str(&fit(result));
    if !result.problem.moves() {
        text.push_str(&format!("{NOTHING_MOVES}\n"));
    }
    text.push_str(mistaken);
    text.push_str(&trouble(result));
    if result.fit.outcome == Outcome::IterationLimit {
        text.push_str(
            "`homepoint diagnose` looks for readings and runs that keep it from settling.\n",
        );
        if matches!(result.noise, Noise::Autocorrelated(_)) {
            text.push_str("The noise that was estimated keeps it from settling: `--noise sandwich` keeps the values of the plain fit.\n");
        }
    }
    text.push_str(&global::verdict(result));
    text.push_str(&autocorrelation::text(&correlated(result)));
    text.push_str(&noise::text(&result.noise));
    text.push_str(&smoothing::text(result));
    text.push_str(&stated(&contradicted(result)));
    let estimates = result.estimates();
    text.push_str(&linear_range::text(&beyond_range(&result.problem, &estimates)));
    let has_settled = result.fit.outcome.is_result();
    let header: &[&str] = if has_settled {
        &["parameter", "of", "value", "u (k=1)"]
    } else {
        &["parameter", "of", "where it stopped"]
    };
    let mut rows = table(header);
    let shown: Vec<&Estimate> = estimates.iter().filter(|one| !one.fixed).collect();
    for one in shown.iter().take(MOST_ROWS) {
        let value = one.value.map_or_else(
            || "not determined".to_owned(),
            |value| figure::value(value, one.sigma, &one.declared),
        );
        let of = one.of.clone().unwrap_or_else(|| scope_word(one.scope).to_owned());
        let mut row = vec![one.name.clone(), of, value];
        if has_settled {
            row.push(match (one.sigma, one.bound) {
                (_, Some(bound)) => format!("at its {} bound", bound.word()),
                (Some(sigma), None) => {
                    figure::uncertainty_of(one.value.unwrap_or(f64::NAN), sigma, &one.declared)
                }
                (None, None) => String::new(),
            });
        }
        rows.add_row(row);
    }
    align_right(&mut rows, &[2, 3]);
    text.push('\n');
    text.push_str(&drawn(&rows));
    if shown.len() > MOST_ROWS {
        let rest = shown.len() - MOST_ROWS;
        text.push_str(&format!("... and {rest} more: `--out DIR` or `--format json` has all\n"));
    }
    if has_settled {
        text.push_str(&correlations::text(covariance_of_estimates(result).as_ref()));
    }
    text
}

fn fit(result: &Calibration) -> String {
    let factor = result.variance_factor().map_or_else(
        || "without degrees of freedom".to_owned(),
        |value| format!("variance factor {}", ratio(value, 3)),
    );
    let stated = result.fit.normal.priors.len();
    let stated = match stated {
        0 => String::new(),
        1 => " and a stated value".to_owned(),
        several => format!(" and {several} stated values"),
    };
    let mut text = format!(
        "{}{stated}, {}, {}: {factor}\n",
        counted(result.readings - result.fit.normal.priors.len(), "reading"),
        counted(result.unknowns(), "unknown"),
        counted(result.fit.iterations, "iteration")
    );
    let rms: Vec<String> = result
        .rms
        .iter()
        .map(|(name, value)| {
            format!(
                "{name} {}",
                figure::size(*value, &residual_unit(*value, &unit_of(result, name)))
            )
        })
        .collect();
    text.push_str(&global::line(result));
    text.push_str(&format!("residual rms: {}\n", rms.join(", ")));
    text
}

/// The unit in which a measurand is read.
pub(crate) fn unit_of(result: &Calibration, name: &str) -> Unit {
    let of = |part: &Part| {
        let index = part.system.assembly.names.measurands.iter().position(|m| m.name == name)?;
        Some(part.unit_of(index))
    };
    result.problem.parts.iter().find_map(of).unwrap_or_else(Unit::one)
}

/// Residuals of angles in radians are small: they are read more easily in parts of one.
pub(crate) fn residual_unit(size: f64, declared: &Unit) -> Unit {
    if declared.symbol == "rad" {
        let part = if size < 1e-3 { "µrad" } else { "mrad" };
        Unit::parse(part).unwrap_or_else(|_| declared.clone())
    } else {
        declared.clone()
    }
}

/// What keeps the numbers from being used, or the fit from its solution; empty if nothing does.
pub fn trouble(result: &Calibration) -> String {
    let mut text = String::new();
    if !result.fit.outcome.is_result() {
        text.push_str(&format!("\nno result: {}\n", result.fit.outcome));
    } else if result.fit.outcome == Outcome::Near {
        let why = match may_jump(&result.problem) {
            true => {
                " The model may jump there, as with the sign of a noisy rate: smoother signals (`smooth`), or `tanh` in place of `sign`, may help."
            }
            false => "",
        };
        text.push_str(&format!("{}{why}\n", result.fit.outcome));
    }
    text.push_str(&held(result));
    for one in &result.refused {
        text.push_str(&format!("\nno result: {}\n", refused(one)));
    }
    let lacking = -result.degrees_of_freedom();
    if lacking > 0 {
        text.push_str(&format!(
            "\nThere are fewer readings and stated values than unknowns: {} at least, at other values of the inputs, or state the parameters that are known (`sigma`, `fixed = true`).\n",
            counted(lacking.unsigned_abs() as usize, "more reading"),
        ));
        return text;
    }
    if !result.unobservable.is_empty() {
        text.push_str("\nThese readings do not determine everything:\n");
    }
    for one in &result.unobservable {
        text.push_str(&format!("- {}\n  remedy: {}\n", one.words, one.remedy));
        for sum in &one.determined {
            let size = figure::measured(sum.value, sum.sigma, &sum.declared);
            text.push_str(&format!("  determined to first order: {} = {size}\n", terms(sum)));
        }
    }
    text
}

/// Members of effects that were held, a sentence each; empty if there are none.
pub fn held(result: &Calibration) -> String {
    let alike = |a: &Held, b: &Held| a.name == b.name && a.of.is_some() && b.of.is_some();
    let each = result.held.chunk_by(alike).map(|all| {
        let Held { name, why, .. } = &all[0];
        let runs: Vec<String> =
            all.iter().filter_map(|one| Some(format!("`{}`", one.of.as_ref()?))).collect();
        match runs.as_slice() {
            [] => format!("\n`{name}` is held at zero, for the model absorbs it: {why}.\n"),
            runs => format!(
                "\n`{name}` of {} is held at zero: no reading there depends on it.\n",
                runs.join(", ")
            ),
        }
    });
    each.collect()
}

/// Stated values that the readings contradict, one a line; empty if there are none.
pub(crate) fn stated(contradicted: &[Contradicted]) -> String {
    let mut text = String::new();
    for one in contradicted {
        let Estimate { name, declared, .. } = &one.estimate;
        let of = one.estimate.of.as_ref().map_or_else(String::new, |of| format!(" of `{of}`"));
        let stated = figure::measured(one.stated, one.sigma, declared);
        let alone = figure::value(one.alone, Some(one.sigma), declared);
        text.push_str(&format!(
            "`{name}`{of} is stated as {stated}, but the readings say {alone}: {} standard deviations apart.\n",
            decimal(one.deviations, 0)
        ));
    }
    if text.is_empty() { text } else { format!("\n{text}") }
}

/// The result of `delays`.
pub fn delays(title: &str, from: &From, delays: &Delays) -> String {
    let second = Unit::coherent(Dimension::TIME);
    let mut text = format!("{title}\ntransformation from {}\n\n", from_words(*from));
    let header = [
        "measurand",
        "readings",
        "solved",
        "blind",
        "failed",
        "mean delay",
        "u (k=1)",
        "median U (k=2)",
    ];
    let mut rows = table(&header);
    for one in &delays.measurands {
        rows.add_row([
            one.measurand.clone(),
            one.readings.to_string(),
            one.solved.to_string(),
            one.blind.to_string(),
            one.failed.to_string(),
            one.mean.map_or_else(
                || "-".to_owned(),
                |mean| figure::value(mean, one.sigma_of_mean, &second),
            ),
            one.sigma_of_mean.map_or_else(String::new, |u| figure::uncertainty(u, &second)),
            one.median_expanded_uncertainty
                .map_or_else(String::new, |u| figure::uncertainty(u, &second)),
        ]);
    }
    align_right(&mut rows, &[1, 2, 3, 4, 5, 6, 7]);
    text.push_str(&drawn(&rows));
    for one in &delays.measurands {
        text.push_str(&budget::blind_text(&one.measurand, &one.blind_ranges));
    }
    for (name, why) in &delays.left_out {
        text.push_str(&format!("`{name}` is left out: {why}\n"));
    }
    text.push('\n');
    text
}

/// The result of `compare`.
pub fn comparison(title: &str, from: &From, list: &[Comparison]) -> String {
    let second = Unit::coherent(Dimension::TIME);
    let mut text = format!(
        "{title}\ntransformation for the delay of each reading from {}\n\n",
        from_words(*from)
    );
    let mut rows =
        table(&["measurand", "readings", "u", "joint estimate", "u", "difference", "normalised"]);
    let cell = |value: Option<f64>, sigma: Option<f64>| {
        value.map_or_else(|| "-".to_owned(), |value| figure::value(value, sigma, &second))
    };
    let spread =
        |sigma: Option<f64>| sigma.map_or_else(String::new, |u| figure::uncertainty(u, &second));
    for one in list {
        let normalised = one.normalised().map_or_else(|| "-".to_owned(), |value| decimal(value, 2));
        rows.add_row([
            one.measurand.clone(),
            cell(one.newton, one.newton_sigma),
            spread(one.newton_sigma),
            cell(one.batch, one.batch_sigma),
            spread(one.batch_sigma),
            cell(one.difference(), one.newton_sigma),
            normalised,
        ]);
    }
    align_right(&mut rows, &[1, 2, 3, 4, 5, 6]);
    text.push_str(&drawn(&rows));
    text.push('\n');
    text.push_str(&disagreement(list));
    text
}

/// Says which measurands have other delays by one way than by the other; empty where both agree.
fn disagreement(list: &[Comparison]) -> String {
    let apart = |one: &&Comparison| one.normalised().is_some_and(|value| value.abs() > DISAGREE);
    let names: Vec<String> =
        list.iter().filter(apart).map(|one| format!("`{}`", one.measurand)).collect();
    if names.is_empty() {
        return String::new();
    }
    format!(
        "The two ways disagree about {}: by more than {DISAGREE:.0} standard uncertainties of their difference. One of them, or the model, is wrong: `homepoint diagnose` looks for the cause.\n",
        names.join(", ")
    )
}

pub(crate) fn from_words(from: From) -> &'static str {
    match from {
        From::ReferenceRuns => "the reference runs alone",
        From::JointFit => "the joint fit of all runs",
        From::Paper => "the reference runs as if nothing were delayed (the paper's way)",
        From::Iterated => "the reference runs, in turn with the delays",
    }
}
