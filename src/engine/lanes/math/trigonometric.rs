//! Sine, cosine and tangent over a chunk.
//!
//! Method: `x = n π/2 + r` with |r| <= π/4 (Cody and Waite, *Software Manual for the Elementary
//! Functions*, 1980), π/2 in four parts of which the first three have 33 bits, so that their
//! products with |n| < 2^20 are exact and r has its digits even next to a multiple of π/2. Then
//! minimax polynomials (Remez exchange on the relative error; 2^-57.9 for the sine, 2^-63.9 for the
//! cosine), and the quadrant. The tangent is the quotient of sine and cosine, each with its
//! rounding error, of an r that is a sum of two numbers. Beyond |x| = 2^20: lane by lane, as the
//! tangent, after [`super::far_angle`].

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use super::super::arithmetic::{Arithmetic, LANES, Lanes, Plain};
use super::{SIGN, WHOLE, far_angle, map, map_or, pair, polynomial};

/// Largest argument of the kernels.
const LARGEST: f64 = 1_048_576.0;

/// π/2 as a sum: three parts of 33 bits and the rest.
const HALF_PI: [f64; 4] =
    [1.5707963267341256, 6.077100506303966e-11, 2.0222662487111665e-21, 8.4784276603689e-32];

/// π/2 as a sum, the middle part of 33 bits: with a fused multiply-add the first needs no spare
/// bits.
const HALF_PI_FUSED: [f64; 3] = [FRAC_PI_2, 6.12323399538461e-17, 3.5215598651832e-27];

/// `(sin r / r - 1) / r²` in powers of r².
const SINE: [f64; 6] = [
    -0.1666666666666663,
    0.00833333333332184,
    -0.00019841269829359203,
    2.755731353899485e-06,
    -2.505073449769995e-08,
    1.5895441085205823e-10,
];

/// `(cos r - 1 + r²/2) / r⁴` in powers of r².
const COSINE: [f64; 6] = [
    0.041666666666666595,
    -0.0013888888888873344,
    2.4801587289004373e-05,
    -2.75573142178701e-07,
    2.087570552359277e-09,
    -1.1358756366116439e-11,
];

/// Sine of angles in radians.
#[inline(always)]
pub fn sin<A: Arithmetic>(x: &Lanes, out: &mut Lanes) {
    sin_cos::<A>(x, out, &mut [0.0; LANES]);
}

/// Cosine of angles in radians.
#[inline(always)]
pub fn cos<A: Arithmetic>(x: &Lanes, out: &mut Lanes) {
    sin_cos::<A>(x, &mut [0.0; LANES], out);
}

/// Sine and cosine of angles in radians, at little more than the price of one of them.
#[inline(always)]
pub fn sin_cos<A: Arithmetic>(x: &Lanes, sin: &mut Lanes, cos: &mut Lanes) {
    map(x, sin, remainder::<A>);
    for (sin, cos) in sin.iter_mut().zip(cos.iter_mut()) {
        (*sin, *cos) = of_remainder::<A>(*sin);
    }
    let mut outside = 0;
    for ((sin, cos), &x) in sin.iter_mut().zip(cos.iter_mut()).zip(x) {
        (*sin, *cos) = turned::<A>(x, (*sin, *cos));
        outside |= excess(x);
    }
    if outside >> 63 == 1 {
        redo_far(x, sin, cos);
    }
}

/// The first bit says whether |x| is above [`LARGEST`], or NaN.
#[inline(always)]
fn excess(x: f64) -> u64 {
    x.abs().to_bits() + (i64::MAX as u64 - LARGEST.to_bits())
}

#[cold]
#[inline(never)]
fn redo_far(x: &Lanes, sin: &mut Lanes, cos: &mut Lanes) {
    for ((sin, cos), &x) in sin.iter_mut().zip(cos).zip(x) {
        if excess(x) >> 63 == 1 {
            (*sin, *cos) = (far_sine(x), far_cosine(x));
        }
    }
}

/// Tangent of angles in radians.
#[inline(always)]
pub fn tan<A: Arithmetic>(x: &Lanes, out: &mut Lanes) {
    map_or(x, out, tangent::<A>, far_tangent);
}

/// `x - n π/2`, right to the last place or two, next to a multiple of π/2, too.
#[inline(always)]
fn remainder<A: Arithmetic>(x: f64) -> f64 {
    let n = quarters::<A>(x) - WHOLE;
    if A::FUSED {
        HALF_PI_FUSED.iter().fold(x, |rest, part| A::mul_add(-n, *part, rest))
    } else {
        HALF_PI.iter().fold(x, |rest, part| rest - n * part)
    }
}

/// [`WHOLE`] and the whole number n of right angles next to x.
#[inline(always)]
fn quarters<A: Arithmetic>(x: f64) -> f64 {
    A::mul_add(x, FRAC_2_PI, WHOLE)
}

/// Sine and cosine of an angle up to π/4.
#[inline(always)]
fn of_remainder<A: Arithmetic>(r: f64) -> (f64, f64) {
    let z = r * r;
    let sine = A::mul_add(r * z, polynomial::<A, 6>(z, SINE), r);
    let cosine = A::mul_add(z * z, polynomial::<A, 6>(z, COSINE), A::mul_add(-0.5, z, 1.0));
    // Zero keeps its sign; all others have it.
    (f64::from_bits(sine.to_bits() | r.to_bits() & SIGN), cosine)
}

