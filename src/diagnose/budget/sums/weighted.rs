//! The sums of all measurands together, each with its weight.

use super::Sums;
use super::store::{Placed, Store};

/// Sums under given noise scale factors.
#[derive(Clone, Debug)]
pub struct Weighted<'a> {
    /// Of which columns.
    pub sums: &'a Sums,
    pub(super) store: Store,
}

impl Weighted<'_> {
    /// The product of two columns; the column after the last is the residual.
    pub fn product(&self, a: usize, b: usize) -> f64 {
        self.sums.product_of(&self.store, a, b)
    }

    pub(super) fn add_priors(&mut self) {
        let residual = self.store.wide.nrows() - 1;
        for row in &self.sums.priors {
            let own = row.coefficients.iter().map(|(column, value)| (*column, *value));
            let all: Vec<(Option<&Placed>, f64)> = own
                .map(|(column, value)| (Some(&self.sums.place[column]), value))
                .chain([(None, row.residual)])
                .collect();
            for (a, p) in &all {
                for (b, q) in &all {
                    let value = p * q;
                    let wide = |one: &Option<&Placed>| match one {
                        None => Some(residual),
                        Some(Placed::Wide(at)) => Some(*at),
                        Some(Placed::Narrow(..)) => None,
                    };
                    match (wide(a), wide(b), a, b) {
                        (Some(a), Some(b), ..) => self.store.wide[(a, b)] += value,
                        (Some(a), None, _, Some(Placed::Narrow(b, _))) => {
                            self.store.strips[(a, *b)] += value;
                        }
                        (None, None, Some(Placed::Narrow(_, a)), Some(Placed::Narrow(_, b))) => {
                            // In the first run that both act in: only sums over runs are asked for.
                            let first = a.iter().find_map(|(run, i)| {
                                let j = b.iter().find(|(other, _)| other == run)?.1;
                                Some((*run, *i, j))
                            });
                            if let Some((run, i, j)) = first {
                                self.store.runs[run][(i, j)] += value;
                            }
                        }
                        _ => {}
                    }
                }
            }
        }
    }
}
