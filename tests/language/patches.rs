//! What effects do to a graph: exactly absent when off, no cycles, no order of listing.

use homepoint::graph::{Kind, Local, MeasurandKind, PatchTarget, assemble};
use homepoint::number::{Dual, Number, derivative, variable};

use crate::bench::{Declared, Sample, evaluate, measurand, polar, signal};

/// A plain model: `target = radius + a`, `m = 2 target`.
fn plain() -> Declared {
    Declared::default()
        .input("a", "m", true)
        .parameter("radius", Kind::Scalar, "m")
        .quantity("target", "radius + a")
        .measurand("m", "2 * target", "m")
        .measurand("n", "m + target", "m")
}

#[test]
fn effects_that_are_off_are_exactly_absent() {
    let nominal = polar().assemble();
    let patched = polar()
        .effect("clock", &[("k", "1")], &[("t", "t + k * run_time")])
        .effect(
            "map",
            &[("k", "s")],
            &[("horizontal.t", "t + k * cos(horizontal) * rate(arm_angle) * 1 s")],
        )
        .effect(
            "eccentricity",
            &[("c", "rad"), ("s", "rad")],
            &[("arm_angle", "arm_angle + c * cos(arm_angle) + s * sin(arm_angle)")],
        )
        .effect("stretch", &[("k", "m*s^2")], &[("radius", "radius + k * rate(arm_angle)^2")])
        .effect(
            "bend",
            &[("k", "m*s^2")],
            &[("target", "target + k * rate(rate(arm_angle)) * rotate(arm_turn, [0, 1, 0])")],
        )
        .effect("twist", &[("k", "rad")], &[("orientation", "turn([0, 0, k]) * orientation")])
        .effect("collimation", &[("c", "rad")], &[("horizontal", "horizontal + c / sin(vertical)")])
        .effect("level", &[("k", "1")], &[("distance.sigma", "sigma * (1 + k)")])
        .assemble();
    for time in [0.0, 0.31, 2.9] {
        for name in ["horizontal", "vertical", "distance"] {
            let at = |assembly: &homepoint::graph::Assembly| {
                let sample = Sample::at(time).polar(&assembly.names);
                measurand(assembly, name, &sample.with(&assembly.names, "vertical.delay", &[1e-3]))
            };
            assert_eq!(at(&nominal), at(&patched), "{name} at {time}");
        }
    }
    let factor = patched.measurands[2].sigma_factor.unwrap();
    let sample = Sample::at(0.0).with(&patched.names, "level.k", &[0.25]);
    assert_eq!(evaluate(&patched.graph, &[factor], &sample), [1.25]);
    assert!(nominal.measurands[2].sigma_factor.is_none());
}

#[test]
fn the_order_in_which_independent_effects_are_listed_changes_nothing() {
    let growth =
        |d: Declared| d.effect("growth", &[("k", "m")], &[("radius", "radius + k * a / 1 m")]);
    let offset =
        |d: Declared| d.effect("offset", &[("k", "m")], &[("target", "target + k * radius / 1 m")]);
    let orders = [offset(growth(plain())).assemble(), growth(offset(plain())).assemble()];
    let values = orders.map(|assembly| {
        let names = &assembly.names;
        let sample = Sample::at(0.4)
            .with(names, "radius", &[1.5])
            .with(names, "growth.k", &[0.25])
            .with(names, "offset.k", &[0.125]);
        (measurand(&assembly, "m", &sample), measurand(&assembly, "n", &sample))
    });
    assert_eq!(values[0], values[1]);
    // An effect on the radius flows through the one on the target, whichever comes first.
    let a: f64 = signal(0, 0, 0.4);
    let radius = 1.5 + 0.25 * a;
    let target = radius + a + 0.125 * radius;
    assert!((values[0].0 - 2.0 * target).abs() < 1e-14);
    assert!((values[0].1 - 3.0 * target).abs() < 1e-14);
}

