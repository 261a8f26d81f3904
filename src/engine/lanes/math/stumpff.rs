//! Stumpff functions `c_k(x) = Σ (-x)^i / (k + 2 i)!` over a chunk.
//!
//! Method: the power series for `-(k + 1)(k + 2) <= x <= max(1, k (k - 1))`; beyond it
//! `c_{k+2} = (1/k! - c_k) / x` from `c_0 = cos √x` or `c_1 = sin √x / √x`, the root taken with its
//! rounding error. The seams lie where either way loses no digit. Lane by lane, as
//! [`Number::stumpff`], for x beyond 2^40, for large negative x, and for orders above 12.

use super::super::arithmetic::{Arithmetic, LANES, Lanes};
use super::{any_nan, pair, trigonometric};
use crate::number::Number;

/// Highest order of the kernels.
const HIGHEST: usize = 12;

/// `1/n!`: the whole numbers below 35! are exact, later ones carry no digit that counts.
const INVERSE_FACTORIALS: [f64; 64] = {
    let mut table = [1.0; 64];
    let mut factorial: u128 = 1;
    let mut n = 1;
    while n < table.len() {
        if n < 35 {
            factorial *= n as u128;
            table[n] = 1.0 / factorial as f64;
        } else {
            table[n] = table[n - 1] / n as f64;
        }
        n += 1;
    }
    table
};

/// For each order the terms of the series above 1e-18 of the first, at the far end of its range.
const TERMS: [usize; HIGHEST + 1] = {
    let mut table = [0; HIGHEST + 1];
    let mut order = 0;
    while order < table.len() {
        let (mut terms, mut term) = (0, 1.0);
        while term > 1e-18 {
            terms += 1;
            let n = order + 2 * terms;
            term *= ((order + 1) * (order + 2)) as f64 / (n * (n - 1)) as f64;
        }
        table[order] = terms;
        order += 1;
    }
    table
};

/// Stumpff function of this order.
#[inline(always)]
pub fn stumpff<A: Arithmetic>(x: &Lanes, order: u8, out: &mut Lanes) {
    let k = usize::from(order);
    if k > HIGHEST {
        *out = [f64::NAN; LANES];
    } else {
        let near = (k * k.saturating_sub(1)).max(1) as f64;
        let far = -(((k + 1) * (k + 2)) as f64);
        series::<A>(x, k, out);
        let mut all_near = true;
        for &x in x {
            all_near &= x <= near && x >= far;
        }
        if all_near {
            return;
        }
        let mut beyond = [0.0; LANES];
        recurrence::<A>(x, k, &mut beyond);
        for ((out, &x), beyond) in out.iter_mut().zip(x).zip(&beyond) {
            *out = if x <= near && x >= far { *out } else { *beyond };
        }
    }
    if any_nan(out) {
        redo(x, order, out);
    }
}

/// The last step, where large terms meet, is taken with its rounding errors.
#[inline(always)]
fn series<A: Arithmetic>(x: &Lanes, k: usize, out: &mut Lanes) {
    *out = [0.0; LANES];
    let coefficients = INVERSE_FACTORIALS.iter().skip(k).step_by(2).take(TERMS[k]);
    for &coefficient in coefficients.skip(1).rev() {
        for (out, &x) in out.iter_mut().zip(x) {
            *out = A::mul_add(-x, *out, coefficient);
        }
    }
    let first = INVERSE_FACTORIALS[k];
    for (out, &x) in out.iter_mut().zip(x) {
        let (rest, rest_low) = pair::product::<A>(-x, *out);
        let (sum, error) = pair::sum_of_any(first, rest);
        *out = sum + (error + rest_low);
    }
}

/// From `c_0` or `c_1` upwards by twos; NaN where x is negative or beyond 2^40.
#[inline(always)]
fn recurrence<A: Arithmetic>(x: &Lanes, k: usize, out: &mut Lanes) {
    if k.is_multiple_of(2) {
        super::map(x, out, order_zero::<A>);
    } else {
        super::map(x, out, order_one::<A>);
    }
    for &inverse_factorial in INVERSE_FACTORIALS[..k].iter().skip(k % 2).step_by(2) {
        for (out, &x) in out.iter_mut().zip(x) {
            *out = (inverse_factorial - *out) / x;
        }
    }
}

#[inline(always)]
fn order_zero<A: Arithmetic>(x: f64) -> f64 {
    let (root, low) = root::<A>(x);
    trigonometric::of_sum::<A>(root, low).1
}

#[inline(always)]
fn order_one<A: Arithmetic>(x: f64) -> f64 {
    let (root, low) = root::<A>(x);
    trigonometric::of_sum::<A>(root, low).0 / root
}

/// Square root and its rounding error.
#[inline(always)]
fn root<A: Arithmetic>(x: f64) -> (f64, f64) {
    let root = x.sqrt();
    let (square, error) = pair::product::<A>(root, root);
    (root, ((x - square) - error) * (0.5 / root))
}

#[cold]
#[inline(never)]
fn redo(x: &Lanes, order: u8, out: &mut Lanes) {
    for (out, &x) in out.iter_mut().zip(x) {
        if out.is_nan() {
            *out = Number::stumpff(x, order);
        }
    }
}
