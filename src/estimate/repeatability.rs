//! Whether several campaigns of one instrument agree: between-campaign spread, drift, E_n.
//!
//! Each campaign has its mean delay `x_i`; their covariance V counts what they share. The variance
//! b² between campaigns is that for which `χ² = n - 1` with `V + b² 1` (Mandel and Paule 1970),
//! zero where χ² is less without it. The drift is the slope over the campaigns' order. `E_n` of two
//! campaigns is their difference over its expanded uncertainty (k = 2), as in ISO/IEC 17043: above
//! 1 they disagree.

use nalgebra::{DMatrix, DVector};

use crate::estimate::delays::{Delays, Summary};
use crate::estimate::transformation::Transformation;

/// Halvings that find the variance between campaigns.
const HALVINGS: u32 = 80;

/// Two campaigns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Their numbers.
    pub campaigns: [usize; 2],
    /// First less second (s).
    pub difference: f64,
    /// Difference over its expanded uncertainty (k = 2).
    pub normalised_error: f64,
}

/// What several campaigns say of one delay.
#[derive(Clone, Debug, PartialEq)]
pub struct Repeatability {
    /// Weighted mean (s), the spread between campaigns counted.
    pub mean: f64,
    /// Its standard uncertainty (s).
    pub sigma: f64,
    /// χ² of the campaigns' means without a spread between them.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Standard deviation between campaigns (s).
    pub between: f64,
    /// Drift from one campaign to the next (s); `None` for two campaigns.
    pub drift: Option<f64>,
    /// Its standard uncertainty (s).
    pub drift_sigma: Option<f64>,
    /// All pairs.
    pub pairs: Vec<Agreement>,
}

/// How campaigns agree, from their means and the covariance of these; `None` for less than two.
pub fn repeatability(means: &DVector<f64>, covariance: &DMatrix<f64>) -> Option<Repeatability> {
    let count = means.len();
    if count < 2 {
        return None;
    }
    let ones = DMatrix::from_element(count, 1, 1.0);
    let (_, _, alone) = least_squares(means, covariance, &ones)?;
    let free = (count - 1) as f64;
    let between = between(means, covariance, &ones, free);
    let wide = covariance + DMatrix::identity(count, count) * between.powi(2);
    let (mean, spread, _) = least_squares(means, &wide, &ones)?;
    let middle = (count - 1) as f64 / 2.0;
    let line = DMatrix::from_fn(count, 2, |i, k| if k == 0 { 1.0 } else { i as f64 - middle });
    let drift = if count > 2 { least_squares(means, &wide, &line) } else { None };
    let mut pairs = Vec::new();
    for i in 0..count {
        for j in i + 1..count {
            let variance = covariance[(i, i)] + covariance[(j, j)] - 2.0 * covariance[(i, j)];
            let difference = means[i] - means[j];
            let normalised_error = difference / (2.0 * variance.max(f64::MIN_POSITIVE).sqrt());
            pairs.push(Agreement { campaigns: [i, j], difference, normalised_error });
        }
    }
    Some(Repeatability {
        mean: mean[0],
        sigma: spread[(0, 0)].sqrt(),
        chi_squared: alone,
        degrees_of_freedom: count - 1,
        between,
        drift: drift.as_ref().map(|(solved, _, _)| solved[1]),
        drift_sigma: drift.map(|(_, spread, _)| spread[(1, 1)].sqrt()),
        pairs,
    })
}

/// Generalised least squares: solution, its covariance, χ².
fn least_squares(
    values: &DVector<f64>,
    covariance: &DMatrix<f64>,
    design: &DMatrix<f64>,
) -> Option<(DVector<f64>, DMatrix<f64>, f64)> {
    let weight = covariance.clone().cholesky()?;
    let spread = (design.transpose() * weight.solve(design)).try_inverse()?;
    let solved = &spread * design.transpose() * weight.solve(values);
    let left = values - design * &solved;
    let chi_squared = left.dot(&weight.solve(&left));
    Some((solved, spread, chi_squared))
}

/// The standard deviation between campaigns at which χ² is as expected.
fn between(
    values: &DVector<f64>,
    covariance: &DMatrix<f64>,
    ones: &DMatrix<f64>,
    free: f64,
) -> f64 {
    let count = values.len();
    let exceeds = |between: f64| {
        let wide = covariance + DMatrix::identity(count, count) * between.powi(2);
        least_squares(values, &wide, ones).is_some_and(|(_, _, chi_squared)| chi_squared > free)
    };
    if !exceeds(0.0) {
        return 0.0;
    }
    // The range of the values is more than their spread.
    let (mut low, mut high) = (0.0, (values.max() - values.min()) * 2.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if exceeds(middle) { &mut low } else { &mut high }) = middle;
    }
    low
}

/// How the campaigns agree on each measurand's mean delay; empty for less than two campaigns.
///
/// What campaigns share counts where their transformations come from one estimate of all of them.
pub fn of_campaigns(given: &[Transformation], solved: &[Delays]) -> Vec<(String, Repeatability)> {
    let mut names: Vec<&str> = Vec::new();
    for one in solved.iter().flat_map(|delays| &delays.measurands) {
        if !names.contains(&one.measurand.as_str()) {
            names.push(&one.measurand);
        }
    }
    let own = |name: &str| -> Vec<(usize, &Summary)> {
        let found = |(part, delays): (usize, &'_ Delays)| -> Option<(usize, usize)> {
            let at = delays.measurands.iter().position(|one| one.measurand == name)?;
            delays.measurands[at].mean.map(|_| (part, at))
        };
        let places: Vec<(usize, usize)> = solved.iter().enumerate().filter_map(found).collect();
        places.into_iter().map(|(part, at)| (part, &solved[part].measurands[at])).collect()
    };
    names
        .into_iter()
        .filter_map(|name| {
            let list = own(name);
            let means = DVector::from_iterator(
                list.len(),
                list.iter().map(|(_, one)| one.mean.unwrap_or(0.0)),
            );
            let covariance = DMatrix::from_fn(list.len(), list.len(), |i, j| {
                let ((a, x), (b, y)) = (list[i], list[j]);
                let alike = given[a].covariance.shape() == given[b].covariance.shape();
                let shared = if alike {
                    (x.sensitivity.transpose() * &given[a].covariance * &y.sensitivity)[(0, 0)]
                } else {
                    0.0
                };
                shared + if i == j { x.random.unwrap_or(0.0).powi(2) } else { 0.0 }
            });
            Some((name.to_owned(), repeatability(&means, &covariance)?))
        })
        .collect()
}
