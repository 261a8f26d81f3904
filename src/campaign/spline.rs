//! Cubic smoothing spline of a logged stream: value, rate and acceleration from one curve.
//!
//! Answers: the curve and its derivatives at any time, over any [`Number`]. Between knots it is a
//! cubic; outside it stands still at its end value. How the curve is found is
//! `smoothing`'s business.
//!
//! An interpolating curve is useless for derivatives: the second derivative of interpolated noise
//! exceeds the true acceleration of a real encoder stream many times over.

use std::sync::Arc;

use crate::campaign::points::merge;
use crate::campaign::smoothing::{self, Curve};
use crate::number::Number;

/// Values nearer in time than this part of the mean spacing become one knot, by averaging times and
/// values: the equations stay well conditioned.
const SAME_TIME: f64 = 1e-3;

/// With a given time constant, so do values nearer than this part of it. Averaging over a fiftieth
/// of the time constant lowers an amplitude at `ω = 1/s` by 2·10⁻⁵ and bounds the condition of the
/// equations however dense the stream.
const SAME_PART: f64 = 0.02;

/// A stream pauses where nothing comes for so many of its mean spacings.
const PAUSE: f64 = 10.0;

/// Over a pause the curve is a guess if it moves by so many times what values scatter about it.
const GUESSED: f64 = 10.0;

/// How much to smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Smoothing {
    /// The time constant (s) of the equivalent kernel, see `smoothing`.
    TimeConstant(f64),
    /// The standard deviation of the noise of each value, in the unit of the values: the least
    /// predicted error (Mallows's C_p), right for noise that is independent from value to value.
    Noise(f64),
    /// Neither is known: generalised cross-validation, right for noise that is independent from
    /// value to value (it smooths too little where noise is correlated).
    CrossValidation,
}

/// Why a stream cannot be smoothed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SplineError {
    /// Nothing to smooth.
    #[error("the stream holds no values")]
    Empty,
    /// As many times as values are needed.
    #[error("{times} times, but {values} values")]
    Lengths {
        /// Number of times.
        times: usize,
        /// Number of values.
        values: usize,
    },
    /// A time or a value is NaN or infinite.
    #[error("value {index} of the stream is not a finite number")]
    NotFinite {
        /// Its index.
        index: usize,
    },
    /// Time runs backwards.
    #[error("the time of value {index} is before that of the value preceding it")]
    Decreasing {
        /// Its index.
        index: usize,
    },
    /// The time constant or the standard deviation is not positive.
    #[error("the smoothing must be a positive, finite number")]
    Smoothing,
}

mod combined;
mod drawn;
mod near;
mod pieces;
mod resmoothed;

use pieces::Pieces;
use resmoothed::Raw;

/// A natural cubic spline: knots and, in each interval, a cubic.
#[derive(Clone, Debug)]
pub struct Spline {
    /// Knot times (s) since [`Spline::origin`], increasing; the first is 0.
    pub knots: Arc<[f64]>,
    /// Time of the first knot (s); kept apart so that times of 10⁹ s lose no digits.
    pub origin: f64,
    pieces: Pieces,
    /// Value at the first and the last knot.
    ends: [f64; 2],
    /// Pauses over which the curve is a guess: seconds since the origin.
    gaps: Vec<[f64; 2]>,
    /// Root of the mean leverage.
    noise_gain: f64,
    /// Effective time constant (s).
    time_constant: f64,
    /// Standard deviation of the raw values about the curve, by their scatter, and of one knot as
    /// a part of it; `None` of a curve that was made of others.
    scatter: Option<[f64; 2]>,
    /// Whether the time constant was given.
    is_stated: bool,
    /// What it was made of; only where the noise was stated.
    raw: Option<Raw>,
}

