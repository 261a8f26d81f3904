//! Elementary functions over a chunk of samples.
//!
//! Answers: what the functions of [`crate::graph::node`] are worth, a chunk of samples at a time.
//! Each is a kernel without branches in a plain loop, so the compiler vectorises it for the
//! instruction set of its caller: everything is inlined, and the caller as a whole is compiled for
//! AVX2 or AVX-512. Lanes that leave the range of a kernel (most kernels show it as NaN), and they
//! alone, are computed once more one at a time, mostly by [`crate::number::Number`], that is by the
//! standard library. So the whole range of `f64` is covered, and the values at singular points are
//! those of [`crate::number`].
//!
//! Long kernels run in stages, each a loop over the chunk: a processor looks ahead some hundred
//! instructions, which is one or two rounds of a long loop, too few to fill the time that each step
//! waits for the one before, but many rounds of a short one.
//!
//! The value of a lane depends on that lane only. With and without fused multiply-add
//! ([`super::arithmetic::Arithmetic`]) values differ by rounding.
//!
//! Worst errors found, in units in the last place (ulp) of the true value, at some ten thousand
//! points a function made as the tables of `tests/engine/lane_math.rs` are (their generator with
//! scale 40), without fused multiply-add; with it they are at most 0.1 more:
//!
//! | function | method | error |
//! |---|---|---|
//! | [`sin`], [`cos`], [`sin_cos`] | reduction modulo π/2, polynomials | 1.6 |
//! | [`tan`] | quotient of the two with their rounding errors | 0.9 |
//! | [`asin`], [`acos`] | polynomial up to 1/2, beyond it of the half angle | 1.1 |
//! | [`atan`], [`atan2`] | one division to at most tan(π/8), polynomial | 1.6 |
//! | [`exp`] | reduction modulo ln 2, polynomial | 0.6 |
//! | [`ln`] | exponent, polynomial of (x - 1) / (x + 1) | 0.8 |
//! | [`tanh`] | polynomial up to 0.55, exponential beyond | 1.4 |
//! | [`pow`] | logarithm and exponent as sums of two numbers | 0.7 |
//! | [`powi`] | squaring: the bits of [`crate::number::Number::powi`] | n/2 |
//! | [`hypot`] | root of the sum of squares | 1.1 |
//! | [`stumpff()`], orders 0 to 4 | series or recurrence, of the larger of value and swing | 1.7 |
//! | [`stumpff()`], orders 5 to 8 | the same | 2.4 |
//! | [`floor`], [`sign`], [`min`], [`max`], ... | as defined | none |
//! | [`sqrt`], [`fract`], [`add`], ... | one operation | 0.5 |
//!
//! The swing of a Stumpff function of order k, `min(1/k!, x^(-k/2))`, is the size it oscillates
//! with.

mod algebraic;
mod exponential;
mod far_angle;
mod inverse_trigonometric;
mod pair;
mod power;
mod rounding;
mod stumpff;
mod trigonometric;

pub use algebraic::{
    abs, add, divide, hypot, max, min, multiply, negate, reciprocal_or_zero, sign, sqrt, subtract,
};
pub use exponential::{exp, ln, tanh};
pub use inverse_trigonometric::{acos, asin, atan, atan2};
pub use power::{pow, powi};
pub use rounding::{floor, fract};
pub use stumpff::stumpff;
pub use trigonometric::{cos, sin, sin_cos, tan};

use super::arithmetic::{Arithmetic, Lanes};

/// 1.5 · 2^52: added to a number below 2^51 in size, it leaves the nearest whole number in the last
/// bits, ready to be used as an integer or, after subtraction, as a number.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// The bit that is the sign of a number.
const SIGN: u64 = 1 << 63;

/// `Σ coefficients[i] x^i`: four terms at a time, so few steps wait for each other and the
/// processor has several registers under way at the same time (after G. Estrin, 1960).
#[inline(always)]
fn polynomial<A: Arithmetic, const N: usize>(x: f64, coefficients: [f64; N]) -> f64 {
    let square = x * x;
    let fourth = square * square;
    let mut first = (N - 1) / 4 * 4;
    let mut sum = up_to_four::<A, N>(x, square, &coefficients, first);
    while first > 0 {
        first -= 4;
        sum = A::mul_add(sum, fourth, up_to_four::<A, N>(x, square, &coefficients, first));
    }
    sum
}

