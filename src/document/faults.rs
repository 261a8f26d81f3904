//! Faults of one text as they are found: of many the first, each at its place.

use crate::diagnostic::{Diagnostic, Diagnostics, nearest};

/// After so many faults of a text the rest are not reported.
const MOST: usize = 50;

/// The faults found so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Faults {
    first: Vec<Diagnostic>,
    count: usize,
}

impl Faults {
    /// Records a fault.
    pub(crate) fn report(&mut self, fault: Diagnostic) {
        self.count += 1;
        if !self.is_full() {
            self.first.push(fault);
        }
    }

    /// Whether another fault would only be counted: its message need not be made.
    pub(crate) fn is_full(&self) -> bool {
        self.first.len() >= MOST
    }

    /// How many faults were found.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The first of them.
    pub(crate) fn first(&self) -> &[Diagnostic] {
        &self.first
    }

    /// The same in the order of the text.
    pub(crate) fn in_order(mut self) -> Self {
        let place = |fault: &Diagnostic| fault.place.as_ref().map(|at| (at.line, at.column));
        self.first.sort_by_key(place);
        self
    }

    /// What is reported.
    pub(crate) fn all(self) -> Diagnostics {
        let mut all = self.first;
        if self.count > all.len() {
            all.push(Diagnostic::error("there are more faults than these"));
        }
        Diagnostics(all)
    }
}

/// What to do about a name that is not known here; empty where nothing is.
pub(crate) fn known_here(name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if known.is_empty() => String::new(),
        None => format!("known here: {}", known.join(", ")),
    }
}
