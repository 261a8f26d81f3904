//! The scalar the engine computes with: plain `f64` or a dual number that carries derivatives.
//!
//! Answers: the value of an elementary function *and* its derivatives, right at singular points.
//! This is the only file that names the dual-number library; everything else is generic over
//! [`Number`] and asks [`Dual`], [`Dual2`], [`Gradient`] or [`NestedDual`] for derivatives.
//!
//! Conventions at singular points (each is tested with its derivative):
//!
//! | function | at | value | derivative |
//! |---|---|---|---|
//! | `sqrt`, `abs`, `hypot` | 0 | 0 | 0 |
//! | `atan2` | the origin, whatever the signs of the zeros | 0 | 0 |
//! | `asin`, `acos` | ±1 | as `f64` | 0 |
//! | `pow` | base 0, exponent p > 0 | 0 | that of the power where finite, else 0 |
//! | `min`, `max` | a tie | either | of `self` |
//!
//! Outside its domain (`asin(2)`, `sqrt(-1)`, `ln(-1)`, `pow` of a negative base) a function is
//! NaN.
//!
//! Where a function is singular in a part of its argument only, its value is split off exactly and
//! the derivatives are computed about a regular point, so values agree over all number types.
//!
//! It does not know about units, vectors or rotations.

mod stumpff;

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use num_dual::{Derivative, Dual2_64, Dual64, DualNum, DualSVec64};

/// A real number with (possibly) derivatives.
pub trait Number:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// A number without derivatives.
    fn constant(value: f64) -> Self;
    /// The real part.
    fn value(&self) -> f64;
    /// Sine of an angle in radians.
    fn sin(self) -> Self;
    /// Cosine of an angle in radians.
    fn cos(self) -> Self;
    /// Tangent of an angle in radians.
    fn tan(self) -> Self;
    /// Inverse sine in radians, in [-π/2, π/2]; its derivatives keep their digits next to ±1.
    fn asin(self) -> Self {
        let cosine = ((-self + 1.0) * (self + 1.0)).sqrt();
        self.atan2(cosine)
    }
    /// Inverse cosine in radians, in [0, π]; its derivatives keep their digits next to ±1.
    fn acos(self) -> Self {
        let sine = ((-self + 1.0) * (self + 1.0)).sqrt();
        sine.atan2(self)
    }
    /// Inverse tangent in radians.
    fn atan(self) -> Self;
    /// Angle of the point `(x, self)` in radians, in (-π, π]; -π only where `self` is -0.
    fn atan2(self, x: Self) -> Self {
        let (a, b) = (self.value(), x.value());
        let length = a.hypot(b);
        if length < f64::MIN_POSITIVE {
            return Self::constant(0.0);
        }
        let angle = a.atan2(b);
        if !length.is_finite() {
            return Self::constant(angle);
        }
        // Turn by the real angle first: what is left is the small angle 0 / 1, away from every cut.
        let (s, c) = (a / length, b / length);
        let (dy, dx) = ((self - a) / length, (x - b) / length);
        ((dy * c - dx * s) / (dx * c + dy * s + 1.0)).atan() + angle
    }
    /// Square root.
    fn sqrt(self) -> Self;
    /// Length of the legs `self` and `other`; neither overflows nor underflows.
    fn hypot(self, other: Self) -> Self {
        let (a, b) = (self.value(), other.value());
        let length = a.hypot(b);
        if length < f64::MIN_POSITIVE || !length.is_finite() {
            return Self::constant(length);
        }
        // length √(1 + 0): the derivatives about the exact real length.
        let (s, c) = (a / length, b / length);
        let (dy, dx) = ((self - a) / length, (other - b) / length);
        ((dy * s + dx * c) * 2.0 + dy * dy + dx * dx + 1.0).sqrt() * length
    }
    /// e to the power of `self`.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Integer power by squaring: right at zero, and `powi(0)` is 1 everywhere.
    fn powi(self, exponent: i32) -> Self {
        let (mut power, mut base) = (Self::constant(1.0), self);
        let mut left = exponent.unsigned_abs();
        while left > 0 {
            if left & 1 == 1 {
                power = power * base;
            }
            left >>= 1;
            if left > 0 {
                base = base * base;
            }
        }
        if exponent >= 0 {
            power
        } else if power.value().is_infinite() {
            // A quotient of infinities would leave NaN as derivative.
            Self::constant(1.0 / power.value())
        } else {
            Self::constant(1.0) / power
        }
    }
    /// Power with a number as exponent, for a base of at least zero; NaN below.
    ///
    /// At base zero: whole exponents as [`Number::powi`], other positive ones 0 with derivatives 0
    /// (right up to the exponent's floor), negative ones infinite.
    fn pow(self, exponent: Self) -> Self {
        let (base, power) = (self.value(), exponent.value());
        if base < 0.0 || base.is_nan() || power.is_nan() {
            return Self::constant(f64::NAN);
        }
        if base == 0.0 {
            let whole = power.fract() == 0.0 && (0.0..=f64::from(i32::MAX)).contains(&power);
            return if whole { self.powi(power as i32) } else { Self::constant(base.powf(power)) };
        }
        if base.is_infinite() || power.is_infinite() {
            return Self::constant(base.powf(power));
        }
        // base^power exactly, times e to a power that is 0 in value.
        let ln = base.ln();
        ((self.ln() - ln) * exponent + (exponent - power) * ln).exp() * base.powf(power)
    }
    /// Absolute value.
    fn abs(self) -> Self {
        self * self.signum().value()
    }
    /// Sign: -1, 0 or 1, with derivative 0.
    fn signum(self) -> Self {
        let value = self.value();
        Self::constant(if value == 0.0 { 0.0 } else { value.signum() })
    }
    /// Largest whole number not above `self`, with derivative 0.
    fn floor(self) -> Self {
        Self::constant(self.value().floor())
    }
    /// `self - floor(self)`, with derivative 1.
    fn fract(self) -> Self {
        self - self.value().floor()
    }
    /// The smaller of two numbers; NaN if either is.
    fn min(self, other: Self) -> Self {
        if other.value() < self.value() || other.value().is_nan() { other } else { self }
    }
    /// The larger of two numbers; NaN if either is.
    fn max(self, other: Self) -> Self {
        if other.value() > self.value() || other.value().is_nan() { other } else { self }
    }
    /// Stumpff function `c_k(x) = Σ (-x)^i / (k + 2 i)!` of order k: `c_0(x²) = cos x`,
    /// `c_1(x²) = sin x / x`. Entire, so rotations by a rotation vector are smooth at zero; its
    /// derivative is `(k c_{k+2} - c_{k+1}) / 2`.
    fn stumpff(self, order: u8) -> Self {
        stumpff::stumpff(self, order)
    }
}