#[test]
fn effects_on_one_name_apply_in_the_order_of_layers() {
    let assembly = plain()
        .effect("first", &[], &[("radius", "2 * radius")])
        .effect("second", &[], &[("radius", "self + 1 m")])
        .assemble();
    let sample = Sample::at(0.0).with(&assembly.names, "radius", &[3.0]);
    let a: f64 = signal(0, 0, 0.0);
    assert!((measurand(&assembly, "m", &sample) - 2.0 * (7.0 + a)).abs() < 1e-14);
}

#[test]
fn all_patches_of_one_effect_act_on_the_graph_before_it() {
    let assembly = plain()
        .effect("swap", &[], &[("radius", "radius + target"), ("target", "target + radius")])
        .assemble();
    let sample = Sample::at(0.0).with(&assembly.names, "radius", &[3.0]);
    let a: f64 = signal(0, 0, 0.0);
    // target is patched: (3 + a) + 3, both from before; the patched radius is not used by it.
    assert!((measurand(&assembly, "m", &sample) - 2.0 * (6.0 + a)).abs() < 1e-14);
}

#[test]
fn a_patch_of_t_may_use_signals_and_measurands() {
    let assembly = plain()
        .effect("lag", &[("k", "1")], &[("t", "t + k * m / 1 m * 1 s")])
        .effect("late", &[("k", "s")], &[("n.t", "n.t + k")])
        .assemble();
    let names = &assembly.names;
    let sample = Sample::at(0.4)
        .with(names, "radius", &[1.5])
        .with(names, "n.delay", &[0.01])
        .with(names, "lag.k", &[0.001])
        .with(names, "late.k", &[0.02]);
    // In n's graph m is taken at n's moment; `t` before `lag` already holds `late`'s share or not,
    // by the order of layers: `late` is last, so its own right-hand side sees `lag`.
    let before = 0.01;
    let m = 2.0 * (1.5 + signal(0, 0, 0.4 + before));
    let t = before + 0.001 * m + 0.02;
    let target: f64 = 1.5 + signal(0, 0, 0.4 + t);
    assert!((measurand(&assembly, "n", &sample) - 3.0 * target).abs() < 1e-14);
    let offset = evaluate(&assembly.graph, &[assembly.measurands[1].offset], &sample)[0];
    assert!((offset - t).abs() < 1e-15);
}

#[test]
fn derivatives_flow_through_patched_moments() {
    let assembly = plain().effect("lag", &[("k", "s")], &[("t", "t + k * a / 1 m")]).assemble();
    let sample = Sample::at(<Dual as Number>::constant(0.4)).with(
        &assembly.names,
        "lag.k",
        &[variable(0.0)],
    );
    let expected = 2.0 * signal::<f64>(0, 1, 0.4) * signal::<f64>(0, 0, 0.4);
    assert!((derivative(measurand(&assembly, "m", &sample)) - expected).abs() < 1e-14);
}

#[test]
fn rates_of_measurands_in_patches_of_measurands_and_times_end() {
    let assembly = polar()
        .effect(
            "rate_dependent_delay",
            &[("k", "s^2")],
            &[("t", "t + k * sqrt(rate(vertical)^2 + rate(horizontal)^2 * sin(vertical)^2)")],
        )
        .effect(
            "reversal",
            &[("k", "rad")],
            &[
                ("horizontal", "horizontal + k * sign(rate(horizontal))"),
                ("vertical", "vertical + k * sign(rate(vertical))"),
            ],
        )
        .effect("lag", &[("k", "s^2")], &[("vertical", "vertical - k * rate(rate(vertical))")])
        .assemble();
    let names = &assembly.names;
    let sample = Sample::at(0.7).polar(names).with(names, "lag.k", &[1e-3]);
    assert!(f64::is_finite(measurand(&assembly, "vertical", &sample)));
    assert!(assembly.graph.nodes().len() < 2_000, "{}", assembly.graph.nodes().len());
}

