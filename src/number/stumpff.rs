//! Stumpff functions `c_k(x) = Σ (-x)^i / (k + 2 i)!`, over any [`Number`].
//!
//! Answers: value and derivatives to rounding for all real x, without a seam between the branches.
//! For `|x| <= (k + 1)(k + 2)` the terms of the series fall from the start and little cancels;
//! beyond it `c_{k+2} = (1/k! - c_k) / x`, from the trigonometric (x > 0) or hyperbolic (x < 0)
//! functions, divides errors by more than it multiplies them. (Stumpff 1947; Danby, Fundamentals of
//! Celestial Mechanics, 6.9.) For large x the absolute error is that of `cos √x`: `√x / 2` units of
//! rounding.

use super::Number;

/// Terms beyond the last that matters for the value: they carry the derivatives near x = 0.
const TERMS_FOR_DERIVATIVES: u32 = 6;

pub(super) fn stumpff<N: Number>(x: N, order: u8) -> N {
    let k = f64::from(order);
    if x.value().abs() <= (k + 1.0) * (k + 2.0) { series(x, k) } else { recurrence(x, order) }
}

/// `1/k! (1 - x/((k+1)(k+2)) (1 - x/((k+3)(k+4)) (...)))`, cut where terms vanish.
fn series<N: Number>(x: N, k: f64) -> N {
    let divisor = |i: u32| {
        let n = k + 2.0 * f64::from(i);
        n * (n - 1.0)
    };
    let size = x.value().abs();
    let (mut terms, mut term) = (0, 1.0);
    while term > 1e-18 {
        terms += 1;
        term *= size / divisor(terms);
    }
    let mut sum = N::constant(1.0);
    for i in (1..=terms + TERMS_FOR_DERIVATIVES).rev() {
        sum = -(x * sum / divisor(i)) + 1.0;
    }
    let mut factorial = 1.0;
    let mut n = 2.0;
    while n <= k {
        factorial *= n;
        n += 1.0;
    }
    sum / factorial
}

/// From `c_0` or `c_1` upwards by twos.
fn recurrence<N: Number>(x: N, order: u8) -> N {
    let even = order.is_multiple_of(2);
    let mut current = if x.value() < 0.0 {
        let root = (-x).sqrt();
        let (up, down) = (root.exp(), (-root).exp());
        if even { (up + down) * 0.5 } else { (up - down) * (N::constant(0.5) / root) }
    } else {
        let root = x.sqrt();
        if even { root.cos() } else { root.sin() * (N::constant(1.0) / root) }
    };
    // A dual number multiplies by the reciprocal: so does this, to give the same bits.
    let inverse = N::constant(1.0) / x;
    let mut inverse_factorial = 1.0;
    let mut k = order % 2;
    while k < order {
        current = (-current + inverse_factorial) * inverse;
        inverse_factorial /= (f64::from(k) + 1.0) * (f64::from(k) + 2.0);
        k += 2;
    }
    current
}
