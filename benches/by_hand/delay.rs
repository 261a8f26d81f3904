//! The delay of each reading with its standard uncertainty, analytically.
//!
//! Newton from the reference time, a step halved while it leads uphill; it ends at a step of 1e-14
//! s like `homepoint::estimate::newton::solve`, or where rounding lets no step lead nearer. Then
//! `u² = (u_m² + J Σ Jᵀ) / m'²` with the full covariance Σ of the reading's other parameters, of
//! which only the columns that its row has are touched. The row comes from the last step's
//! geometry.

use super::jacobian::{
    COMMON, COMMON_COLUMNS, DISTANCE_COLUMNS, HORIZONTAL_COLUMNS, Model, Moment, Predicted,
    VERTICAL_COLUMNS, wrapped,
};
use super::{COLUMNS, Columns};

/// The delay of one reading.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Delay {
    /// Delay (s).
    pub(crate) delay: f64,
    /// Derivative of the measurand with respect to it.
    pub(crate) slope: f64,
    /// Standard uncertainty (s): of the reading alone.
    pub(crate) random: f64,
    /// Standard uncertainty (s): of the parameters.
    pub(crate) common: f64,
}

impl Delay {
    /// A reading that no delay explains.
    pub(crate) const NONE: Self =
        Self { delay: f64::NAN, slope: f64::NAN, random: f64::NAN, common: f64::NAN };
}

/// A step this small (s), or this small against the delay, ends the iteration.
const TOLERANCE: f64 = 1e-14;

/// The root of `f` nearest to 0 downhill, with the last evaluation; `f` gives value, slope and
/// more.
#[inline(always)]
pub(crate) fn solve<T>(
    range: f64,
    mut f: impl FnMut(f64) -> (f64, f64, T),
) -> Option<(f64, f64, T)> {
    let mut t = 0.0;
    let (mut value, mut slope, mut rest) = f(t);
    for _ in 0..50 {
        let mut step = (-value / slope).clamp(-range, range);
        if !step.is_finite() {
            return None;
        }
        if step.abs() <= TOLERANCE.max(4.0 * f64::EPSILON * t.abs()) {
            return Some((t + step, slope, rest));
        }
        let mut next = (t + step).clamp(-range, range);
        let mut there = f(next);
        let mut halvings = 0;
        loop {
            if there.0.abs() < value.abs() {
                break;
            }
            // So small a step that leads nowhere: rounding has been reached.
            if step.abs() <= 1e-9 * range || value.abs() <= 1e-12 {
                return Some((t, slope, rest));
            }
            if halvings == 20 {
                return None;
            }
            halvings += 1;
            step *= 0.5;
            next = (t + step).clamp(-range, range);
            there = f(next);
        }
        t = next;
        (value, slope, rest) = there;
    }
    None
}

/// The delays of one measurand over a run.
struct Measurand<const N: usize> {
    /// Covariance of the common columns and the reading's own ones, the delay not among them.
    covariance: [[f64; N]; N],
    sigma: f64,
    range: f64,
}

impl<const N: usize> Measurand<N> {
    /// `own`: the measurand's own columns, the delay first.
    fn new(own: &[usize], covariance: &[[f64; COLUMNS]; COLUMNS], sigma: f64, range: f64) -> Self {
        let mut columns = [0; N];
        columns[..COMMON].copy_from_slice(&COMMON_COLUMNS[..COMMON]);
        columns[COMMON..].copy_from_slice(&own[1..]);
        Self { covariance: columns.map(|i| columns.map(|j| covariance[i][j])), sigma, range }
    }

    #[inline(always)]
    fn run(
        &self,
        model: &Model,
        data: &Columns<'_>,
        readings: &[f64],
        predict: impl Fn([f64; 3]) -> Predicted,
        difference: impl Fn(f64) -> f64,
        own: impl Fn(&Predicted) -> [f64; 2],
    ) -> Vec<Delay> {
        let each = data.angle.iter().zip(data.rate).zip(readings);
        each.map(|((angle, rate), reading)| {
            let found = solve(self.range, |t| {
                let moment = model.at(*angle, *rate, t);
                let predicted = predict(moment.point);
                let slope = model.slope(&moment, predicted.gradient);
                (difference(predicted.value - reading), slope, (moment, predicted))
            });
            found.map_or(Delay::NONE, |(delay, slope, (moment, predicted))| {
                self.finish(model, delay, slope, &moment, &predicted, own(&predicted))
            })
        })
        .collect()
    }

    #[inline(always)]
    fn finish(
        &self,
        model: &Model,
        delay: f64,
        slope: f64,
        moment: &Moment,
        predicted: &Predicted,
        own: [f64; 2],
    ) -> Delay {
        let (common, _) = model.chain(moment, predicted.gradient);
        let mut row = [0.0; N];
        row[..COMMON].copy_from_slice(&common[..COMMON]);
        row[COMMON..].copy_from_slice(&own[..N - COMMON]);
        // Both triangles are the same: the diagonal's half, then all twice.
        let half = |i: usize| -> f64 {
            let above: f64 = (i + 1..N).map(|j| self.covariance[i][j] * row[j]).sum();
            row[i] * (0.5 * self.covariance[i][i] * row[i] + above)
        };
        let variance = 2.0 * (0..N).map(half).sum::<f64>();
        let seconds = 1.0 / slope.abs();
        Delay {
            delay,
            slope,
            random: self.sigma * seconds,
            common: variance.max(0.0).sqrt() * seconds,
        }
    }
}

/// The delay of every reading of a run: horizontal, vertical, distance. `covariance` is that of all
/// columns, `sigma` the readings' standard uncertainties, `range` (s) the farthest delay looked
/// for.
pub(crate) fn delays(
    model: &Model,
    data: &Columns<'_>,
    covariance: &[[f64; COLUMNS]; COLUMNS],
    sigma: [f64; 3],
    range: f64,
) -> [Vec<Delay>; 3] {
    let [horizontal, vertical, distance] = data.readings;
    [
        Measurand::<9>::new(&HORIZONTAL_COLUMNS, covariance, sigma[0], range).run(
            model,
            data,
            horizontal,
            |point| model.horizontal(point),
            wrapped,
            |predicted| [predicted.by_collimation, predicted.by_index],
        ),
        Measurand::<8>::new(&VERTICAL_COLUMNS, covariance, sigma[1], range).run(
            model,
            data,
            vertical,
            |point| model.vertical(point),
            |difference| difference,
            |_| [1.0, 0.0],
        ),
        Measurand::<8>::new(&DISTANCE_COLUMNS, covariance, sigma[2], range).run(
            model,
            data,
            distance,
            |point| model.distance(point),
            |difference| difference,
            |_| [1.0, 0.0],
        ),
    ]
}