#[test]
fn locals_of_an_effect_shadow_and_may_be_per_measurand() {
    let mut declared = plain().effect(
        "map",
        &[],
        &[("t", "t + c"), ("m", "m + order * c / 1 s * 1 m"), ("head", "head + 0 * radius")],
    );
    for name in ["map.c.m", "map.c.n"] {
        declared = declared.parameter(name, Kind::Scalar, "s");
    }
    let count = declared.0.parameters.len();
    let locals = &mut declared.0.layers[0].locals;
    locals.insert("c".into(), Local::PerMeasurand(vec![count - 2, count - 1]));
    locals.insert("order".into(), Local::Constant(3.0, homepoint::units::Dimension::NONE));
    locals.insert("head".into(), Local::Name("target".into()));
    locals.insert("radius".into(), Local::Constant(1e9, homepoint::units::Dimension::LENGTH));
    declared.0.layers[0].patches[2].target = PatchTarget::Name("head".into());
    let assembly = declared.assemble();
    let names = &assembly.names;
    let sample = Sample::at(0.4).with(names, "radius", &[1.5]).with(names, "map.c.m", &[0.1]).with(
        names,
        "map.c.n",
        &[0.2],
    );
    // n names m, whose patch uses m's own c and the graph before the effect, moments included.
    let target: f64 = 1.5 + signal(0, 0, 0.4);
    let m = 2.0 * target + 3.0 * 0.1;
    assert!((measurand(&assembly, "n", &sample) - (m + target)).abs() < 1e-14);
    let offset = evaluate(&assembly.graph, &[assembly.measurands[1].offset], &sample);
    assert_eq!(offset, [0.2]);
}

#[test]
fn patches_of_vectors_rotations_delays_and_noise_levels() {
    let mut declared = polar()
        .effect("drift", &[("k", "m/s")], &[("position", "position + [k, 0, 0] * time")])
        .effect("slow", &[("k", "s")], &[("distance.delay", "self + k")])
        .effect("level", &[("k", "1")], &[("distance.sigma", "distance.sigma * (1 + k)")])
        .effect("square", &[("k", "m")], &[("distance.sigma", "hypot(sigma, sigma * k / 1 m)")]);
    declared.0.measurands[0].kind = MeasurandKind::Angle { period: std::f64::consts::TAU };
    let assembly = declared.assemble();
    let names = &assembly.names;
    let sample = Sample::at(0.5)
        .polar(names)
        .with(names, "drift.k", &[0.1])
        .with(names, "slow.k", &[0.02])
        .with(names, "level.k", &[1.0])
        .with(names, "square.k", &[0.75]);
    let factor = assembly.measurands[2].sigma_factor.unwrap();
    assert_eq!(evaluate(&assembly.graph, &[factor], &sample), [2.5]);
    assert_eq!(evaluate(&assembly.graph, &[assembly.measurands[2].offset], &sample), [0.02]);
    let moved = polar().assemble();
    let c = |values: &[f64]| values.to_vec();
    let shifted = Sample::at(0.5).polar(&moved.names).with(
        &moved.names,
        "position",
        &c(&[0.2 + 0.05, -0.1, 1.4]),
    );
    let difference =
        measurand(&assembly, "horizontal", &sample) - measurand(&moved, "horizontal", &shifted);
    assert!(difference.abs() < 1e-15);
}

#[test]
fn many_effects_on_entangled_names_stay_small() {
    let mut declared = polar();
    for i in 0..12 {
        let wave = format!("arm_angle + c * cos({i} * arm_angle)");
        let growth = "radius + c * 1 m * sin(arm_angle)";
        let reading = format!("horizontal + c * cos({i} * horizontal) * vertical");
        declared = declared
            .effect(&format!("wave{i}"), &[("c", "rad")], &[("arm_angle", &wave)])
            .effect(&format!("growth{i}"), &[("c", "1")], &[("radius", growth)])
            .effect(&format!("reading{i}"), &[("c", "1")], &[("horizontal", &reading)])
            .effect(&format!("late{i}"), &[("c", "s")], &[("t", "t + c * rate(arm_angle) * 1 s")]);
    }
    let assembly = assemble(declared.0).unwrap();
    assert!(assembly.graph.nodes().len() < 60_000, "{}", assembly.graph.nodes().len());
    let nominal = polar().assemble();
    let at = |assembly: &homepoint::graph::Assembly| {
        measurand(assembly, "horizontal", &Sample::at(0.4).polar(&assembly.names))
    };
    assert_eq!(at(&assembly), at(&nominal));
}