/// Sine and cosine of x from those of its remainder.
#[inline(always)]
fn turned<A: Arithmetic>(x: f64, of_remainder: (f64, f64)) -> (f64, f64) {
    in_quadrant(quarters::<A>(x).to_bits(), of_remainder)
}

/// Sine and cosine of x + low for positive x, low its rounding error; NaN beyond [`LARGEST`].
#[inline(always)]
pub(super) fn of_sum<A: Arithmetic>(x: f64, low: f64) -> (f64, f64) {
    let (quadrant, (high, rest)) = reduce::<A>(x);
    let (sine, cosine) = in_quadrant(quadrant, of_pair::<A>(pair::sum(high, rest + low)));
    if x <= LARGEST { (sine, cosine) } else { (f64::NAN, f64::NAN) }
}

/// Sine and cosine of `quadrant π/2 + r` from those of r.
#[inline(always)]
fn in_quadrant(quadrant: u64, (s, c): (f64, f64)) -> (f64, f64) {
    // Exchanged bit by bit: to choose costs more where there is no instruction for it.
    let (s, c) = (s.to_bits(), c.to_bits());
    let differing = (s ^ c) & (quadrant & 1).wrapping_neg();
    let sine = s ^ differing ^ ((quadrant & 2) << 62);
    let cosine = c ^ differing ^ ((quadrant.wrapping_add(1) & 2) << 62);
    (f64::from_bits(sine), f64::from_bits(cosine))
}

/// Sine and cosine of an angle up to π/4 that is a sum.
#[inline(always)]
fn of_pair<A: Arithmetic>(r: (f64, f64)) -> (f64, f64) {
    let ((s, s_low), (c, c_low)) = near_zero::<A>(r);
    (s + s_low, c + c_low)
}

#[inline(always)]
fn tangent<A: Arithmetic>(x: f64) -> f64 {
    let (quadrant, r) = reduce::<A>(x);
    let tangent = tangent_in_quadrant::<A>(quadrant, r);
    if x.abs() <= LARGEST { tangent } else { f64::NAN }
}

/// Tangent of `quadrant π/2 + r`.
#[inline(always)]
fn tangent_in_quadrant<A: Arithmetic>(quadrant: u64, r: (f64, f64)) -> f64 {
    let (s, c) = near_zero::<A>(r);
    let (s, c) = (pair::sum(s.0, s.1), pair::sum(c.0, c.1));
    let even = quadrant & 1 == 0;
    let (above, below) = if even { (s, c) } else { (c, (-s.0, -s.1)) };
    let reciprocal = 1.0 / below.0;
    let quotient = above.0 * reciprocal;
    let (back, back_low) = pair::product::<A>(quotient, below.0);
    let rest = ((above.0 - back) - back_low) + (above.1 - quotient * below.1);
    A::mul_add(rest, reciprocal, quotient)
}

fn far_sine(x: f64) -> f64 {
    far(x, |quadrant, r| in_quadrant(quadrant, of_pair::<Plain>(r)).0)
}

fn far_cosine(x: f64) -> f64 {
    far(x, |quadrant, r| in_quadrant(quadrant, of_pair::<Plain>(r)).1)
}

fn far_tangent(x: f64) -> f64 {
    far(x, tangent_in_quadrant::<Plain>)
}

/// A function of the reduced angle; NaN if the angle is infinite or NaN.
fn far(x: f64, function: fn(u64, (f64, f64)) -> f64) -> f64 {
    if !x.is_finite() {
        return f64::NAN;
    }
    let (quadrant, (high, low)) = far_angle::reduce(x);
    function(quadrant, pair::sum(high, low))
}

/// `x = n π/2 + high + low`: n (its last two bits count), high and low.
#[inline(always)]
fn reduce<A: Arithmetic>(x: f64) -> (u64, (f64, f64)) {
    let shifted = quarters::<A>(x);
    let n = shifted - WHOLE;
    if A::FUSED {
        let first = A::mul_add(-n, HALF_PI_FUSED[0], x); // exact
        let (high, error) = pair::sum(first, -n * HALF_PI_FUSED[1]);
        return (shifted.to_bits(), (high, A::mul_add(-n, HALF_PI_FUSED[2], error)));
    }
    let first = A::mul_add(-n, HALF_PI[0], x); // exact
    let (second, e1) = pair::sum(first, -n * HALF_PI[1]);
    let (high, e2) = pair::sum(second, -n * HALF_PI[2]);
    let low = A::mul_add(-n, HALF_PI[3], e1 + e2);
    (shifted.to_bits(), (high, low))
}

/// Sine and cosine of high + low, at most π/4 in size, both as large part and small part.
#[inline(always)]
fn near_zero<A: Arithmetic>((high, low): (f64, f64)) -> ((f64, f64), (f64, f64)) {
    let z = high * high;
    let half = 0.5 * z;
    let s = A::mul_add(high * z, polynomial::<A, 6>(z, SINE), A::mul_add(-half, low, low));
    let (one, error) = pair::sum(1.0, -half);
    let c = A::mul_add(z * z, polynomial::<A, 6>(z, COSINE), A::mul_add(-high, low, error));
    ((high, s), (one, c))
}