impl<T> Number for T
where
    T: DualNum<Primitive = f64> + Copy + Send + Sync,
{
    fn constant(value: f64) -> Self {
        T::from(value)
    }
    fn value(&self) -> f64 {
        self.re()
    }
    fn sin(self) -> Self {
        DualNum::sin(&self)
    }
    fn cos(self) -> Self {
        DualNum::cos(&self)
    }
    fn tan(self) -> Self {
        // Addition theorem about the real part: sin / cos would round otherwise than `f64::tan`.
        let real = self.re().tan();
        if !self.re().is_finite() {
            return T::from(real);
        }
        let rest = DualNum::tan(&(self - self.re()));
        (rest + real) / (-rest * real + 1.0)
    }
    fn atan(self) -> Self {
        DualNum::atan(&self)
    }
    fn sqrt(self) -> Self {
        if self.re() == 0.0 { T::from(0.0) } else { DualNum::sqrt(&self) }
    }
    fn exp(self) -> Self {
        DualNum::exp(&self)
    }
    fn ln(self) -> Self {
        DualNum::ln(&self)
    }
    fn tanh(self) -> Self {
        // Addition theorem about the real part: sinh / cosh would overflow to NaN.
        let real = self.re().tanh();
        if !self.re().is_finite() {
            return T::from(real);
        }
        let rest = DualNum::tanh(&(self - self.re()));
        (rest + real) / (rest * real + 1.0)
    }
}

/// Value and one derivative.
pub type Dual = Dual64;
/// Value, first and second derivative with respect to one variable.
pub type Dual2 = Dual2_64;
/// Value, derivatives with respect to two variables, and the mixed second derivative.
pub type NestedDual = num_dual::Dual<Dual64>;
/// Value and `N` partial derivatives.
pub type Gradient<const N: usize> = DualSVec64<N>;

/// The variable of a first derivative, at `value`.
pub fn variable(value: f64) -> Dual {
    Dual64::new(value, 1.0)
}

/// The derivative carried by a [`Dual`].
pub fn derivative(number: Dual) -> f64 {
    number.eps
}

/// The variable of a first and second derivative, at `value`.
pub fn variable2(value: f64) -> Dual2 {
    Dual2_64::new(value, 1.0, 0.0)
}

/// The first and second derivative carried by a [`Dual2`].
pub fn derivatives2(number: Dual2) -> [f64; 2] {
    [number.v1, number.v2]
}

/// A number at `value` that moves at `rates` with two independent variables.
pub fn nested(value: f64, rates: [f64; 2]) -> NestedDual {
    NestedDual::new(Dual64::new(value, rates[0]), Dual64::new(rates[1], 0.0))
}

/// The derivatives with respect to the first and the second variable, and the mixed one.
pub fn nested_derivatives(number: NestedDual) -> [f64; 3] {
    [number.re.eps, number.eps.re, number.eps.eps]
}

/// Variable `index` of `N` at `value`; an `index` of `N` or more gives a constant.
pub fn partial<const N: usize>(value: f64, index: usize) -> Gradient<N> {
    let number = Gradient::<N>::from_re(value);
    if index < N { number.derivative(index) } else { number }
}

/// A number with given partial derivatives.
pub fn with_partials<const N: usize>(value: f64, partials: [f64; N]) -> Gradient<N> {
    Gradient::<N>::new(value, Derivative::some(nalgebra::SVector::from(partials)))
}

/// The partial derivatives carried by a [`Gradient`].
pub fn partials<const N: usize>(number: &Gradient<N>) -> [f64; N] {
    match &number.eps.0 {
        Some(vector) => vector.data.0[0],
        None => [0.0; N],
    }
}
