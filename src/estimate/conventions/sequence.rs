//! Several things that were mistaken, set right one after the other.

use crate::engine::Problem;
use crate::estimate::minima::thinned::Tried;
use crate::formula::Expression;

use super::suspect::Suspect;

/// What is set right, in the order in which it is done to the numbers as they were read.
#[derive(Clone, Debug, Default)]
pub(super) struct Sequence<'c> {
    all: Vec<Suspect<'c>>,
    /// The one that was found last.
    last: usize,
}

impl<'c> Sequence<'c> {
    /// With one more: after all others and, where it is about numbers of theirs, before them. All
    /// angles in gon, of which one counts from the other axis, are turned into degrees first.
    pub(super) fn with(&self, suspect: &Suspect<'c>) -> Vec<Self> {
        let at = |place: usize| {
            let mut all = self.all.clone();
            all.insert(place, suspect.clone());
            Self { all, last: place }
        };
        let is_shared = self.all.iter().any(|one| one.shares_numbers(suspect));
        let first = is_shared.then(|| at(0));
        std::iter::once(at(self.all.len())).chain(first).collect()
    }

    /// The same with another one in the place of that which was found last.
    pub(super) fn replaced(mut self, other: Suspect<'c>) -> Self {
        self.all[self.last] = other;
        self
    }

    /// The one that was found last.
    pub(super) fn last(&self) -> &Suspect<'c> {
        &self.all[self.last]
    }

    /// The problem with all of it set right; `None` where that cannot be done.
    pub(super) fn applied(&self, problem: &Problem) -> Option<Problem> {
        let (one, more) = self.all.split_first()?;
        more.iter().try_fold(one.applied(problem)?, |problem, one| one.applied(&problem))
    }

    /// As of [`Suspect::score`] of the one that was found last.
    pub(super) fn score(&self, changed: &Problem, fit: &Tried) -> f64 {
        self.last().score(changed, fit)
    }

    /// What each changed number is, as a formula of the columns as they were read.
    pub(super) fn formulas(&self) -> Vec<(String, Expression)> {
        self.all.iter().fold(Vec::new(), |before, one| one.formulas(before))
    }
}
