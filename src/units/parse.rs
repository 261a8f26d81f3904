//! Reads units (`um/min^0.5`, `m/(rad/s^2)`, `N m/rad`) and quantities (`1.5 arcsec`).

use super::{Dimension, Exponent, QUOTES, Unit, UnitError, row, spelled};
use crate::units::TABLE;

/// How deep parentheses may nest.
const MAXIMUM_DEPTH: usize = 16;

impl Unit {
    /// Reads a unit: known symbols, `*` or a blank, `/`, `^` with a rational power, parentheses;
    /// `degC` alone; `°` and `°C` for `deg` and `degC`, `'` and `"` for `arcmin` and `arcsec`. A blank after `/` is refused, for `m/s rad`
    /// could mean two things.
    ///
    /// # Errors
    /// The part that is not a unit, with the nearest known symbol.
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        if spelled(text.trim()) == "degC" {
            return Ok(Self {
                symbol: "degC".into(),
                factor: 1.0,
                offset: 273.15,
                dimension: Dimension::TEMPERATURE,
            });
        }
        let mut reader = Reader { text, at: 0, depth: 0 };
        let (factor, dimension) = reader.product()?;
        if let Some(rest) = reader.peek() {
            return Err(
                reader.fault(format!("expected `*`, `/` or the end of the unit, found `{rest}`"))
            );
        }
        let in_range = factor.is_finite() && factor > 0.0;
        if !in_range {
            return Err(UnitError {
                message: format!(
                    "the unit `{}` is too large or too small to compute with",
                    text.trim()
                ),
                start: 0,
                end: text.len(),
                help: None,
            });
        }
        Ok(Self { symbol: spelled(text.trim()).into_owned(), factor, offset: 0.0, dimension })
    }
}

/// Reads a number with its unit, `1.5 arcsec` (a plain number has the unit `1`): value in SI, unit.
///
/// # Errors
/// No finite number at the start, or a unit that is not one.
pub fn parse_quantity(text: &str) -> Result<(f64, Unit), UnitError> {
    let lead = text.len() - text.trim_start().len();
    let rest = &text[lead..];
    let length = number_length(rest);
    let number: f64 = rest[..length].parse().map_err(|_| UnitError {
        message: format!("expected a number with its unit, found `{}`", text.trim()),
        start: lead,
        end: text.len(),
        help: Some("write the number first, then its unit, as in \"1.5 arcsec\"".into()),
    })?;
    if !number.is_finite() {
        return Err(UnitError {
            message: format!("`{}` is too large", &rest[..length]),
            start: lead,
            end: lead + length,
            help: None,
        });
    }
    let unit_text = &rest[length..];
    let decimals = unit_text.strip_prefix(',').unwrap_or_default();
    if decimals.starts_with(|c: char| c.is_ascii_digit()) {
        return Err(UnitError {
            message: format!("expected a decimal point, found a comma in `{}`", text.trim()),
            start: lead + length,
            end: lead + length + 1,
            help: Some(format!("write \"{}.{}\"", &rest[..length], decimals.trim_end())),
        });
    }
    if unit_text.trim_start().starts_with('/') {
        let number = &rest[..length];
        return Err(UnitError {
            message: format!("expected a unit, found `{}`", unit_text.trim()),
            start: lead + length,
            end: text.trim_end().len(),
            help: Some(format!(
                "write the 1 of the unit beside the number: \"{number} 1{}\"",
                unit_text.trim()
            )),
        });
    }
    let unit = if unit_text.trim().is_empty() {
        Unit::one()
    } else {
        Unit::parse(unit_text).map_err(|error| UnitError {
            start: error.start + lead + length,
            end: error.end + lead + length,
            ..error
        })?
    };
    Ok((unit.to_si(number), unit))
}

/// Bytes of the decimal number at the start of a text.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        at
    };
    let mut at = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    at = digits(at);
    if bytes.get(at) == Some(&b'.') {
        at = digits(at + 1);
    }
    if matches!(bytes.get(at), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(at + 1), Some(b'+' | b'-')));
        let end = digits(at + 1 + sign);
        if end > at + 1 + sign {
            at = end;
        }
    }
    at
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

type Parsed = Result<(f64, Dimension), UnitError>;

