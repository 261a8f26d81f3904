//! What is said of models and effects that do not fit together, and where.

use homepoint::graph::{Kind, PatchTarget, assemble};

use crate::bench::{Declared, formula, polar};

fn plain(text: &str, unit: &str) -> Declared {
    Declared::default()
        .input("arm_angle", "rad", true)
        .parameter("radius", Kind::Scalar, "m")
        .parameter("position", Kind::Vector, "m")
        .parameter("orientation", Kind::Rotation, "1")
        .measurand("m", text, unit)
}

#[test]
fn kinds_and_dimensions_are_checked_at_the_part_that_is_wrong() {
    let messages: Vec<String> = [
        ("radius + arm_angle", "m"),
        ("2 * (position - radius).x", "m"),
        ("orientation + orientation", "1"),
        ("norm(position * position)", "1"),
        ("norm(orientation * position)", "m"),
        ("norm(position / orientation)", "m"),
        ("1 / position", "1"),
        ("sin(radius)", "1"),
        ("atan2(radius, arm_angle)", "1"),
        ("min(0, radius, 3 s)", "m"),
        ("norm([radius, 0, arm_angle])", "m"),
        ("radius^arm_angle", "m"),
        ("2^radius", "1"),
        ("norm(rotate(position, position))", "m"),
        ("norm(rate(orientation))", "1/s"),
        ("arm_angle.x", "1"),
        ("inverse(radius)", "m"),
        ("norm(turn(position))", "m"),
        ("radius^2", "m"),
        ("position", "m"),
        ("-orientation", "1"),
        ("exp(1 s)", "1"),
    ]
    .iter()
    .map(|(text, unit)| format!("{text}\n{}", plain(text, unit).faults()))
    .collect();
    insta::assert_snapshot!(messages.join("\n"));
}

#[test]
fn names_that_are_not_there_or_turn_in_circles() {
    let cycle = plain("a", "1").quantity("a", "2 * b").quantity("b", "c + 1").quantity("c", "a");
    let messages = [
        plain("radios + 1 m", "m").faults(),
        plain("self", "m").faults(),
        plain("sigma", "m").faults(),
        plain("m + 1", "m").faults(),
        plain("radius", "m").quantity("unused", "nowhere + radius").faults(),
        plain("radius", "m").quantity("radius", "1 m").faults(),
        plain("radius", "m").quantity("time", "1 s").faults(),
        cycle.faults(),
    ];
    insta::assert_snapshot!(messages.join("\n"));
}

#[test]
fn effects_that_do_not_fit_say_why() {
    let messages = [
        polar().effect("sag", &[("k", "m")], &[("platform_angle", "self + k / 1 m")]).faults(),
        polar().effect("sag", &[("k", "m")], &[("target", "target + k * down")]).faults(),
        polar().effect("sag", &[("k", "m")], &[("target", "k")]).faults(),
        polar().effect("sag", &[("k", "m")], &[("radius", "k * radius")]).faults(),
        polar().effect("sag", &[("k", "m")], &[("t", "t + k")]).faults(),
        polar().effect("sag", &[("k", "m")], &[("distance.sigma", "sigma + 1")]).faults(),
        polar().effect("sag", &[("k", "m")], &[("time", "time + 1 s")]).faults(),
        polar().effect("sag", &[("radial", "m")], &[("radius", "radius + radiel")]).faults(),
    ];
    insta::assert_snapshot!(messages.join("\n"));
}

/// A chain of quantities, the last one first, each made of the one before by `text` with `q` in it.
fn chain(links: usize, text: &str) -> Declared {
    let mut declared = Declared::default();
    for i in (1..links).rev() {
        declared = declared.quantity(&format!("q{i}"), &text.replace('q', &format!("q{}", i - 1)));
    }
    declared.quantity("q0", "1").measurand("m", &format!("q{}", links - 1), "1")
}

#[test]
fn long_chains_of_names_do_not_exhaust_the_stack() {
    for text in ["q + 1", "-norm([abs(2 * q) + 1, 0, 0])", "max(-q, 2^q, [0, 0, (q)].z)"] {
        // With half the stack that a thread has by default.
        let walk = move || chain(2_000, text).faults();
        let thread = std::thread::Builder::new().stack_size(1 << 20).spawn(walk).unwrap();
        assert!(thread.join().unwrap().contains("deep"), "{text}");
    }
    let assembly = chain(100, "q + 1").assemble();
    let sample = crate::bench::Sample::at(0.0);
    let value: f64 = crate::bench::measurand(&assembly, "m", &sample);
    assert!((value - 100.0).abs() < 1e-12);
}

#[test]
fn a_graph_that_multiplies_is_refused() {
    let mut declared = Declared::default().input("a", "1", true).quantity("q0", "a");
    for i in 1..60 {
        let text = format!("rate(sin(q{0}) * cos(q{0}) * tan(q{0})) * 1 s", i - 1);
        declared = declared.quantity(&format!("q{i}"), &text);
    }
    assert!(declared.measurand("m", "q59", "1").faults().contains("nodes"));
}

#[test]
fn indices_that_point_at_nothing_are_faults() {
    let mut declared = polar();
    declared.0.measurands[0].delay = 99;
    assert!(declared.faults().contains("the delay of `horizontal` points at nothing"));
    let mut declared = polar().effect("late", &[], &[("t", "t")]);
    declared.0.layers[0].patches[0].target = PatchTarget::Time(9);
    assert!(assemble(declared.0).is_err());
    let mut declared = polar();
    declared.0.coordinates = Some(homepoint::graph::CoordinatesNames {
        from: formula("target"),
        measured: formula("distance"),
        gap: None,
        helpers: Default::default(),
        rotation: 1,
        translation: 2,
    });
    assert!(declared.faults().contains("a point is a vector"));
}

/// Torque is mass times gravity times lever; voltage is current times resistance.
#[test]
fn dimensions_of_mechanics_and_electricity_are_checked() {
    let arm = |text: &str, unit: &str| {
        Declared::default()
            .input("angle", "rad", true)
            .input("current", "mA", true)
            .parameter("mass", Kind::Scalar, "kg")
            .parameter("lever", Kind::Scalar, "cm")
            .parameter("h", Kind::Scalar, "m")
            .parameter("constant", Kind::Scalar, "N m/A")
            .measurand("reading", text, unit)
    };
    for (text, unit) in [
        ("mass * 9.81 m/s^2 * lever * sin(angle)", "N m"),
        ("mass * 9.81 m/s^2 * lever", "mNm"),
        ("constant * current", "N m"),
        ("2 ohm * current + constant * rate(angle)", "V"),
        ("mass * 9.81 m/s^2 / (3 cm * 2 mm)", "kPa"),
        ("2 m / h", "%"),
    ] {
        assert!(assemble(arm(text, unit).0).is_ok(), "{text}: {}", arm(text, unit).faults());
    }
    for (text, unit, message) in [
        ("mass * 9.81 m/s^2", "N m", "a force (N)"),
        ("mass * lever", "N m", "a number in m*kg"),
        ("constant * current", "V", "a torque or an energy (N m)"),
        ("2 m/h", "m", "`h` in `2 m/h` is a unit and a name, too"),
    ] {
        let said = arm(text, unit).faults();
        assert!(said.contains(message), "{text}: {said}");
    }
}
