//! The graph of every measurand of a model with its effects: what every engine evaluates.
//!
//! Answers: which nodes predict each reading, at which offset from the reference time it is read,
//! what becomes of its stated uncertainty, and the target from one sample's readings. It evaluates
//! nothing.

use crate::diagnostic::{Diagnostic, Diagnostics, Span, nearest};
use crate::formula::Formula;
use crate::graph::context::{Context, Moment, Resolver};
use crate::graph::layers::{BUILT_IN, Meaning, Named};
use crate::graph::lower::number;
use crate::graph::names::{CoordinatesNames, Kind, PatchTarget};
use crate::graph::typed::{Fault, Typed, fault, fault_with, quoted};
use crate::graph::{Graph, Names, NodeId, Value};
use crate::units::Dimension;

/// The graph of one model with its effects: what every engine evaluates.
#[derive(Clone, Debug)]
pub struct Assembly {
    /// What was declared.
    pub names: Names,
    /// The nodes.
    pub graph: Graph,
    /// For each measurand of `names`, its nodes.
    pub measurands: Vec<MeasurandGraph>,
    /// Nodes of `[coordinates]`, if the model has them.
    pub coordinates: Option<CoordinatesGraph>,
}

/// The nodes of one measurand, at its own moment.
#[derive(Clone, Debug)]
pub struct MeasurandGraph {
    /// Predicted reading (radians not wrapped).
    pub value: Value,
    /// The offset `t` from the reference time at which it is read, effects included.
    pub offset: NodeId,
    /// Factor on the stated standard uncertainty, if an effect patches `NAME.sigma`; where that is
    /// a formula it is stated as one, in SI.
    pub sigma_factor: Option<NodeId>,
}

/// The target from one sample's readings, for Horn's start and the deviations.
#[derive(Clone, Debug)]
pub struct CoordinatesGraph {
    /// The target in the rig's frame at reference time (offset zero).
    pub from: [NodeId; 3],
    /// The target in the instrument's frame, from the readings.
    pub measured: [NodeId; 3],
    /// What readings without errors make zero, in the unit of `measured`.
    pub gap: Option<NodeId>,
    /// Index of the rotation parameter from `from`'s frame to `measured`'s.
    pub rotation: usize,
    /// Index of the translation parameter.
    pub translation: usize,
}

/// Builds the graph of every measurand.
///
/// An effect that patches or names what the model lacks is a fault too: its messages say why the
/// effect cannot be tested with this model.
///
/// # Errors
/// Every fault of a formula: unknown names, cycles, wrong kinds or dimensions, limits passed.
pub fn assemble(names: Names) -> Result<Assembly, Diagnostics> {
    let mut faults = Faults::default();
    declared_twice(&names, &mut faults);
    indices(&names, &mut faults);
    // Indices out of range cannot be worked with.
    faults.0.into_result(())?;
    let mut faults = Faults::default();
    let mut resolver = Resolver::new(&names);
    targets(&resolver, &mut faults);
    let mut measurands = Vec::with_capacity(names.measurands.len());
    for m in 0..names.measurands.len() {
        match measurand(&mut resolver, m) {
            Ok(graph) => measurands.push(graph),
            Err(fault) => faults.add(fault),
        }
    }
    unread(&mut resolver, &mut faults);
    let coordinates = match &names.coordinates {
        Some(declared) => match coordinates(&mut resolver, declared) {
            Ok(graph) => Some(graph),
            Err(fault) => {
                faults.add(fault);
                None
            }
        },
        None => None,
    };
    let graph = resolver.graph;
    faults.0.into_result(Assembly { names, graph, measurands, coordinates })
}

/// Faults, each once.
#[derive(Default)]
struct Faults(Diagnostics);

impl Faults {
    fn add(&mut self, fault: Fault) {
        if !self.0.0.contains(&fault) {
            self.0.0.push(*fault);
        }
    }
}

/// One name may mean one thing only.
fn declared_twice(names: &Names, faults: &mut Faults) {
    let mut seen: std::collections::HashMap<&str, &str> =
        BUILT_IN.iter().map(|(name, _)| (*name, "built in")).collect();
    let inputs = names.inputs.iter().map(|input| (input.name.as_str(), "an input", None));
    let parameters = names.parameters.iter().map(|p| (p.name.as_str(), "a parameter", None));
    let quantities = names.quantities.iter().map(|(n, f)| (n.as_str(), "a quantity", Some(f)));
    let measurands =
        names.measurands.iter().map(|m| (m.name.as_str(), "a measurand", Some(&m.formula)));
    for (name, what, formula) in inputs.chain(parameters).chain(quantities).chain(measurands) {
        let Some(before) = seen.insert(name, what) else {
            continue;
        };
        let message = format!("`{name}` is {before} and cannot be {what} too");
        let help = "give one of them another name";
        faults.add(match formula {
            Some(formula) => fault_with(formula, formula.root.span, message, help),
            None => Box::new(Diagnostic::error(message).help(help)),
        });
    }
}

