//! Elementary functions over lanes.
#![expect(missing_docs, reason = "placeholder")]
use crate::engine::lanes::arithmetic::{Arithmetic, LANES, Lanes};
use crate::number::Number;
macro_rules! one { ($($name:ident),*) => { $(#[inline(always)] pub fn $name<A: Arithmetic>(a: &Lanes, out: &mut Lanes) { for i in 0..LANES { out[i] = Number::$name(a[i]); } })* } }
one!(tan, asin, acos, atan, exp, ln, tanh, fract);
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
two!(pow, min, max);

#[inline(always)]
fn sc<A: Arithmetic>(x: f64) -> (f64, f64) {
    const MAGIC: f64 = 6755399441055744.0;
    let kq = A::mul_add(x, std::f64::consts::FRAC_2_PI, MAGIC);
    let q = kq.to_bits();
    let k = kq - MAGIC;
    let r = A::mul_add(k, -1.570_796_326_734_125_6, x);
    let r = A::mul_add(k, -6.077_100_506_303_966e-11, r);
    let r = A::mul_add(k, -2.022_266_248_795_950_7e-21, r);
    let z = r * r;
    let mut s = 1.58969099521155010221e-10;
    for c in [
        -2.50507602534068634195e-08,
        2.75573137070700676789e-06,
        -1.98412698298579493134e-04,
        8.33333333332248946124e-03,
        -1.66666666666666324348e-01,
    ] {
        s = A::mul_add(s, z, c);
    }
    let s = A::mul_add(s * z, r, r);
    let mut c = -1.13596475577881948265e-11;
    for d in [
        2.08757232129817482790e-09,
        -2.75573143513906633035e-07,
        2.48015872894767294178e-05,
        -1.38888888888741095749e-03,
        4.16666666666666019037e-02,
    ] {
        c = A::mul_add(c, z, d);
    }
    let hz = 0.5 * z;
    let w = 1.0 - hz;
    let c = w + A::mul_add(c * z, z, (1.0 - w) - hz);
    let swap = q & 1 != 0;
    let (a, b) = if swap { (c, s) } else { (s, c) };
    let sign_s = (q & 2) << 62;
    let sign_c = ((q + 1) & 2) << 62;
    (f64::from_bits(a.to_bits() ^ sign_s), f64::from_bits(b.to_bits() ^ sign_c))
}
#[inline(always)]
pub fn sin_cos<A: Arithmetic>(a: &Lanes, s: &mut Lanes, c: &mut Lanes) {
    for i in 0..LANES {
        let (p, q) = sc::<A>(a[i]);
        s[i] = p;
        c[i] = q;
    }
}
#[inline(always)]
pub fn sin<A: Arithmetic>(a: &Lanes, s: &mut Lanes) {
    for i in 0..LANES {
        s[i] = sc::<A>(a[i]).0;
    }
}
#[inline(always)]
pub fn cos<A: Arithmetic>(a: &Lanes, s: &mut Lanes) {
    for i in 0..LANES {
        s[i] = sc::<A>(a[i]).1;
    }
}
#[inline(always)]
pub fn hypot<A: Arithmetic>(a: &Lanes, b: &Lanes, s: &mut Lanes) {
    for i in 0..LANES {
        s[i] = A::mul_add(a[i], a[i], b[i] * b[i]).sqrt();
    }
}
#[inline(always)]
pub fn floor<A: Arithmetic>(a: &Lanes, s: &mut Lanes) {
    const M: f64 = 6755399441055744.0;
    for i in 0..LANES {
        let r = (a[i] + M) - M;
        s[i] = if r > a[i] { r - 1.0 } else { r };
    }
}
#[inline(always)]
pub fn atan2<A: Arithmetic>(y: &Lanes, x: &Lanes, out: &mut Lanes) {
    for i in 0..LANES {
        let (ay, ax) = (y[i].abs(), x[i].abs());
        let (hi, lo) = if ay > ax { (ay, ax) } else { (ax, ay) };
        let big = lo > 0.41421356237309503 * hi;
        let (n, d) = if big { (lo - hi, lo + hi) } else { (lo, hi) };
        let t = if d == 0.0 { 0.0 } else { n / d };
        let z = t * t;
        let mut p = 1.62858201153657823623e-02;
        for c in [
            -3.65315727442169155270e-02,
            4.97687799461593236017e-02,
            -5.83357013379057348645e-02,
            6.66107313738753120669e-02,
            -7.69187620504482999495e-02,
            9.09088713343650656196e-02,
            -1.11111104054623557880e-01,
            1.42857142725034663711e-01,
            -1.99999999998764832476e-01,
            3.33333333333329318027e-01,
        ] {
            p = A::mul_add(p, z, c);
        }
        let r = A::mul_add(-(p * z), t, t);
        let r = if big { r + std::f64::consts::FRAC_PI_4 } else { r };
        let r = if ay > ax { std::f64::consts::FRAC_PI_2 - r } else { r };
        let r = if x[i] < 0.0 { std::f64::consts::PI - r } else { r };
        out[i] = f64::from_bits(r.to_bits() | (y[i].to_bits() & (1 << 63)));
    }
}

#[inline(always)]
pub fn sqrt<A: Arithmetic>(a: &Lanes, s: &mut Lanes) {
    for i in 0..LANES {
        s[i] = a[i].sqrt();
    }
}
