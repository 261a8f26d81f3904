//! The natural cubic smoothing spline, after Reinsch (1967) and Green & Silverman (1994, ch. 2).
//!
//! Minimises `Σ wᵢ (yᵢ - f(xᵢ))² + λ ∫ f''² dx` with a banded factorisation in O(n).
//!
//! **Time constant.** With `wᵢ` the spacing of the knots about `xᵢ` the sum is the integral
//! `∫ (y - f)² dx`, and `λ = s⁴` makes `f` the data passed through the filter `1 / (1 + (ω s)⁴)`,
//! whose kernel is `κ(x/s)/s` with `κ(u) = ½ exp(-|u|/√2) sin(|u|/√2 + π/4)` (Silverman 1984): `s`
//! is *the time constant*; amplitudes halve at `ω = 1/s`, a period of `2π s`. What a user calls
//! `smooth` is that period. The spacing about a knot is the part of the stream within `s` of it
//! over the number of values there, so that the time constant is the same where values come
//! densely, in bursts, or not for a while.
//!
//! **Known noise** and **cross-validation** weigh every raw value alike and search the time constant
//! between a hundredth and 300 of the mean spacing (at most the length of the stream): the
//! equations lose digits as the fourth power of it.

use crate::campaign::points::Points;

/// Values and second derivatives at the knots.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    /// Value at each knot.
    pub(crate) value: Vec<f64>,
    /// Second derivative at each knot; zero at both ends.
    pub(crate) second: Vec<f64>,
    /// Mean leverage of one raw value, in (0, 1].
    pub(crate) leverage: f64,
    /// Effective time constant (s).
    pub(crate) time_constant: f64,
}

/// Smooths with a given time constant (s).
pub(crate) fn by_time_constant(points: &Points, seconds: f64) -> Curve {
    // Beyond the length of the stream nothing changes but the rounding.
    let longest = points.x.last().map_or(seconds, |length| length.max(f64::MIN_POSITIVE));
    let s = seconds.min(longest);
    solve_or_relax(points, &local_spacing(points, s), s)
}

/// Smooths so that the predicted squared error of the curve is least, where values have noise of this
/// standard deviation: `misfit² + 2 σ² tr A / n` (Mallows 1973, Craven and Wahba 1979). A misfit of
/// `sigma` would be too smooth, for a curve follows its noise in part: amplitudes came out too small.
pub(crate) fn by_noise(points: &Points, sigma: f64) -> Curve {
    by_score(points, |curve| misfit(points, curve).powi(2) + 2.0 * sigma * sigma * curve.leverage)
}

/// Smooths so that generalised cross-validation is least: `misfit² / (1 - tr A / n)²`.
pub(crate) fn by_cross_validation(points: &Points) -> Curve {
    by_score(points, |curve| {
        let left = (1.0 - curve.leverage).max(1e-12);
        (misfit(points, curve) / left).powi(2)
    })
}

/// Smooths so that a score is least.
fn by_score(points: &Points, score: impl Fn(&Curve) -> f64) -> Curve {
    let (low, high) = search_range(points);
    let weights = even_weights(points);
    let at = |log: f64| solve_or_relax(points, &weights, log.exp());
    let score = |log: f64| score(&at(log));
    // A scan first: the score may have more than one minimum.
    const STEPS: usize = 30;
    let step = (high - low) / STEPS as f64;
    let mut best = (f64::INFINITY, low);
    for index in 0..=STEPS {
        let log = low + step * index as f64;
        let value = score(log);
        if value < best.0 {
            best = (value, log);
        }
    }
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut a, mut b) = ((best.1 - step).max(low), (best.1 + step).min(high));
    for _ in 0..25 {
        let (c, d) = (b - golden * (b - a), a + golden * (b - a));
        if score(c) < score(d) {
            b = d;
        } else {
            a = c;
        }
    }
    at(0.5 * (a + b))
}

