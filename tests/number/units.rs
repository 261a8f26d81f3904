//! Units: values, dimensions, places of faults.

use homepoint::units::{Dimension, Exponent, TABLE, Unit, parse_quantity};
use proptest::prelude::*;

#[test]
fn known_units_have_their_si_value() {
    let degree = std::f64::consts::PI / 180.0;
    for (text, value, dimension) in [
        ("m", 1.0, Dimension::LENGTH),
        ("um", 1e-6, Dimension::LENGTH),
        ("gon", std::f64::consts::PI / 200.0, Dimension::NONE),
        ("arcsec", degree / 3600.0, Dimension::NONE),
        ("rad/s", 1.0, Dimension::NONE / Dimension::TIME),
        ("m/(rad/s^2)", 1.0, Dimension::LENGTH * Dimension::TIME * Dimension::TIME),
        ("um/h", 1e-6 / 3600.0, Dimension::LENGTH / Dimension::TIME),
        ("deg / s^2", degree, Dimension::NONE / Dimension::TIME / Dimension::TIME),
        ("1/s", 1.0, Dimension::NONE / Dimension::TIME),
        ("ppm", 1e-6, Dimension::NONE),
        ("\"", degree / 3600.0, Dimension::NONE),
        ("\u{2033}/s", degree / 3600.0, Dimension::NONE / Dimension::TIME),
        ("''", degree / 3600.0, Dimension::NONE),
        ("'", degree / 60.0, Dimension::NONE),
        ("\u{2032}", degree / 60.0, Dimension::NONE),
    ] {
        let unit = Unit::parse(text).unwrap();
        assert!((unit.factor / value - 1.0).abs() < 1e-15, "{text}: {}", unit.factor);
        assert_eq!(unit.dimension, dimension, "{text}");
    }
    let walk = Unit::parse("um/min^0.5").unwrap();
    assert!((walk.factor / (1e-6 / 60_f64.sqrt()) - 1.0).abs() < 1e-15);
    assert_eq!(
        walk.dimension,
        Dimension::LENGTH / Dimension::TIME.pow(Exponent::new(1, 2).unwrap())
    );
}

#[test]
fn degrees_celsius_stand_alone_with_their_offset() {
    let (value, unit) = parse_quantity("20.1 degC").unwrap();
    assert!((value - 293.25).abs() < 1e-12);
    assert!((unit.from_si(value) - 20.1).abs() < 1e-12);
    let error = Unit::parse("um/degC").unwrap_err();
    assert_eq!((error.start, error.end), (3, 7));
    assert!(error.help.unwrap().contains("write K"));
}

#[test]
fn faults_point_at_the_part_meant() {
    let error = parse_quantity("1.5 arcsex").unwrap_err();
    assert_eq!((error.start, error.end), (4, 10));
    assert_eq!(error.help.as_deref(), Some("did you mean `arcsec`?"));
    let comma = parse_quantity("1,5 mm").unwrap_err();
    assert_eq!(comma.help.as_deref(), Some("write \"1.5 mm\""));
    assert!(parse_quantity("fast").is_err());
    assert!(parse_quantity("1e999 m").is_err());
    assert!(parse_quantity("").is_err());
    assert!(Unit::parse(&"(".repeat(100_000)).is_err());
    assert!(Unit::parse("m^1e9").is_err());
    assert!(Unit::parse("m 2").is_err());
}

#[test]
fn a_dimension_reads_as_its_si_unit() {
    for text in ["1", "m", "m/s^2", "1/s", "m/s^0.5", "kg/(m*s^2)"] {
        let text = text.to_owned();
        let shown = Unit::parse(&text.replace("kg/(m*s^2)", "hPa")).unwrap().dimension.to_string();
        assert_eq!(shown.replace("kg/(m*s^2)", "x"), text.replace("kg/(m*s^2)", "x"));
    }
}

