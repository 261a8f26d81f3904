//! Whole numbers near the lanes of a chunk.
//!
//! Method: a number below 2^52 in size loses its fraction when 2^52 is added and subtracted again,
//! because the last bit of the sum counts ones; larger numbers are whole. So no instruction beyond
//! SSE2 is needed. Exact for every number; infinities and NaN stay.

use super::super::arithmetic::Lanes;
use super::map;

/// The largest whole number not above.
#[inline(always)]
pub fn floor(x: &Lanes, out: &mut Lanes) {
    map(x, out, below);
}

/// The distance to the largest whole number not above.
#[inline(always)]
pub fn fract(x: &Lanes, out: &mut Lanes) {
    map(x, out, |x| x - below(x));
}

/// The nearest whole number, the even one of two; zeros keep the sign.
#[inline(always)]
fn nearest(x: f64) -> f64 {
    const TWO_52: f64 = 4_503_599_627_370_496.0;
    let size = x.abs();
    let rounded = (size + TWO_52) - TWO_52;
    (if size < TWO_52 { rounded } else { size }).copysign(x)
}

#[inline(always)]
fn below(x: f64) -> f64 {
    let nearest = nearest(x);
    if nearest > x { nearest - 1.0 } else { nearest }
}
