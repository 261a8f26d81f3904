//! Angles in degrees, minutes and seconds: `094:10:49.3`, `94°10'49.3"`, `94d10m49.3s`, `094 10 49.3`.

use crate::diagnostic::Diagnostic;
use crate::units::Unit;

/// What stands behind degrees, minutes and seconds; a quote within a quoted cell is two.
const FORMS: [[&str; 3]; 8] = [
    [":", ":", ""],
    ["°", "'", "\"\""],
    ["°", "'", "\""],
    ["°", "'", "''"],
    ["°", "\u{2032}", "\u{2033}"],
    ["°", "'", ""],
    ["d", "m", "s"],
    [" ", " ", ""],
];
/// Units of a header that such a column may have.
const UNITS: [&str; 4] = ["dms", "deg", "°", ""];

/// What is expected of a cell.
pub(crate) const EXPECTED: &str = "degrees, minutes and seconds are written as 94:10:49.3 or 94°10'49.3\", minutes and seconds below 60; the sign holds for all three";

/// The degrees (of arc) of such a cell; `None` for anything else.
pub(crate) fn degrees(cell: &str) -> Option<f64> {
    let (sign, size) = match cell.strip_prefix(['-', '\u{2212}']) {
        Some(rest) => (-1.0, rest),
        None => (1.0, cell.strip_prefix('+').unwrap_or(cell)),
    };
    FORMS
        .iter()
        .find_map(|form| parts(size, form))
        .map(|[degrees, minutes, seconds]| sign * (degrees + (minutes + seconds / 60.0) / 60.0))
}

/// The three numbers of a cell of one form.
fn parts(
    size: &str,
    [behind_degrees, behind_minutes, behind_seconds]: &[&str; 3],
) -> Option<[f64; 3]> {
    let (degrees, rest) = size.split_once(behind_degrees)?;
    let (minutes, rest) = rest.trim_start().split_once(behind_minutes)?;
    let seconds = rest.trim_start().strip_suffix(behind_seconds)?.trim_end();
    let (whole, decimals) = seconds.split_once(['.', ',']).unwrap_or((seconds, "0"));
    let are_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let is_count = |text: &str, most: usize| (1..=most).contains(&text.len()) && are_digits(text);
    let is_sound =
        is_count(degrees, 3) && is_count(minutes, 2) && is_count(whole, 2) && are_digits(decimals);
    let number = |text: &str| text.parse::<f64>().ok();
    let found = [
        number(degrees).filter(|_| is_sound)?,
        number(minutes)?,
        number(&format!("{whole}.{decimals}"))?,
    ];
    (found[1] < 60.0 && found[2] < 60.0).then_some(found)
}

/// The unit of a column of such cells, beside that of its header; a fault where that is another one.
pub(crate) fn unit_of(
    name: &str,
    in_header: Option<&str>,
    stated: Option<&Unit>,
) -> Result<Unit, Diagnostic> {
    let header = in_header.unwrap_or_default().trim();
    let other = match stated {
        Some(stated) => Some(stated.symbol.as_str()).filter(|symbol| *symbol != "deg"),
        None => Some(header).filter(|header| !UNITS.contains(header)),
    };
    match other {
        Some(other) => {
            let message = format!(
                "the column `{name}` holds degrees, minutes and seconds, but its unit is `{other}`"
            );
            let help =
                format!("write `{name} [dms]`, or `{name} [deg]`; hours of angle are not read");
            Err(Diagnostic::error(message).help(help))
        }
        None => Ok(Unit::parse("deg").unwrap_or_else(|_| Unit::one())),
    }
}

#[cfg(test)]
mod tests {
    use super::degrees;

    #[test]
    fn degrees_minutes_and_seconds_are_one_number() {
        let east = 94.0 + (10.0 + 49.3 / 60.0) / 60.0;
        for cell in [
            "094:10:49.3",
            "+94:10:49.3",
            "94°10'49.3\"",
            "94°10'49.3\"\"",
            "94° 10' 49.3''",
            "94°10\u{2032}49.3\u{2033}",
            "94d10m49.3s",
            "094 10 49.3",
            "94:10:49,3",
        ] {
            assert_eq!(degrees(cell), Some(east), "{cell}");
        }
        // The sign holds where the degrees are zero, too.
        assert_eq!(degrees("-00:30:36"), Some(-0.51));
        assert_eq!(degrees("\u{2212}0 30 36"), Some(-0.51));
        for cell in [
            "",
            "94",
            "94.5",
            "-",
            "94:10",
            "94:60:00",
            "94:10:60",
            "94:-10:49",
            "94:10:",
            "94::49",
            "1e2:10:10",
            "94:10.5:49",
            "94:10:49:1",
            "94°10:49",
            "94d10m49.3",
            "94 10 49 3",
            "9410:1:1",
        ] {
            assert_eq!(degrees(cell), None, "{cell}");
        }
    }
}
