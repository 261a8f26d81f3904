//! A small bench: models declared in a few lines, and one sample to evaluate them at.

use std::collections::HashMap;

use homepoint::engine::pointwise::{Leaves, Program};
use homepoint::formula::Formula;
use homepoint::graph::{
    Assembly, Clock, Graph, Input, Kind, Leaf, Local, Measurand, MeasurandKind, Names, NodeId,
    Parameter, Patch, PatchLayer, PatchTarget, Value, assemble,
};
use homepoint::number::Number;
use homepoint::units::Unit;

pub(crate) fn formula(text: &str) -> Formula {
    Formula::parse_text("test", text).unwrap()
}

pub(crate) fn unit(text: &str) -> Unit {
    Unit::parse(text).unwrap()
}

/// Names under construction.
#[derive(Clone, Default)]
pub(crate) struct Declared(pub(crate) Names);

impl Declared {
    pub(crate) fn input(mut self, name: &str, unit_text: &str, signal: bool) -> Self {
        self.0.inputs.push(Input { name: name.into(), unit: unit(unit_text), signal, error: None });
        self
    }

    pub(crate) fn parameter(mut self, name: &str, kind: Kind, unit_text: &str) -> Self {
        self.0.parameters.push(Parameter { name: name.into(), kind, unit: unit(unit_text) });
        self
    }

    pub(crate) fn quantity(mut self, name: &str, text: &str) -> Self {
        self.0.quantities.insert(name.into(), formula(text));
        self
    }

    pub(crate) fn measurand(mut self, name: &str, text: &str, unit_text: &str) -> Self {
        self = self.parameter(&format!("{name}.delay"), Kind::Scalar, "s");
        self.0.measurands.push(Measurand {
            name: name.into(),
            formula: formula(text),
            kind: MeasurandKind::Plain,
            unit: unit(unit_text),
            sigma: None,
            delay: self.0.parameters.len() - 1,
        });
        self
    }

    /// An effect; `parameters` (name, unit) become `EFFECT.NAME`; `patches` are target and formula.
    pub(crate) fn effect(
        mut self,
        effect: &str,
        parameters: &[(&str, &str)],
        patches: &[(&str, &str)],
    ) -> Self {
        let mut locals = HashMap::new();
        for (name, unit_text) in parameters {
            self = self.parameter(&format!("{effect}.{name}"), Kind::Scalar, unit_text);
            locals.insert((*name).to_owned(), Local::Parameter(self.0.parameters.len() - 1));
        }
        let measurand = |name: &str| self.0.measurands.iter().position(|m| m.name == name).unwrap();
        let patches = patches
            .iter()
            .map(|(target, text)| Patch {
                target: match target.rsplit_once('.') {
                    _ if *target == "t" => PatchTarget::AllTimes,
                    Some((name, "t")) => PatchTarget::Time(measurand(name)),
                    Some((name, "sigma")) => PatchTarget::Sigma(measurand(name)),
                    _ => PatchTarget::Name((*target).into()),
                },
                formula: formula(text),
            })
            .collect();
        self.0.layers.push(PatchLayer { effect: effect.into(), locals, patches });
        self
    }

    pub(crate) fn assemble(self) -> Assembly {
        assemble(self.0).unwrap()
    }

    /// The messages of a model that must fail.
    pub(crate) fn faults(self) -> String {
        match assemble(self.0) {
            Ok(assembly) => unreachable!("{} nodes and no fault", assembly.graph.nodes().len()),
            Err(faults) => faults.to_string(),
        }
    }
}

/// The polar instrument of formats.md, section 2.
pub(crate) fn polar() -> Declared {
    Declared::default()
        .input("arm_angle", "rad", true)
        .parameter("radius", Kind::Scalar, "m")
        .parameter("orientation", Kind::Rotation, "1")
        .parameter("position", Kind::Vector, "m")
        .quantity("arm_turn", "rotation_z(arm_angle)")
        .quantity("target", "rotate(arm_turn, [radius, 0, 0])")
        .quantity("point", "rotate(orientation, target) + position")
        .measurand("horizontal", "atan2(point.y, point.x)", "rad")
        .measurand("vertical", "atan2(hypot(point.x, point.y), point.z)", "rad")
        .measurand("distance", "norm(point)", "m")
}

