//! Sets of effects, and which of them can matter to a name.
//!
//! A name's meaning depends on the set of effects that are on. Only those that can reach it matter;
//! cutting the set down to them keeps the number of different meanings small. Names are followed
//! through every definition and every patch of the set, so the answer may name an effect too many,
//! never one too few.

use crate::formula::Formula;
use crate::graph::names::{Local, Names, PatchTarget};
use crate::graph::node::Clock;
use crate::graph::table::{Set, Table};

/// A set of layers (effects), by index.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct LayerSet(Vec<u64>);

impl LayerSet {
    /// The first `count` layers.
    pub fn all(count: usize) -> Self {
        let mut set = Self::none(count);
        (0..count).for_each(|layer| set.insert(layer));
        set
    }

    /// No layer of `count`.
    pub fn none(count: usize) -> Self {
        Self(vec![0; count.div_ceil(64)])
    }

    /// Whether a layer is in it.
    pub fn contains(&self, layer: usize) -> bool {
        self.0.get(layer / 64).is_some_and(|word| word & (1 << (layer % 64)) != 0)
    }

    /// Puts a layer in.
    pub fn insert(&mut self, layer: usize) {
        if let Some(word) = self.0.get_mut(layer / 64) {
            *word |= 1 << (layer % 64);
        }
    }

    /// The same without one layer.
    pub fn without(&self, layer: usize) -> Self {
        let mut set = self.clone();
        if let Some(word) = set.0.get_mut(layer / 64) {
            *word &= !(1 << (layer % 64));
        }
        set
    }
}

/// What a name of the model is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Named {
    /// An input.
    Input(usize),
    /// A parameter.
    Parameter(usize),
    /// A random parameter of the model's own.
    Random(usize),
    /// A quantity.
    Quantity(usize),
    /// A measurand.
    Measurand(usize),
    /// `t`, the offset from the reference time.
    Offset,
    /// A time of the sample.
    Clock(Clock),
    /// `moment`, the reference time plus `t`.
    Moment,
    /// `pi`.
    Pi,
}

/// The names that every model has.
pub const BUILT_IN: [(&str, Named); 11] = [
    ("t", Named::Offset),
    ("time", Named::Clock(Clock::Time)),
    ("run_time", Named::Clock(Clock::RunTime)),
    ("setup_time", Named::Clock(Clock::SetupTime)),
    ("uniform_time", Named::Clock(Clock::UniformTime)),
    ("jump_time", Named::Clock(Clock::JumpTime)),
    ("first_jump_time", Named::Clock(Clock::FirstJumpTime)),
    ("last_jump_time", Named::Clock(Clock::LastJumpTime)),
    ("index", Named::Clock(Clock::Index)),
    ("moment", Named::Moment),
    ("pi", Named::Pi),
];

/// What a name in a formula stands for.
#[derive(Clone, Copy, Debug)]
pub enum Meaning<'n> {
    /// A name of the model.
    Model(Named),
    /// The unpatched noise level.
    Sigma,
    /// A name of the effect.
    Local(&'n Local),
    /// Nothing.
    Unknown,
}

/// A patch: index of its layer and index within it.
pub type PatchIndex = (usize, usize);

/// The names of a model, what each uses, and which patches act on it.
#[derive(Debug)]
pub struct Dictionary<'n> {
    names: &'n Names,
    index: Table<String, Named>,
    /// Patches by what they act on (for `t` by measurand too), in order of layers.
    patches: Table<(Named, Option<usize>), Vec<PatchIndex>>,
    /// Names used by quantities, measurands and patches.
    quantity_uses: Vec<Vec<Named>>,
    measurand_uses: Vec<Vec<Named>>,
    patch_uses: Table<PatchIndex, Vec<Named>>,
}