impl Spline {
    /// Smooths `values` recorded at `times` (s, not decreasing).
    ///
    /// Values of the same time, or nearly so, are averaged first. One value gives a constant, two a
    /// straight line.
    ///
    /// # Errors
    /// [`SplineError`]: nothing given, lengths differ, time runs backwards, something not finite.
    pub fn fit(times: &[f64], values: &[f64], smoothing: Smoothing) -> Result<Self, SplineError> {
        check(times, values, smoothing)?;
        let first = times[0];
        let spacing = (times[times.len() - 1] - first) / times.len() as f64;
        let near = match smoothing {
            Smoothing::TimeConstant(s) => (SAME_TIME * spacing).max(SAME_PART * s),
            _ => SAME_TIME * spacing,
        };
        let mut points = merge(times, values, near);
        // Knots count from the first of them.
        let shift = points.x[0];
        points.x.iter_mut().for_each(|x| *x -= shift);
        let curve = match smoothing {
            Smoothing::TimeConstant(seconds) => smoothing::by_time_constant(&points, seconds),
            Smoothing::Noise(sigma) => smoothing::by_noise(&points, sigma),
            Smoothing::CrossValidation => smoothing::by_cross_validation(&points),
        };
        let scatter = smoothing::misfit(&points, &curve);
        let raw = match smoothing {
            Smoothing::Noise(sigma) => Some(Raw::of(&points, sigma)),
            _ => None,
        };
        let mut spline = Self::from_curve(first + shift, points.x, &curve);
        spline.raw = raw;
        spline.gaps = spline.guessed(mean_spacing(times), scatter);
        let of_knot = (spline.knots.len() as f64 / values.len() as f64).sqrt();
        spline.scatter = Some([smoothing::raw_scatter(scatter, &curve), of_knot]);
        spline.is_stated = matches!(smoothing, Smoothing::TimeConstant(_));
        Ok(spline)
    }

    /// The pauses over which the curve is a guess: longer than half the period of what it lets
    /// pass, and it moves there.
    fn guessed(&self, spacing: f64, scatter: f64) -> Vec<[f64; 2]> {
        let shortest = std::f64::consts::PI * self.time_constant;
        let moves = |piece: usize, length: f64| {
            let at = |eighth: i32| {
                self.within(piece, self.knots[piece] + length * f64::from(eighth) / 8.0, 0)
            };
            (1..=8).any(|eighth| (at(eighth) - at(0)).abs() > GUESSED * scatter)
        };
        let pieces = self.knots.windows(2).enumerate();
        pieces
            .filter(|(piece, knots)| {
                let length = knots[1] - knots[0];
                is_pause(length, spacing) && length > shortest && moves(*piece, length)
            })
            .map(|(_, knots)| [knots[0], knots[1]])
            .collect()
    }

    /// The piecewise cubic with given values and second derivatives at the knots.
    fn from_curve(origin: f64, knots: Vec<f64>, curve: &Curve) -> Self {
        let pieces = Pieces::of(&knots, &curve.value, &curve.second);
        let first = curve.value.first().copied().unwrap_or(f64::NAN);
        let last = curve.value.last().copied().unwrap_or(f64::NAN);
        Self {
            knots: knots.into(),
            origin,
            pieces,
            ends: [first, last],
            gaps: Vec::new(),
            noise_gain: curve.leverage.sqrt(),
            time_constant: curve.time_constant,
            scatter: None,
            is_stated: false,
            raw: None,
        }
    }

    /// The `order`-th time derivative at `time + offset` (s). Outside the knots the curve stands
    /// still at its end value; derivatives beyond the third are zero.
    pub fn at<N: Number>(&self, time: f64, offset: N, order: u8) -> N {
        let x = offset + (time - self.origin);
        let at = x.value();
        if at.is_nan() {
            return N::constant(f64::NAN);
        }
        let end = self.knots.last().copied().unwrap_or(0.0);
        if at < 0.0 || at > end || self.pieces.len() == 0 {
            let value = self.ends[usize::from(at > 0.0)];
            return N::constant(if order == 0 { value } else { 0.0 });
        }
        let right = self.knots.partition_point(|knot| *knot <= at);
        let left = right.saturating_sub(1).min(self.pieces.len() - 1);
        self.within(left, x, order)
    }

