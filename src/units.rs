//! Units and dimensions: every number a person writes or reads carries its unit; inside all is SI.
//!
//! An angle counts as a plain number in dimension checks. `degC` stands alone (offset 273.15 K).
//! It does not know about formulas or files.

pub mod dimension;
pub mod display;
mod multiple;
mod nearest;
pub mod parse;

use std::borrow::Cow;

pub use dimension::{Dimension, Exponent};
pub use display::DisplayUnits;
pub use parse::parse_quantity;

/// A unit: what one of it is in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// As written.
    pub symbol: String,
    /// SI value of one unit.
    pub factor: f64,
    /// SI value of zero units (273.15 for degC alone).
    pub offset: f64,
    /// Its dimension.
    pub dimension: Dimension,
}

impl Unit {
    /// The unit of plain numbers, `1`.
    pub fn one() -> Self {
        Self { symbol: "1".into(), factor: 1.0, offset: 0.0, dimension: Dimension::NONE }
    }

    /// The second.
    pub fn second() -> Self {
        Self::coherent(Dimension::TIME)
    }

    /// The coherent SI unit of a dimension.
    pub fn coherent(dimension: Dimension) -> Self {
        Self { symbol: dimension.to_string(), factor: 1.0, offset: 0.0, dimension }
    }

    /// The symbol under which SI values of this unit are written: itself if it is coherent (`rad`,
    /// `m/(rad/s)^2`), `rad` for an angle, else by its dimension.
    pub fn si_symbol(&self) -> String {
        if self.factor == 1.0 && self.offset == 0.0 {
            self.symbol.clone()
        } else if self.is_angle() {
            "rad".to_owned()
        } else {
            self.dimension.to_string()
        }
    }

    /// Whether it is one of angles.
    pub fn is_angle(&self) -> bool {
        names_angle(&self.symbol) && self.dimension == Dimension::NONE
    }

    /// Whether one of angles is a part of it, as of `deg/s`.
    pub(crate) fn has_angle(&self) -> bool {
        self.symbol.split(|c: char| !c.is_alphabetic()).any(names_angle)
    }

    /// Whether a quantity of the unit `stated` may stand where one of this unit is asked for: of
    /// the same dimension, and not without an angle where there is one, which nobody could tell
    /// from degrees or turns.
    pub fn accepts(&self, stated: &Self) -> bool {
        self.dimension == stated.dimension && !self.misses(stated)
    }

    /// Whether `stated` differs by an angle alone that it lacks, as `1/s` from `deg/s`.
    pub fn misses(&self, stated: &Self) -> bool {
        self.dimension == stated.dimension && self.has_angle() && !stated.has_angle()
    }

    /// The unit of differences of values in this one: K for degC, else itself.
    pub fn of_differences(&self) -> Self {
        if self.offset == 0.0 { self.clone() } else { Self::coherent(self.dimension) }
    }

    /// A value in this unit, in SI.
    pub fn to_si(&self, value: f64) -> f64 {
        value * self.factor + self.offset
    }

    /// An SI value, in this unit.
    pub fn from_si(&self, value: f64) -> f64 {
        (value - self.offset) / self.factor
    }
}

/// Numbers from here on are written with a power of ten.
pub const LONG: f64 = 1e15;

/// A number to so many decimals; a very large one with a power of ten, and `-` for none.
pub fn decimal(number: f64, decimals: usize) -> String {
    if number.abs() < LONG {
        format!("{number:.decimals$}")
    } else if number.is_finite() {
        format!("{number:.3e}")
    } else {
        "-".to_owned()
    }
}

/// Ratios below it are written with a power of ten.
const SHORT: f64 = 1e-4;

/// A ratio to so many decimals, a small one to as many as show two significant digits.
pub fn ratio(number: f64, decimals: usize) -> String {
    let size = number.abs();
    if size >= 10.0_f64.powi(1 - decimals as i32) || size == 0.0 || size.is_nan() {
        decimal(number, decimals)
    } else if size >= SHORT {
        decimal(number, (1.0 - size.log10().floor()) as usize)
    } else {
        format!("{number:.1e}")
    }
}

/// Why a unit or a quantity could not be read; `start..end` are bytes of the text given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct UnitError {
    /// What was found and expected.
    pub message: String,
    /// First byte of the offending part.
    pub start: usize,
    /// One past its last byte.
    pub end: usize,
    /// What to do.
    pub help: Option<String>,
}

