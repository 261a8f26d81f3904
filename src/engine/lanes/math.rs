//! Elementary functions over lanes.
#![expect(missing_docs, reason = "placeholder")]
use crate::engine::lanes::arithmetic::{Arithmetic, LANES, Lanes};
use crate::number::Number;
macro_rules! one { ($($name:ident),*) => { $(#[inline(always)] pub fn $name<A: Arithmetic>(a: &Lanes, out: &mut Lanes) { for i in 0..LANES { out[i] = Number::$name(a[i]); } })* } }
one!(sin, cos, tan, asin, acos, atan, sqrt, exp, ln, tanh, floor, fract);
#[inline(always)]
pub fn sign<A: Arithmetic>(a: &Lanes, out: &mut Lanes) {
    for i in 0..LANES {
        out[i] = Number::signum(a[i]);
    }
}
#[inline(always)]
pub fn reciprocal_or_zero<A: Arithmetic>(a: &Lanes, out: &mut Lanes) {
    for i in 0..LANES {
        out[i] = if a[i] == 0.0 { 0.0 } else { 1.0 / a[i] };
    }
}
#[inline(always)]
pub fn powi<A: Arithmetic>(a: &Lanes, e: i32, out: &mut Lanes) {
    for i in 0..LANES {
        out[i] = Number::powi(a[i], e);
    }
}
#[inline(always)]
pub fn stumpff<A: Arithmetic>(a: &Lanes, e: u8, out: &mut Lanes) {
    for i in 0..LANES {
        out[i] = Number::stumpff(a[i], e);
    }
}
macro_rules! two { ($($name:ident),*) => { $(#[inline(always)] pub fn $name<A: Arithmetic>(a: &Lanes, b: &Lanes, out: &mut Lanes) { for i in 0..LANES { out[i] = Number::$name(a[i], b[i]); } })* } }
two!(pow, atan2, hypot, min, max);
#[inline(always)]
pub fn sin_cos<A: Arithmetic>(a: &Lanes, s: &mut Lanes, c: &mut Lanes) {
    for i in 0..LANES {
        s[i] = Number::sin(a[i]);
        c[i] = Number::cos(a[i]);
    }
}
