//! `delayed` against the same expression at the earlier moment, and against dual numbers along its
//! duration.

use homepoint::graph::{Assembly, Kind};
use homepoint::number::{derivative, variable};

use crate::bench::{Declared, Sample, measurand};

const FORMULAS: &[&str] = &[
    "sin(a) * cos(b) + tan(a / 3)",
    "norm(rotate(rotation_x(a) * turn([a, b, 0.1]), [1, b, a]) + [2, 0, 0])",
    "rate(a) * 1 s + a * (rate(rate(b)) * 1 s^2)",
    "time / 1 s * a + moment / 1 s + run_time / 1 s",
    "rate(delayed(a, 0.05 s)) * 1 s + delayed(b, 0.2 s)",
];

fn assembly(text: &str) -> Assembly {
    Declared::default()
        .input("a", "1", true)
        .input("b", "1", true)
        .parameter("d", Kind::Scalar, "s")
        .measurand("value", text, "1")
        .measurand("earlier", &format!("delayed({text}, d)"), "1")
        .measurand("turned", &format!("rotate(delayed(rotation_z({text}), d), [1, 0, 0]).x"), "1")
        .measurand("rate", &format!("rate(delayed({text}, d))"), "1/s")
        .assemble()
}

#[test]
fn an_expression_is_what_it_was_a_duration_before() {
    for text in FORMULAS {
        let assembly = assembly(text);
        for (time, d) in [(0.3, 0.0), (0.3, 0.11), (1.7, -0.4)] {
            let now = Sample::at(time).with(&assembly.names, "d", &[d]);
            let due = measurand(&assembly, "value", &Sample::at(time - d));
            let near = |found: f64, due: f64, what: &str| {
                let off = (found - due).abs();
                assert!(off <= 1e-12 * (1.0 + due.abs()), "{what} {text}: {found} {due}");
            };
            near(measurand(&assembly, "earlier", &now), due, "value of");
            near(measurand(&assembly, "turned", &now), due.cos(), "turn by");
            let dual = measurand(&assembly, "value", &Sample::at(variable(time - d)));
            near(measurand(&assembly, "rate", &now), derivative(dual), "rate of");
            // Along the duration it goes back at the rate.
            let along =
                Sample::at(variable(time) * 0.0 + time).with(&assembly.names, "d", &[variable(d)]);
            near(
                derivative(measurand(&assembly, "earlier", &along)),
                -derivative(dual),
                "derivative along the duration of",
            );
        }
    }
}

/// The delay of a reading is not a thing that moves: it stays, whatever it is made of.
#[test]
fn the_offset_of_a_reading_stays() {
    let assembly = Declared::default()
        .input("a", "1", true)
        .parameter("d", Kind::Scalar, "s")
        .measurand("value", "t / 1 s + a", "1")
        .measurand("earlier", "delayed(t / 1 s + a, d)", "1")
        .effect("late", &[("k", "s")], &[("t", "t + k * sin(a)")])
        .assemble();
    let at = |time: f64, d: f64| {
        Sample::at(time).with(&assembly.names, "d", &[d]).with(&assembly.names, "late.k", &[0.02])
    };
    let t = measurand(&assembly, "value", &at(0.6, 0.0));
    assert!((measurand(&assembly, "earlier", &at(0.6, 0.0)) - t).abs() < 1e-14);
    let [now, before] = [0.0, 0.1].map(|d| measurand(&assembly, "earlier", &at(0.6, d)));
    let offset = 0.02 * signal_sine(0.6);
    let a = |time: f64| crate::bench::signal(0, 0, time + offset);
    assert!((now - before - (a(0.6) - a(0.5))).abs() < 1e-12, "{now} {before}");
}

/// The sine of signal `a` where an effect on `t` takes it: at the moment without that effect.
fn signal_sine(time: f64) -> f64 {
    crate::bench::signal::<f64>(0, 0, time).sin()
}

#[test]
fn a_duration_that_moves_or_is_none_is_a_fault() {
    let faults = |text: &str| {
        Declared::default().input("a", "1", true).measurand("value", text, "1").faults()
    };
    assert!(faults("delayed(a, a * 1 s)").contains("the same in all samples"));
    assert!(faults("delayed(a, 2)").contains("a duration"));
    assert!(faults("delayed(a, 2 m)").contains("a duration"));
}
