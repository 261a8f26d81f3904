//! Runs of one setup that were recorded at the same time, as far as their times say.
//!
//! An instrument measures one run after the other. Where runs overlap times begin anew in each
//! file, or a file is named twice: a drift or a random walk through a setup is then looked for along
//! wrong times.

use crate::campaign::Run;
use crate::campaign::declared::RunEntry;
use crate::diagnostic::Diagnostic;

/// What to say of runs that overlap; `None` where none do.
pub(super) fn overlap(entries: &[RunEntry], runs: &[Run]) -> Option<Diagnostic> {
    let entry = |run: &Run| entries.iter().find(|entry| entry.name.text == run.name);
    let recorded = |run: &&Run| entry(run).is_some_and(|entry| entry.plan.is_empty());
    let mut spans: Vec<(&Run, f64, f64)> = runs
        .iter()
        .filter(recorded)
        .filter_map(|run| {
            let [start, end] = run.record.ends(|samples| &samples.time)?;
            Some((run, start, end))
        })
        .collect();
    spans.sort_by(|(a, from_a, _), (b, from_b, _)| {
        a.setup.cmp(&b.setup).then(from_a.total_cmp(from_b))
    });
    let (first, second) = spans.windows(2).find_map(|pair| {
        let [(a, _, end), (b, start, _)] = pair else { return None };
        (a.setup == b.setup && start < end).then_some((*a, *b))
    })?;
    let (one, other) = (entry(first)?, entry(second)?);
    let file = |entry: &RunEntry| entry.data.as_ref().map(|data| data.name.text.clone());
    let (what, help) = if file(one).is_some() && file(one) == file(other) {
        ("read the same file", "name each file once")
    } else {
        let begin = |run: &Run| run.record.first_time();
        let is_anew = begin(first) == begin(second);
        (
            if is_anew { "begin at the same time" } else { "overlap in time" },
            "let times go on from file to file of a setup: drifts and walks through it are looked for along \
             them",
        )
    };
    let names = (&first.name, &second.name, &one.setup);
    let words = format!("runs `{}` and `{}` of setup `{}` {what}", names.0, names.1, names.2);
    Some(Diagnostic::warning(words).at(other.name.place.clone()).help(help))
}
