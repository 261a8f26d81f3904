//! Dimensions: rational powers of length, time, mass, temperature and electric current.

use std::fmt;
use std::ops::{Div, Mul};

/// Exponent of a base dimension as a reduced fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Exponent {
    numerator: i16,
    denominator: i16,
}

impl Exponent {
    /// Zero.
    pub const ZERO: Self = Self { numerator: 0, denominator: 1 };

    /// `numerator / denominator`, reduced; `None` if the denominator is 0 or the result is beyond
    /// ±1000 or has a denominator above 1000 (no unit needs that).
    pub fn new(numerator: i64, denominator: i64) -> Option<Self> {
        if denominator == 0 || denominator == i64::MIN || numerator == i64::MIN {
            return None;
        }
        let sign = denominator.signum();
        let divisor = greatest_common_divisor(numerator.abs(), denominator.abs()).max(1);
        let (numerator, denominator) = (sign * numerator / divisor, denominator.abs() / divisor);
        if numerator.abs() > 1000 || denominator > 1000 {
            return None;
        }
        Some(Self { numerator: numerator as i16, denominator: denominator as i16 })
    }

    /// The fraction nearest to a decimal such as 0.5 or 2, if it is one with a denominator up
    /// to 12.
    pub fn from_decimal(value: f64) -> Option<Self> {
        (1..=12_i32).find_map(|denominator| {
            let numerator = value * f64::from(denominator);
            ((numerator - numerator.round()).abs() < 1e-9 && numerator.abs() <= 1000.0)
                .then(|| Self::new(numerator.round() as i64, i64::from(denominator)))
                .flatten()
        })
    }

    /// As a decimal.
    pub fn value(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }

    fn plus(self, other: Self) -> Option<Self> {
        let (a, b) = (i64::from(self.denominator), i64::from(other.denominator));
        Self::new(i64::from(self.numerator) * b + i64::from(other.numerator) * a, a * b)
    }

    fn times(self, other: Self) -> Option<Self> {
        Self::new(
            i64::from(self.numerator) * i64::from(other.numerator),
            i64::from(self.denominator) * i64::from(other.denominator),
        )
    }
}

impl fmt::Display for Exponent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.numerator, self.denominator) {
            (n, 1) => write!(f, "{n}"),
            (1, 2) => write!(f, "0.5"),
            (n, d) => write!(f, "({n}/{d})"),
        }
    }
}

/// Powers of length (m), time (s), mass (kg), temperature (K) and electric current (A).
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Dimension {
    /// Exponents of m, s, kg, K, A.
    pub exponents: [Exponent; 5],
}

impl Dimension {
    /// A plain number or an angle.
    pub const NONE: Self = Self { exponents: [Exponent::ZERO; 5] };
    /// Length, m.
    pub const LENGTH: Self = Self::base(0);
    /// Time, s.
    pub const TIME: Self = Self::base(1);
    /// Mass, kg.
    pub const MASS: Self = Self::base(2);
    /// Temperature, K.
    pub const TEMPERATURE: Self = Self::base(3);

    /// Electric current, A.
    pub const CURRENT: Self = Self::base(4);

    /// Whether it is that of a load: a force, a torque, a pressure, a current, a voltage.
    pub fn is_of_a_load(self) -> bool {
        let force = Self::MASS * Self::LENGTH / (Self::TIME * Self::TIME);
        let torque = force * Self::LENGTH;
        let pressure = force / (Self::LENGTH * Self::LENGTH);
        let voltage = torque / Self::TIME / Self::CURRENT;
        [force, torque, pressure, Self::CURRENT, voltage].contains(&self)
    }

    const fn base(index: usize) -> Self {
        let mut exponents = [Exponent::ZERO; 5];
        exponents[index] = Exponent { numerator: 1, denominator: 1 };
        Self { exponents }
    }

    /// This dimension to a power. Exponents too large to be meant saturate to none.
    pub fn pow(self, exponent: Exponent) -> Self {
        Self { exponents: self.exponents.map(|own| own.times(exponent).unwrap_or(Exponent::ZERO)) }
    }
}

impl Mul for Dimension {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let mut exponents = self.exponents;
        for (own, theirs) in exponents.iter_mut().zip(other.exponents) {
            *own = own.plus(theirs).unwrap_or(Exponent::ZERO);
        }
        Self { exponents }
    }
}

impl Div for Dimension {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        self * other.pow(Exponent { numerator: -1, denominator: 1 })
    }
}

/// A current is shown where there is one: recorded trials bear a number of what their campaigns state,
/// which was made before there were currents.
impl fmt::Debug for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = if self.exponents[4] == Exponent::ZERO { 4 } else { 5 };
        f.debug_struct("Dimension").field("exponents", &&self.exponents[..shown]).finish()
    }
}

impl fmt::Display for Dimension {
    /// As a unit in SI: `1`, `m`, `m/s^2`, `1/s`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = |positive: bool| {
            ["m", "s", "kg", "K", "A"]
                .iter()
                .zip(self.exponents)
                .filter(|(_, e)| if positive { e.numerator > 0 } else { e.numerator < 0 })
                .map(|(symbol, e)| {
                    let e = Exponent { numerator: e.numerator.abs(), ..e };
                    if e.value() == 1.0 { (*symbol).to_owned() } else { format!("{symbol}^{e}") }
                })
                .collect::<Vec<_>>()
        };
        let (above, below) = (part(true), part(false));
        let above = if above.is_empty() { "1".to_owned() } else { above.join("*") };
        match below.as_slice() {
            [] => write!(f, "{above}"),
            [one] => write!(f, "{above}/{one}"),
            many => write!(f, "{above}/({})", many.join("*")),
        }
    }
}

fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
