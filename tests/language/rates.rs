//! `rate` against dual numbers in the moment and against finite differences, at singular points
//! too.

use homepoint::graph::{Assembly, Kind};
use homepoint::number::{Dual, Number, derivative, variable};
use proptest::prelude::*;

use crate::bench::{Declared, Sample, measurand};

const FORMULAS: &[&str] = &[
    "sin(a) * cos(b) + tan(a / 3)",
    "asin(sin(a) / 3) + acos(cos(b) / 2) + atan(a * b)",
    "atan2(sin(a), 0.3 + b)",
    "hypot(sin(a), b) + sqrt(2 + sin(b))",
    "exp(-a) * log(3 + b) / (2 + sin(a))",
    "abs(sin(a)) + tanh(a - b) + fract(a) + floor(b) * a",
    "min(a, b, 1) * max(sin(a), cos(b))",
    "(2 + sin(a))^2.7 + (2 + sin(a))^b + a^3 + (3 + a)^-2 + (4 + b)^1.5",
    "norm(rotate(rotation_x(a) * turn([a, b, 0.1]), [1, b, a]) + [2, 0, 0])",
    "rotate(inverse(rotation([1, a, b], b)), normalize([a, b, 1])).x",
    "dot([a, b, 1], cross([b, 1, a], rotate(quaternion(2, a, b, 0.3), [1, 0, 0])))",
    "a * (time / 1 s)^2 + uniform_time / 1 s + index * moment / 1 s",
    "rate(a) * 1 s + a * (rate(rate(b)) * 1 s^2)",
];

/// The formula as `value` and its rate as `rate`.
fn pair(text: &str) -> Assembly {
    Declared::default()
        .input("a", "1", true)
        .input("b", "1", true)
        .parameter("p", Kind::Vector, "1")
        .measurand("value", text, "1")
        .measurand("rate", &format!("rate({text})"), "1/s")
        .assemble()
}

fn check(assembly: &Assembly, text: &str, time: f64) -> Result<(), TestCaseError> {
    let dual = measurand(assembly, "value", &Sample::at(variable(time)));
    let rate = measurand(assembly, "rate", &Sample::at(time));
    let expected = derivative(dual);
    prop_assert!(
        (rate - expected).abs() <= 1e-12 * (1.0 + expected.abs()),
        "{text} at {time}: rate {rate}, dual {expected}"
    );
    let at = |t: f64| measurand(assembly, "value", &Sample::at(t));
    let h = 1e-5;
    let difference = (8.0 * (at(time + h) - at(time - h))
        - (at(time + 2.0 * h) - at(time - 2.0 * h)))
        / (12.0 * h);
    // Only where no jump or kink is near.
    if (at(time + h) + at(time - h) - 2.0 * at(time)).abs() < 1e-7 {
        prop_assert!(
            (rate - difference).abs() <= 1e-7 * (1.0 + rate.abs()),
            "{text} at {time}: rate {rate}, difference {difference}"
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn rates_agree_with_dual_numbers_and_differences(time in 0.0f64..4.0) {
        for text in FORMULAS {
            check(&pair(text), text, time)?;
        }
    }
}

#[test]
fn rates_nest() {
    let assembly = Declared::default()
        .input("a", "1", true)
        .measurand("first", "rate(sin(a)^2 * time)", "1")
        .measurand("second", "rate(rate(sin(a)^2 * time))", "1/s")
        .assemble();
    for time in [0.0, 0.4, 1.7] {
        let dual = measurand(&assembly, "first", &Sample::at(variable(time)));
        let second = measurand(&assembly, "second", &Sample::at(time));
        assert!((derivative(dual) - second).abs() < 1e-13 * (1.0 + second.abs()));
    }
}

/// Derivatives at points where formulas are careless; the argument is `time`, the point time zero.
#[test]
fn rates_at_singular_points_are_the_conventions_of_the_numbers() {
    for (text, expected) in [
        ("rotate(turn([u, 0, 0]), [0, 1, 0]).z", 1.0),
        ("rotate(turn([0, 0, 0]), [u, 1, 0]).x", 1.0),
        ("rotate(rotation([0, 0, 0], u), [0, 1, 0]).z", 0.0),
        ("norm([u, u, u])", 0.0),
        ("hypot(u, 2 * u)", 0.0),
        ("sqrt(u)", 0.0),
        ("abs(u)", 0.0),
        ("atan2(u, u)", 0.0),
        ("atan2(u, 1)", 1.0),
        ("atan2(1, u)", -1.0),
        ("asin(1 - u)", 0.0),
        ("acos(1 - u)", 0.0),
        ("acos(u - 1)", 0.0),
        ("normalize([u, 0, 0]).x", 0.0),
        ("min(u, 2 * u)", 1.0),
        ("max(u, 2 * u)", 1.0),
        ("u^2 + u^3 + u", 1.0),
        ("sign(u) + floor(u)", 0.0),
        ("fract(u)", 1.0),
    ] {
        let assembly = Declared::default()
            .quantity("u", "time / 1 s")
            .measurand("value", text, "1")
            .measurand("rate", &format!("rate({text})"), "1/s")
            .assemble();
        let rate = measurand(&assembly, "rate", &Sample::at(0.0));
        let dual: Dual = measurand(&assembly, "value", &Sample::at(variable(0.0)));
        assert_eq!(rate, expected, "rate of {text}");
        assert_eq!(derivative(dual), expected, "dual of {text}");
        let second = derivative(measurand(&assembly, "rate", &Sample::at(variable(0.0))));
        assert!(second.is_finite(), "second derivative of {text}");
    }
}

#[test]
fn a_small_turn_is_smooth_through_zero() {
    let assembly = Declared::default()
        .input("a", "1", true)
        .parameter("p", Kind::Vector, "1")
        .measurand("m", "rotate(turn(p), [1, 2, 3]).x", "1")
        .assemble();
    // At zero: p × v, so d/dp_y = 3, d/dp_z = -2.
    for (component, expected) in [(0, 0.0), (1, 3.0), (2, -2.0)] {
        let mut p = [<Dual as Number>::constant(0.0); 3];
        p[component] = variable(0.0);
        let sample = Sample::at(<Dual as Number>::constant(0.0)).with(&assembly.names, "p", &p);
        let m = measurand(&assembly, "m", &sample);
        assert_eq!((m.value(), derivative(m)), (1.0, expected));
    }
}

#[test]
fn parameters_and_t_stand_still_and_the_moment_moves() {
    let model = |text: &str| {
        Declared::default()
            .input("a", "1", true)
            .parameter("p", Kind::Scalar, "1")
            .measurand("m", &format!("1 s * rate({text})"), "1")
            .effect("late", &[("k", "s")], &[("t", "t + k * sin(a)")])
            .assemble()
    };
    for (text, expected) in [
        ("t / 1 s", 0.0),
        ("moment / 1 s", 1.0),
        ("p", 0.0),
        ("index", 0.0),
        ("m.delay / 1 s", 0.0),
    ] {
        let assembly = model(text);
        let sample = Sample::at(0.3).with(&assembly.names, "late.k", &[0.2]);
        assert_eq!(measurand(&assembly, "m", &sample), expected, "{text}");
    }
    let assembly = model("a");
    let sample = Sample::at(0.3).with(&assembly.names, "late.k", &[0.2]);
    let t = 0.2 * f64::sin(crate::bench::signal(0, 0, 0.3));
    assert_eq!(measurand(&assembly, "m", &sample), crate::bench::signal(0, 1, 0.3 + t));
}
