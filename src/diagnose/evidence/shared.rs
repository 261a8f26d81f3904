//! What candidates have in common with each other and with the nominal parameters.

use nalgebra::DMatrix;

use super::columns::Column;
use super::{Entry, Evidence};

impl Evidence {
    fn shared_with(&self, a: &Entry, columns: &[Column], across: &DMatrix<f64>) -> DMatrix<f64> {
        let own = self.products(&a.columns, columns);
        a.basis.tr_mul(&(own - a.coupling.tr_mul(across)))
    }

    /// `W_aᵀ S_ab W_b`: the cosines between what two candidates do beyond the nominal parameters.
    pub fn overlap(&self, a: &Entry, b: &Entry) -> DMatrix<f64> {
        self.shared_with(a, &b.columns, &b.across) * &b.basis
    }

    /// For each nominal column, how much of the length of an entry's first column it takes up.
    pub fn takers(&self, entry: &Entry) -> Vec<(usize, f64)> {
        let Some(column) = (0..entry.raw.len()).find(|k| entry.raw[*k] > 0.0) else {
            return Vec::new();
        };
        let mut takers: Vec<(usize, f64)> = (0..self.nominal.length.len())
            .map(|n| {
                let share = entry.coupling[(n, column)] * self.nominal.length[n];
                (n, (share / entry.raw[column]).abs())
            })
            .collect();
        takers.sort_by(|a, b| b.1.total_cmp(&a.1));
        takers
    }
}
