//! What candidates have in common with each other, with stated values and with the nominal
//! parameters.

use nalgebra::DMatrix;

use crate::engine::gram::PriorRow;

use super::basis::beyond;
use super::columns::Column;
use super::{Entry, Evidence, Projected};

/// Squared sine of the angle below which a direction is taken up by what it stands beside: tangents
/// of effects that are not quite linear differ by as much.
const NEARLY: f64 = 3e-4;

impl Evidence {
    /// `W_aᵀ S_ab`: what a candidate has in common with the columns of another one.
    pub fn shared(&self, a: &Entry, b: &Projected) -> DMatrix<f64> {
        self.shared_with(a, &b.columns, &b.across)
    }

    fn shared_with(&self, a: &Entry, columns: &[Column], across: &DMatrix<f64>) -> DMatrix<f64> {
        let own = self.products(&a.columns, columns);
        a.basis.tr_mul(&(own - a.coupling.tr_mul(across)))
    }

    /// `W_aᵀ S_ab W_b`: the cosines between what two candidates do beyond the nominal parameters.
    pub fn overlap(&self, a: &Entry, b: &Entry) -> DMatrix<f64> {
        self.shared_with(a, &b.columns, &b.across) * &b.basis
    }

    /// What `b` explains beyond the nominal parameters and `a`, with its degrees of freedom.
    pub fn beyond(&self, a: &Entry, b: &Entry) -> (f64, usize) {
        if a.degrees() == 0 || b.degrees() == 0 {
            return (b.gain(), b.degrees());
        }
        beyond(&self.overlap(a, b), &a.score, &b.score, NEARLY)
    }

    /// Part of an entry's gain that lies in prior rows: what its best values take off their
    /// squares. Rows of columns that are noise are none: they say how a walk goes, nothing that is
    /// stated.
    pub fn prior_share(&self, entry: &Entry, is_noise: impl Fn(usize) -> bool) -> f64 {
        let own = entry.gain();
        if own <= 0.0 || self.nominal.priors.is_empty() {
            return 0.0;
        }
        let step = self.nominal_step(entry);
        let mut gain = 0.0;
        let stated =
            |row: &&PriorRow| !row.coefficients.iter().any(|(column, _)| is_noise(*column));
        for row in self.nominal.priors.iter().filter(stated) {
            let moved: f64 = row.coefficients.iter().map(|(column, by)| by * step[*column]).sum();
            gain += row.residual.powi(2) - (row.residual - moved).powi(2);
        }
        (gain / own).clamp(0.0, 1.0)
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
