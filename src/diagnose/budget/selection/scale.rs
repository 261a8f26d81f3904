//! Noise scale factors of measurands that follow from a model.

use super::Selection;
use crate::diagnose::budget::terms::Combination;

/// Rounds in which noise scale factors and model settle.
const ROUNDS: usize = 3;

impl Selection<'_> {
    /// Lets the noise scale factors follow from a model: the residual sum of squares of each
    /// measurand over its readings less the model's degrees of freedom.
    pub fn set_scale(&mut self, model: &[usize]) {
        for _ in 0..ROUNDS {
            let (values, covariance) = self.solved(model);
            let columns = self.columns(model);
            let mut vector = self.residual.clone();
            for (column, value) in columns.iter().zip(values.iter()) {
                vector.extend(column.iter().map(|(own, by)| (*own, -by * value)));
            }
            let mut next = self.scale.clone();
            for (measurand, next) in next.iter_mut().enumerate() {
                let readings = self.sums.readings[measurand] as f64;
                if readings == 0.0 {
                    continue;
                }
                let product = |a: &Combination, b: &Combination| -> f64 {
                    let with = |(i, p): &(usize, f64)| {
                        let sum =
                            |(j, q): &(usize, f64)| q * self.sums.product_in(measurand, *i, *j);
                        p * b.iter().map(sum).sum::<f64>()
                    };
                    a.iter().map(with).sum()
                };
                let square = product(&vector, &vector);
                let mut freedom = 0.0;
                for (i, a) in columns.iter().enumerate() {
                    for (j, b) in columns.iter().enumerate().take(i + 1) {
                        let times = if i == j { 1.0 } else { 2.0 };
                        freedom += times * covariance[(i, j)] * product(a, b);
                    }
                }
                freedom /= self.scale[measurand].powi(2);
                *next = (square.max(0.0) / (readings - freedom).max(1.0)).sqrt().max(1e-12);
            }
            let change = next.iter().zip(&self.scale).map(|(new, old)| (new / old - 1.0).abs());
            let is_settled = change.fold(0.0, f64::max) < 1e-4;
            self.scale = next;
            self.weigh();
            if is_settled {
                break;
            }
        }
    }

    /// The same noise scale factors as another selection.
    pub fn adopt_scale(&mut self, scale: &[f64]) {
        self.scale = scale.to_vec();
        self.weigh();
    }
}
