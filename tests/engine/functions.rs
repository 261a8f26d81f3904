//! The functions of the language in lanes: every row of their table against the definition.

use homepoint::engine::lanes::{Code, InstructionSet, LANES, Lanes, Workspace};
use homepoint::engine::pointwise::Leaves;
use homepoint::formula::functions::{Meaning, TABLE};
use homepoint::graph::{Graph, Leaf};

/// A sample of which nothing is asked.
struct Nothing;

impl Leaves<f64> for Nothing {
    fn leaf(&self, _: Leaf) -> f64 {
        f64::NAN
    }

    fn signal(&self, _: u32, _: u8, _: f64) -> f64 {
        f64::NAN
    }
}

#[test]
fn functions_of_one_number_agree_with_the_definition() {
    // From -9.5 to 9.6, with the singular points -1, 0 and 1.
    let points: Lanes = std::array::from_fn(|i| (i as f64 - 95.0) / 10.0);
    assert!([-1.0, 0.0, 1.0].iter().all(|x| points.contains(x)));
    for entry in TABLE {
        let (Meaning::Plain(function)
        | Meaning::Keep(function)
        | Meaning::Drop(function)
        | Meaning::Root(function)) = entry.meaning
        else {
            continue;
        };
        let mut graph = Graph::default();
        let given = graph.leaf(Leaf::Given(0));
        let value = graph.unary(function, given);
        let code = Code::new(&graph, &[vec![value]]);
        for set in InstructionSet::available() {
            let mut workspace = Workspace::new(&code, set);
            workspace.hold_still(&code, &Nothing);
            workspace.give(&code, 0, &points);
            workspace.compute(&code, 0, &[]);
            let found = workspace.outputs(&code, 0)[0];
            for i in 0..LANES {
                let due: f64 = function.apply(points[i]);
                let is_near = (found[i] - due).abs() <= 1e-12 * due.abs().max(1.0);
                assert!(
                    is_near || found[i] == due || (found[i].is_nan() && due.is_nan()),
                    "{}({}) on {}: {} instead of {due}",
                    entry.name,
                    points[i],
                    set.name(),
                    found[i]
                );
            }
        }
    }
}
