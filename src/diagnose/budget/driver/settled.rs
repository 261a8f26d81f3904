//! The model of a competition after rows left the fit that it does not have.
//!
//! A row that entered first and was not worth its price beside the whole model leaves the fit. The
//! competition did without it; so the next one ends with the same model, wherever chi squared is what
//! the sums predict without that row. This is tested in place of another search; the rows are judged again.

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::library::variant::Variant;
use crate::diagnose::thresholds::TIE;

use super::{Competed, Search};

/// A model by the names of its terms.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    terms: Vec<(String, Option<Variant>)>,
    /// Its noise scale factors, and its chi squared under them.
    scale: Vec<f64>,
    chi_squared: f64,
}

impl Search<'_> {
    /// The model of a competition, without rows that `leave` the fit; `None` where one of these was a
    /// term of it, or was judged.
    pub(super) fn settled(&self, competed: &Competed, leave: &[usize]) -> Option<Settled> {
        let Competed { linear, judged, scale } = competed;
        let was_pruned = |row: &usize| {
            !judged.model.contains(row)
                && judged.objections.iter().all(|(term, _)| term != row)
                && linear.terms[*row].is_effect()
        };
        if leave.is_empty() || !leave.iter().all(was_pruned) || !judged.nameless.is_empty() {
            return None;
        }
        let selection = self.selection_of(competed);
        let chi_squared = selection.chi_squared(&judged.model);
        let terms = judged.model.iter().map(|term| {
            let own = &linear.terms[selection.whole(*term)];
            (own.name.clone(), own.variant)
        });
        let (terms, scale) = (terms.collect(), scale.clone());
        Some(Settled { terms, scale, chi_squared })
    }
}

impl Settled {
    /// The model on another fit, under its noise scale factors, which are then the selection's. `None`
    /// where a term is missing or the fit is not what the sums predict.
    pub(super) fn here(
        &self,
        linear: &Linear,
        selection: &mut Selection<'_>,
    ) -> Option<Vec<usize>> {
        let place = |(name, variant): &(String, Option<Variant>)| {
            linear.terms.iter().rposition(|own| own.name == *name && own.variant == *variant)
        };
        let model: Vec<usize> = self.terms.iter().map(place).collect::<Option<_>>()?;
        // Changes of one block have one name.
        if (1..model.len()).any(|at| model[..at].contains(&model[at])) {
            return None;
        }
        selection.adopt_scale(&self.scale);
        let is_as_predicted = selection.chi_squared(&model) <= self.chi_squared + TIE;
        is_as_predicted.then_some(model)
    }
}