/// Each value is that of the SI brochure, of a compound its product worked out by hand.
#[test]
fn units_of_mechanics_and_electricity_have_their_si_value() {
    let tau = std::f64::consts::TAU;
    for (text, value, dimension) in [
        ("9.81 m/s^2", 9.81, "m/s^2"),
        ("3 N m", 3.0, "m^2*kg/s^2"),
        ("250 mN m", 0.25, "m^2*kg/s^2"),
        ("250 mNm", 0.25, "m^2*kg/s^2"),
        ("2 N m/rad", 2.0, "m^2*kg/s^2"),
        ("4 N m/(rad s)", 4.0, "m^2*kg/s^3"),
        ("2 rad s", 2.0, "s"),
        ("0.5 %", 0.005, "1"),
        ("0.5%", 0.005, "1"),
        ("12 cm", 0.12, "m"),
        ("3 km/h", 3.0 / 3.6, "m/s"),
        ("1 in", 0.0254, "m"),
        ("60 L/min", 1e-3, "m^3/s"),
        ("3 mL", 3e-6, "m^3"),
        ("5 g", 0.005, "kg"),
        ("2 t", 2000.0, "kg"),
        ("0.02 kg m^2", 0.02, "m^2*kg"),
        ("7 kN", 7000.0, "m*kg/s^2"),
        ("1 MPa", 1e6, "kg/(m*s^2)"),
        ("2 bar", 2e5, "kg/(m*s^2)"),
        ("1013 mbar", 101_300.0, "kg/(m*s^2)"),
        ("10 kgf", 98.0665, "m*kg/s^2"),
        ("2 lb", 0.907_184_74, "kg"),
        ("5 mK", 0.005, "K"),
        ("3 mV", 0.003, "m^2*kg/(s^3*A)"),
        ("20 mA", 0.02, "A"),
        ("0.1 N m/A", 0.1, "m^2*kg/(s^2*A)"),
        ("60 W", 60.0, "m^2*kg/s^3"),
        ("2 J", 2.0, "m^2*kg/s^2"),
        ("4096 counts", 4096.0, "1"),
        ("30 rpm", tau / 2.0, "1/s"),
        ("30 rev/min", tau / 2.0, "1/s"),
        ("0.25 turn", tau / 4.0, "1"),
        ("50 mdeg", 0.05 * tau / 360.0, "1"),
    ] {
        let (found, unit) = parse_quantity(text).unwrap();
        assert!((found / value - 1.0).abs() < 1e-15, "{text}: {found}");
        assert_eq!(unit.dimension.to_string(), dimension, "{text}");
    }
    assert!(!Unit::parse("rpm").unwrap().is_angle());
    assert!(Unit::parse("rad/s").unwrap().accepts(&Unit::parse("rpm").unwrap()));
    let error = Unit::parse("m/s rad").unwrap_err();
    assert_eq!((error.start, error.end), (4, 5));
}

#[test]
fn another_spelling_is_told_its_symbol() {
    for (text, symbol) in [
        ("degrees", "deg"),
        ("seconds", "s"),
        ("Sec", "s"),
        ("meter", "m"),
        ("RPM", "rpm"),
        ("hz", "Hz"),
        ("KG", "kg"),
        ("percent", "%"),
        ("Newton", "N"),
        ("arcsex", "arcsec"),
    ] {
        let help = Unit::parse(text).unwrap_err().help.unwrap();
        assert_eq!(help, format!("did you mean `{symbol}`?"), "{text}");
    }
}

/// The degree sign and the Greek letter in place of the micro sign are other characters for known symbols.
#[test]
fn other_characters_are_known_symbols() {
    for (text, symbol) in [
        ("°", "deg"),
        ("°/s", "deg/s"),
        ("m°/h", "mdeg/h"),
        ("°C", "degC"),
        (" ℃", "degC"),
        ("\u{3bc}m", "\u{b5}m"),
        ("\u{3bc}rad/(m °)", "\u{b5}rad/(m deg)"),
    ] {
        assert_eq!(Unit::parse(text), Unit::parse(symbol), "{text}");
    }
    assert!(Unit::parse("°").unwrap().is_angle());
    assert!(Unit::parse("deg/s").unwrap().accepts(&Unit::parse("°/s").unwrap()));
    let error = Unit::parse("mm/°C").unwrap_err();
    assert!(error.help.unwrap().contains("write K"));
}

