//! Sums and products with their rounding errors: numbers as unevaluated pairs, high + low.
//!
//! Sources: T. J. Dekker, *A floating-point technique for extending the available precision*,
//! Numerische Mathematik 18 (1971) 224-242.

use super::super::arithmetic::Arithmetic;

/// `a + b` and its rounding error, for `a = 0` or `|a| >= |b|`.
#[inline(always)]
pub(super) fn sum(a: f64, b: f64) -> (f64, f64) {
    let high = a + b;
    (high, (a - high) + b)
}

/// `a + b` and its rounding error, whichever is larger (D. E. Knuth, *The Art of Computer
/// Programming*, volume 2, 4.2.2).
#[inline(always)]
pub(super) fn sum_of_any(a: f64, b: f64) -> (f64, f64) {
    let high = a + b;
    let part = high - a;
    (high, (a - (high - part)) + (b - part))
}

/// `a b` and its rounding error, for factors and product far from overflow and underflow.
#[inline(always)]
pub(super) fn product<A: Arithmetic>(a: f64, b: f64) -> (f64, f64) {
    let high = a * b;
    if A::FUSED {
        return (high, a.mul_add(b, -high));
    }
    let ((a1, a2), (b1, b2)) = (halves(a), halves(b));
    (high, ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2)
}

/// A number as the sum of two of 26 bits each.
#[inline(always)]
fn halves(x: f64) -> (f64, f64) {
    let scaled = 134_217_729.0 * x; // 2^27 + 1
    let high = scaled - (scaled - x);
    (high, x - high)
}
