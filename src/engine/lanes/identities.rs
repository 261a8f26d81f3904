//! The same numbers with fewer costly instructions: what is rewritten before a graph is compiled.
//!
//! | written | computed |
//! |---|---|
//! | sin, cos of `± atan2(y, x) + o`, o standing still | sin and cos of o, with `y / r` and `x / r` |
//! | `a / b`, a or b standing still | `a · (1 / b)` |
//! | `1 / (x² + y²)` where `hypot(x, y)` is there | `(1 / hypot(x, y))²` |
//! | `a - b` where `b - a` is there | `-(b - a)` |
//! | `a (c b)`, `c a ± c b`, c a number | `c (a b)`, `c (a ± b)`: the 2 of a square meets the 1/2 of its root |
//!
//! They agree to a few units in the last place, and at the origin, where atan2 counts as 0,
//! exactly. They do not hold for infinite x, y, for b below the smallest normal number and for
//! points as near to the origin as its root.

use crate::graph::import::Import;
use crate::graph::{Binary, Graph, Leaf, Node, NodeId, Unary};

/// A graph with the same outputs, rewritten.
pub(super) fn rewritten(graph: &Graph, groups: &[Vec<NodeId>]) -> (Graph, Vec<Vec<NodeId>>) {
    let mut into = Graph::boundless();
    let mut import = Import::rewriting(rewrite);
    let mut leaf = |graph: &mut Graph, leaf: Leaf| graph.leaf(leaf);
    let groups = groups
        .iter()
        .map(|group| group.iter().map(|n| import.node(graph, *n, &mut into, &mut leaf)).collect())
        .collect();
    (into, groups)
}

fn rewrite(graph: &mut Graph, node: Node) -> Option<NodeId> {
    match node {
        Node::Unary(function @ (Unary::Sin | Unary::Cos), angle) => {
            let (turn, offset) = of_a_point(graph, angle)?;
            Some(turned(graph, function, turn, offset))
        }
        Node::Binary(Binary::Divide, a, b) if graph.is_moving(a) != graph.is_moving(b) => {
            let one = graph.constant(1.0);
            let reciprocal = graph.divide(one, b);
            Some(graph.multiply(a, reciprocal))
        }
        Node::Binary(Binary::Multiply, a, b) => {
            let ((c, a), (d, b)) = (numbered(graph, a), numbered(graph, b));
            let number = c * d;
            ((c != 1.0 || d != 1.0) && number.is_normal()).then(|| {
                let product = graph.multiply(a, b);
                graph.scale(number, product)
            })
        }
        Node::Binary(function @ (Binary::Add | Binary::Subtract), a, b) => {
            let ((c, first), (d, second)) = (numbered(graph, a), numbered(graph, b));
            if c == d && c != 1.0 {
                let sum = graph.binary(function, first, second);
                return Some(graph.scale(c, sum));
            }
            let opposite = graph.find(Node::Binary(Binary::Subtract, b, a))?;
            (function == Binary::Subtract)
                .then(|| graph.intern(Node::Unary(Unary::Negate, opposite)))
        }
        Node::Unary(Unary::ReciprocalOrZero, squares) => {
            let length = length_of_squares(graph, squares)?;
            let reciprocal = graph.unary(Unary::ReciprocalOrZero, length);
            Some(graph.multiply(reciprocal, reciprocal))
        }
        _ => None,
    }
}

/// A node as a number times the rest, if that moves: what stands still costs nothing.
fn numbered(graph: &mut Graph, node: NodeId) -> (f64, NodeId) {
    if let Some(number) = graph.constant_value(node) {
        return (number, graph.constant(1.0));
    }
    let Node::Binary(Binary::Multiply, a, b) = graph.node(node) else { return (1.0, node) };
    match (graph.constant_value(a), graph.constant_value(b)) {
        (Some(number), _) if graph.is_moving(b) => (number, b),
        (_, Some(number)) if graph.is_moving(a) => (number, a),
        _ => (1.0, node),
    }
}

/// The length whose square is a sum of two squares, if it is computed anyway.
fn length_of_squares(graph: &Graph, squares: NodeId) -> Option<NodeId> {
    let Node::Binary(Binary::Add, a, b) = graph.node(squares) else { return None };
    let leg = |square| match graph.node(square) {
        Node::Binary(Binary::Multiply, a, b) if a == b => Some(a),
        _ => None,
    };
    let (a, b) = (leg(a)?, leg(b)?);
    let length = |a, b| graph.find(Node::Binary(Binary::Hypot, a, b));
    length(a, b).or_else(|| length(b, a))
}

/// The angle of a point, `[y, x]`, and whether it counts negative.
struct Turn {
    point: [NodeId; 2],
    negative: bool,
}

/// An angle as that of a moving point and an offset that stands still.
fn of_a_point(graph: &mut Graph, angle: NodeId) -> Option<(Turn, NodeId)> {
    let (mut rest, mut negative, mut offset) = (angle, false, graph.constant(0.0));
    loop {
        match graph.node(rest) {
            Node::Binary(Binary::Atan2, y, x) => {
                return Some((Turn { point: [y, x], negative }, offset));
            }
            Node::Unary(Unary::Negate, inner) => (rest, negative) = (inner, !negative),
            Node::Binary(function @ (Binary::Add | Binary::Subtract), a, b) => {
                let (inner, still, first) = match (graph.is_moving(a), graph.is_moving(b)) {
                    (true, false) => (a, b, false),
                    (false, true) => (b, a, true),
                    _ => return None,
                };
                // Of a difference either the moving or the still part counts negative.
                let minus = function == Binary::Subtract;
                let still_negative = negative ^ (minus && !first);
                offset = if still_negative {
                    graph.subtract(offset, still)
                } else {
                    graph.add(offset, still)
                };
                (rest, negative) = (inner, negative ^ (minus && first));
            }
            _ => return None,
        }
    }
}

