//! Noise scale factors of measurands that follow from a model.

use nalgebra::DMatrix;

use super::Selection;
use super::combined::Combined;
use crate::estimate::inverse_factor::Factor;

/// Rounds in which noise scale factors and model settle.
const ROUNDS: usize = 3;

impl Selection<'_> {
    /// Lets the noise scale factors follow from a model: the residual sum of squares of each
    /// measurand over its readings less the model's degrees of freedom.
    pub fn set_scale(&mut self, model: &[usize]) {
        let mut columns = self.columns(model);
        let n = columns.len();
        columns.push(self.residual.clone());
        let combined = Combined::of(columns.iter());
        let prior = self.prior(&columns);
        let measurands = (0..self.scale.len()).filter(|one| self.sums.readings[*one] > 0);
        let sums: Vec<(usize, DMatrix<f64>)> = measurands
            .map(|one| (one, combined.squares(|a, b| self.sums.product_in(one, a, b))))
            .collect();
        for _ in 0..ROUNDS {
            let mut whole = prior.clone();
            for (measurand, own) in &sums {
                let weight = self.scale[*measurand].powi(-2);
                whole.zip_apply(own, |sum, value| *sum += weight * value);
            }
            let score = whole.view((0, n), (n, 1)).column(0).into_owned();
            let factor = Factor::of(&whole.view((0, 0), (n, n)).into_owned());
            let left = factor.values(&factor.half(&score)).insert_row(n, -1.0);
            let covariance = factor.covariance();
            let mut change = 0.0_f64;
            for (measurand, own) in &sums {
                let scale = &mut self.scale[*measurand];
                let square = left.dot(&(own * &left)).max(0.0);
                let freedom = covariance.dot(&own.view((0, 0), (n, n))) / scale.powi(2);
                let readings = self.sums.readings[*measurand] as f64;
                let next = (square / (readings - freedom).max(1.0)).sqrt().max(1e-12);
                change = change.max((next / *scale - 1.0).abs());
                *scale = next;
            }
            if change < 1e-4 {
                break;
            }
        }
        self.weigh();
    }

    /// The same noise scale factors as another selection.
    pub fn adopt_scale(&mut self, scale: &[f64]) {
        self.scale = scale.to_vec();
        self.weigh();
    }
}