impl<'n> Dictionary<'n> {
    /// The dictionary of these names. A name declared twice means the first.
    pub fn new(names: &'n Names) -> Self {
        let mut index = Table::default();
        let mut add = |name: &str, named| {
            index.entry(name.to_owned()).or_insert(named);
        };
        for (name, named) in BUILT_IN {
            add(name, named);
        }
        for (i, input) in names.inputs.iter().enumerate() {
            add(&input.name, Named::Input(i));
        }
        for (i, parameter) in names.parameters.iter().enumerate() {
            add(&parameter.name, Named::Parameter(i));
        }
        for (i, random) in names.randoms.iter().enumerate() {
            add(&random.name, Named::Random(i));
        }
        for (i, name) in names.quantities.keys().enumerate() {
            add(name, Named::Quantity(i));
        }
        for (i, measurand) in names.measurands.iter().enumerate() {
            add(&measurand.name, Named::Measurand(i));
            add(&format!("{}.delay", measurand.name), Named::Parameter(measurand.delay));
        }
        let mut dictionary = Self {
            names,
            index,
            patches: Table::default(),
            quantity_uses: Vec::new(),
            measurand_uses: Vec::new(),
            patch_uses: Table::default(),
        };
        dictionary.quantity_uses =
            names.quantities.values().map(|formula| dictionary.uses(formula, None)).collect();
        dictionary.measurand_uses =
            names.measurands.iter().map(|m| dictionary.uses(&m.formula, None)).collect();
        dictionary.index_patches();
        dictionary
    }

    fn index_patches(&mut self) {
        for (l, layer) in self.names.layers.iter().enumerate() {
            for (p, patch) in layer.patches.iter().enumerate() {
                let uses = self.uses(&patch.formula, Some((l, p)));
                self.patch_uses.insert((l, p), uses);
                let targets: Vec<_> = match &patch.target {
                    PatchTarget::AllTimes => {
                        (0..self.names.measurands.len()).map(|m| (Named::Offset, Some(m))).collect()
                    }
                    PatchTarget::Time(m) => vec![(Named::Offset, Some(*m))],
                    PatchTarget::Sigma(_) => Vec::new(),
                    PatchTarget::Name(_) => match self.target((l, p)) {
                        Meaning::Model(named) => vec![(named, None)],
                        _ => Vec::new(),
                    },
                };
                for target in targets {
                    let list = self.patches.entry(target).or_default();
                    // Of one effect the patch of one measurand's `t` goes before that of all.
                    match list.last() {
                        Some((last, _))
                            if *last == l && matches!(patch.target, PatchTarget::AllTimes) => {}
                        Some((last, _)) if *last == l => {
                            list.pop();
                            list.push((l, p));
                        }
                        _ => list.push((l, p)),
                    }
                }
            }
        }
    }