/// Logarithms of the shortest and the longest time constant tried.
fn search_range(points: &Points) -> (f64, f64) {
    let length = points.x.last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
    let spacing = length / points.x.len().max(2) as f64;
    ((0.01 * spacing).ln(), (300.0 * spacing).min(length).ln())
}

/// Weights that count every raw value alike and add up to the length of the stream.
fn even_weights(points: &Points) -> Vec<f64> {
    let total: f64 = points.count.iter().sum();
    let length = points.x.last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
    points.count.iter().map(|count| count * length / total).collect()
}

/// Weights that stand for the stretch of time about each knot, averaged over `± s`: the part of the
/// stream within `± s` over the number of values there, counted in fractions of intervals.
fn local_spacing(points: &Points, s: f64) -> Vec<f64> {
    let end = points.x.last().copied().unwrap_or(0.0);
    let mut total = 0.0;
    // Values before each knot, half of its own included.
    let before: Vec<f64> = points
        .count
        .iter()
        .map(|count| {
            total += count;
            total - 0.5 * count
        })
        .collect();
    let values_until = |x: f64| {
        let right = points.x.partition_point(|knot| *knot <= x);
        match (right.checked_sub(1), points.x.get(right)) {
            (None, _) => before.first().copied().unwrap_or(0.0),
            (Some(left), None) => before[left],
            (Some(left), Some(next)) => {
                let part = (x - points.x[left]) / (next - points.x[left]);
                before[left] + part * (before[right] - before[left])
            }
        }
    };
    let spacing = |x: f64| {
        let (from, to) = ((x - s).max(0.0), (x + s).min(end));
        (to - from) / (values_until(to) - values_until(from))
    };
    let weight = |(x, count): (&f64, &f64)| {
        let weight = count * spacing(*x);
        if weight.is_finite() && weight > 0.0 { weight } else { f64::MIN_POSITIVE }
    };
    points.x.iter().zip(&points.count).map(weight).collect()
}

/// Root mean square of raw minus smoothed, over raw values (averaged ones count as many).
pub(crate) fn misfit(points: &Points, curve: &Curve) -> f64 {
    let mut sum = 0.0;
    let mut total = 0.0;
    for ((y, g), count) in points.y.iter().zip(&curve.value).zip(&points.count) {
        sum += count * (y - g) * (y - g);
        total += count;
    }
    (sum / total).sqrt()
}

/// Standard deviation of the raw values about what they are of, from how far they are off the curve, which
/// follows them in part.
pub(crate) fn raw_scatter(misfit: f64, curve: &Curve) -> f64 {
    misfit / (1.0 - curve.leverage).max(1e-3).sqrt()
}

/// The curve; where rounding spoils the factorisation, with ever less smoothing.
fn solve_or_relax(points: &Points, weights: &[f64], s: f64) -> Curve {
    let mut s = s;
    for _ in 0..200 {
        if let Some(curve) = solve(points, weights, s) {
            return curve;
        }
        s *= 0.7;
    }
    // Not reached for finite data: without a penalty the equations are diagonally dominant.
    Curve {
        value: points.y.clone(),
        second: vec![0.0; points.y.len()],
        leverage: 1.0,
        time_constant: 0.0,
    }
}

