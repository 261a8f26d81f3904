//! Several things that were mistaken, set right one after the other.

use crate::engine::Problem;
use crate::estimate::minima::thinned::Tried;
use crate::formula::Expression;

use super::Instead;
use super::suspect::Suspect;

/// How well a fit does: logarithms of variance factors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Score {
    /// What is made smaller scatters less, and carries no more information; what is made larger must fit
    /// the stated uncertainties all the same.
    pub(super) as_stated: f64,
    /// Where the uncertainties of readings are stretched like these, larger or smaller.
    pub(super) relative: f64,
}

impl Score {
    /// Of a fit in which nothing is stretched.
    pub(super) fn of(variance_factor: f64) -> Self {
        let own = variance_factor.ln();
        Self { as_stated: own, relative: own }
    }

    /// One of them.
    pub(super) fn compared(self, is_relative: bool) -> f64 {
        if is_relative { self.relative } else { self.as_stated }
    }
}

/// What is set right, in the order in which it is done to the numbers as they were read.
#[derive(Clone, Debug, Default)]
pub(super) struct Sequence<'c> {
    all: Vec<Suspect<'c>>,
    /// The places of what was found last: of one, or of two that help together.
    last: Vec<usize>,
}

impl<'c> Sequence<'c> {
    /// With one more: after all others and, where it is about numbers of theirs, before them. All
    /// angles in gon, of which one counts from the other axis, are turned into degrees first.
    pub(super) fn with(&self, suspect: &Suspect<'c>) -> Vec<Self> {
        let at = |place: usize| {
            let mut all = self.all.clone();
            all.insert(place, suspect.clone());
            Self { all, last: vec![place] }
        };
        let is_shared = self.all.iter().any(|one| one.shares_numbers(suspect));
        let first = is_shared.then(|| at(0));
        std::iter::once(at(self.all.len())).chain(first).collect()
    }

    /// With one more that is found together with what was found last.
    pub(super) fn together_with(&self, suspect: &Suspect<'c>) -> Vec<Self> {
        let join = |mut more: Self| {
            let new = more.last[0];
            more.last.extend(self.last.iter().map(|at| at + usize::from(*at >= new)));
            more
        };
        self.with(suspect).into_iter().map(join).collect()
    }

    /// The same with another one at the place of one that was found last.
    pub(super) fn replaced(mut self, place: usize, other: Suspect<'c>) -> Self {
        self.all[place] = other;
        self
    }

    /// What was found last, with its places.
    pub(super) fn places(&self) -> impl Iterator<Item = (usize, &Suspect<'c>)> {
        self.last.iter().map(|at| (*at, &self.all[*at]))
    }

    /// What was found last in words, in the order in which it is set right.
    pub(super) fn named(&self) -> Vec<Instead> {
        let mut all: Vec<(usize, &Suspect<'c>)> = self.places().collect();
        all.sort_by_key(|one| one.0);
        all.into_iter().map(|(_, one)| one.named()).collect()
    }

    /// As of [`Suspect::order`]; of two that help together those that change the fewest numbers come first.
    pub(super) fn order(&self) -> (usize, usize, bool) {
        let numbers: usize = match &self.last[..] {
            [_] => 0,
            _ => self.named().iter().map(|one| one.numbers.len()).sum(),
        };
        let all = self.places().map(|(_, one)| one.order());
        let (length, is_of_inputs) =
            all.fold((0, false), |sum, one| (sum.0 + one.0, sum.1 | one.1));
        (numbers, length, is_of_inputs)
    }

    /// The problem with all of it set right; `None` where that cannot be done.
    pub(super) fn applied(&self, problem: &Problem) -> Option<Problem> {
        let (one, more) = self.all.split_first()?;
        more.iter().try_fold(one.applied(problem)?, |problem, one| one.applied(&problem))
    }

    /// How well a fit of the changed problem does, with what all that was found last stretches.
    pub(super) fn score(&self, changed: &Problem, fit: &Tried) -> Score {
        score(self.places().map(|(_, one)| one), changed, fit)
    }

    /// The same with what all of it stretches.
    pub(super) fn score_of_all(&self, changed: &Problem, fit: &Tried) -> Score {
        score(self.all.iter(), changed, fit)
    }

    /// Whether what was found last doubts a unit that a file states.
    pub(super) fn doubts_a_head(&self) -> bool {
        self.places().any(|(_, one)| one.doubts_a_head())
    }

    /// Whether any of it does.
    pub(super) fn doubts_any_head(&self) -> bool {
        self.all.iter().any(Suspect::doubts_a_head)
    }

    /// What each changed number is, as a formula of the columns as they were read.
    pub(super) fn formulas(&self) -> Vec<(String, Expression)> {
        self.all.iter().fold(Vec::new(), |before, one| one.formulas(before))
    }
}

/// How well a fit of a changed problem does, with what some of the changes stretch.
fn score<'s, 'c: 's>(
    all: impl Iterator<Item = &'s Suspect<'c>>,
    changed: &Problem,
    fit: &Tried,
) -> Score {
    all.fold(Score::of(fit.variance_factor), |score, one| {
        let stretched = one.stretched(changed, fit);
        Score {
            as_stated: score.as_stated + stretched.max(0.0),
            relative: score.relative + stretched,
        }
    })
}