/// `Σ coefficients[first + i] x^i`, i up to 3.
#[inline(always)]
fn up_to_four<A: Arithmetic, const N: usize>(
    x: f64,
    square: f64,
    coefficients: &[f64; N],
    first: usize,
) -> f64 {
    let low = match N - first {
        1 => return coefficients[first],
        _ => A::mul_add(coefficients[first + 1], x, coefficients[first]),
    };
    match N - first {
        2 => low,
        3 => A::mul_add(coefficients[first + 2], square, low),
        _ => {
            let high = A::mul_add(coefficients[first + 3], x, coefficients[first + 2]);
            A::mul_add(high, square, low)
        }
    }
}

/// A kernel that is right for every number, over a chunk.
#[inline(always)]
pub(super) fn map(x: &Lanes, out: &mut Lanes, kernel: impl Fn(f64) -> f64) {
    for (out, &x) in out.iter_mut().zip(x) {
        *out = kernel(x);
    }
}

/// The same, of what is there already.
#[inline(always)]
fn in_place(lanes: &mut Lanes, kernel: impl Fn(f64) -> f64) {
    for lane in lanes {
        *lane = kernel(*lane);
    }
}

/// The same for two arguments.
#[inline(always)]
pub(super) fn map2(a: &Lanes, b: &Lanes, out: &mut Lanes, kernel: impl Fn(f64, f64) -> f64) {
    for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
        *out = kernel(a, b);
    }
}

/// Whether any lane is NaN.
#[inline(always)]
fn any_nan(lanes: &Lanes) -> bool {
    let mut found = 0;
    for lane in lanes {
        found |= u64::from(lane.is_nan());
    }
    found != 0
}

/// The first bit says whether a number lies outside two positive ones, or is NaN: bits are gathered
/// over a chunk for less than a choice in every lane.
#[inline(always)]
fn outside(x: f64, (from, to): (f64, f64)) -> u64 {
    let bits = x.to_bits();
    bits | bits.wrapping_sub(from.to_bits()) | to.to_bits().wrapping_sub(bits)
}

/// Whether the first bit says so.
#[inline(always)]
fn says_outside(bits: u64) -> bool {
    bits >> 63 == 1
}

/// A kernel that gives NaN where it does not hold; `exact` computes what comes out as NaN.
#[inline(always)]
fn map_or(x: &Lanes, out: &mut Lanes, kernel: impl Fn(f64) -> f64, exact: fn(f64) -> f64) {
    map(x, out, kernel);
    if any_nan(out) {
        redo(x, out, exact);
    }
}

/// A kernel of two numbers and what says by its first bit that it does not hold there, which is
/// what `exact` is for.
#[inline(always)]
fn map2_within(
    a: &Lanes,
    b: &Lanes,
    out: &mut Lanes,
    kernel: impl Fn(f64, f64) -> (f64, u64),
    exact: fn(f64, f64) -> f64,
) {
    let mut found = 0;
    for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
        let (value, bits) = kernel(a, b);
        *out = value;
        found |= bits;
    }
    if says_outside(found) {
        redo2((a, b), out, |a, b, _| says_outside(kernel(a, b).1), exact);
    }
}

#[cold]
#[inline(never)]
fn redo(x: &Lanes, out: &mut Lanes, exact: fn(f64) -> f64) {
    for (out, &x) in out.iter_mut().zip(x) {
        if out.is_nan() {
            *out = exact(x);
        }
    }
}

/// The same for two arguments, where `is_wrong` says so of them and the result.
#[cold]
#[inline(never)]
fn redo2(
    (a, b): (&Lanes, &Lanes),
    out: &mut Lanes,
    is_wrong: impl Fn(f64, f64, f64) -> bool,
    exact: fn(f64, f64) -> f64,
) {
    for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
        if is_wrong(a, b, *out) {
            *out = exact(a, b);
        }
    }
}
