//! Stated values that the readings contradict.
//!
//! A value with an uncertainty is one more observation. What the fit leaves of it, over what the
//! other observations leave free (its redundancy), is a standard normal number where it is right:
//! the test of Baarda (1968) for a gross error, of a stated value. It does not say whether the
//! value is wrong or the model of the readings.

use nalgebra::{DMatrix, DVector};

use crate::engine::layout::Instance;
use crate::estimate::calibrate::{Calibration, Estimate};
use crate::estimate::eigen;
use crate::statistics::ln_chi_squared;

/// Probability that a campaign whose stated values are all right has a contradicted one (Baarda's).
const BY_CHANCE: f64 = 1e-3;
/// Standard deviations by which a stated value is left only where it is wrong, or the model.
pub const BY_FAR: f64 = 20.0;
/// Redundancy below which the readings say nothing of a stated value.
const SILENT: f64 = 1e-6;

/// A stated value that is far from what the readings say.
#[derive(Clone, Debug)]
pub struct Contradicted {
    /// The parameter.
    pub parameter: String,
    /// Its component that is farthest away, as it is estimated.
    pub estimate: Estimate,
    /// What is stated of that (SI).
    pub stated: f64,
    /// With this standard uncertainty (SI).
    pub sigma: f64,
    /// What everything else says (SI).
    pub alone: f64,
    /// Their difference in standard deviations of itself.
    pub deviations: f64,
    /// What the sum of squares loses without the stated value, all its components: chi squared of
    /// as many degrees where it is right.
    pub gain: f64,
    /// How many components of it the readings determine.
    pub components: usize,
}

/// The stated values that the readings contradict, farthest first; none of a fit that is not sound.
///
/// Where residuals are larger than stated the bar is higher by as much: by the variance factor of
/// what remains without all that are contradicted. Otherwise a value that is far enough off would
/// raise the bar beyond itself, and two such values would hide each other. So all that are beyond
/// the bar of stated noise are left out first, and those that are not beyond the raised bar then put
/// back, until none is.
pub fn contradicted(result: &Calibration) -> Vec<Contradicted> {
    if !result.is_sound() {
        return Vec::new();
    }
    let count = result.problem.layout.instances.len();
    let judged = (0..count).filter_map(|index| Some((index, judged(result, index)?)));
    let mut found: Vec<(usize, Contradicted)> = judged.collect();
    let tested = found.iter().map(|(_, one)| one.components).sum();
    found.retain(|(_, one)| is_apart(one.deviations, tested));
    while !found.is_empty() {
        let indices: Vec<usize> = found.iter().map(|(index, _)| *index).collect();
        let scale = noise_scale_without(result, &indices);
        let before = found.len();
        found.retain(|(_, one)| is_apart(one.deviations / scale, tested));
        if found.len() == before {
            break;
        }
    }
    let mut found: Vec<Contradicted> = found.into_iter().map(|(_, one)| one).collect();
    found.sort_by(|a, b| b.deviations.total_cmp(&a.deviations));
    found
}

/// Whether so many standard deviations contradict a stated value, the farthest of so many components
/// that the readings test.
fn is_apart(deviations: f64, tested: usize) -> bool {
    ln_chi_squared(deviations.powi(2), 1) + (tested.max(1) as f64).ln() < BY_CHANCE.ln()
}

/// The noise scale factor of everything but these stated values, 1 at least.
fn noise_scale_without(result: &Calibration, indices: &[usize]) -> f64 {
    let (redundancy, left) = redundancy(result, indices);
    let (gain, components) = gain(redundancy, &left);
    let cost = (result.fit.cost - gain).max(0.0);
    let degrees = result.degrees_of_freedom() - components as i64;
    let factor = if degrees > 0 { cost / degrees as f64 } else { 1.0 };
    factor.max(1.0).sqrt()
}

