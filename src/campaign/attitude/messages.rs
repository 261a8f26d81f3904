//! What is said of the attitudes of a stream.

use crate::campaign::attitude::Found;
use crate::campaign::order::times;
use crate::diagnostic::{Diagnostic, counted};

/// Ranges of rows that a message lists.
const MOST_RANGES: usize = 40;

impl Found {
    /// What is to be said of `of`, whose rows stand in these lines.
    pub(super) fn told(&self, of: &str, lines: &[usize]) -> Vec<Diagnostic> {
        let rows = |ranges: &[[usize; 2]]| listed(ranges, lines);
        let rows_of = |ranges: &[[usize; 2]]| {
            counted(ranges.iter().map(|[a, b]| b - a + 1).sum::<usize>(), "row")
        };
        let mut all = Vec::new();
        if self.signs > 0 {
            let message = format!("{of} changes its sign {}: made continuous", times(self.signs));
            let help =
                "q and -q are the same rotation; a curve through the components needs one sign";
            all.push(Diagnostic::warning(message).help(help));
        }
        if !self.empty.is_empty() {
            let message = format!(
                "{of} is no rotation in {}, its length is 0 or beyond 1000: left out ({})",
                rows_of(&self.empty),
                rows(&self.empty)
            );
            all.push(Diagnostic::warning(message));
        }
        if !self.lengths.is_empty() {
            let message = format!(
                "{of} has a length off 1 by more than 1 % in {}: scaled to 1 ({})",
                rows_of(&self.lengths),
                rows(&self.lengths)
            );
            let help = "are these the four components of one quaternion?";
            all.push(Diagnostic::warning(message).help(help));
        }
        if !self.bursts.is_empty() {
            let message = format!(
                "{of} leaps away and back {}: {} left out ({})",
                times(self.bursts.len()),
                rows_of(&self.bursts),
                rows(&self.bursts)
            );
            let help =
                "markers or a board may have been confused there; the curve bridges these rows";
            all.push(Diagnostic::warning(message).help(help));
        }
        if !self.leaps.is_empty() {
            let message = format!(
                "{of} leaps {} and does not come back ({})",
                times(self.leaps.len()),
                rows(&self.leaps)
            );
            let help = "the leap is taken for a motion: is it another frame or another marker from there on?";
            all.push(Diagnostic::warning(message).help(help));
        }
        all
    }
}

/// Ranges of rows in the words of a message.
fn listed(ranges: &[[usize; 2]], lines: &[usize]) -> String {
    let words = |[first, last]: &[usize; 2]| match (lines[*first], lines[*last]) {
        (first, last) if first == last => first.to_string(),
        (first, last) => format!("{first}-{last}"),
    };
    let some: Vec<String> = ranges.iter().take(MOST_RANGES).map(words).collect();
    let more = match ranges.len().saturating_sub(MOST_RANGES) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let rows = if some.len() == 1 && !some[0].contains('-') { "row" } else { "rows" };
    format!("{rows} {}{more}", some.join(", "))
}
