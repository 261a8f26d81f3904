//! The known unit that is a multiple of another one.

use crate::units::{TABLE, Unit};

/// Relative rounding of factors.
const SAME: f64 = 1e-9;

impl Unit {
    /// The known unit that is so many of this one, as `deg/s` is pi/180 of `rad/s`: a symbol of the table for
    /// all of it, or for what is before its first sign.
    pub(crate) fn times(&self, factor: f64) -> Option<Self> {
        let sign = self.symbol.find(['/', '*', ' ', '^']).unwrap_or(self.symbol.len());
        let rest = &self.symbol[sign..];
        let is_it = |other: &Self| {
            let is_like = self.accepts(other) && other.accepts(self);
            let ratio = other.factor / (self.factor * factor);
            is_like && self.offset == 0.0 && other.offset == 0.0 && (ratio - 1.0).abs() < SAME
        };
        let with = |rest: &str| {
            let all =
                TABLE.iter().filter_map(|(own, ..)| Self::parse(&format!("{own}{rest}")).ok());
            all.into_iter().find(is_it)
        };
        with("").or_else(|| with(rest))
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::Unit;

    #[test]
    fn multiples_of_units_have_their_symbols() {
        let degree = 1_f64.to_radians();
        for (unit, factor, other) in [
            ("rad", degree, Some("deg")),
            ("deg", 1.0 / degree, Some("rad")),
            ("rad/s", degree, Some("deg/s")),
            ("deg", 0.9, Some("gon")),
            ("m", 1e-3, Some("mm")),
            ("m/s^2", 1e-3, Some("mm/s^2")),
            ("m", -1.0, None),
            ("m", 3.3, None),
            ("degC", 1e-3, None),
        ] {
            let found = Unit::parse(unit).unwrap().times(factor);
            assert_eq!(found.map(|one| one.symbol).as_deref(), other, "{unit} {factor}");
        }
    }
}
