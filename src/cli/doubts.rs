//! What makes the numbers of a fit doubtful, told beside them: readings far off the model, accelerations that are missed.

use super::render;
use crate::diagnostic::Diagnostic;
use crate::estimate::calibrate::Calibration;
use crate::estimate::unrecorded::{Unrecorded, unrecorded};

/// Residuals larger than stated by so much are no matter of uncertainties.
const SPOILT: f64 = 10.0;

/// Tells all of it, unless nothing is to be told.
pub(super) fn tell(fit: &Calibration, quiet: bool) {
    if quiet {
        return;
    }
    render::all(&spoilt(fit).into_iter().collect::<Vec<_>>());
    tell_of_accelerations(fit);
}

/// Tells of accelerations that nobody recorded, but that readings miss.
pub(super) fn tell_of_accelerations(fit: &Calibration) {
    if fit.is_sound() {
        let missed = unrecorded(&fit.problem, &fit.fit.point);
        render::all(&missed.iter().map(acceleration).collect::<Vec<_>>());
    }
}

/// Readings so far off the model that nothing that rests on it can be right.
fn spoilt(fit: &Calibration) -> Option<Diagnostic> {
    let times = fit.variance_factor().map_or(0.0, f64::sqrt);
    (fit.is_sound() && times > SPOILT).then(|| {
        let message = format!(
            "the residuals of the joint fit are {times:.0} times as large as stated: readings or the model are wrong"
        );
        let help = "these numbers may be, too: `homepoint diagnose` looks for the cause";
        Diagnostic::warning(message).help(help)
    })
}

fn acceleration(one: &Unrecorded) -> Diagnostic {
    let Unrecorded { input, measurand, run, most, .. } = one;
    let message = format!(
        "`{input}` accelerates, but there is no column `{input}_acceleration`: until its delayed reading it is taken to move at a constant rate, which shifts `{measurand}` by {most:.2} of its standard uncertainty (rms of run `{run}`)"
    );
    let help = format!(
        "what is estimated may be wrong by more than its uncertainty: record `{input}_acceleration`, or give `{input}` as a stream of its own (`signals`)"
    );
    Diagnostic::warning(message).help(help)
}