impl Reader<'_> {
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn fault(&self, message: String) -> UnitError {
        let end = self.text[self.at..].chars().next().map_or(self.at, |c| self.at + c.len_utf8());
        UnitError { message, start: self.at, end, help: None }
    }

    fn product(&mut self) -> Parsed {
        let (mut factor, mut dimension) = self.power()?;
        let mut divided = false;
        while let Some(operator) = self.peek() {
            match operator {
                '*' | '/' | '·' => self.at += operator.len_utf8(),
                first if !first.is_alphabetic() && first != '°' => break,
                _ if divided => {
                    return Err(UnitError {
                        help: Some(
                            "write parentheses: `N m/(rad s)`, or the product first: `N m s/rad`"
                                .into(),
                        ),
                        ..self.fault("a product after `/` could mean two things".into())
                    });
                }
                _ => {}
            }
            divided |= operator == '/';
            let (next, next_dimension) = self.power()?;
            if operator == '/' {
                factor /= next;
                dimension = dimension / next_dimension;
            } else {
                factor *= next;
                dimension = dimension * next_dimension;
            }
        }
        Ok((factor, dimension))
    }

    fn power(&mut self) -> Parsed {
        let (factor, dimension) = self.atom()?;
        if self.peek() != Some('^') {
            return Ok((factor, dimension));
        }
        self.at += 1;
        self.peek();
        let parenthesis = self.text[self.at..].starts_with('(');
        if parenthesis {
            self.at += 1;
        }
        let start = self.at;
        let mut exponent = self.number()?;
        if parenthesis && self.peek() == Some('/') {
            self.at += 1;
            self.peek();
            exponent /= self.number()?;
        }
        if parenthesis {
            if self.peek() != Some(')') {
                return Err(self.fault("expected `)` after the exponent".into()));
            }
            self.at += 1;
        }
        let Some(fraction) = Exponent::from_decimal(exponent) else {
            return Err(UnitError {
                message: format!(
                    "`{exponent}` is not a simple fraction: exponents of units are such as 2, 0.5, (1/3)"
                ),
                start,
                end: self.at,
                help: None,
            });
        };
        Ok((factor.powf(fraction.value()), dimension.pow(fraction)))
    }

    fn number(&mut self) -> Result<f64, UnitError> {
        let length = number_length(&self.text[self.at..]);
        match self.text[self.at..self.at + length].parse() {
            Ok(number) => {
                self.at += length;
                Ok(number)
            }
            Err(_) => Err(self.fault("expected a number as exponent".into())),
        }
    }

    fn atom(&mut self) -> Parsed {
        match self.peek() {
            Some('(') => {
                self.depth += 1;
                if self.depth > MAXIMUM_DEPTH {
                    return Err(self.fault(format!("parentheses nest deeper than {MAXIMUM_DEPTH}")));
                }
                self.at += 1;
                let inner = self.product()?;
                if self.peek() != Some(')') {
                    return Err(self.fault("expected `)`".into()));
                }
                self.at += 1;
                self.depth -= 1;
                Ok(inner)
            }
            Some(first)
                if first.is_alphabetic()
                    || matches!(first, '1' | '%' | '°' | '℃')
                    || QUOTES.contains(&first) =>
            {
                let start = self.at;
                let rest = &self.text[start..];
                let end = if matches!(first, '1' | '%') {
                    1
                } else if QUOTES.contains(&first) {
                    rest.find(|c: char| c != first).unwrap_or(rest.len())
                } else {
                    let is_part = |c: char| c.is_alphanumeric() || matches!(c, '_' | '°' | '℃');
                    rest.find(|c: char| !is_part(c)).unwrap_or(rest.len())
                };
                self.at = start + end;
                let symbol = &rest[..end];
                match row(symbol) {
                    Some((_, factor, [powers @ .., _])) => {
                        let exponents = powers.map(|power| {
                            Exponent::new(i64::from(power), 1).unwrap_or(Exponent::ZERO)
                        });
                        Ok((*factor, Dimension { exponents }))
                    }
                    None => Err(unknown(symbol, start)),
                }
            }
            Some(_) => Err(self.fault("expected a unit".into())),
            None => Err(self.fault("expected a unit, found nothing".into())),
        }
    }
}

fn unknown(symbol: &str, start: usize) -> UnitError {
    let help = if spelled(symbol) == "degC" {
        "degC stands alone; in products and differences write K".to_owned()
    } else {
        super::nearest::meant(symbol).unwrap_or_else(|| {
            format!("known units: {}, degC, and their products, quotients and powers", known())
        })
    };
    UnitError {
        message: format!("unknown unit `{symbol}`"),
        start,
        end: start + symbol.len(),
        help: Some(help),
    }
}

/// The symbols of the table, those of a kind together; `µ` has its spelling `u` beside it.
fn known() -> String {
    let mut listed = String::new();
    let mut before = None;
    for (symbol, _, powers) in TABLE.iter().filter(|(symbol, _, _)| symbol.is_ascii()) {
        match before {
            None => {}
            Some(before) if before == powers => listed.push(' '),
            Some(_) => listed.push_str(", "),
        }
        listed.push_str(symbol);
        before = Some(powers);
    }
    listed
}
