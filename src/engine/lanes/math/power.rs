//! Powers over a chunk.
//!
//! Method: `x^y = exp(y ln x)`, the logarithm and the product as sums of two numbers with 19
//! digits, because an exponent of 700 has but 13 digits left behind its point. With s = f / (2 + f)
//! as in [`super::exponential`], `ln(1 + f) = 2 s (1 + s²/3 + s⁴ P(s²))`, of which only P (2^-66 of
//! the result; minimax by Remez exchange) is a plain number. Lane by lane where the base is not
//! positive, normal and finite, or the result may overflow or lose digits.
//!
//! Integer powers are multiplied out as [`Number::powi`] does, to the same bits: each
//! multiplication adds its rounding error, so `x^n` is right to about n/2 ulp.

use super::super::arithmetic::{Arithmetic, LANES, Lanes};
use super::exponential::{
    LARGEST, LN_2, exponent_and_rest, exponential_of_sum, is_positive_and_normal,
};
use super::{any_nan, pair, polynomial, redo2};
use crate::number::Number;

/// 1/3 as a sum.
const THIRD: [f64; 2] = [0.3333333333333333, 1.850371707708594e-17];

/// `(ln((1 + s) / (1 - s)) / 2 s - 1 - s²/3) / s⁴` in powers of s².
const LOGARITHM: [f64; 8] = [
    0.1999999999999999,
    0.14285714285722553,
    0.11111111108768473,
    0.0909090943513079,
    0.07692278437128286,
    0.06668158652746294,
    0.0583741030543205,
    0.059944985149934314,
];

/// Largest exponent of the kernel: beyond it only a base of 1 has a finite power.
const LARGEST_EXPONENT: f64 = 1e30;

/// `x^y`; NaN for a negative base.
#[inline(always)]
pub fn pow<A: Arithmetic>(x: &Lanes, y: &Lanes, out: &mut Lanes) {
    // Two loops: the compiler does not vectorise the whole for SSE2.
    let (mut ln, mut ln_low) = ([0.0; LANES], [0.0; LANES]);
    for ((ln, ln_low), &x) in ln.iter_mut().zip(&mut ln_low).zip(x) {
        (*ln, *ln_low) = logarithm::<A>(x);
    }
    for (((out, &ln), &ln_low), &y) in out.iter_mut().zip(&ln).zip(&ln_low).zip(y) {
        *out = exponential_of_product::<A>(y, ln, ln_low);
    }
    if any_nan(out) {
        redo2((x, y), out, |_, _, power| power.is_nan(), Number::pow);
    }
}

/// `x^exponent` by squaring, 1 for an exponent of 0 everywhere.
#[inline(always)]
pub fn powi(x: &Lanes, exponent: i32, out: &mut Lanes) {
    let mut base = *x;
    let mut left = exponent.unsigned_abs();
    *out = [1.0; _];
    while left > 0 {
        if left & 1 == 1 {
            for (out, base) in out.iter_mut().zip(&base) {
                *out *= base;
            }
        }
        left >>= 1;
        if left > 0 {
            for base in &mut base {
                *base *= *base;
            }
        }
    }
    if exponent < 0 {
        for out in out {
            *out = 1.0 / *out;
        }
    }
}

/// `exp(y (ln + ln_low))`, or NaN where it may overflow or lose digits.
#[inline(always)]
fn exponential_of_product<A: Arithmetic>(y: f64, ln: f64, ln_low: f64) -> f64 {
    let (product, error) = pair::product::<A>(y, ln);
    let value = exponential_of_sum::<A>(product, A::mul_add(y, ln_low, error));
    if y.abs() <= LARGEST_EXPONENT && product.abs() <= LARGEST { value } else { f64::NAN }
}

/// The natural logarithm as a sum; NaN if x is not positive, normal and finite.
#[inline(always)]
fn logarithm<A: Arithmetic>(x: f64) -> (f64, f64) {
    let (k, f) = exponent_and_rest(x);
    let (s, s_low) = {
        let (below, below_low) = pair::sum(1.0, f + 1.0);
        let reciprocal = 1.0 / below;
        let s = f * reciprocal;
        let (back, back_low) = pair::product::<A>(s, below);
        (s, (((f - back) - back_low) - s * below_low) * reciprocal)
    };
    let (z, z_low) = pair::product::<A>(s, s);
    let z_low = A::mul_add(2.0 * s, s_low, z_low);
    let (third, third_low) = pair::product::<A>(z, THIRD[0]);
    let third_low = A::mul_add(z, THIRD[1], A::mul_add(z_low, THIRD[0], third_low));
    let rest = A::mul_add(z * z, polynomial::<A, 8>(z, LOGARITHM), third_low);
    let (factor, error) = pair::sum(1.0, third);
    let factor_low = error + rest;
    let (half, half_low) = pair::product::<A>(s, factor);
    let half_low = A::mul_add(s, factor_low, A::mul_add(s_low, factor, half_low));
    let (sum, error) = pair::sum(k * LN_2[0], 2.0 * half);
    let (ln, ln_low) = pair::sum(sum, A::mul_add(2.0, half_low, A::mul_add(k, LN_2[1], error)));
    (if is_positive_and_normal(x) { ln } else { f64::NAN }, ln_low)
}