/// A suggestion of another size would be a wrong scale.
#[test]
fn no_unit_of_another_size_is_suggested() {
    for text in ["dm", "MN", "Ms", "mi", "Nmm", "NM", "cN", "Mm", "hm", "mm2", "x"] {
        let help = Unit::parse(text).unwrap_err().help.unwrap();
        assert!(help.starts_with("known units: "), "{text}: {help}");
    }
    for text in ["grad", "Grad", "Grade", "grads"] {
        let help = Unit::parse(text).unwrap_err().help.unwrap();
        assert!(help.contains("`gon` (400") && help.contains("`deg` (360"), "{text}: {help}");
    }
}

#[test]
fn a_quotient_without_its_one_is_answered_with_it() {
    let error = parse_quantity("1e-5/K").unwrap_err();
    assert_eq!((error.start, error.end), (4, 6));
    assert!(error.help.unwrap().contains("\"1e-5 1/K\""));
    assert_eq!(parse_quantity("1e-5 1/K").unwrap().0, 1e-5);
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "\\PC*") {
        let _ = Unit::parse(&text);
        if let Err(error) = parse_quantity(&text) {
            prop_assert!(error.start <= error.end && error.end <= text.len());
        }
    }

    #[test]
    fn a_value_returns_from_si(value in -1e6..1e6_f64) {
        for text in ["gon", "degC", "um/min^0.5", "hPa"] {
            let unit = Unit::parse(text).unwrap();
            prop_assert!((unit.from_si(unit.to_si(value)) - value).abs() <= 1e-9 * value.abs().max(1.0));
        }
    }
}

#[test]
fn si_values_keep_a_symbol_that_says_what_they_are() {
    let symbols = [
        ("rad", "rad"),
        ("arcsec", "rad"),
        ("um", "m"),
        ("m/(rad/s)^2", "m/(rad/s)^2"),
        ("ppm", "1"),
        ("um/h", "m/s"),
        ("urad/m", "1/m"),
        ("degC", "K"),
    ];
    for (text, symbol) in symbols {
        assert_eq!(Unit::parse(text).unwrap().si_symbol(), symbol, "{text}");
    }
}

/// Rows of the table with the exponent of the angle are angles, and no others: no second list.
#[test]
fn an_angle_takes_no_plain_number() {
    let unit = |symbol: &str| Unit::parse(symbol).unwrap();
    for (symbol, _, [length, time, mass, temperature, current, angle]) in TABLE {
        let own = unit(symbol);
        assert_eq!(own.is_angle(), *angle == 1 && *time == 0, "{symbol}");
        let rate = unit(&format!("{symbol}/s"));
        assert_eq!(rate.misses(&Unit::coherent(rate.dimension)), *angle == 1, "{symbol}");
        if own.is_angle() {
            assert_eq!([length, time, mass, temperature, current], [&0; 5], "{symbol}");
            assert!(!own.accepts(&Unit::one()) && own.accepts(&unit("gon")), "{symbol}");
            assert!(!own.accepts(&unit("m")) && own.si_symbol() == "rad", "{symbol}");
        }
    }
    for plain in ["1", "ppm", "%", "counts"] {
        assert!(!unit(plain).is_angle() && unit(plain).accepts(&Unit::one()), "{plain}");
    }
    assert!(unit("mm").accepts(&unit("m")) && !unit("mm").accepts(&Unit::one()));
}

#[test]
fn a_message_and_the_guide_list_every_unit() {
    let help = Unit::parse("furlong").unwrap_err().help.unwrap();
    let guide = include_str!("../../docs/formats.md");
    let (_, guide) = guide.split_once("Known: ").unwrap();
    let (guide, _) = guide.split_once("products,").unwrap();
    for text in [help.as_str(), guide] {
        let listed: Vec<&str> = text.split([' ', '\n', ',', ';', '`']).collect();
        for (symbol, ..) in TABLE {
            let plain = symbol.replace('µ', "u");
            assert!(listed.contains(&plain.as_str()), "{symbol} is not in: {text}");
        }
    }
}

/// A pound-force is the weight of a pound, and a pound-force on a square inch the pressure.
#[test]
fn pounds_force_follow_from_pounds() {
    let si = |text: &str| parse_quantity(text).unwrap().0;
    assert!((si("1 lbf") - si("1 lb") * 9.806_65).abs() < 1e-12);
    assert!((si("1 psi") - si("1 lbf") / si("1 in").powi(2)).abs() < 1e-9);
}
