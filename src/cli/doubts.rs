//! What makes the numbers of a fit doubtful, reported beside them: readings far off the model,
//! accelerations that are missed.

use super::render;
use crate::diagnostic::Diagnostic;
use crate::estimate::between_runs::{Differing, delays_that_differ};
use crate::estimate::calibrate::{Calibration, Estimate};
use crate::estimate::farthest::{Farthest, farthest};
use crate::estimate::global::misfit;
use crate::estimate::overstated::{Overstated, overstated};
use crate::estimate::refused::{Outside, outside_streams};
use crate::estimate::unit_factors::unit_factors;
use crate::estimate::unrecorded::{Unrecorded, unrecorded};
use crate::report::figure;
use crate::report::text::{residual_unit, unit_of};
use crate::units::{Dimension, Unit, decimal};

/// What is asked where a number is far from what is stated, by about as much as a unit.
const UNIT: &str = "(is its unit right?)";

/// Residuals larger than stated by so much are no matter of uncertainties.
const SPOILT: f64 = 5.0;

/// Time zones are apart by multiples of this (s).
const ZONE_STEP: f64 = 1800.0;
/// How near to one a delay is that may be a time zone (s).
const NEAR_ZONE: f64 = 60.0;

/// Reports all of it, unless warnings are left out.
pub(super) fn tell(fit: &Calibration, quiet: bool) {
    if quiet {
        return;
    }
    render::all(&spoilt(fit).into_iter().collect::<Vec<_>>());
    render::all(&overstated(fit).iter().map(|one| small(fit, one)).collect::<Vec<_>>());
    if fit.is_sound() {
        let outside = outside_streams(&fit.problem, &fit.fit.point);
        render::all(&outside.iter().map(extrapolated).collect::<Vec<_>>());
    }
    render::all(&delays_that_differ(fit).iter().map(differing).collect::<Vec<_>>());
    tell_of_logs(fit);
}

/// Reports what may be wrong with the logs: accelerations that nobody recorded, but that readings miss,
/// clocks of other time zones, and scales that absorbed another unit.
pub(super) fn tell_of_logs(fit: &Calibration) {
    if fit.is_sound() {
        let missed = unrecorded(&fit.problem, &fit.fit.point);
        render::all(&missed.iter().map(accelerations).collect::<Vec<_>>());
        render::all(&time_zones(fit));
        render::all(&unit_factors(fit).iter().map(about_a_unit).collect::<Vec<_>>());
    }
}

/// A scale that is about the factor between two units.
fn about_a_unit((one, factor): &(Estimate, f64)) -> Diagnostic {
    let Estimate { name, value, sigma, declared, .. } = one;
    let of = one.of.as_ref().map_or_else(String::new, |of| format!(" of `{of}`"));
    let (over, factor) = if *factor < 1.0 { ("1/", factor.recip()) } else { ("", *factor) };
    let message = format!(
        "`{name}`{of} starts at 1 and is estimated as {}, within 1 % of {over}{} {UNIT}",
        figure::value(value.unwrap_or(f64::NAN), *sigma, declared),
        if factor < 100.0 { decimal(factor, 1) } else { decimal(factor, 0) }
    );
    Diagnostic::warning(message)
        .help("check the units of the columns and parameters that it is a factor of")
}

/// A delay that differs between runs by more than noise: its common value is a mean of theirs.
fn differing(one: &Differing) -> Diagnostic {
    let Differing { name, of, runs, ends: [low, high], scatter } = one;
    let of = of.as_ref().map_or_else(String::new, |of| format!(" of `{of}`"));
    let seconds = Unit::coherent(Dimension::TIME);
    let shown = |size: f64| figure::value(size, Some(0.01 * scatter), &seconds);
    let message = format!(
        "`{name}`{of} differs between its {runs} runs, by {} to {} from the common value (standard deviation {}): its uncertainty does not count that",
        shown(*low),
        shown(*high),
        shown(*scatter)
    );
    let help =
        format!("give it a value for each run in [parameters]: \"{name}\" = {{ scope = \"run\" }}");
    Diagnostic::warning(message).help(help)
}

/// A delay at which some readings lie outside their streams.
fn extrapolated(one: &Outside) -> Diagnostic {
    let Outside { delay, of, value, counts: [outside, all] } = one;
    let of = of.as_ref().map_or_else(String::new, |of| format!(" of `{of}`"));
    let message = format!(
        "at `{delay}`{of} = {} s {outside} of {all} readings lie outside their streams, which are extrapolated there",
        decimal(*value, 3)
    );
    let help = "state a `delay_range` that holds this delay: such readings are then left out";
    Diagnostic::warning(message).help(help)
}

