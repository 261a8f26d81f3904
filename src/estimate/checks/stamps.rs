//! Stamps that stand still, or are rounded, while something moves.

use crate::campaign::Run;
use crate::campaign::signal::Track;
use crate::diagnostic::Diagnostic;

/// Rows of one stamp, on the average, from which on stamps are rounded.
const ROUNDED: usize = 30;

/// The warning of a run in which something moves and time stands still, or goes on by leaps.
pub(super) fn stamps(run: &Run) -> Option<Diagnostic> {
    if !run.record.inputs().iter().any(Track::moves) || run.record.len() < 2 {
        return None;
    }
    let (mut times, mut last) = (0, f64::NAN);
    run.record.walk(|stretch| {
        for time in &stretch.samples.time[stretch.range()] {
            times += usize::from(*time != last);
            last = *time;
        }
    });
    let (name, rows) = (&run.name, run.record.len());
    let (words, help) = if times == 1 {
        (
            format!("run `{name}` has the same time in all its {rows} rows"),
            "what a clock does, and how fast anything moves, cannot be told there: is it the right column?",
        )
    } else if times * ROUNDED <= rows {
        (
            format!(
                "run `{name}` has {times} times in its {rows} rows, about {} rows at each: its stamps are rounded",
                rows / times
            ),
            "delays and rates follow the rounded times: write stamps with all of their digits",
        )
    } else {
        return None;
    };
    Some(Diagnostic::warning(words).help(help))
}
