//! Exponential, natural logarithm and hyperbolic tangent over a chunk.
//!
//! Methods, with minimax polynomials (Remez exchange on the relative error of the result):
//! - `exp x = 2^n exp r`, |r| <= ln 2 / 2 as a sum of two numbers (2^-57.2); lane by lane beyond
//!   |x| = 708, where results overflow or lose digits.
//! - `ln x = k ln 2 + ln(1 + f)`, 1 + f in [√½, √2); with s = f / (2 + f) it is
//!   `f - f²/2 + s (f²/2 + R(s²))` (2^-59; P. T. P. Tang, ACM TOMS 16 (1990) 378-400); lane by lane
//!   for what is not positive, normal and finite.
//! - `tanh x` is `x + x³ P(x²)` up to 0.55 (2^-59), else `1 - 2 / (exp 2x + 1)`.

use std::f64::consts::LOG2_E;

use super::super::arithmetic::{Arithmetic, Lanes};
use super::{WHOLE, map, map_or, pair, polynomial};
use crate::number::Number;

/// ln 2 as a sum; the product of the first part and an exponent is exact.
pub(super) const LN_2: [f64; 2] = [0.6931471805598903, 5.49792301870721e-14];

/// Largest argument of the exponential's kernel.
pub(super) const LARGEST: f64 = 708.0;

/// `(exp r - 1 - r - r²/2) / r³` in powers of r.
const EXPONENTIAL: [f64; 9] = [
    0.16666666666666433,
    0.041666666666604006,
    0.008333333333499815,
    0.0013888888926777453,
    0.00019841269466625095,
    2.4801508706421234e-05,
    2.7557640575699336e-06,
    2.762517702447984e-07,
    2.4978447831682077e-08,
];

/// `(ln((1 + s) / (1 - s)) / s - 2) / s²` in powers of s².
const LOGARITHM: [f64; 7] = [
    0.6666666666666734,
    0.3999999999941513,
    0.2857142874231377,
    0.22222198577609983,
    0.1818356425873566,
    0.15314048377126335,
    0.14796007047629897,
];

/// `(tanh x / x - 1) / x²` in powers of x².
const HYPERBOLIC_TANGENT: [f64; 11] = [
    -0.333333333333333,
    0.13333333333326622,
    -0.05396825396376091,
    0.021869488385861714,
    -0.008863232601505634,
    0.0035920920308639783,
    -0.001455542847552212,
    0.0005884444910499644,
    -0.00023338157344410062,
    8.33164554022479e-05,
    -1.9494691061451255e-05,
];

/// e to the power of x.
#[inline(always)]
pub fn exp<A: Arithmetic>(x: &Lanes, out: &mut Lanes) {
    map_or(x, out, exponential::<A>, Number::exp);
}

/// Natural logarithm; -∞ at 0, NaN below.
#[inline(always)]
pub fn ln<A: Arithmetic>(x: &Lanes, out: &mut Lanes) {
    map_or(x, out, logarithm::<A>, Number::ln);
}

/// Hyperbolic tangent.
#[inline(always)]
pub fn tanh<A: Arithmetic>(x: &Lanes, out: &mut Lanes) {
    map(x, out, hyperbolic_tangent::<A>);
}

#[inline(always)]
fn exponential<A: Arithmetic>(x: f64) -> f64 {
    let value = exponential_of_sum::<A>(x, 0.0);
    if x.abs() <= LARGEST { value } else { f64::NAN }
}

/// `exp(x + low)`, low small against 1, for |x| up to [`LARGEST`].
#[inline(always)]
pub(super) fn exponential_of_sum<A: Arithmetic>(x: f64, low: f64) -> f64 {
    let shifted = A::mul_add(x, LOG2_E, WHOLE);
    let n = shifted - WHOLE;
    let (r, error) = pair::sum(A::mul_add(-n, LN_2[0], x), -n * LN_2[1]);
    let (r, low) = pair::sum(r, error + low);
    let square = r * r;
    let cubic = square * r * polynomial::<A, 9>(r, EXPONENTIAL);
    let (sum, error) = pair::sum(1.0, r);
    let value = sum + (A::mul_add(0.5, square, error) + (cubic + low));
    f64::from_bits(value.to_bits().wrapping_add(shifted.to_bits() << 52))
}

#[inline(always)]
fn logarithm<A: Arithmetic>(x: f64) -> f64 {
    let (k, f) = exponent_and_rest(x);
    let s = f / (2.0 + f);
    let z = s * s;
    let half = 0.5 * f * f;
    let bent = A::mul_add(z, polynomial::<A, 7>(z, LOGARITHM), half);
    let (sum, error) = pair::sum(k * LN_2[0], f);
    let small = A::mul_add(k, LN_2[1], error);
    let value = sum + (small - A::mul_add(-s, bent, half));
    if is_positive_and_normal(x) { value } else { f64::NAN }
}

/// k and f with `x = 2^k (1 + f)` and 1 + f in [√½, √2), for positive normal x.
#[inline(always)]
pub(super) fn exponent_and_rest(x: f64) -> (f64, f64) {
    const ONE: u64 = 1.0_f64.to_bits();
    const ROOT_OF_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    const TWO_52: f64 = 4_503_599_627_370_496.0;
    let shifted = x.to_bits().wrapping_add(ONE - ROOT_OF_HALF);
    let biased = f64::from_bits((shifted >> 52) | TWO_52.to_bits());
    let fraction = f64::from_bits((shifted & ((1 << 52) - 1)) + ROOT_OF_HALF);
    (biased - (TWO_52 + 1023.0), fraction - 1.0)
}

#[inline(always)]
pub(super) fn is_positive_and_normal(x: f64) -> bool {
    (f64::MIN_POSITIVE..=f64::MAX).contains(&x)
}

#[inline(always)]
fn hyperbolic_tangent<A: Arithmetic>(x: f64) -> f64 {
    let size = x.abs();
    // Beyond 20 the result is 1 to rounding. NaN stays.
    let size = if size > 20.0 { 20.0 } else { size };
    let z = size * size;
    let near = A::mul_add(size * z, polynomial::<A, 11>(z, HYPERBOLIC_TANGENT), size);
    let far = 1.0 - 2.0 / (exponential_of_sum::<A>(2.0 * size, 0.0) + 1.0);
    let value = if size > 0.55 { far } else { near }; // NaN is near
    // Adding zero: the tangent of -0 is 0, as in `Number`.
    value.copysign(x) + 0.0
}
