//! Inverse sine, cosine and tangent, and the angle of a point, over a chunk.
//!
//! Method: every angle is `k π/4 + angle(t)` with |t| <= 1/2 and whole k, the sum taken with its
//! rounding error. For the inverse tangent of a quotient q <= 1 (the smaller of |x|, |y| over the
//! larger) t is q, or `(q - 1) / (q + 1)` beyond 1/2, from one division; for the inverse sine and
//! cosine t is |x|, or `√((1 - |x|) / 2)` beyond 1/2. Minimax polynomials in t² (Remez exchange on
//! the relative error; 2^-57.3 for the inverse tangent, 2^-55.7 for the inverse sine).

use super::super::arithmetic::{Arithmetic, Lanes};
use super::{map, map2_or, pair, polynomial};
use crate::number::Number;

/// π/4 as a sum; multiples of the first part up to 4 are exact.
const QUARTER_PI: [f64; 2] = [0.7853981633974456, 2.6951514290790595e-15];

/// `(atan t / t - 1) / t²` in powers of t².
const TANGENT: [f64; 12] = [
    -0.3333333333333298,
    0.19999999999903176,
    -0.14285714276391104,
    0.11111110659842417,
    -0.09090896249449291,
    0.07692073980370222,
    -0.0666381125715673,
    0.058583029402016776,
    -0.05122022481107807,
    0.04186548181561197,
    -0.02743561162485873,
    0.010117284620830096,
];

/// `(asin t / t - 1) / t²` in powers of t².
const SINE: [f64; 12] = [
    0.1666666666666541,
    0.0750000000033623,
    0.04464285682900058,
    0.030381959109083655,
    0.0223717587120717,
    0.01735969498415616,
    0.013885329488982962,
    0.0121686140118989,
    0.006530466062783009,
    0.019521721385497882,
    -0.01621442575985638,
    0.03190583989639543,
];

/// Between these sizes |x| + |y| a quotient of x and y has all its digits.
const SMALLEST: f64 = 4.0 * f64::MIN_POSITIVE;
const LARGEST: f64 = 0.25 * f64::MAX;

/// Inverse tangent in radians, in [-π/2, π/2].
#[inline(always)]
pub fn atan<A: Arithmetic>(x: &Lanes, out: &mut Lanes) {
    map(x, out, arctangent::<A>);
}

/// Angle of the points (x, y) in radians, in [-π, π]; 0 at the origin whatever the signs of the
/// zeros.
#[inline(always)]
pub fn atan2<A: Arithmetic>(y: &Lanes, x: &Lanes, out: &mut Lanes) {
    map2_or(y, x, out, angle::<A>, Number::atan2);
}

/// Inverse sine in radians, in [-π/2, π/2]; NaN outside [-1, 1].
#[inline(always)]
pub fn asin<A: Arithmetic>(x: &Lanes, out: &mut Lanes) {
    map(x, out, arcsine::<A>);
}

/// Inverse cosine in radians, in [0, π]; NaN outside [-1, 1].
#[inline(always)]
pub fn acos<A: Arithmetic>(x: &Lanes, out: &mut Lanes) {
    map(x, out, arccosine::<A>);
}

#[inline(always)]
fn is_plain(size: f64) -> bool {
    let clamped = if size >= SMALLEST { size } else { f64::INFINITY };
    clamped <= LARGEST
}

#[inline(always)]
fn arctangent<A: Arithmetic>(x: f64) -> f64 {
    let size = x.abs();
    let steep = size > 1.0;
    let (small, large) = if steep { (1.0, size) } else { (size, 1.0) };
    quotient_angle::<A>(small, large, steep, false).copysign(x)
}

#[inline(always)]
fn angle<A: Arithmetic>(y: f64, x: f64) -> f64 {
    let (across, along) = (y.abs(), x.abs());
    let steep = across > along;
    let (small, large) = if steep { (along, across) } else { (across, along) };
    // Adding zero: an angle of -0 is 0, as in `Number`.
    let angle = quotient_angle::<A>(small, large, steep, x < 0.0).copysign(y) + 0.0;
    if is_plain(small + large) { angle } else { f64::NAN }
}

/// Inverse tangent of small / large <= 1; that from π/2 if `steep`; and from π if `backward`.
#[inline(always)]
fn quotient_angle<A: Arithmetic>(small: f64, large: f64, steep: bool, backward: bool) -> f64 {
    const SIGN: u64 = 1 << 63;
    let beyond = small > 0.5 * large;
    let above = if beyond { small - large } else { small };
    let below = if beyond { small + large } else { large };
    let k = if beyond { 1.0 } else { 0.0 };
    let k = if steep { 2.0 - k } else { k };
    let k = if backward { 4.0 - k } else { k };
    // Each of the two turns t around.
    let turned = (if steep { SIGN } else { 0 }) ^ (if backward { SIGN } else { 0 });
    let t = f64::from_bits((above / below).to_bits() ^ turned);
    let z = t * t;
    from_quarter_turns::<A>(k, t, t * z * polynomial::<A, 12>(z, TANGENT))
}

/// `k π/4 + t + rest` for whole k from 0 to 4, the rest small against t.
#[inline(always)]
fn from_quarter_turns<A: Arithmetic>(k: f64, t: f64, rest: f64) -> f64 {
    let (sum, error) = pair::sum(k * QUARTER_PI[0], t);
    sum + (error + A::mul_add(k, QUARTER_PI[1], rest))
}

#[inline(always)]
fn arcsine<A: Arithmetic>(x: f64) -> f64 {
    let (beyond, t, rest) = arcsine_up_to_half::<A>(x);
    let k = if beyond { 2.0 } else { 0.0 };
    let factor = if beyond { -2.0 } else { 1.0 };
    // Adding zero: the inverse sine of -0 is 0, as in `Number`.
    from_quarter_turns::<A>(k, factor * t, factor * rest).copysign(x) + 0.0
}

#[inline(always)]
fn arccosine<A: Arithmetic>(x: f64) -> f64 {
    let (beyond, t, rest) = arcsine_up_to_half::<A>(x);
    let beyond_zero_or_pi = if x < 0.0 { 4.0 } else { 0.0 };
    let k = if beyond { beyond_zero_or_pi } else { 2.0 };
    let size = if beyond { 2.0 } else { -1.0 };
    let factor = if x < 0.0 { -size } else { size };
    from_quarter_turns::<A>(k, factor * t, factor * rest)
}

/// Whether |x| > 1/2, t, and the inverse sine of t less t; NaN for |x| > 1.
#[inline(always)]
fn arcsine_up_to_half<A: Arithmetic>(x: f64) -> (bool, f64, f64) {
    let size = x.abs();
    let beyond = size > 0.5;
    let z = if beyond { 0.5 - 0.5 * size } else { size * size };
    let t = if beyond { z.sqrt() } else { size };
    (beyond, t, t * z * polynomial::<A, 12>(z, SINE))
}
