//! A column that is computed from others of its file, row by row: `zenith = "90 deg - elevation"`.

use crate::diagnostic::Diagnostic;
use crate::formula::angles::{bare_angle, makes_angle};
use crate::formula::{Expression, Formula};
use crate::graph::{
    Graph, Input, Kind, Leaf, Measurand, MeasurandKind, Names, Node, NodeId, Parameter, Value,
    assemble,
};
use crate::units::Unit;

/// A formula over the columns of a file, ready to be evaluated.
#[derive(Clone, Debug)]
pub(crate) struct Computation {
    /// Numbers of the columns it names.
    pub(crate) sources: Vec<usize>,
    steps: Vec<(NodeId, Node)>,
    value: NodeId,
    /// The value of each node.
    values: Vec<f64>,
}

impl Computation {
    /// Of a formula whose names are columns of these units, for a quantity of a unit.
    ///
    /// # Errors
    /// The dimensions do not fit, or an angle has no unit.
    pub(crate) fn of(
        formula: &Formula,
        sources: &[(&str, usize, Unit)],
        unit: &Unit,
    ) -> Result<Self, Diagnostic> {
        let is_angle = |name: &str| sources.iter().any(|(own, _, u)| *own == name && u.is_angle());
        if let Some((at, number)) = bare_angle(&formula.root, &is_angle) {
            let message = format!("`{number}` has no unit beside an angle");
            let help = format!("write `{number} deg`, or another unit of angles");
            return Err(Diagnostic::error(message).at(place(formula, at)).help(help));
        }
        if unit.is_angle() && !makes_angle(&formula.root, &is_angle) {
            let message = format!("`{}` is a number, not an angle", formula.text.trim());
            let help = "say in which unit it is: multiply by `1 deg` or `1 rad`";
            return Err(Diagnostic::error(message).at(place(formula, &formula.root)).help(help));
        }
        let input = |(name, _, unit): &(&str, usize, Unit)| Input {
            name: (*name).to_owned(),
            unit: unit.clone(),
            signal: false,
            error: None,
        };
        let delay = Parameter { name: "a.delay".into(), kind: Kind::Scalar, unit: Unit::second() };
        let computed = Measurand {
            name: "the column".into(),
            formula: formula.clone(),
            kind: MeasurandKind::Plain,
            unit: unit.clone(),
            delay: 0,
            sigma: None,
        };
        let names = Names {
            inputs: sources.iter().map(input).collect(),
            parameters: vec![delay],
            measurands: vec![computed],
            ..Names::default()
        };
        let assembly = assemble(names).map_err(|mut faults| faults.0.swap_remove(0))?;
        let value = assembly.measurands.first().and_then(|one| match one.value {
            Value::Scalar(value) => Some(value),
            _ => None,
        });
        let Some(value) = value else {
            let message = "the formula of a column is one number";
            return Err(Diagnostic::error(message).at(place(formula, &formula.root)));
        };
        let steps = steps(&assembly.graph, value);
        let values = vec![0.0; value.0 as usize + 1];
        Ok(Self {
            sources: sources.iter().map(|(_, index, _)| *index).collect(),
            steps,
            value,
            values,
        })
    }

    /// Its value in a row; `source` gives the value of the column of each name. NaN where one is
    /// missing.
    pub(crate) fn value(&mut self, source: impl Fn(usize) -> f64) -> f64 {
        for (id, node) in &self.steps {
            let at = |id: NodeId| self.values[id.0 as usize];
            let value = match *node {
                Node::Constant(bits) => f64::from_bits(bits),
                Node::Leaf(Leaf::Input(input)) => source(input as usize),
                Node::Unary(function, a) => function.apply(at(a)),
                Node::Binary(function, a, b) => function.apply(at(a), at(b)),
                _ => f64::NAN,
            };
            self.values[id.0 as usize] = value;
        }
        self.values[self.value.0 as usize]
    }
}

fn steps(graph: &Graph, value: NodeId) -> Vec<(NodeId, Node)> {
    graph.needed_by(&[value]).into_iter().map(|id| (id, graph.node(id))).collect()
}

fn place(formula: &Formula, at: &Expression) -> crate::diagnostic::Place {
    let (start, end) = (formula.offset + at.span.start, formula.offset + at.span.end);
    formula.source.place(crate::diagnostic::Span::new(start, end))
}
