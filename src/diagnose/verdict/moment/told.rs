//! Where something changed, in words, with its rows.

use std::ops::Range;

use crate::diagnose::found::Location;

use super::between::{Found, Moment, Runs};

impl Runs<'_> {
    /// Where it is, with its share of what the best does.
    pub(super) fn located(&self, found: &Found, most: f64) -> Option<Location> {
        let names = self.model.problem.run_names();
        let records: Vec<_> = self
            .model
            .problem
            .parts
            .iter()
            .flat_map(|part| &part.runs)
            .map(|run| &run.record)
            .collect();
        let rows = |one: &Moment| {
            let Range { start, end } = one.samples;
            let record = records[one.run];
            (record.row(start), (end < record.len()).then(|| record.row(end - 1)))
        };
        let words = |one: &Moment| {
            let name = &names[one.run];
            match rows(one) {
                (first, _) if self.ends_with_setup(one) => {
                    format!("from row {first} of run `{name}` to the end of its setup")
                }
                (first, _) if one.goes_on.is_some() => {
                    format!("from row {first} of run `{name}` on")
                }
                (first, None) => format!("in run `{name}` from row {first} on"),
                (first, Some(last)) => format!("in run `{name}` in rows {first} to {last}"),
            }
        };
        let which: Vec<String> = found.moments.iter().map(words).collect();
        let only = match found.moments.as_slice() {
            [one] if one.goes_on.is_none() => Some(one),
            _ => None,
        };
        let place = self.blocks[found.block].place.as_ref()?;
        let run = only.map(|one| names[one.run].as_str());
        let place = place.in_rows(&which.join(" and "), run, only.map(rows));
        Some(Location { place, share: found.gain / most })
    }
}
