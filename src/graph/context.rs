//! What a name means at a measurand's moment under a set of effects.
//!
//! In the context (layers S, measurand m): if a layer of S patches the name, the last such layer k
//! gives its meaning, and on that patch's right-hand side everything means the graph under S
//! without k. Otherwise its own definition holds, in the same context. So no effect can be part of
//! a cycle, a later effect flows through an earlier one's right-hand side, and with all effects
//! off the graph is the nominal one.

use indexmap::IndexMap;

use crate::diagnostic::{Span, nearest};
use crate::formula::Formula;
use crate::graph::delayed::Delayed;
use crate::graph::layers::{Dictionary, LayerSet, Meaning, Named, PatchIndex};
use crate::graph::names::{Kind, Local, MeasurandKind, Names, PatchTarget};
use crate::graph::node::{Clock, Leaf};
use crate::graph::rate::Rates;
use crate::graph::table::Table;
use crate::graph::typed::{Fault, Typed, fault, fault_with, words};
use crate::graph::{Graph, Value};
use crate::units::Dimension;

/// So many meanings (name, effects, measurand) are worked out at most.
const MEANING_LIMIT: usize = 200_000;

/// When names are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Moment {
    /// At the moment of a measurand's reading.
    Of(usize),
    /// At reference time, without errors; with `readings`, a measurand's name is its reading.
    Reference { readings: bool },
}

impl Moment {
    fn measurand(self) -> Option<usize> {
        match self {
            Self::Of(m) => Some(m),
            Self::Reference { .. } => None,
        }
    }
}

/// Where a formula stands: what its names mean.
#[derive(Clone, Debug)]
pub(super) struct Context {
    /// Effects that are on.
    pub(super) layers: LayerSet,
    /// When.
    pub(super) moment: Moment,
    /// The patch whose right-hand side it is.
    pub(super) patch: Option<PatchIndex>,
    /// The unpatched noise level, in a patch of one.
    pub(super) sigma: Option<Typed>,
    /// Helper lines so far, in `[coordinates]`.
    pub(super) helpers: IndexMap<String, Typed>,
}

type Key = (Named, LayerSet, Moment);

/// Turns names into nodes.
pub(super) struct Resolver<'n> {
    pub(super) names: &'n Names,
    pub(super) dictionary: Dictionary<'n>,
    pub(super) graph: Graph,
    pub(super) rates: Rates,
    pub(super) delayed: Delayed,
    pub(super) depth: usize,
    known: Table<Key, Result<Typed, Fault>>,
    cut: Table<Key, LayerSet>,
    active: Vec<Key>,
}

impl<'n> Resolver<'n> {
    pub(super) fn new(names: &'n Names) -> Self {
        Self {
            names,
            dictionary: Dictionary::new(names),
            graph: Graph::default(),
            rates: Rates::default(),
            delayed: Delayed::default(),
            depth: 0,
            known: Table::default(),
            cut: Table::default(),
            active: Vec::new(),
        }
    }

    /// A context without effects, or with all of them.
    pub(super) fn context(&self, moment: Moment, effects: bool) -> Context {
        let count = self.names.layers.len();
        let layers = if effects { LayerSet::all(count) } else { LayerSet::none(count) };
        Context { layers, moment, patch: None, sigma: None, helpers: IndexMap::new() }
    }

    /// The value of a name in a formula.
    #[inline(never)]
    pub(super) fn name(
        &mut self,
        formula: &Formula,
        name: &str,
        span: Span,
        context: &Context,
    ) -> Result<Typed, Fault> {
        if let Some(helper) = context.helpers.get(name) {
            return Ok(*helper);
        }
        match self.dictionary.meaning(context.patch, name) {
            Meaning::Model(named) => self.resolve(named, context, (formula, span)),
            Meaning::Sigma => match context.sigma {
                Some(sigma) => Ok(sigma),
                None => Err(self.unknown(formula, name, span, context)),
            },
            Meaning::Local(local) => self.local(local, formula, name, span, context),
            Meaning::Unknown => Err(self.unknown(formula, name, span, context)),
        }
    }

    fn local(
        &mut self,
        local: &Local,
        formula: &Formula,
        name: &str,
        span: Span,
        context: &Context,
    ) -> Result<Typed, Fault> {
        let random = |resolver: &mut Self, index: usize| {
            let dimension = resolver.names.randoms[index].dimension;
            Typed::scalar(resolver.graph.leaf(Leaf::Random(index as u32)), dimension)
        };
        let own = self.measurand_of(context);
        let each = |list: &[usize]| own.and_then(|m| list.get(m).copied());
        let parameter = match local {
            Local::Parameter(p) => Some(*p),
            Local::PerMeasurand(list) => each(list),
            Local::Random(r) => return Ok(random(self, *r)),
            Local::RandomPerMeasurand(list) => match each(list) {
                Some(r) => return Ok(random(self, r)),
                None => None,
            },
            Local::Constant(value, dimension) => {
                return Ok(Typed::scalar(self.graph.constant(*value), *dimension));
            }
            Local::Name(_) => None,
        };
        match parameter {
            Some(p) => self.resolve(Named::Parameter(p), context, (formula, span)),
            None => Err(self.unknown(formula, name, span, context)),
        }
    }