/// Solves `(R + λ Qᵀ W⁻¹ Q) γ = Qᵀ y`, `g = y - λ W⁻¹ Q γ`, and the trace of the smoother from the
/// central bands of the inverse (Hutchinson & de Hoog 1985).
fn solve(points: &Points, weights: &[f64], s: f64) -> Option<Curve> {
    let (x, y) = (&points.x, &points.y);
    let n = x.len();
    if n < 3 {
        let (value, second) = (y.clone(), vec![0.0; n]);
        return Some(Curve { value, second, leverage: 1.0, time_constant: s });
    }
    let lambda = s.powi(4);
    let m = n - 2;
    let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // Column j of Q has (1/h_j, -1/h_j - 1/h_{j+1}, 1/h_{j+1}) in rows j, j+1, j+2.
    let q = |j: usize| [1.0 / h[j], -1.0 / h[j] - 1.0 / h[j + 1], 1.0 / h[j + 1]];
    let v: Vec<f64> = weights.iter().map(|weight| lambda / weight).collect();

    let (mut d, mut l1, mut l2) = (vec![0.0; m], vec![0.0; m], vec![0.0; m]);
    let mut gamma = vec![0.0; m];
    for j in 0..m {
        let a = q(j);
        let mut diagonal = (h[j] + h[j + 1]) / 3.0
            + a[0] * a[0] * v[j]
            + a[1] * a[1] * v[j + 1]
            + a[2] * a[2] * v[j + 2];
        let mut right = (y[j + 2] - y[j + 1]) / h[j + 1] - (y[j + 1] - y[j]) / h[j];
        if j >= 1 {
            diagonal -= l1[j - 1] * l1[j - 1] * d[j - 1];
            right -= l1[j - 1] * gamma[j - 1];
        }
        if j >= 2 {
            diagonal -= l2[j - 2] * l2[j - 2] * d[j - 2];
            right -= l2[j - 2] * gamma[j - 2];
        }
        if !diagonal.is_finite() || diagonal <= 0.0 {
            return None;
        }
        d[j] = diagonal;
        gamma[j] = right;
        if j + 1 < m {
            let b = q(j + 1);
            let mut next = h[j + 1] / 6.0 + a[1] * b[0] * v[j + 1] + a[2] * b[1] * v[j + 2];
            if j >= 1 {
                next -= l1[j - 1] * l2[j - 1] * d[j - 1];
            }
            l1[j] = next / diagonal;
        }
        if j + 2 < m {
            l2[j] = a[2] * q(j + 2)[0] * v[j + 2] / diagonal;
        }
    }
    // Back substitution, and with it the central bands of the inverse.
    let mut inverse = vec![[0.0; 3]; m + 2];
    let mut solved = vec![0.0; m + 2];
    for j in (0..m).rev() {
        solved[j] = gamma[j] / d[j] - l1[j] * solved[j + 1] - l2[j] * solved[j + 2];
        let (next, after) = (inverse[j + 1], inverse[j + 2]);
        let second = -l1[j] * next[1] - l2[j] * after[0];
        let first = -l1[j] * next[0] - l2[j] * next[1];
        inverse[j] = [1.0 / d[j] - l1[j] * first - l2[j] * second, first, second];
    }
    let mut value = Vec::with_capacity(n);
    let mut trace = 0.0;
    for i in 0..n {
        // Row i of Q: columns i-2, i-1, i.
        let c = if i >= 2 { q(i - 2)[2] } else { 0.0 };
        let b = if i >= 1 && i - 1 < m { q(i - 1)[1] } else { 0.0 };
        let a = if i < m { q(i)[0] } else { 0.0 };
        let (ic, ib) = (i.saturating_sub(2), i.saturating_sub(1));
        value.push(y[i] - v[i] * (c * solved[ic] + b * solved[ib] + a * solved[i]));
        let quadratic = c * c * inverse[ic][0]
            + b * b * inverse[ib][0]
            + a * a * inverse[i][0]
            + 2.0 * (c * b * inverse[ic][1] + b * a * inverse[ib][1] + c * a * inverse[ic][2]);
        trace += 1.0 - v[i] * quadratic;
    }
    if value.iter().chain(&solved).any(|number| !number.is_finite()) {
        return None;
    }
    let mut second = vec![0.0; n];
    second[1..=m].copy_from_slice(&solved[..m]);
    let raw: f64 = points.count.iter().sum();
    Some(Curve { value, second, leverage: (trace / raw).clamp(0.0, 1.0), time_constant: s })
}
