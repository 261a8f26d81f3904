//! What a model's names and functions come to, against formulas written by hand.

use homepoint::graph::{Kind, Node, Value};
use homepoint::number::{Dual, Number, derivative, variable};

use crate::bench::{Declared, Sample, evaluate, measurand, polar, signal};

/// Rotation matrix of the unit quaternion used by the bench, written out independently.
fn matrix() -> [[f64; 3]; 3] {
    let (w, x, y, z) = (0.9, 0.1, -0.3, 0.3);
    [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
}

#[test]
fn the_polar_model_predicts_what_its_equations_say() {
    let assembly = polar().assemble();
    let delay = 0.002;
    let sample =
        Sample::at(0.8).polar(&assembly.names).with(&assembly.names, "horizontal.delay", &[delay]);
    for (name, t) in [("horizontal", delay), ("vertical", 0.0), ("distance", 0.0)] {
        let angle: f64 = signal(0, 0, 0.8 + t);
        let target = [1.146 * angle.cos(), 1.146 * angle.sin(), 0.0];
        let m = matrix();
        let p: Vec<f64> = (0..3)
            .map(|i| (0..3).map(|j| m[i][j] * target[j]).sum::<f64>() + [0.2, -0.1, 1.4][i])
            .collect();
        let expected = match name {
            "horizontal" => p[1].atan2(p[0]),
            "vertical" => p[0].hypot(p[1]).atan2(p[2]),
            _ => (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt(),
        };
        assert!((measurand(&assembly, name, &sample) - expected).abs() < 1e-14, "{name}");
    }
}

#[test]
fn a_delay_moves_its_own_measurand_only_and_carries_derivatives() {
    let assembly = polar().assemble();
    let sample = Sample::at(<Dual as Number>::constant(0.8)).polar(&assembly.names).with(
        &assembly.names,
        "vertical.delay",
        &[variable(0.001)],
    );
    assert_eq!(derivative(measurand(&assembly, "horizontal", &sample)), 0.0);
    assert_eq!(derivative(measurand(&assembly, "distance", &sample)), 0.0);
    let at = |delay: f64| {
        let sample = Sample::at(0.8).polar(&assembly.names);
        measurand(&assembly, "vertical", &sample.with(&assembly.names, "vertical.delay", &[delay]))
    };
    let slope = (at(0.001 + 1e-6) - at(0.001 - 1e-6)) / 2e-6;
    assert!((derivative(measurand(&assembly, "vertical", &sample)) - slope).abs() < 1e-8);
}

/// A formula of `time`, the signals `a` and `b` and the parameters `p` (m), `v` (m), `q`.
fn value(text: &str, unit: &str) -> f64 {
    let assembly = Declared::default()
        .input("a", "rad", true)
        .input("b", "rad", true)
        .parameter("p", Kind::Scalar, "m")
        .parameter("v", Kind::Vector, "m")
        .parameter("q", Kind::Rotation, "1")
        .measurand("m", text, unit)
        .assemble();
    let names = &assembly.names;
    let sample = Sample::at(0.8).with(names, "p", &[2.0]).with(names, "v", &[0.3, -0.4, 1.2]).with(
        names,
        "q",
        &[0.5, 0.5, 0.5, 0.5],
    );
    measurand(&assembly, "m", &sample)
}

#[test]
fn every_function_means_what_its_table_says() {
    let a: f64 = signal(0, 0, 0.8);
    let b: f64 = signal(1, 0, 0.8);
    let cases = [
        ("sin(a) + cos(a) * tan(a)", "1", 2.0 * a.sin()),
        ("asin(sin(a) / 2)", "1", (a.sin() / 2.0).asin()),
        ("acos(sin(a) / 2) + atan(a)", "1", (a.sin() / 2.0).acos() + a.atan()),
        ("atan2(3 * p, -p)", "1", f64::atan2(3.0, -1.0)),
        ("sqrt(p * p / 4) + hypot(3 m, 2 * p)", "m", 6.0),
        ("exp(a) * log(b)", "1", a.exp() * b.ln()),
        ("abs(-p) + p * sign(-p)", "m", 0.0),
        ("tanh(a) + floor(b) + fract(b)", "1", a.tanh() + b),
        ("min(p, 1 m, 3 m) + max(p, 0, 1 mm)", "m", 3.0),
        ("norm(v)", "m", 1.3),
        ("dot(v, [1, 2, 0])", "m", -0.5),
        ("cross(v, [0, 0, 1]).y", "m", -0.3),
        ("normalize(v).z", "1", 1.2 / 1.3),
        ("norm(normalize(0 * v))", "1", 0.0),
        ("rotate(rotation_x(90 deg), v).z", "m", -0.4),
        ("rotate(rotation_y(90 deg), v).x", "m", 1.2),
        ("rotate(rotation_z(90 deg), v).x", "m", 0.4),
        ("rotate(rotation([0, 0, 5 m], 90 deg), v).y", "m", 0.3),
        ("rotate(turn([0, 0, 90 deg]), v).y", "m", 0.3),
        ("rotate(turn([0, 0, 0]), v).y", "m", -0.4),
        ("rotate(quaternion(2, 2, 2, 2), v).x", "m", 1.2),
        ("rotate(q, v).x", "m", 1.2),
        ("rotate(inverse(q) * q, v).x", "m", 0.3),
        ("rotate(rotation_z(90 deg) * rotation_x(90 deg), v).z", "m", -0.4),
        ("rotate(rotation_z(90 deg) * rotation_x(90 deg), v).x", "m", 1.2),
        ("-a^2 + 2^-1 + 2^3^2", "1", -a * a + 512.5),
        ("(p^2)^0.5 + p^(2/3) * p^(1/3)", "m", 4.0),
        ("a^1.5", "1", a.powf(1.5)),
        ("a^b", "1", a.powf(b)),
        ("2 * pi - 360 deg", "1", 0.0),
        ("time + run_time + setup_time + uniform_time", "s", 4.0 * 0.8 - 0.5 + 4.0 - 0.49),
        ("index * 1 ms", "s", 0.007),
        ("delayed(time, 0.3 s) + t", "s", 0.5),
        ("-(v / 2 - v).x", "m", 0.15),
        ("20 degC - 293.15 K + -2 degC", "K", 271.15),
    ];
    for (text, unit, expected) in cases {
        let found = value(text, unit);
        assert!(
            (found - expected).abs() < 2e-14 * (1.0 + expected.abs()),
            "{text}: {found} {expected}"
        );
    }
    // `rate` has tests of its own, and `delayed` more.
    for entry in homepoint::formula::functions::TABLE {
        let call = format!("{}(", entry.name);
        let tried = cases.iter().any(|(text, _, _)| text.contains(&call));
        assert!(tried || entry.name == "rate", "{} is not tried", entry.name);
    }
}

#[test]
fn coordinates_are_taken_from_readings_at_reference_time_without_effects() {
    let mut declared = polar().effect("growth", &[("k", "m")], &[("radius", "radius + k")]);
    let angles =
        "[sin(vertical) * cos(horizontal), sin(vertical) * sin(horizontal), cos(vertical)]";
    declared.0.coordinates = Some(homepoint::graph::CoordinatesNames {
        from: crate::bench::formula("target"),
        measured: crate::bench::formula("distance * direction"),
        gap: None,
        helpers: [("direction".to_owned(), crate::bench::formula(angles))].into_iter().collect(),
        rotation: 1,
        translation: 2,
    });
    let assembly = declared.assemble();
    let names = &assembly.names;
    let mut sample = Sample::at(0.8).polar(names).with(names, "growth.k", &[0.5]).with(
        names,
        "horizontal.delay",
        &[0.1],
    );
    sample.readings = [((0, 0), 0.4), ((1, 0), 1.1), ((2, 0), 3.0)].into_iter().collect();
    let coordinates = assembly.coordinates.as_ref().unwrap();
    assert_eq!((coordinates.rotation, coordinates.translation), (1, 2));
    let angle: f64 = signal(0, 0, 0.8);
    let from = evaluate(&assembly.graph, &coordinates.from, &sample);
    let expected = [1.146 * angle.cos(), 1.146 * angle.sin(), 0.0];
    assert!(from.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15));
    let measured = evaluate(&assembly.graph, &coordinates.measured, &sample);
    let (s, c) = 1.1f64.sin_cos();
    let expected = [3.0 * s * 0.4f64.cos(), 3.0 * s * 0.4f64.sin(), 3.0 * c];
    assert!(measured.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15));
}

#[test]
fn equal_expressions_are_one_node_and_constants_fold() {
    let assembly = Declared::default()
        .parameter("p", Kind::Scalar, "m")
        .quantity("one", "p + 0 m + 0 * p * 1")
        .quantity("two", "--(p * 1) / 1")
        .measurand("m", "one - (two - two) * 0 + norm([0 m, 0, 0])", "m")
        .assemble();
    let Value::Scalar(node) = assembly.measurands[0].value else {
        unreachable!("a number was declared");
    };
    assert!(matches!(assembly.graph.node(node), Node::Leaf(_)));
}