/// Delays near whole half hours: nobody reads so late.
fn time_zones(fit: &Calibration) -> Vec<Diagnostic> {
    let layout = &fit.problem.layout;
    let far = fit.estimates().into_iter().filter_map(|one| {
        let delay =
            one.value.filter(|_| one.instance.is_some_and(|at| layout.instances[at].is_delay()))?;
        let steps = (delay / ZONE_STEP).round();
        let is_near = steps != 0.0 && (delay - steps * ZONE_STEP).abs() < NEAR_ZONE;
        is_near.then_some((one.name, delay, steps * ZONE_STEP / 3600.0))
    });
    let warnings = far.map(|(name, delay, hours)| {
        let message = format!(
            "`{name}` is {} s, near {} h: the times of the logs may be of different time zones, or of summer time",
            decimal(delay, 1),
            decimal(hours, 1)
        );
        let help = "check the clocks of the logs; UTC is assumed for times of day without a zone";
        Diagnostic::warning(message).help(help)
    });
    warnings.collect()
}

/// The same beside delays, which say nothing of how the joint fit went: residuals that are larger
/// than stated, too.
pub(super) fn tell_beside_delays(fit: &Calibration, quiet: bool) {
    tell(fit, quiet);
    let misfit = misfit(fit).filter(|times| (1.0..=SPOILT).contains(times));
    if let Some(times) = misfit.filter(|_| !quiet) {
        let message = format!(
            "the residuals of the joint fit are {} times as large as stated: the uncertainties do not hold",
            decimal(times, 1)
        );
        let help =
            "delays may be off by many times theirs: `homepoint diagnose` looks for the cause";
        render::all(&[Diagnostic::warning(message).help(help)]);
    }
}

/// Readings so far off the model that nothing that rests on it can be right.
fn spoilt(fit: &Calibration) -> Option<Diagnostic> {
    let times = fit.variance_factor().map_or(0.0, f64::sqrt);
    (fit.has_settled() && times > SPOILT).then(|| {
        let message = format!(
            "the residuals of the joint fit are {} times as large as stated: readings or the model are wrong",
            decimal(times, 0)
        );
        let help = "these numbers may be, too: `homepoint diagnose` looks for the cause";
        let warning = Diagnostic::warning(message).help(help);
        match farthest(fit) {
            Some(far) => warning.help(farthest_words(&far)),
            None => warning,
        }
    })
}

/// A measurand that scatters far less than stated, which the global test does not show.
fn small(fit: &Calibration, one: &Overstated) -> Diagnostic {
    let Overstated { measurand, of, scatter, stated } = one;
    let of = of.as_ref().map_or_else(String::new, |of| format!(" in campaign `{of}`"));
    let size = |size: f64| figure::size(size, &residual_unit(size, &unit_of(fit, measurand)));
    let times = one.times();
    let message = format!(
        "the residuals of `{measurand}`{of} are {} times smaller than stated {UNIT}",
        decimal(times, if times < 10.0 { 1 } else { 0 })
    );
    let help = format!(
        "they scatter by {}, stated is {}: check the unit in the header of its column, and its `sigma` in [measurands]",
        size(*scatter),
        size(*stated)
    );
    Diagnostic::warning(message).help(help)
}

/// Stretches of rows that are listed.
const MOST_STRETCHES: usize = 3;

fn farthest_words(far: &Farthest) -> String {
    let Farthest { run, measurand, rows } = far;
    let of = |(first, last): &(usize, usize)| match first == last {
        true => format!("{first}"),
        false => format!("{first} to {last}"),
    };
    let listed: Vec<String> = rows.iter().take(MOST_STRETCHES).map(of).collect();
    let more = match rows.len().saturating_sub(MOST_STRETCHES) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let is_one = matches!(rows[..], [(first, last)] if first == last);
    let word = if is_one { "row" } else { "rows" };
    format!(
        "the largest residuals are of `{measurand}` in {word} {}{more} of run `{run}`",
        listed.join(", ")
    )
}

fn accelerations(missed: &Unrecorded) -> Diagnostic {
    let Unrecorded { inputs, lambda, run, measurand, most } = missed;
    let names = inputs.join("`, `");
    let verb = if inputs.len() == 1 { "accelerates" } else { "accelerate" };
    let message = format!(
        "`{names}` {verb}, but no column says how: until a delayed reading a constant rate is assumed, which shifts `{measurand}` by {} of its standard uncertainty in run `{run}` (rms), {} times the noise over all readings",
        if *most < 0.01 { format!("{most:.1e}") } else { decimal(*most, 2) },
        decimal(*lambda, 0)
    );
    let columns = inputs.iter().map(|input| format!("`{input}_acceleration`"));
    let columns = columns.collect::<Vec<_>>().join(", ");
    let help = format!(
        "what is estimated may be wrong by several times its uncertainty: record {columns}, or give what moves as a stream of its own (`signals`)"
    );
    Diagnostic::warning(message).help(help)
}
