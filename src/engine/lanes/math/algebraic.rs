//! Functions of a chunk that need a few instructions only.
//!
//! All but the hypotenuse are exact or rounded once, and right for every number. The hypotenuse is
//! `√(a² + b²)`, lane by lane where a square overflows or loses digits.

use super::super::arithmetic::{Arithmetic, Lanes};
use super::{map, map2, map2_within, outside};
use crate::number::Number;

/// `-x`.
#[inline(always)]
pub fn negate(x: &Lanes, out: &mut Lanes) {
    map(x, out, |x| -x);
}

/// `a + b`.
#[inline(always)]
pub fn add(a: &Lanes, b: &Lanes, out: &mut Lanes) {
    map2(a, b, out, |a, b| a + b);
}

/// `a - b`.
#[inline(always)]
pub fn subtract(a: &Lanes, b: &Lanes, out: &mut Lanes) {
    map2(a, b, out, |a, b| a - b);
}

/// `a b`.
#[inline(always)]
pub fn multiply(a: &Lanes, b: &Lanes, out: &mut Lanes) {
    map2(a, b, out, |a, b| a * b);
}

/// `a / b`.
#[inline(always)]
pub fn divide(a: &Lanes, b: &Lanes, out: &mut Lanes) {
    map2(a, b, out, |a, b| a / b);
}

/// Square root; NaN below 0, and 0 at both zeros.
#[inline(always)]
pub fn sqrt(x: &Lanes, out: &mut Lanes) {
    map(x, out, |x| (x + 0.0).sqrt());
}

/// Absolute value; as in [`Number::abs`] both zeros keep their sign.
#[inline(always)]
pub fn abs(x: &Lanes, out: &mut Lanes) {
    map(x, out, |x| x * signum(x));
}

/// -1, 0 or 1; NaN stays.
#[inline(always)]
pub fn sign(x: &Lanes, out: &mut Lanes) {
    map(x, out, signum);
}

/// `1/x`, and 0 at 0.
#[inline(always)]
pub fn reciprocal_or_zero(x: &Lanes, out: &mut Lanes) {
    map(x, out, |x| if x == 0.0 { 0.0 } else { 1.0 / x });
}

/// The smaller; NaN if either is.
#[inline(always)]
pub fn min(a: &Lanes, b: &Lanes, out: &mut Lanes) {
    map2(a, b, out, |a, b| if b < a || b.is_nan() { b } else { a });
}

/// The larger; NaN if either is.
#[inline(always)]
pub fn max(a: &Lanes, b: &Lanes, out: &mut Lanes) {
    map2(a, b, out, |a, b| if b > a || b.is_nan() { b } else { a });
}

/// Length of the legs `a` and `b`; neither overflows nor underflows.
#[inline(always)]
pub fn hypot<A: Arithmetic>(a: &Lanes, b: &Lanes, out: &mut Lanes) {
    map2_within(a, b, out, length::<A>, Number::hypot);
}

/// The length, and what says by its first bit that the square of it has not all digits.
#[inline(always)]
fn length<A: Arithmetic>(a: f64, b: f64) -> (f64, u64) {
    /// 2^-900: a square that loses digits is nothing against it.
    const SMALLEST: f64 = 1.183_052_186_166_774_7e-271;
    let square = A::mul_add(a, a, b * b);
    (square.sqrt(), outside(square, (SMALLEST, f64::MAX)))
}

#[inline(always)]
fn signum(x: f64) -> f64 {
    // Adding zero: the sign of -0 is 0.
    let at_zero = x + 0.0;
    let negative = if x < 0.0 { -1.0 } else { at_zero };
    if x > 0.0 { 1.0 } else { negative }
}
