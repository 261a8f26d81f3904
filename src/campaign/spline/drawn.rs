//! Curves with one draw of the errors that smoothing leaves in them.

use crate::campaign::points::Points;
use crate::campaign::smoothing;
use crate::campaign::spline::Spline;

/// Knots for which errors are drawn: of long streams the first say enough.
const DRAWN: usize = 200_000;

impl Spline {
    /// The curve with one draw of its error. `None` of a curve that was made of others.
    ///
    /// Its error is noise of the raw values (`sigma`, else their scatter about the curve), smoothed
    /// as they were, and what smoothing takes off the motion: what it takes off the curve, smoothed
    /// once more, is nearly as much.
    pub(crate) fn disturbed(
        &self,
        sigma: Option<f64>,
        normal: &mut dyn FnMut() -> f64,
    ) -> Option<Self> {
        let values = self.pieces.values().chain([self.ends[1]]);
        let values: Vec<f64> = values.take(self.knots.len().min(DRAWN)).collect();
        let disturbed = self.smoothed_noise(&values, sigma, normal)?;
        Some(Self { gaps: self.gaps.clone(), ..disturbed })
    }

    /// The curve with a multiple of as much noise again as the raw values have brought into it, one
    /// draw. `None` of a curve that was made of others.
    pub(crate) fn noisier(
        &self,
        sigma: Option<f64>,
        times: f64,
        normal: &mut dyn FnMut() -> f64,
    ) -> Option<Self> {
        let noise = self.smoothed_noise(&vec![0.0; self.knots.len()], sigma, normal)?;
        Self::sum(0.0, &[(1.0, self), (times, &noise)])
    }

    /// The curve smoothed once more in the same way: what that takes off it is nearly what was taken off
    /// the motion. `None` of a curve that was made of others.
    pub(crate) fn smoothed_again(&self) -> Option<Self> {
        let values: Vec<f64> = self.pieces.values().chain([self.ends[1]]).collect();
        let again = self.smoothed_noise(&values, Some(0.0), &mut || 0.0)?;
        Some(Self { gaps: self.gaps.clone(), ..again })
    }

    /// Values at the first knots with noise of the raw values, smoothed as these were.
    fn smoothed_noise(
        &self,
        values: &[f64],
        sigma: Option<f64>,
        normal: &mut dyn FnMut() -> f64,
    ) -> Option<Self> {
        let [scatter, of_knot] = self.scatter?;
        let sigma = of_knot * sigma.unwrap_or(scatter);
        let x = self.knots.get(..values.len())?.to_vec();
        let y: Vec<f64> = values.iter().map(|own| own + sigma * normal()).collect();
        let points = Points { x, count: vec![1.0; y.len()], y };
        let curve = smoothing::by_time_constant(&points, self.time_constant);
        Some(Self::from_curve(self.origin, points.x, &curve))
    }
}