/// One row of the unit table: symbol, factor to SI, exponents of m, s, kg, K, A and rad.
///
/// The last one says that a unit holds an angle. No dimension check counts it, see
/// [`Unit::accepts`].
pub type Row = (&'static str, f64, [i16; 6]);

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const GON: f64 = std::f64::consts::PI / 200.0;
const TURN: f64 = std::f64::consts::TAU;

/// The known units. To add a unit, add a row: which units are angles and which ones a message lists
/// follow from it. `tests/number/units.rs` then asks for it in `docs/formats.md`.
pub const TABLE: &[Row] = &[
    ("1", 1.0, [0, 0, 0, 0, 0, 0]),
    ("m", 1.0, [1, 0, 0, 0, 0, 0]),
    ("km", 1e3, [1, 0, 0, 0, 0, 0]),
    ("cm", 1e-2, [1, 0, 0, 0, 0, 0]),
    ("mm", 1e-3, [1, 0, 0, 0, 0, 0]),
    ("um", 1e-6, [1, 0, 0, 0, 0, 0]),
    ("µm", 1e-6, [1, 0, 0, 0, 0, 0]),
    ("nm", 1e-9, [1, 0, 0, 0, 0, 0]),
    ("in", 0.0254, [1, 0, 0, 0, 0, 0]),
    ("ft", 0.3048, [1, 0, 0, 0, 0, 0]),
    ("L", 1e-3, [3, 0, 0, 0, 0, 0]),
    ("mL", 1e-6, [3, 0, 0, 0, 0, 0]),
    ("s", 1.0, [0, 1, 0, 0, 0, 0]),
    ("ms", 1e-3, [0, 1, 0, 0, 0, 0]),
    ("us", 1e-6, [0, 1, 0, 0, 0, 0]),
    ("µs", 1e-6, [0, 1, 0, 0, 0, 0]),
    ("ns", 1e-9, [0, 1, 0, 0, 0, 0]),
    ("min", 60.0, [0, 1, 0, 0, 0, 0]),
    ("h", 3600.0, [0, 1, 0, 0, 0, 0]),
    ("d", 86_400.0, [0, 1, 0, 0, 0, 0]),
    ("kn", 1852.0 / 3600.0, [1, -1, 0, 0, 0, 0]),
    ("mph", 0.44704, [1, -1, 0, 0, 0, 0]),
    ("rad", 1.0, [0, 0, 0, 0, 0, 1]),
    ("mrad", 1e-3, [0, 0, 0, 0, 0, 1]),
    ("urad", 1e-6, [0, 0, 0, 0, 0, 1]),
    ("µrad", 1e-6, [0, 0, 0, 0, 0, 1]),
    ("deg", DEGREE, [0, 0, 0, 0, 0, 1]),
    ("mdeg", DEGREE * 1e-3, [0, 0, 0, 0, 0, 1]),
    ("arcmin", DEGREE / 60.0, [0, 0, 0, 0, 0, 1]),
    ("arcsec", DEGREE / 3600.0, [0, 0, 0, 0, 0, 1]),
    ("gon", GON, [0, 0, 0, 0, 0, 1]),
    ("mgon", GON * 1e-3, [0, 0, 0, 0, 0, 1]),
    ("turn", TURN, [0, 0, 0, 0, 0, 1]),
    ("rev", TURN, [0, 0, 0, 0, 0, 1]),
    ("rpm", TURN / 60.0, [0, -1, 0, 0, 0, 1]),
    ("Hz", 1.0, [0, -1, 0, 0, 0, 0]),
    ("kHz", 1e3, [0, -1, 0, 0, 0, 0]),
    ("MHz", 1e6, [0, -1, 0, 0, 0, 0]),
    ("Bd", 1.0, [0, -1, 0, 0, 0, 0]),
    ("ppm", 1e-6, [0, 0, 0, 0, 0, 0]),
    ("%", 1e-2, [0, 0, 0, 0, 0, 0]),
    ("count", 1.0, [0, 0, 0, 0, 0, 0]),
    ("counts", 1.0, [0, 0, 0, 0, 0, 0]),
    ("K", 1.0, [0, 0, 0, 1, 0, 0]),
    ("mK", 1e-3, [0, 0, 0, 1, 0, 0]),
    ("kg", 1.0, [0, 0, 1, 0, 0, 0]),
    ("g", 1e-3, [0, 0, 1, 0, 0, 0]),
    ("mg", 1e-6, [0, 0, 1, 0, 0, 0]),
    ("t", 1e3, [0, 0, 1, 0, 0, 0]),
    ("lb", 0.453_592_37, [0, 0, 1, 0, 0, 0]),
    ("N", 1.0, [1, -2, 1, 0, 0, 0]),
    ("kN", 1e3, [1, -2, 1, 0, 0, 0]),
    ("mN", 1e-3, [1, -2, 1, 0, 0, 0]),
    ("kgf", 9.806_65, [1, -2, 1, 0, 0, 0]),
    ("lbf", 4.448_221_615_260_5, [1, -2, 1, 0, 0, 0]),
    ("J", 1.0, [2, -2, 1, 0, 0, 0]),
    ("kJ", 1e3, [2, -2, 1, 0, 0, 0]),
    ("Nm", 1.0, [2, -2, 1, 0, 0, 0]),
    ("mNm", 1e-3, [2, -2, 1, 0, 0, 0]),
    ("W", 1.0, [2, -3, 1, 0, 0, 0]),
    ("kW", 1e3, [2, -3, 1, 0, 0, 0]),
    ("mW", 1e-3, [2, -3, 1, 0, 0, 0]),
    ("hPa", 100.0, [-1, -2, 1, 0, 0, 0]),
    ("Pa", 1.0, [-1, -2, 1, 0, 0, 0]),
    ("kPa", 1e3, [-1, -2, 1, 0, 0, 0]),
    ("MPa", 1e6, [-1, -2, 1, 0, 0, 0]),
    ("bar", 1e5, [-1, -2, 1, 0, 0, 0]),
    ("mbar", 100.0, [-1, -2, 1, 0, 0, 0]),
    ("psi", 6_894.757_293_168_361, [-1, -2, 1, 0, 0, 0]),
    ("A", 1.0, [0, 0, 0, 0, 1, 0]),
    ("mA", 1e-3, [0, 0, 0, 0, 1, 0]),
    ("uA", 1e-6, [0, 0, 0, 0, 1, 0]),
    ("µA", 1e-6, [0, 0, 0, 0, 1, 0]),
    ("V", 1.0, [2, -3, 1, 0, -1, 0]),
    ("kV", 1e3, [2, -3, 1, 0, -1, 0]),
    ("mV", 1e-3, [2, -3, 1, 0, -1, 0]),
    ("uV", 1e-6, [2, -3, 1, 0, -1, 0]),
    ("µV", 1e-6, [2, -3, 1, 0, -1, 0]),
    ("ohm", 1.0, [2, -3, 1, 0, -2, 0]),
    ("T", 1.0, [0, -2, 1, 0, -1, 0]),
    ("mT", 1e-3, [0, -2, 1, 0, -1, 0]),
    ("uT", 1e-6, [0, -2, 1, 0, -1, 0]),
    ("µT", 1e-6, [0, -2, 1, 0, -1, 0]),
    ("nT", 1e-9, [0, -2, 1, 0, -1, 0]),
    ("G", 1e-4, [0, -2, 1, 0, -1, 0]),
    ("mG", 1e-7, [0, -2, 1, 0, -1, 0]),
];

/// Other characters for what is in the table: the degree sign, primes and quotes for minutes and seconds
/// of arc (a quote inside quotes is doubled), and the Greek letter in place of the micro sign.
const SPELLINGS: [(&str, &str); 9] = [
    ("°", "deg"),
    ("℃", "degC"),
    ("\"\"", "arcsec"),
    ("\"", "arcsec"),
    ("\u{2033}", "arcsec"),
    ("''", "arcsec"),
    ("'", "arcmin"),
    ("\u{2032}", "arcmin"),
    ("\u{3bc}", "\u{b5}"),
];
/// Characters that are a unit by themselves, without letters beside them.
const QUOTES: [char; 4] = ['"', '\'', '\u{2032}', '\u{2033}'];

/// A text in the characters of the table; most are.
fn spelled(text: &str) -> Cow<'_, str> {
    if text.is_ascii() && !text.contains(QUOTES) {
        return Cow::Borrowed(text);
    }
    let replaced = |text: String, (other, own): &(&str, &str)| text.replace(other, own);
    Cow::Owned(SPELLINGS.iter().fold(text.to_owned(), replaced))
}

/// The row of a symbol.
fn row(symbol: &str) -> Option<&'static Row> {
    let symbol = spelled(symbol);
    TABLE.iter().find(|(known, _, _)| *known == symbol)
}

/// Whether a symbol of the table is that of an angle.
fn names_angle(symbol: &str) -> bool {
    row(symbol).is_some_and(|(_, _, [.., angle])| *angle != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_ratio_keeps_two_significant_digits() {
        let shown = [1.486, 0.024, 0.00031, 0.0000127, 0.0, -0.0049].map(|value| ratio(value, 2));
        assert_eq!(shown, ["1.49", "0.024", "0.00031", "1.3e-5", "0.00", "-0.0049"]);
        assert_eq!(ratio(f64::INFINITY, 2), "-");
    }
}