/// Every index within `names` must have something to point at.
fn indices(names: &Names, faults: &mut Faults) {
    use crate::graph::names::Local;
    let parameter = |p: &usize| *p < names.parameters.len();
    let random = |r: &usize| *r < names.randoms.len();
    let mut check = |good: bool, what: &str| {
        if !good {
            faults.add(Box::new(Diagnostic::error(format!("{what} points at nothing"))));
        }
    };
    for input in &names.inputs {
        check(input.error.as_ref().is_none_or(random), &format!("the error of `{}`", input.name));
    }
    for measurand in &names.measurands {
        check(parameter(&measurand.delay), &format!("the delay of `{}`", measurand.name));
    }
    for layer in &names.layers {
        for (name, local) in &layer.locals {
            let good = match local {
                Local::Parameter(p) => parameter(p),
                Local::PerMeasurand(list) => list.iter().all(parameter),
                Local::Random(r) => random(r),
                Local::RandomPerMeasurand(list) => list.iter().all(random),
                Local::Constant(..) | Local::Name(_) => true,
            };
            check(good, &format!("`{name}` of the effect `{}`", layer.effect));
        }
        for patch in &layer.patches {
            if let PatchTarget::Time(m) | PatchTarget::Sigma(m) = patch.target {
                check(
                    m < names.measurands.len(),
                    &format!("a patch of the effect `{}`", layer.effect),
                );
            }
        }
    }
    if let Some(coordinates) = &names.coordinates {
        check(
            parameter(&coordinates.rotation) && parameter(&coordinates.translation),
            "[coordinates]",
        );
    }
}

/// Every patch must act on something the model has.
fn targets(resolver: &Resolver<'_>, faults: &mut Faults) {
    for (l, layer) in resolver.names.layers.iter().enumerate() {
        for (p, patch) in layer.patches.iter().enumerate() {
            let PatchTarget::Name(name) = &patch.target else {
                continue;
            };
            let (formula, span) = (&patch.formula, patch.formula.root.span);
            match resolver.dictionary.target((l, p)) {
                Meaning::Model(
                    Named::Input(_)
                    | Named::Parameter(_)
                    | Named::Random(_)
                    | Named::Quantity(_)
                    | Named::Measurand(_)
                    | Named::Offset,
                ) => {}
                Meaning::Unknown => {
                    let message = format!(
                        "the effect `{}` patches `{name}`, which the model lacks",
                        layer.effect
                    );
                    let mut fault = fault(formula, span, message);
                    let mut known: Vec<&str> = resolver.dictionary.known().collect();
                    known.sort_unstable();
                    if let Some(near) = nearest(name, known) {
                        *fault = fault.help(format!("did you mean `{near}`?"));
                    }
                    faults.add(fault);
                }
                _ => faults.add(fault_with(
                    formula,
                    span,
                    format!("the effect `{}` cannot patch `{name}`", layer.effect),
                    "patch `t`, an input, a parameter, a quantity or a measurand",
                )),
            }
        }
    }
}

/// The nodes of one measurand at its moment, with all effects on.
fn measurand(resolver: &mut Resolver<'_>, m: usize) -> Result<MeasurandGraph, Fault> {
    let context = resolver.context(Moment::Of(m), true);
    let formula = &resolver.names.measurands[m].formula;
    let at = (formula, formula.root.span);
    let value = resolver.resolve(Named::Measurand(m), &context, at)?.value;
    let offset = resolver.resolve(Named::Offset, &context, at)?;
    let offset = number(formula, formula.root.span, &offset, "a delay")?;
    let sigma_factor = sigma_factor(resolver, m, context)?;
    Ok(MeasurandGraph { value, offset, sigma_factor })
}

/// What the effects make of a noise level of one unit, or of the formula in its place.
fn sigma_factor(
    resolver: &mut Resolver<'_>,
    m: usize,
    mut context: Context,
) -> Result<Option<NodeId>, Fault> {
    let names = resolver.names;
    let mut patches = Vec::new();
    for (l, layer) in names.layers.iter().enumerate() {
        let patch = layer.patches.iter().rposition(|patch| patch.target == PatchTarget::Sigma(m));
        patches.extend(patch.map(|p| (l, p)));
    }
    let stated = &names.measurands[m].sigma;
    if patches.is_empty() && stated.is_none() {
        return Ok(None);
    }
    let dimension = names.measurands[m].unit.dimension;
    let mut sigma = Typed::scalar(resolver.graph.constant(1.0), dimension);
    if let Some(formula) = stated {
        let level = resolver.lower(formula, &formula.root, &context)?;
        if level.kind() != Kind::Scalar || !level.fits(dimension) {
            let message = format!(
                "the standard uncertainty of `{}` is {}, expected {}",
                names.measurands[m].name,
                level.words(),
                sigma.words()
            );
            return Err(fault(formula, formula.root.span, message));
        }
        sigma = Typed { dimension, any_dimension: false, ..level };
    }
    let all = context.layers.clone();
    for (position, index) in patches.iter().enumerate() {
        context.layers =
            patches[position..].iter().fold(all.clone(), |layers, (l, _)| layers.without(*l));
        context.patch = Some(*index);
        context.sigma = Some(sigma);
        let formula = &names.layers[index.0].patches[index.1].formula;
        let after = resolver.lower(formula, &formula.root, &context)?;
        if after.kind() != Kind::Scalar || !after.fits(dimension) {
            let message = format!(
                "the effect `{}` makes `{}.sigma` {}, which is {}",
                names.layers[index.0].effect,
                names.measurands[m].name,
                after.words(),
                sigma.words()
            );
            return Err(fault(formula, formula.root.span, message));
        }
        sigma = Typed { dimension, any_dimension: false, ..after };
    }
    Ok(Some(sigma.value.nodes()[0]))
}