    /// The measurand that a per-measurand name belongs to: the patched one, else the context's.
    fn measurand_of(&self, context: &Context) -> Option<usize> {
        let patched = context.patch.and_then(|index| match self.dictionary.patch(index).target {
            PatchTarget::Time(m) | PatchTarget::Sigma(m) => Some(m),
            PatchTarget::AllTimes => None,
            PatchTarget::Name(_) => match self.dictionary.target(index) {
                Meaning::Model(Named::Measurand(m)) => Some(m),
                _ => None,
            },
        });
        patched.or(context.moment.measurand())
    }

    /// The value of a thing of the model in a context, named at a place.
    pub(super) fn resolve(
        &mut self,
        named: Named,
        context: &Context,
        at: (&Formula, Span),
    ) -> Result<Typed, Fault> {
        let layers = self.mattering(named, context);
        let key = (named, layers, context.moment);
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        if let Some(start) = self.active.iter().position(|active| *active == key) {
            return Err(self.cycle(start, named, at));
        }
        if self.known.len() >= MEANING_LIMIT {
            return Err(fault_with(
                at.0,
                at.1,
                "names and effects are too entangled here to be worked out",
                "use fewer effects at once",
            ));
        }
        self.active.push(key.clone());
        let result = self.define(named, &key.1, context.moment, at);
        self.active.pop();
        self.known.insert(key, result.clone());
        result
    }

    fn mattering(&mut self, named: Named, context: &Context) -> LayerSet {
        let key = (named, context.layers.clone(), context.moment);
        if let Some(cut) = self.cut.get(&key) {
            return cut.clone();
        }
        let measurand = context.moment.measurand();
        let cut = self.dictionary.mattering(named, measurand, &context.layers);
        self.cut.insert(key, cut.clone());
        cut
    }

    /// The last patch of a thing, or its own definition.
    #[inline(never)]
    fn define(
        &mut self,
        named: Named,
        layers: &LayerSet,
        moment: Moment,
        at: (&Formula, Span),
    ) -> Result<Typed, Fault> {
        let mut context = Context {
            layers: layers.clone(),
            moment,
            patch: None,
            sigma: None,
            helpers: IndexMap::new(),
        };
        let last = self.dictionary.last_patch(named, moment.measurand(), layers);
        let typed = if let Some(index) = last {
            context.layers = layers.without(index.0);
            let before = self.resolve(named, &context, at)?;
            context.patch = Some(index);
            self.patched(index, named, &before, &context)?
        } else {
            self.own(named, &context, at)?
        };
        if named == Named::Offset
            && let Value::Scalar(node) = typed.value
        {
            self.rates.hold_still(node);
        }
        Ok(typed)
    }

    /// The right-hand side of a patch, which must be what the thing was before.
    #[inline(never)]
    fn patched(
        &mut self,
        index: PatchIndex,
        named: Named,
        before: &Typed,
        context: &Context,
    ) -> Result<Typed, Fault> {
        let formula = &self.dictionary.patch(index).formula;
        let after = self.lower(formula, &formula.root, context)?;
        if after.kind() != before.kind() || !after.fits(before.dimension) {
            let message = format!(
                "the effect `{}` makes `{}` {}, which is {}",
                self.names.layers[index.0].effect,
                self.dictionary.name_of(named),
                after.words(),
                before.words()
            );
            return Err(fault(formula, formula.root.span, message));
        }
        Ok(Typed { dimension: before.dimension, any_dimension: false, ..after })
    }