/// What the other observations leave free of these stated values, `I − C Q Cᵀ`, and what the fit
/// leaves of them, both in their standard uncertainties.
fn redundancy(result: &Calibration, indices: &[usize]) -> (DMatrix<f64>, DVector<f64>) {
    let layout = &result.problem.layout;
    let rows: Vec<_> =
        indices.iter().flat_map(|index| result.fit.point.priors_of(layout, *index)).collect();
    let count = rows.len();
    let left = DVector::from_iterator(count, rows.iter().map(|row| row.residual));
    let redundancy = DMatrix::from_fn(count, count, |i, j| {
        let pairs = rows[i].coefficients.iter().flat_map(|a| {
            rows[j].coefficients.iter().map(move |b| a.1 * b.1 * result.covariance[(a.0, b.0)])
        });
        f64::from(u8::from(i == j)) - pairs.sum::<f64>()
    });
    (redundancy, left)
}

/// The component of a stated value that is farthest from what the readings say, if the readings say
/// anything.
fn judged(result: &Calibration, index: usize) -> Option<Contradicted> {
    let layout = &result.problem.layout;
    let setting = &layout.instances[index].setting;
    let stated = setting.stated_components(layout.instances[index].kind);
    let (redundancy, left) = redundancy(result, &[index]);
    let count = left.len();
    let deviations = |row: usize| {
        let free = redundancy[(row, row)];
        if free > SILENT { left[row].abs() / free.sqrt() } else { 0.0 }
    };
    let worst = (0..count).max_by(|a, b| deviations(*a).total_cmp(&deviations(*b)))?;
    let apart = deviations(worst);
    if apart.is_nan() || apart <= 0.0 {
        return None;
    }
    let free = redundancy[(worst, worst)].max(SILENT);
    let component = *stated.get(worst)?;
    let estimate = result.estimates_of(index).into_iter().nth(component)?;
    let (gain, components) = gain(redundancy, &left);
    let (stated, sigma) = (setting.value_of(component)?, setting.sigma_of(component)?);
    Some(Contradicted {
        parameter: layout.instances[index].name.clone(),
        alone: stated + (estimate.value? - stated) / free,
        estimate,
        stated,
        sigma,
        deviations: apart,
        gain,
        components,
    })
}

/// What is stated of a parameter in one fit, against another in which nothing is: the value that is
/// farthest away. `None` where all of it is where it is stated.
pub fn against(stated: &Calibration, free: &Calibration, name: &str) -> Option<Contradicted> {
    let layout = &free.problem.layout;
    let mut farthest: Option<Contradicted> = None;
    let own = (0..layout.instances.len()).filter(|index| layout.instances[*index].name == name);
    let each = own.flat_map(|index| {
        free.estimates_of(index)
            .into_iter()
            .enumerate()
            .map(move |(component, one)| (index, component, one))
    });
    for (index, component, estimate) in each {
        let same = |one: &&Instance| one.name == name && one.of == layout.instances[index].of;
        let Some(setting) =
            stated.problem.layout.instances.iter().find(same).map(|one| &one.setting)
        else {
            continue;
        };
        let known = |values: &Option<Vec<f64>>| values.as_ref()?.get(component).copied();
        let (Some(value), Some(alone)) = (known(&setting.value), estimate.value) else { continue };
        let sigma = known(&setting.sigma).unwrap_or(0.0);
        let deviations = (value - alone).abs() / sigma.hypot(estimate.sigma.unwrap_or(0.0));
        if is_apart(deviations, 1)
            && farthest.as_ref().is_none_or(|one| one.deviations < deviations)
        {
            farthest = Some(Contradicted {
                parameter: name.to_owned(),
                estimate,
                stated: value,
                sigma,
                alone,
                deviations,
                gain: stated.fit.cost - free.fit.cost,
                components: 1,
            });
        }
    }
    farthest
}

/// `rᵀ R⁻¹ r` over what is free, and in how many directions that is.
fn gain(redundancy: DMatrix<f64>, left: &DVector<f64>) -> (f64, usize) {
    let Some(eigen) = eigen::symmetric(redundancy) else { return (0.0, 0) };
    let free = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    let free = free.filter(|(value, _)| **value > SILENT);
    let gains = free.map(|(value, vector)| vector.dot(left).powi(2) / value);
    gains.fold((0.0, 0), |(sum, count), gain| (sum + gain, count + 1))
}