    /// The `order`-th derivative at `x` since the origin, in a piece.
    fn within<N: Number>(&self, piece: usize, x: N, order: u8) -> N {
        let [a, b, c, d] = self.pieces.at(piece, &self.knots);
        let u = x - self.knots[piece];
        match order {
            0 => ((u * d + c) * u + b) * u + a,
            1 => (u * (3.0 * d) + 2.0 * c) * u + b,
            2 => u * (6.0 * d) + 2.0 * c,
            3 => N::constant(6.0 * d),
            _ => N::constant(0.0),
        }
    }

    /// Whether the curve is known at the times `from..=to` (s): they lie within the knots, and in
    /// no pause over which it is a guess.
    pub fn covers(&self, from: f64, to: f64) -> bool {
        let (from, to) = (from - self.origin, to - self.origin);
        let next = self.gaps.partition_point(|[_, end]| *end <= from);
        let is_free = self.gaps.get(next).is_none_or(|[start, _]| *start >= to);
        from >= 0.0 && to <= self.knots.last().copied().unwrap_or(0.0) && is_free
    }

    /// Number and greatest length (s) of the pauses over which it is a guess.
    pub fn gaps(&self) -> (usize, f64) {
        let lengths = self.gaps.iter().map(|[start, end]| end - start);
        (self.gaps.len(), lengths.fold(0.0, f64::max))
    }

    /// Time of the first and of the last knot (s).
    pub fn span(&self) -> (f64, f64) {
        (self.origin, self.origin + self.knots.last().copied().unwrap_or(0.0))
    }

    /// Standard uncertainty of a smoothed value as a part of that of one raw value: the root of
    /// the mean leverage, `√(tr A / n)` with smoothed = A raw. An upper bound for independent
    /// noise (`√(tr A Aᵀ / n)` is up to 13 % less).
    pub fn noise_gain(&self) -> f64 {
        self.noise_gain
    }

    /// Whether its time constant was given.
    pub(crate) fn is_stated(&self) -> bool {
        self.is_stated
    }

    /// The effective time constant (s), see `smoothing`.
    pub fn time_constant(&self) -> f64 {
        self.time_constant
    }
}

/// Mean interval between times, pauses left out.
pub(crate) fn mean_spacing(times: &[f64]) -> f64 {
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut known = f64::INFINITY;
    // A long pause hides shorter ones: each look takes those out that the last one let be seen.
    loop {
        let own = steps.iter().filter(|step| !is_pause(**step, known));
        let (sum, count) = own.fold((0.0, 0), |(sum, count), step| (sum + step, count + 1));
        let mean = if count > 0 { sum / f64::from(count) } else { 0.0 };
        // NaN among times is for others to tell.
        if mean >= known || mean.is_nan() {
            return mean;
        }
        known = mean;
    }
}

/// Whether an interval is a pause of a stream with that spacing.
pub(crate) fn is_pause(length: f64, spacing: f64) -> bool {
    length > PAUSE * spacing
}

fn check(times: &[f64], values: &[f64], smoothing: Smoothing) -> Result<(), SplineError> {
    if times.len() != values.len() {
        return Err(SplineError::Lengths { times: times.len(), values: values.len() });
    }
    if times.is_empty() {
        return Err(SplineError::Empty);
    }
    for (index, (time, value)) in times.iter().zip(values).enumerate() {
        if !time.is_finite() || !value.is_finite() {
            return Err(SplineError::NotFinite { index });
        }
        if index > 0 && *time < times[index - 1] {
            return Err(SplineError::Decreasing { index });
        }
    }
    match smoothing {
        Smoothing::TimeConstant(by) | Smoothing::Noise(by) if !by.is_finite() || by <= 0.0 => {
            Err(SplineError::Smoothing)
        }
        _ => Ok(()),
    }
}
