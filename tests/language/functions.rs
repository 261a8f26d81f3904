//! Every row of the table of functions: a rule for its arguments, right derivatives, a line in the
//! guide. A function that is added comes under these tests by its row.

use homepoint::formula::functions::{Entry, Meaning, TABLE};
use homepoint::graph::partials::slope;
use homepoint::graph::{Clock, Graph, Leaf, Unary, assemble};
use homepoint::number::{derivative, derivatives2, variable, variable2};

use crate::bench::{Declared, Sample, evaluate};

/// The functions of one number.
fn unary(entry: &Entry) -> Option<Unary> {
    match entry.meaning {
        Meaning::Plain(unary)
        | Meaning::Keep(unary)
        | Meaning::Drop(unary)
        | Meaning::Root(unary) => Some(unary),
        Meaning::Own => None,
    }
}

/// Whether a function can be called with some numbers, vectors and rotations.
fn has_a_rule(entry: &Entry) -> bool {
    let count = *entry.arity.start();
    let arguments = ["a", "[a, b, a]", "rotation_z(a)", "1 s"];
    (0..4_usize.pow(count as u32)).any(|choice| {
        let own = (0..count).map(|k| arguments[choice / 4_usize.pow(k as u32) % 4]);
        let call = format!("{}({})", entry.name, own.collect::<Vec<_>>().join(", "));
        let names = Declared::default()
            .input("a", "rad", true)
            .input("b", "rad", true)
            .quantity("result", &call)
            .measurand("m", "a", "rad");
        assemble(names.0).is_ok()
    })
}

#[test]
fn every_function_has_a_rule_for_its_arguments() {
    for entry in TABLE {
        assert!(has_a_rule(entry), "`{}` can be called with nothing", entry.signature);
    }
}

/// The nodes of a derivative are those of the dual numbers, which are those of differences.
#[test]
fn derivatives_of_functions_of_one_number_are_right() {
    for (entry, function) in TABLE.iter().filter_map(|entry| Some((entry, unary(entry)?))) {
        let mut graph = Graph::default();
        let time = graph.leaf(Leaf::Clock(Clock::Time));
        let value = graph.unary(function, time);
        let slope = slope(&mut graph, function, time, value);
        let mut compared = 0;
        for x in [-2.3, -1.0, -0.73, -0.31, 0.0, 0.27, 0.64, 1.0, 1.7, 40.3] {
            let due = function.apply(variable(x));
            if !due.re.is_finite() || !derivative(due).is_finite() {
                continue;
            }
            let place = format!("{} at {x}", entry.name);
            let near = |found: f64, due: f64, most: f64| {
                assert!((found - due).abs() <= most * due.abs().max(1.0), "{place}: {found} {due}");
            };
            let [first] = evaluate(&graph, &[slope], &Sample::at(x))[..] else { unreachable!() };
            near(first, derivative(due), 1e-13);
            // Away from where a function is singular, or has a step.
            if x.abs() == 1.0 || x == 0.0 {
                continue;
            }
            let [second] = evaluate(&graph, &[slope], &Sample::at(variable(x)))[..] else {
                unreachable!()
            };
            near(derivative(second), derivatives2(function.apply(variable2(x)))[1], 1e-11);
            let at = |x: f64| function.apply(x);
            near(derivative(due), (at(x + 1e-5) - at(x - 1e-5)) / 2e-5, 1e-8);
            compared += 1;
        }
        assert!(compared >= 2, "{}: compared at {compared} points", entry.name);
    }
}

#[test]
fn the_guide_names_every_function() {
    let guide = include_str!("../../docs/formats.md");
    let (_, guide) = guide.split_once("Functions: ").unwrap();
    let (guide, _) = guide.split_once("a number with a unit").unwrap();
    let named: Vec<&str> = guide.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    for entry in TABLE {
        assert!(named.contains(&entry.name), "`{}` is not in docs/formats.md", entry.name);
    }
}
