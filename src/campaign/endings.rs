//! Units that people write at the end of a name: `x_mm`, `heading_deg`.

/// Endings of names that are units, and the units.
const ENDINGS: [(&str, &str); 28] = [
    ("s", "s"),
    ("sec", "s"),
    ("secs", "s"),
    ("seconds", "s"),
    ("ms", "ms"),
    ("msec", "ms"),
    ("us", "us"),
    ("usec", "us"),
    ("ns", "ns"),
    ("nsec", "ns"),
    ("nanoseconds", "ns"),
    ("m", "m"),
    ("meters", "m"),
    ("metres", "m"),
    ("mm", "mm"),
    ("cm", "cm"),
    ("um", "um"),
    ("km", "km"),
    ("rad", "rad"),
    ("radians", "rad"),
    ("mrad", "mrad"),
    ("deg", "deg"),
    ("degrees", "deg"),
    ("arcsec", "arcsec"),
    ("gon", "gon"),
    ("mps", "m/s"),
    ("rpm", "rpm"),
    ("hz", "Hz"),
];

/// Parts of the names of columns that hold the decimals of seconds, and their unit.
const DECIMALS: [(&str, &str); 5] =
    [("nano", "ns"), ("nsec", "ns"), ("micro", "us"), ("usec", "us"), ("msec", "ms")];

/// The unit of the decimals of seconds that a column of this name holds.
pub(crate) fn decimals(name: &str) -> Option<&'static str> {
    let small = name.to_lowercase();
    DECIMALS.iter().find(|(own, _)| small.contains(own)).map(|(_, unit)| *unit)
}

/// The unit that the ending of a name is, as `deg` of `heading_deg`.
pub(crate) fn ending(name: &str) -> Option<&'static str> {
    let small = name.to_lowercase();
    let (_, ending) = small.rsplit_once('_')?;
    ENDINGS.iter().find(|(own, _)| *own == ending).map(|(_, unit)| *unit)
}