    /// A patch by its index.
    pub fn patch(&self, (layer, patch): PatchIndex) -> &'n crate::graph::Patch {
        &self.names.layers[layer].patches[patch]
    }

    /// What a patch acts on.
    pub fn target(&self, index: PatchIndex) -> Meaning<'n> {
        match &self.patch(index).target {
            PatchTarget::AllTimes | PatchTarget::Time(_) => Meaning::Model(Named::Offset),
            PatchTarget::Sigma(_) => Meaning::Sigma,
            PatchTarget::Name(name) => {
                let name = match self.names.layers[index.0].locals.get(name) {
                    Some(Local::Name(other)) => other,
                    _ => name,
                };
                self.find(name).map_or(Meaning::Unknown, Meaning::Model)
            }
        }
    }

    /// The name of the model, if it has it.
    pub fn find(&self, name: &str) -> Option<Named> {
        self.index.get(name).copied()
    }

    /// All names of the model.
    pub fn known(&self) -> impl Iterator<Item = &str> {
        self.index.keys().map(String::as_str)
    }

    /// What a thing of the model is called.
    pub fn name_of(&self, named: Named) -> &str {
        match named {
            Named::Input(i) => &self.names.inputs[i].name,
            Named::Parameter(i) => &self.names.parameters[i].name,
            Named::Random(i) => &self.names.randoms[i].name,
            Named::Quantity(i) => self.names.quantities.get_index(i).map_or("", |(name, _)| name),
            Named::Measurand(i) => &self.names.measurands[i].name,
            other => {
                BUILT_IN.iter().find(|(_, named)| *named == other).map_or("", |(name, _)| name)
            }
        }
    }

    /// What a name stands for in the formula of a patch, or in a formula of the model.
    pub fn meaning(&self, patch: Option<PatchIndex>, name: &str) -> Meaning<'n> {
        let Some(index) = patch else {
            return self.find(name).map_or(Meaning::Unknown, Meaning::Model);
        };
        let layer = &self.names.layers[index.0];
        let of = |m: &usize, what: &str| {
            let name = name.strip_suffix(what).and_then(|name| name.strip_suffix('.'));
            self.names.measurands.get(*m).is_some_and(|own| Some(own.name.as_str()) == name)
        };
        let own = name == "self"
            || match &self.patch(index).target {
                PatchTarget::AllTimes => name == "t",
                PatchTarget::Time(m) => name == "t" || of(m, "t"),
                PatchTarget::Sigma(m) => name == "sigma" || of(m, "sigma"),
                PatchTarget::Name(target) => name == target,
            };
        if own {
            return self.target(index);
        }
        match layer.locals.get(name) {
            Some(Local::Name(other)) => {
                return self.find(other).map_or(Meaning::Unknown, Meaning::Model);
            }
            Some(local) => return Meaning::Local(local),
            None => {}
        }
        self.find(name).map_or(Meaning::Unknown, Meaning::Model)
    }

    /// The last layer of a set that patches a thing in the context of a measurand, and its patch.
    pub fn last_patch(
        &self,
        named: Named,
        measurand: Option<usize>,
        layers: &LayerSet,
    ) -> Option<PatchIndex> {
        let list = self.patches_of(named, measurand);
        list.iter().rev().find(|(layer, _)| layers.contains(*layer)).copied()
    }

    fn patches_of(&self, named: Named, measurand: Option<usize>) -> &[PatchIndex] {
        let key = (named, if named == Named::Offset { measurand } else { None });
        self.patches.get(&key).map_or(&[], Vec::as_slice)
    }

    /// The layers of a set that can matter to a thing in the context of a measurand.
    pub fn mattering(&self, named: Named, measurand: Option<usize>, layers: &LayerSet) -> LayerSet {
        let mut mattering = LayerSet::none(self.names.layers.len());
        let mut seen = Set::from_iter([named]);
        let mut waiting = vec![named];
        while let Some(next) = waiting.pop() {
            let mut visit = |used: Named| {
                if seen.insert(used) {
                    waiting.push(used);
                }
            };
            match next {
                Named::Quantity(i) => self.quantity_uses[i].iter().copied().for_each(&mut visit),
                Named::Measurand(i) => self.measurand_uses[i].iter().copied().for_each(&mut visit),
                Named::Input(i) if self.names.inputs[i].signal => visit(Named::Offset),
                Named::Moment => visit(Named::Offset),
                Named::Offset => {
                    let delay = measurand.and_then(|m| self.names.measurands.get(m));
                    delay.into_iter().for_each(|m| visit(Named::Parameter(m.delay)));
                }
                _ => {}
            }
            for index in self.patches_of(next, measurand) {
                if layers.contains(index.0) {
                    mattering.insert(index.0);
                    self.patch_uses[index].iter().copied().for_each(&mut visit);
                }
            }
        }
        mattering
    }

    /// The names of the model that a formula uses.
    fn uses(&self, formula: &Formula, patch: Option<PatchIndex>) -> Vec<Named> {
        let mut uses = Vec::new();
        for (name, _) in formula.root.names() {
            match self.meaning(patch, name) {
                Meaning::Model(named) => uses.push(named),
                Meaning::Local(Local::Parameter(p)) => uses.push(Named::Parameter(*p)),
                Meaning::Local(Local::PerMeasurand(list)) => {
                    uses.extend(list.iter().map(|p| Named::Parameter(*p)));
                }
                _ => {}
            }
        }
        uses.sort_by_key(|named| format!("{named:?}"));
        uses.dedup();
        uses
    }
}
