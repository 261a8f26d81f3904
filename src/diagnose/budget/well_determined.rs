//! What of a row and of effects that the readings hardly separate from it is well determined: the sum of
//! its value and of theirs, each with a factor. Of effects with one value each; how far apart they may be is
//! for [`super::confounded`] to say.

use nalgebra::DMatrix;

use super::answer::Confounded;
use super::linear::Linear;
use super::selection::Selection;
use super::sizes::WellDetermined;
use super::solved::Solved;

impl Solved {
    /// Of a row (by its place in the model) and others that are all rows, or all outside the model; `None`
    /// where one of them has several values.
    pub(super) fn well_determined(
        &self,
        linear: &Linear,
        selection: &Selection<'_>,
        (model, at): (&[usize], usize),
        others: &[&Confounded],
    ) -> Option<WellDetermined> {
        let is_of_rows = others.first()?.is_row;
        if self.terms[at].len() != 1 || others.iter().any(|one| one.is_row != is_of_rows) {
            return None;
        }
        let size =
            |term: usize| linear.size(selection.terms[term].columns.first()?.first()?.0, 0.0);
        let mut terms = vec![(1.0, size(model[at])?)];
        let own = self.terms[at].start;
        if !is_of_rows {
            // A row's value without the others in the model is that sum.
            for other in others {
                let is_named = |term: &usize| linear.terms[*term].name == other.name;
                terms.push((other.factor?, size((0..linear.terms.len()).find(is_named)?)?));
            }
            let sigma = self.covariance[(own, own)].max(0.0).sqrt();
            return Some(WellDetermined { terms, value: self.values[own], sigma });
        }
        let mut places = Vec::new();
        for other in others {
            let place = model.iter().position(|term| linear.terms[*term].name == other.name)?;
            let [column] = self.terms[place].clone().collect::<Vec<_>>()[..] else { return None };
            places.push((place, column));
        }
        let n = places.len();
        let across = DMatrix::from_fn(1, n, |_, j| self.covariance[(own, places[j].1)]);
        let among = DMatrix::from_fn(n, n, |i, j| self.covariance[(places[i].1, places[j].1)]);
        // What the row varies with the others is taken off it.
        let slope = &across * among.cholesky()?.inverse();
        let mut value = self.values[own];
        for (slope, (place, column)) in slope.iter().zip(&places) {
            value -= slope * self.values[*column];
            terms.push((-slope, size(model[*place])?));
        }
        let variance = self.covariance[(own, own)] - (slope * across.transpose())[(0, 0)];
        Some(WellDetermined { terms, value, sigma: variance.max(0.0).sqrt() })
    }
}
