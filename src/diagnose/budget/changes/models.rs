//! The models beside which changes are looked for: a whole one, and it without each of its rows and
//! blocks. It is factored once.

use super::absorbed::Lacking;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::selection::normal::Factored;
use crate::diagnose::thresholds::ENTER;

/// Share of the log Bayes factor of a row or a block that a change in its place has at least: it may
/// stand for this term and another one.
const IN_PLACE: f64 = 0.5;

/// A model and parts of it, itself the first.
pub(super) struct Models {
    pub(super) whole: Vec<usize>,
    pub(super) factored: Factored,
    /// What each lacks.
    pub(super) lacking: Lacking,
    /// The log Bayes factor that a change beside each has at least.
    pub(super) least: Vec<f64>,
}

impl Models {
    /// Of a model: a change may hide in each of its terms that is none.
    pub(super) fn of(selection: &Selection<'_>, whole: &[usize]) -> Self {
        let factored = selection.factored(whole);
        let (mut parts, mut least) = (vec![Vec::new()], vec![ENTER]);
        let gains = selection.contributions(whole);
        for ((term, range), gain) in whole.iter().zip(selection.ranges(whole)).zip(gains) {
            if selection.terms[*term].change.is_none() {
                parts.push(range.collect());
                least.push(IN_PLACE * selection.ln_bayes_factor(*term, gain));
            }
        }
        let lacking = Lacking::new(&factored.factor, &parts);
        Self { whole: whole.to_vec(), factored, lacking, least }
    }
}
