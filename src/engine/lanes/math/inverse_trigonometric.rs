//! Inverse sine, cosine and tangent, and the angle of a point, over a chunk.
//!
//! Method: every angle is `k π/4 + angle(t)` with whole k. For the inverse tangent of a quotient q
//! <= 1 (the smaller of |x|, |y| over the larger) t is q, or `(q - 1) / (q + 1)` beyond tan(π/8),
//! from one division; for the inverse sine and cosine t is |x|, or `√((1 - |x|) / 2)` beyond 1/2,
//! and the sum is taken with its rounding error. Minimax polynomials in t² (Remez exchange on the
//! relative error; 2^-57.4 for the inverse tangent, 2^-55.7 for the inverse sine).

use std::f64::consts::{FRAC_PI_4, SQRT_2};

use super::super::arithmetic::{Arithmetic, Lanes};
use super::{SIGN, in_place, map, map2, outside, pair, polynomial, redo2, says_outside};
use crate::number::Number;

/// π/4 as a sum; multiples of the first part up to 4 are exact.
const QUARTER_PI: [f64; 2] = [0.7853981633974456, 2.6951514290790595e-15];

/// tan(π/8).
const EIGHTH: f64 = SQRT_2 - 1.0;

/// `(atan t / t - 1) / t²` in powers of t².
const TANGENT: [f64; 11] = [
    -0.333333333333332,
    0.19999999999953205,
    -0.1428571428016209,
    0.11111110781921689,
    -0.09090897718289402,
    0.07692059589503851,
    -0.0666309770720566,
    0.05847848099328411,
    -0.05039138886420012,
    0.03806080213274736,
    -0.01790354536615928,
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
    map(x, out, |x| quotient::<A>(x.abs(), 1.0));
    in_place(out, from_zero::<A>);
    for (out, &x) in out.iter_mut().zip(x) {
        *out = unfolded::<A>(*out, x, 1.0);
    }
}

/// Angle of the points (x, y) in radians, in [-π, π]; 0 at the origin whatever the signs of the
/// zeros.
#[inline(always)]
pub fn atan2<A: Arithmetic>(y: &Lanes, x: &Lanes, out: &mut Lanes) {
    map2(y, x, out, |y, x| quotient::<A>(y.abs(), x.abs()));
    in_place(out, from_zero::<A>);
    let mut found = 0;
    for ((out, &y), &x) in out.iter_mut().zip(y).zip(x) {
        // Adding zero: an angle of -0 is 0, as in `Number`.
        *out = unfolded::<A>(*out, y, x) + 0.0;
        found |= beyond_plain(y, x);
    }
    if says_outside(found) {
        redo2((y, x), out, |y, x, _| says_outside(beyond_plain(y, x)), Number::atan2);
    }
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

/// The first bit says that a quotient of the two may lose digits, or is none.
#[inline(always)]
fn beyond_plain(y: f64, x: f64) -> u64 {
    outside(x.abs() + y.abs(), (SMALLEST, LARGEST))
}

/// Minus the quotient of two sizes, the smaller over the larger, or minus its t where it is beyond
/// tan(π/8).
#[inline(always)]
fn quotient<A: Arithmetic>(across: f64, along: f64) -> f64 {
    let (small, large) = sorted(across, along);
    let beyond = short_of::<A>(small, large) < 0.0;
    // A choice between a number and zero costs least; in `small - off(large)` it would become
    // another one.
    let off = |size: f64| if beyond { size } else { 0.0 };
    (off(large) - small) / (large + off(small))
}

/// The smaller and the larger.
#[inline(always)]
fn sorted(a: f64, b: f64) -> (f64, f64) {
    if a < b { (a, b) } else { (b, a) }
}

/// What a quotient is short of tan(π/8), times the larger.
#[inline(always)]
fn short_of<A: Arithmetic>(small: f64, large: f64) -> f64 {
    A::mul_add(EIGHTH, large, -small)
}

/// Inverse tangent of t.
#[inline(always)]
fn from_zero<A: Arithmetic>(t: f64) -> f64 {
    let z = t * t;
    A::mul_add(t * z, polynomial::<A, 11>(z, TANGENT), t)
}

/// The angle of (x, y) from that of its [`quotient`], which is negative: `k π/4 ± angle`, with
/// signs moved as bits, which costs less than to choose.
#[inline(always)]
fn unfolded<A: Arithmetic>(angle: f64, y: f64, x: f64) -> f64 {
    let signed = |size: f64, sign: u64| f64::from_bits(size.to_bits() ^ sign);
    let (across, along) = (y.abs(), x.abs());
    let (small, large) = sorted(across, along);
    let backward = x.to_bits() & SIGN;
    let turned = backward ^ ((along - across).to_bits() & SIGN);
    // 0 beyond tan(π/8), else -1.
    let k = -0.5 - 0.5_f64.copysign(short_of::<A>(small, large));
    let k = signed(k, turned) + (2.0 - signed(1.0, backward));
    let size = A::mul_add(k, FRAC_PI_4, -signed(angle, turned));
    signed(size, y.to_bits() & SIGN)
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