/// Checks what no measurand reaches: quantities nobody uses, patches of such.
fn unread(resolver: &mut Resolver<'_>, faults: &mut Faults) {
    let names = resolver.names;
    let moment = if names.measurands.is_empty() {
        Moment::Reference { readings: false }
    } else {
        Moment::Of(0)
    };
    let context = resolver.context(moment, true);
    let mut things: Vec<(Named, &Formula)> = Vec::new();
    things.extend(names.quantities.values().enumerate().map(|(q, f)| (Named::Quantity(q), f)));
    for (l, layer) in names.layers.iter().enumerate() {
        for (p, patch) in layer.patches.iter().enumerate() {
            if let Meaning::Model(named) = resolver.dictionary.target((l, p)) {
                things.push((named, &patch.formula));
            }
        }
    }
    for (named, formula) in things {
        if let Err(fault) = resolver.resolve(named, &context, (formula, formula.root.span)) {
            faults.add(fault);
        }
    }
}

/// The nodes of `[coordinates]`: at reference time, without effects.
fn coordinates(
    resolver: &mut Resolver<'_>,
    declared: &CoordinatesNames,
) -> Result<CoordinatesGraph, Fault> {
    let context = resolver.context(Moment::Reference { readings: false }, false);
    let (from, dimension) = point(resolver, &declared.from, &context)?;
    let mut context = resolver.context(Moment::Reference { readings: true }, false);
    for (name, formula) in &declared.helpers {
        let typed = resolver.lower(formula, &formula.root, &context)?;
        context.helpers.insert(name.clone(), typed);
    }
    let (measured, measured_dimension) = point(resolver, &declared.measured, &context)?;
    let gap =
        declared.gap.as_ref().map(|formula| gap(resolver, formula, &context, measured_dimension));
    let gap = gap.transpose()?;
    let parameters = &resolver.names.parameters;
    let span = declared.from.root.span;
    let rotation = &parameters[declared.rotation];
    if rotation.kind != Kind::Rotation {
        let message = format!("`{}` is not a rotation, [coordinates] needs one", rotation.name);
        return Err(fault(&declared.from, span, message));
    }
    let translation = &parameters[declared.translation];
    let due = translation.unit.dimension;
    if translation.kind != Kind::Vector || dimension != due || measured_dimension != due {
        let message = format!(
            "`from` (in {dimension}), `measured` (in {measured_dimension}) and `{}` (in {due}) must \
             be vectors of one dimension",
            translation.name
        );
        return Err(fault(&declared.from, span, message));
    }
    let (rotation, translation) = (declared.rotation, declared.translation);
    Ok(CoordinatesGraph { from, measured, gap, rotation, translation })
}

/// The node of a gap.
fn gap(
    resolver: &mut Resolver<'_>,
    formula: &Formula,
    context: &Context,
    due: Dimension,
) -> Result<NodeId, Fault> {
    let typed = resolver.lower(formula, &formula.root, context)?;
    match typed.value {
        Value::Scalar(node) if typed.dimension == due => Ok(node),
        _ => {
            let span = formula.root.span;
            let message = format!(
                "{} is {}; a gap is a number in the unit of the point ({due})",
                quoted(formula, span),
                typed.words()
            );
            Err(fault(formula, span, message))
        }
    }
}

/// The nodes of a point.
fn point(
    resolver: &mut Resolver<'_>,
    formula: &Formula,
    context: &Context,
) -> Result<([NodeId; 3], Dimension), Fault> {
    let span: Span = formula.root.span;
    let typed = resolver.lower(formula, &formula.root, context)?;
    match typed.value {
        Value::Vector(nodes) => Ok((nodes, typed.dimension)),
        _ => {
            let message =
                format!("{} is {}; a point is a vector", quoted(formula, span), typed.words());
            Err(fault(formula, span, message))
        }
    }
}
