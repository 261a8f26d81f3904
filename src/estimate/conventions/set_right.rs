//! What was mistaken is set right: one convention after the other as long as a problem fits far better,
//! or two that help together alone. Which fits best is for `next` to find.

use crate::engine::Problem;
use crate::formula::show::text;

use super::looked::Looked;
use super::next::{Glanced, Next, next_of};
use super::sequence::Sequence;
use super::suspect::Suspect;
use super::turns::changed_formulas;
use super::{GOOD, MOST, Mistaken, VERY_BAD};

/// Sets right what may have been mistaken, one after the other, as long as a problem fits far
/// better; `suspects` are what may be the first of it, and what may follow. Of a problem that fits very
/// badly and of which none is, the pairs that may help together.
pub(super) fn set_right<'c>(
    mut stands: Looked,
    suspects: [&[Suspect<'c>]; MOST],
) -> (Mistaken, Vec<Sequence<'c>>) {
    let first = stands.problem.clone();
    let mut found = Mistaken::none(&stands);
    found.tried = suspects[0].len();
    let mut pairs = Vec::new();
    let mut set = Sequence::default();
    let mut is_confirmed = true;
    let as_read = stands.clone();
    for suspects in suspects {
        if stands.variance_factor < GOOD {
            break;
        }
        let sequences: Vec<Sequence<'c>> =
            suspects.iter().flat_map(|suspect| set.with(suspect)).collect();
        let Some(glanced) = Glanced::at(&first, &stands, &sequences) else { break };
        let is_first = found.what.is_empty() && stands.variance_factor > VERY_BAD;
        pairs = if is_first { glanced.pairs() } else { Vec::new() };
        let Some(next) = next_of(&first, &stands, glanced) else { break };
        next.add_to(&mut found);
        is_confirmed = next.typed.is_better_than_read(&as_read);
        (set, stands) = (next.sequence.clone(), next.looked);
    }
    if !is_confirmed {
        // The fit that the line to type makes does not confirm it.
        let tried = found.tried;
        return (Mistaken { tried, ..Mistaken::none(&as_read) }, pairs);
    }
    (found.with_changes(&first, &set, &stands), pairs)
}

/// Sets two things right that help together, where neither does by itself.
pub(super) fn set_two_right(stands: &Looked, pairs: &[Sequence<'_>]) -> Option<Mistaken> {
    let first = &stands.problem;
    let next = next_of(first, stands, Glanced::at(first, stands, pairs)?)?;
    if !next.typed.is_better(stands) {
        return None;
    }
    let mut found = Mistaken::none(stands);
    next.add_to(&mut found);
    Some(found.with_changes(first, next.sequence, &next.looked))
}

impl Next<'_, '_> {
    /// Notes what is set right.
    fn add_to(&self, found: &mut Mistaken) {
        found.what.extend(self.sequence.named());
        found.alike.clone_from(&self.alike);
        found.variance_factors[1] = self.typed.of_all;
        found.without_outliers[1] = self.typed.variance_factor;
    }
}

impl Mistaken {
    /// With what is to be changed in columns and formulas, from the numbers as they were read.
    fn with_changes(mut self, first: &Problem, set: &Sequence<'_>, stands: &Looked) -> Self {
        let found = &mut self;
        found.formulas = changed_formulas(first, &stands.problem);
        let shown = set.formulas().into_iter().map(|(name, formula)| (text(&formula), name));
        found.columns =
            shown.filter(|(formula, name)| formula != name).map(|(f, n)| (n, f)).collect();
        self
    }
}