/// Sine or cosine of `± a + o`.
fn turned(graph: &mut Graph, function: Unary, turn: Turn, offset: NodeId) -> NodeId {
    let [y, x] = turn.point;
    let squares = graph.sum_of_products(&[(y, y), (x, x)]);
    let reciprocal = graph.unary(Unary::ReciprocalOrZero, squares);
    let inverse = graph.unary(Unary::Sqrt, reciprocal);
    let sine = graph.multiply(y, inverse);
    let sine = if turn.negative { graph.negate(sine) } else { sine };
    // 1 at the origin, where the angle counts as 0, and elsewhere nothing but rounding.
    let (one, elsewhere) = (graph.constant(1.0), graph.multiply(squares, reciprocal));
    let origin = graph.subtract(one, elsewhere);
    let across = graph.multiply(x, inverse);
    let cosine = graph.add(across, origin);
    let (sin_o, cos_o) = (graph.unary(Unary::Sin, offset), graph.unary(Unary::Cos, offset));
    if function == Unary::Sin {
        graph.sum_of_products(&[(sine, cos_o), (cosine, sin_o)])
    } else {
        let [plus, minus] = [(cosine, cos_o), (sine, sin_o)].map(|(a, b)| graph.multiply(a, b));
        graph.subtract(plus, minus)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::pointwise::{Leaves, Program};

    /// Given values by index, parameters by index.
    struct Values<'a>(&'a [f64], &'a [f64]);

    impl Leaves<f64> for Values<'_> {
        fn leaf(&self, leaf: Leaf) -> f64 {
            match leaf {
                Leaf::Given(index) => self.0[index as usize],
                Leaf::Parameter { parameter, .. } => self.1[parameter as usize],
                _ => f64::NAN,
            }
        }

        fn signal(&self, _: u32, _: u8, _: f64) -> f64 {
            f64::NAN
        }
    }

    /// Sine and cosine of every way to write an angle of the point with two offsets; quotients.
    fn outputs(graph: &mut Graph) -> Vec<NodeId> {
        let [y, x] = [0, 1].map(|index| graph.leaf(Leaf::Given(index)));
        let [o, p] =
            [0, 1].map(|parameter| graph.leaf(Leaf::Parameter { parameter, component: 0 }));
        let angle = graph.atan2(y, x);
        let negative = graph.negate(angle);
        let mut angles = vec![angle, negative];
        for one in [angle, negative] {
            angles.extend([graph.add(one, o), graph.subtract(one, o), graph.subtract(o, one)]);
        }
        for one in angles.clone() {
            angles.extend([graph.subtract(p, one), graph.subtract(one, p), graph.add(p, one)]);
        }
        let squares = graph.sum_of_products(&[(x, x), (y, y)]);
        let reciprocal = graph.unary(Unary::ReciprocalOrZero, squares);
        let mut outputs = vec![
            graph.divide(y, o),
            graph.divide(o, y),
            graph.binary(Binary::Hypot, y, x),
            reciprocal,
        ];
        for angle in angles {
            outputs.extend([Unary::Sin, Unary::Cos].map(|of| graph.unary(of, angle)));
        }
        let (difference, opposite) = (graph.subtract(x, y), graph.subtract(y, x));
        let (twice, half) = (graph.scale(2.0, difference), graph.scale(-0.5, opposite));
        let thrice = [x, y].map(|one| graph.scale(3.0, one));
        outputs.extend([difference, opposite, twice, graph.multiply(twice, half)]);
        outputs.extend([graph.add(thrice[0], thrice[1]), graph.subtract(thrice[0], thrice[1])]);
        let large = graph.scale(1e200, x);
        let larger = graph.scale(1e200, y);
        outputs.push(graph.multiply(large, larger));
        outputs
    }

    #[test]
    fn what_is_rewritten_has_the_same_values_everywhere_and_at_the_origin() {
        let mut graph = Graph::default();
        let outputs = outputs(&mut graph);
        let (other, groups) = rewritten(&graph, std::slice::from_ref(&outputs));
        let is_angle = |n: &NodeId| matches!(other.node(*n), Node::Binary(Binary::Atan2, ..));
        assert!(!other.needed_by(&groups[0]).iter().any(is_angle));
        let (before, after) = (Program::new(&graph, &outputs), Program::new(&other, &groups[0]));
        let axes = [0.0, -1.0, 1.0, 2.5, -0.3, 1e-9, -1e8];
        for point in axes.iter().flat_map(|y| axes.map(|x| [*y, x])) {
            let values = Values(&point, &[0.7, -2.9]);
            let (mut one, mut two) = (Vec::new(), Vec::new());
            let pairs =
                before.evaluate(&values, &mut one).iter().zip(after.evaluate(&values, &mut two));
            for (number, (expected, found)) in pairs.enumerate() {
                // Angles up to 7 rad are rounded to 4.4e-16 at each of up to three sums.
                let scale = expected.abs().max(1.0);
                assert!(
                    found == expected || (found - expected).abs() < 1.5e-15 * scale,
                    "{number} at {point:?}: {found}, not {expected}"
                );
            }
        }
    }
}
