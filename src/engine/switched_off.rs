//! Whether an effect is absent where it is switched off.
//!
//! Answers: which reading an effect still changes when its parameters are zero and nothing is
//! drawn. Mostly both models are the same nodes then; where they are not, expressions that only
//! look different are told from such as differ by their values at some points. It does not ask
//! whether the effect does anything when it is on.

mod slope;

use std::collections::{BTreeMap, HashMap};

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::effect::Members;
use crate::engine::point::from_components;
use crate::engine::pointwise::{Leaves, Program};
use crate::graph::import::Import;
use crate::graph::names::Parameter;
use crate::graph::{Graph, Kind, Leaf, NodeId};
use crate::model::{Model, Override};
use crate::system::{Selected, System};

pub use slope::without_slope;

/// Points at which expressions are compared.
const POINTS: u32 = 24;
/// By so much two expressions of the same thing may differ, in SI, and of values above 1 in parts
/// of them: far more than rounding.
const ROUNDING: f64 = 1e-11;

/// The value of a component of a parameter of an effect that is switched off: what is free is zero
/// (no turn), constants and members of families are what they are.
pub fn off(system: &System, parameter: usize, component: u8) -> f64 {
    let setting = &system.settings[parameter];
    let stated = setting.fixed.then_some(setting.value.as_deref()).flatten();
    let kind = system.assembly.names.parameters[parameter].kind;
    from_components(kind, stated.unwrap_or_default())[usize::from(component)]
}

/// Why an effect cannot be tested with a model beside effects that are in use: it is there although
/// its parameters are zero. `None` where it is absent, as it should be.
///
/// # Errors
/// As [`System::build`].
pub fn remains(
    (model, in_use): (&Model, &[Selected]),
    selected: &Selected,
    overrides: &[Override],
    input_sigma: &[Option<f64>],
) -> Result<Option<Diagnostic>, Diagnostics> {
    let effect = &selected.effect;
    let without = System::build(model, in_use, overrides, input_sigma)?;
    let mut found = None;
    for member in members(selected) {
        let one = Selected { member, ..selected.clone() };
        let all: Vec<Selected> = in_use.iter().cloned().chain([one]).collect();
        let with = System::build(model, &all, overrides, input_sigma)?;
        found = found.or_else(|| changed(&without, &with));
    }
    Ok(found.map(|what| {
        let message = format!("it changes {what} where its parameters are zero");
        let told = Diagnostic::error(message).help(
            "write it so that zero switches it off, as in 'self + offset' or 'self * (1 + scale)'; what is always there belongs in the model",
        );
        match effect.patches.first() {
            Some(patch) => told.at(effect.source.place(patch.span)),
            None => told,
        }
    }))
}

/// The same of an effect alone with a model, whose inputs have no uncertainty.
///
/// # Errors
/// As [`System::build`].
pub fn remains_alone(
    model: &Model,
    selected: &Selected,
    overrides: &[Override],
) -> Result<Option<Diagnostic>, Diagnostics> {
    remains((model, &[]), selected, overrides, &vec![None; model.inputs.len()])
}

/// The chosen members of an effect's families; where none is chosen all of a list, both ends of a
/// range and its middle, one family at a time.
fn members(selected: &Selected) -> Vec<BTreeMap<String, f64>> {
    let open =
        selected.effect.shape.iter().filter(|(name, _)| !selected.member.contains_key(*name));
    let others = open.flat_map(|(name, family)| {
        let values = match &family.members {
            Members::List(list) => list.clone(),
            Members::Range { from, to } => vec![*from, family.members.default_member(), *to],
        };
        let with = |value| selected.member.clone().into_iter().chain([(name.clone(), value)]);
        values.into_iter().map(with).map(Iterator::collect).collect::<Vec<_>>()
    });
    std::iter::once(selected.member.clone()).chain(others).collect()
}

/// What of a model is another with an effect that is switched off, in words.
fn changed(without: &System, with: &System) -> Option<String> {
    let mut graph = Graph::boundless();
    let [before, after] = [without, with]
        .map(|system| outputs(system, without, &mut graph, &|at, of| off(system, at, of)));
    let names = without.assembly.names.measurands.iter();
    names.zip(before.iter().zip(&after)).find_map(|(measurand, (before, after))| {
        let name = &measurand.name;
        let differs = |one: fn(&Outputs) -> &[NodeId]| {
            differ(&graph, &without.assembly.names.parameters, one(before), one(after))
        };
        if differs(|one| &one.reading) {
            Some(format!("`{name}`"))
        } else {
            differs(|one| &one.level).then(|| format!("the noise of `{name}`"))
        }
    })
}

