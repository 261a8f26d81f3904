//! Curves smoothed once more, as of values with another noise.
//!
//! What a stream is smoothed by follows from the standard uncertainty that is stated of it. Where the
//! values are multiplied, as with another unit, the stated uncertainty stands, and the curve is
//! another one than that of the values as they were, multiplied.

use std::sync::Arc;

use crate::campaign::points::Points;
use crate::campaign::smoothing;
use crate::campaign::spline::{Spline, mean_spacing};

/// What a curve of stated noise was made of.
#[derive(Clone, Debug)]
pub(super) struct Raw {
    /// Value at each knot before smoothing.
    values: Arc<[f64]>,
    /// How many values of the stream each stands for.
    counts: Arc<[f64]>,
    /// Standard deviation of the noise by which it is smoothed.
    sigma: f64,
}

impl Raw {
    pub(super) fn of(points: &Points, sigma: f64) -> Self {
        Self { values: points.y.as_slice().into(), counts: points.count.as_slice().into(), sigma }
    }

    /// Of the values multiplied, with a constant.
    pub(super) fn scaled(&self, constant: f64, factor: f64) -> Self {
        let values = self.values.iter().map(|value| constant + factor * value).collect();
        Self { values, counts: self.counts.clone(), sigma: self.sigma * factor.abs() }
    }
}

impl Spline {
    /// The noise by which it is smoothed, where that was stated.
    pub(crate) fn stated_noise(&self) -> Option<f64> {
        self.raw.as_ref().map(|raw| raw.sigma)
    }

    /// The curve of the same values for another noise; `None` where none was stated.
    pub(crate) fn smoothed_for(&self, sigma: f64) -> Option<Self> {
        let raw = self.raw.as_ref()?;
        let (y, count) = (raw.values.to_vec(), raw.counts.to_vec());
        let points = Points { x: self.knots.to_vec(), y, count };
        let curve = smoothing::by_noise(&points, sigma);
        let scatter = smoothing::misfit(&points, &curve);
        let mut spline = Self::from_curve(self.origin, points.x, &curve);
        spline.gaps = spline.guessed(mean_spacing(&spline.knots), scatter);
        spline.raw = Some(Raw { sigma, ..raw.clone() });
        let raw = smoothing::raw_scatter(scatter, &curve);
        spline.scatter = self.scatter.map(|[_, of_knot]| [raw, of_knot]);
        Some(spline)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use crate::campaign::spline::Smoothing;

    #[test]
    fn multiplied_values_are_smoothed_as_if_they_had_been_read_so() {
        let times: Vec<f64> = (0..400).map(|n| 0.02 * f64::from(n)).collect();
        // Noise of 2 mm about a motion of a metre.
        let noise = |n: usize| 0.002 * (1.7 * ((n * 7919) % 1000) as f64 / 500.0 - 1.7);
        let values: Vec<f64> =
            times.iter().enumerate().map(|(n, t)| (0.9 * t).sin() + noise(n)).collect();
        let small: Vec<f64> = values.iter().map(|value| value / 1e5).collect();
        let stated = Smoothing::Noise(0.002);
        let right = Spline::fit(&times, &values, stated).unwrap();
        let read = Spline::fit(&times, &small, stated).unwrap();
        let scaled = Spline::sum(0.0, &[(1e5, &read)]).unwrap();
        let apart = |one: &Spline, time: f64| -> f64 {
            let difference: f64 = one.at(time, 0.0, 0) - right.at(time, 0.0, 0);
            difference.abs()
        };
        assert!(apart(&scaled, 5.2) > 0.1);
        assert!((scaled.stated_noise().unwrap() - 200.0).abs() < 1e-9);
        let again = scaled.smoothed_for(0.002).unwrap();
        for time in [0.5, 3.0, 6.1] {
            assert!(apart(&again, time) < 1e-9);
        }
    }
}