/// One sample: parameters by name and component, signals as smooth functions of time.
#[derive(Clone)]
pub(crate) struct Sample<N> {
    pub(crate) time: N,
    parameters: HashMap<(u32, u8), N>,
    pub(crate) readings: HashMap<(u32, u8), f64>,
}

impl<N: Number> Sample<N> {
    pub(crate) fn at(time: N) -> Self {
        Self { time, parameters: HashMap::new(), readings: HashMap::new() }
    }

    pub(crate) fn with(mut self, names: &Names, name: &str, values: &[N]) -> Self {
        let index = names.parameters.iter().position(|p| p.name == name).unwrap();
        for (component, value) in values.iter().enumerate() {
            self.parameters.insert((index as u32, component as u8), *value);
        }
        self
    }

    /// The polar model's parameters.
    pub(crate) fn polar(self, names: &Names) -> Self {
        let c = |x: f64| N::constant(x);
        self.with(names, "radius", &[c(1.146)])
            .with(names, "orientation", &[c(0.9), c(0.1), c(-0.3), c(f64::sqrt(0.09))])
            .with(names, "position", &[c(0.2), c(-0.1), c(1.4)])
    }
}

/// Signal `input`: `0.3 + 0.7 (input + 1) time + 0.2 sin(3 time)`.
pub(crate) fn signal<N: Number>(input: u32, order: u8, time: N) -> N {
    let rate = 0.7 * f64::from(input + 1);
    let wave = (time * 3.0 + f64::from(order) * std::f64::consts::FRAC_PI_2).sin()
        * (0.2 * 3f64.powi(i32::from(order)));
    match order {
        0 => wave + time * rate + 0.3,
        1 => wave + rate,
        _ => wave,
    }
}

impl<N: Number> Leaves<N> for Sample<N> {
    fn leaf(&self, leaf: Leaf) -> N {
        match leaf {
            Leaf::Parameter { parameter, component } => self
                .parameters
                .get(&(parameter, component))
                .copied()
                .unwrap_or_else(|| N::constant(0.0)),
            Leaf::Clock(Clock::Index) => N::constant(7.0),
            Leaf::Clock(Clock::Time) => self.time,
            Leaf::Clock(Clock::RunTime) => self.time - 0.5,
            Leaf::Clock(Clock::SetupTime) => self.time + 4.0,
            Leaf::Clock(Clock::UniformTime) => self.time - 0.49,
            Leaf::Clock(Clock::JumpTime) => N::constant(0.35),
            Leaf::Clock(Clock::FirstJumpTime) => N::constant(-0.15),
            Leaf::Clock(Clock::LastJumpTime) => N::constant(0.25),
            Leaf::Reading { measurand, component } => {
                N::constant(self.readings[&(measurand, component)])
            }
            Leaf::Input(_) | Leaf::Random(_) | Leaf::Given(_) => N::constant(0.0),
        }
    }

    fn signal(&self, input: u32, order: u8, offset: N) -> N {
        signal(input, order, self.time + offset)
    }
}

pub(crate) fn evaluate<N: Number>(graph: &Graph, outputs: &[NodeId], sample: &Sample<N>) -> Vec<N> {
    Program::new(graph, outputs).evaluate(sample, &mut Vec::new()).to_vec()
}

/// The value of a scalar measurand.
pub(crate) fn measurand<N: Number>(assembly: &Assembly, name: &str, sample: &Sample<N>) -> N {
    let index = assembly.names.measurands.iter().position(|m| m.name == name).unwrap();
    let Value::Scalar(node) = assembly.measurands[index].value else {
        unreachable!("{name} is no number");
    };
    evaluate(&assembly.graph, &[node], sample)[0]
}