/// The nodes of one measurand.
struct Outputs {
    reading: Vec<NodeId>,
    level: Vec<NodeId>,
}

/// The nodes of a system's measurands in a graph whose parameters are those of `known`: others are
/// what `value` has of them by their number and component.
fn outputs(
    system: &System,
    known: &System,
    graph: &mut Graph,
    value: &dyn Fn(usize, u8) -> f64,
) -> Vec<Outputs> {
    let numbers: HashMap<&str, u32> = (0..)
        .zip(&known.assembly.names.parameters)
        .map(|(n, one)| (one.name.as_str(), n))
        .collect();
    let mut leaf = |graph: &mut Graph, leaf| match leaf {
        Leaf::Random(_) => graph.constant(0.0),
        Leaf::Parameter { parameter, component } => {
            let index = parameter as usize;
            match numbers.get(system.assembly.names.parameters[index].name.as_str()) {
                Some(parameter) => graph.leaf(Leaf::Parameter { parameter: *parameter, component }),
                None => graph.constant(value(index, component)),
            }
        }
        other => graph.leaf(other),
    };
    let mut import = Import::default();
    let mut of = |node: NodeId, graph: &mut Graph| {
        import.node(&system.assembly.graph, node, graph, &mut leaf)
    };
    let measurands = system.assembly.measurands.iter().map(|one| {
        let reading = one.value.nodes().iter().map(|node| of(*node, graph)).collect();
        let level = match one.sigma_factor {
            Some(factor) => of(factor, graph),
            None => graph.constant(1.0),
        };
        Outputs { reading, level: vec![level] }
    });
    measurands.collect()
}

/// Whether two lists of nodes differ: in value at some point, or because the second has no values
/// at any point where the first has. Their parameters are these.
fn differ(graph: &Graph, parameters: &[Parameter], before: &[NodeId], after: &[NodeId]) -> bool {
    if before == after {
        return false;
    }
    let both: Vec<NodeId> = before.iter().chain(after).copied().collect();
    let program = Program::new(graph, &both);
    let (mut workspace, mut has_values, mut has_both) = (Vec::new(), false, false);
    for point in 0..POINTS {
        let values = program.evaluate(&Anywhere { point, parameters }, &mut workspace);
        let (before, after) = values.split_at(before.len());
        if before.iter().all(|value| value.is_finite()) {
            has_values = true;
            if after.iter().all(|value| value.is_finite()) {
                has_both = true;
                let far = |(a, b): (&f64, &f64)| (a - b).abs() > ROUNDING * a.abs().max(1.0);
                if before.iter().zip(after).any(far) {
                    return true;
                }
            }
        }
    }
    has_values && !has_both
}

/// Some values, others at every point: of both signs at every other one, of three magnitudes;
/// rotations are such.
struct Anywhere<'a> {
    point: u32,
    parameters: &'a [Parameter],
}

impl Anywhere<'_> {
    fn some(&self, key: [u32; 3]) -> f64 {
        // Multiples of irrational numbers, which fill the interval evenly.
        let [kind, number, component] = key.map(f64::from);
        let sum = 0.754_877_666 * (number + 1.0) + 0.569_840_291 * component + 0.213_6 * kind;
        let even = (sum + 0.618_033_989 * f64::from(self.point + 1)).fract();
        let magnitude = [1.0, 0.1, 8.0][self.point as usize / 2 % 3];
        magnitude * if self.point.is_multiple_of(2) { 0.1 + even } else { 2.0 * even - 1.0 }
    }
}

impl Leaves<f64> for Anywhere<'_> {
    fn leaf(&self, leaf: Leaf) -> f64 {
        let key = match leaf {
            Leaf::Parameter { parameter, component } => {
                let at = |component| self.some([0, parameter, component]);
                if self.parameters[parameter as usize].kind == Kind::Rotation {
                    let vector = [0, 1, 2].map(at);
                    return from_components(Kind::Rotation, &vector)[usize::from(component)];
                }
                return at(u32::from(component));
            }
            Leaf::Random(number) => [1, number, 0],
            Leaf::Input(number) => [2, number, 0],
            Leaf::Clock(clock) => [3, clock as u32, 0],
            Leaf::Given(number) => [4, number, 0],
            Leaf::Reading { measurand, component } => [5, measurand, u32::from(component)],
        };
        self.some(key)
    }

    fn signal(&self, input: u32, order: u8, offset: f64) -> f64 {
        self.some([6, input, u32::from(order)]) + offset * self.some([7, input, u32::from(order)])
    }
}