    /// A thing's own definition.
    #[inline(never)]
    fn own(
        &mut self,
        named: Named,
        context: &Context,
        at: (&Formula, Span),
    ) -> Result<Typed, Fault> {
        let names = self.names;
        match named {
            Named::Input(i) => self.input(i, context, at),
            Named::Parameter(p) => {
                let parameter = &names.parameters[p];
                let value = self.graph.leaves(parameter.kind, |component| Leaf::Parameter {
                    parameter: p as u32,
                    component,
                });
                let dimension = match parameter.kind {
                    Kind::Rotation => Dimension::NONE,
                    _ => parameter.unit.dimension,
                };
                Ok(Typed::new(value, dimension))
            }
            Named::Random(r) => {
                let dimension = names.randoms[r].dimension;
                // Its mean is what holds for the readings' own coordinates.
                let node = match context.moment {
                    Moment::Of(_) => self.graph.leaf(Leaf::Random(r as u32)),
                    Moment::Reference { .. } => self.graph.constant(0.0),
                };
                Ok(Typed::scalar(node, dimension))
            }
            Named::Quantity(q) => match names.quantities.get_index(q) {
                Some((_, formula)) => self.lower(formula, &formula.root, context),
                None => Err(fault(at.0, at.1, "this quantity is not declared")),
            },
            Named::Measurand(m) => self.measurand(m, context),
            Named::Offset => match context.moment {
                Moment::Of(m) => {
                    let delay = Named::Parameter(names.measurands[m].delay);
                    self.resolve(delay, context, at)
                }
                Moment::Reference { .. } => {
                    Ok(Typed::scalar(self.graph.constant(0.0), Dimension::TIME))
                }
            },
            Named::Clock(clock) => {
                let node = self.graph.leaf(Leaf::Clock(clock));
                let counts = clock == Clock::Index;
                Ok(Typed::scalar(node, if counts { Dimension::NONE } else { Dimension::TIME }))
            }
            Named::Moment => {
                let time = self.graph.leaf(Leaf::Clock(Clock::Time));
                let offset = self.resolve(Named::Offset, context, at)?;
                let node = offset.value.nodes()[0];
                Ok(Typed::scalar(self.graph.add(time, node), Dimension::TIME))
            }
            Named::Pi => Ok(Typed::plain(self.graph.constant(std::f64::consts::PI))),
        }
    }

    fn input(
        &mut self,
        index: usize,
        context: &Context,
        at: (&Formula, Span),
    ) -> Result<Typed, Fault> {
        let input = &self.names.inputs[index];
        let mut node = if input.signal {
            let offset = self.resolve(Named::Offset, context, at)?.value.nodes()[0];
            self.graph.signal(index as u32, 0, offset)
        } else {
            self.graph.leaf(Leaf::Input(index as u32))
        };
        if let (Some(error), Moment::Of(_)) = (input.error, context.moment) {
            let error = self.graph.leaf(Leaf::Random(error as u32));
            node = self.graph.add(node, error);
        }
        Ok(Typed::scalar(node, input.unit.dimension))
    }

    #[inline(never)]
    fn measurand(&mut self, index: usize, context: &Context) -> Result<Typed, Fault> {
        let measurand = &self.names.measurands[index];
        let (kind, dimension) = match measurand.kind {
            MeasurandKind::Rotation => (Kind::Rotation, Dimension::NONE),
            _ => (Kind::Scalar, measurand.unit.dimension),
        };
        if context.moment == (Moment::Reference { readings: true }) {
            let value = self
                .graph
                .leaves(kind, |component| Leaf::Reading { measurand: index as u32, component });
            return Ok(Typed::new(value, dimension));
        }
        let formula = &measurand.formula;
        let typed = self.lower(formula, &formula.root, context)?;
        if typed.kind() != kind || !typed.fits(dimension) {
            let message = format!(
                "`{}` is declared as {}, but its formula is {}",
                measurand.name,
                words(kind, dimension),
                typed.words()
            );
            return Err(fault(formula, formula.root.span, message));
        }
        Ok(Typed { dimension, any_dimension: false, ..typed })
    }

    fn cycle(&self, start: usize, named: Named, at: (&Formula, Span)) -> Fault {
        let mut path: Vec<&str> = Vec::new();
        for (active, _, _) in self.active[start..].iter().take(20) {
            path.push(self.dictionary.name_of(*active));
        }
        path.push(self.dictionary.name_of(named));
        let message = format!("`{}` is defined by itself: {}", path[0], path.join(" -> "));
        fault(at.0, at.1, message)
    }

    fn unknown(&self, formula: &Formula, name: &str, span: Span, context: &Context) -> Fault {
        let layer = context.patch.map(|(layer, _)| &self.names.layers[layer]);
        let whose = match layer {
            Some(layer) => format!("neither the model nor the effect `{}` has", layer.effect),
            None => "the model has no".to_owned(),
        };
        let mut fault = fault(formula, span, format!("{whose} `{name}`"));
        if matches!(name, "self" | "sigma" | "each") {
            *fault =
                fault.help(format!("`{name}` has a meaning only in an effect that patches it"));
            return fault;
        }
        let mut visible: Vec<&str> = self.dictionary.known().collect();
        visible.extend(context.helpers.keys().map(String::as_str));
        visible.extend(layer.into_iter().flat_map(|layer| layer.locals.keys()).map(String::as_str));
        visible.sort_unstable();
        if let Some(near) = nearest(name, visible) {
            *fault = fault.help(format!("did you mean `{near}`?"));
        }
        fault
    }
}
