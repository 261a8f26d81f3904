//! Which logged numbers of a model are single numbers, vectors, quaternions and poses.

use std::collections::BTreeSet;

use crate::campaign::loaded::HeadUnit;
use crate::convention::{Convention, Form};
use crate::estimate::conventions::units::scale;
use crate::formula::{Axis, Expression, ExpressionKind, Formula, Function};
use crate::graph::{MeasurandKind, Names};
use crate::units::{Dimension, Unit};

/// Most pairs of numbers that are asked whether they have changed places; those beyond are counted.
const MOST_PAIRS: usize = 1000;

/// A column of readings, or an input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// Column of the readings.
    Reading(usize),
    /// Index of the input.
    Input(usize),
}

/// A logged number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Channel {
    /// What the model calls it.
    pub(super) name: String,
    pub(super) source: Source,
    pub(super) unit: Unit,
    /// The units that files state of it; that of the model where they state none.
    pub(super) heads: Vec<Unit>,
    /// Whether a file states one.
    pub(super) is_headed: bool,
    /// Whether its values show that it has no unit, as those of a quaternion's components.
    pub(super) has_no_unit: bool,
    /// Whether it is one of the coordinates of a vector.
    pub(super) is_coordinate: bool,
}

/// The logged numbers of a model, by what they make together.
pub(super) struct Channels {
    numbers: Vec<Channel>,
    vectors: Vec<Vec<Channel>>,
    quaternions: Vec<Vec<Channel>>,
}

impl Channels {
    /// `heads` are the units in which columns are read; `without_unit` are inputs whose values show that they
    /// have none.
    pub(super) fn of(names: &Names, heads: &[&HeadUnit], without_unit: &BTreeSet<usize>) -> Self {
        let heads_of = |name: &str, unit: &Unit| -> Vec<Unit> {
            let own = heads.iter().filter(|head| head.name == name);
            let own: Vec<Unit> = own.map(|head| head.unit.clone()).collect();
            if own.is_empty() { vec![unit.clone()] } else { own }
        };
        let is_headed = |name: &str| heads.iter().any(|head| head.name == name);
        let (mut all, mut quaternions) = (Vec::new(), Vec::new());
        let mut column = 0;
        for measurand in &names.measurands {
            let mut read = |name: String| {
                column += 1;
                let (source, unit) = (Source::Reading(column - 1), measurand.unit.clone());
                let (heads, is_headed) = (heads_of(&name, &unit), is_headed(&name));
                let (has_no_unit, is_coordinate) = (false, false);
                Channel { name, source, unit, heads, is_headed, has_no_unit, is_coordinate }
            };
            match measurand.kind {
                MeasurandKind::Rotation => quaternions.push(
                    ["w", "x", "y", "z"]
                        .map(|one| read(format!("{}_{one}", measurand.name)))
                        .to_vec(),
                ),
                _ => all.push(read(measurand.name.clone())),
            }
        }
        let of_sigma = of_sigma_alone(names);
        let inputs = names.inputs.iter().enumerate();
        let inputs = inputs.filter(|(_, input)| !of_sigma.contains(input.name.as_str()));
        all.extend(inputs.map(|(index, input)| Channel {
            name: input.name.clone(),
            source: Source::Input(index),
            unit: input.unit.clone(),
            heads: heads_of(&input.name, &input.unit),
            is_headed: is_headed(&input.name),
            has_no_unit: without_unit.contains(&index),
            is_coordinate: false,
        }));
        let mut vectors: Vec<Vec<Channel>> = Vec::new();
        let together = |parts: &[Expression], into: &mut Vec<Vec<Channel>>| {
            let of = |part: &Expression| {
                let ExpressionKind::Name(name) = &part.kind else { return None };
                all.iter().find(|one| one.name == *name).cloned()
            };
            let found: Option<Vec<Channel>> = parts.iter().map(of).collect();
            let Some(found) = found.filter(|found| is_alike(found) && !into.contains(found)) else {
                return;
            };
            into.push(found);
        };
        for formula in formulas(names) {
            formula.root.visit(&mut |one| match &one.kind {
                ExpressionKind::Vector(parts) => together(&parts[..], &mut vectors),
                ExpressionKind::Call(Function::Quaternion, parts) => {
                    together(parts, &mut quaternions);
                }
                _ => {}
            });
        }
        let read = |name: &str| all.iter().find(|one| one.name == name).cloned();
        for found in readings_of_vectors(names) {
            let found: Vec<Channel> = found.iter().filter_map(|name| read(name)).collect();
            if found.len() == 3 && is_alike(&found) && !vectors.contains(&found) {
                vectors.push(found);
            }
        }
        let taken =
            |one: &Channel| vectors.iter().chain(&quaternions).flatten().any(|own| own == one);
        let numbers = all.iter().filter(|one| !taken(one)).cloned().collect();
        vectors.iter_mut().flatten().for_each(|one| one.is_coordinate = true);
        Self { numbers, vectors, quaternions }
    }

    /// The units that files state of single numbers, and of the components of vectors, each once.
    pub(super) fn heads(&self, form: Form) -> Vec<Unit> {
        let numbers = self.numbers.iter().filter(|_| form == Form::Number);
        each_once(numbers.chain(self.vectors.iter().flatten()).flat_map(|one| &one.heads))
    }

    /// All units in which something is stated, by files or by the model, each once.
    pub(super) fn units(&self) -> Vec<Unit> {
        let all = self.numbers.iter().chain(self.vectors.iter().flatten());
        each_once(all.flat_map(|one| one.heads.iter().chain([&one.unit])))
    }

    /// The numbers to which a convention may apply, together; and how many more there are.
    pub(super) fn for_convention(&self, convention: &Convention) -> (Vec<Vec<Channel>>, usize) {
        let is_another_unit = scale(convention).is_some_and(|scale| scale.abs() != 1.0);
        let fits = |one: &Channel| {
            let is_headed = |head: &Unit| one.heads.iter().any(|own| own.symbol == head.symbol);
            !(one.has_no_unit && is_another_unit)
                && convention.unit.as_ref().is_none_or(|unit| unit.dimension == one.unit.dimension)
                && convention.head.as_ref().is_none_or(is_headed)
        };
        let mut all: Vec<Vec<Channel>> = match convention.form {
            Form::Number => {
                let each = self.numbers.iter().filter(|one| fits(one));
                let each: Vec<_> = each.map(|one| vec![one.clone()]).collect();
                let mut all = with_all_together(each, |a, b| a.unit.dimension == b.unit.dimension);
                // A height may be in feet beside a place in metres.
                for one in self.vectors.iter().flatten().filter(|_| is_another_unit) {
                    let alone = vec![one.clone()];
                    if fits(one) && !all.contains(&alone) {
                        all.push(alone);
                    }
                }
                all
            }
            Form::Pair => pairs(&self.numbers),
            Form::Vector => {
                let own = self.vectors.iter().filter(|vector| vector.iter().all(fits));
                with_all_together(own.cloned().collect(), |_, _| true)
            }
            Form::Quaternion => self.quaternions.clone(),
            Form::Pose => {
                let poses = self.vectors.iter().flat_map(|position| {
                    let own = self
                        .quaternions
                        .iter()
                        .filter(|attitude| is_reading(&position[0]) == is_reading(&attitude[0]));
                    own.map(|attitude| [position.as_slice(), attitude].concat())
                });
                poses.collect()
            }
        };
        all.retain(|channels| channels.iter().all(fits));
        let more = all.len().saturating_sub(MOST_PAIRS);
        all.truncate(MOST_PAIRS);
        (all, more)
    }
}

/// Units that differ by their symbols, in their order.
fn each_once<'u>(units: impl Iterator<Item = &'u Unit>) -> Vec<Unit> {
    let mut found: Vec<Unit> = Vec::new();
    for one in units {
        if !found.iter().any(|known| known.symbol == one.symbol) {
            found.push(one.clone());
        }
    }
    found
}

fn formulas(names: &Names) -> impl Iterator<Item = &Formula> {
    let measurands = names.measurands.iter().map(|one| &one.formula);
    let measured = names.coordinates.iter().flat_map(|one| [&one.measured, &one.from]);
    names.quantities.values().chain(measurands).chain(measured)
}

/// Names that the standard uncertainties of readings hang on, and nothing else does: larger ones fit
/// anything.
fn of_sigma_alone(names: &Names) -> BTreeSet<&str> {
    let readings = names.measurands.iter().map(|one| &one.formula);
    let from = names.coordinates.iter().map(|one| &one.from);
    let patches = names.layers.iter().flat_map(|layer| &layer.patches).map(|one| &one.formula);
    let of_readings = reached(names, readings.chain(from).chain(patches).collect());
    let sigmas = names.measurands.iter().filter_map(|one| one.sigma.as_ref());
    reached(names, sigmas.collect()).difference(&of_readings).copied().collect()
}

/// All names that formulas hang on, over whatever quantities.
fn reached<'a>(names: &'a Names, mut open: Vec<&'a Formula>) -> BTreeSet<&'a str> {
    let mut known = BTreeSet::new();
    while let Some(formula) = open.pop() {
        let new = formula.root.names().into_iter().filter(|(name, _)| known.insert(*name));
        open.extend(new.filter_map(|(name, _)| names.quantities.get(name)));
    }
    known
}

/// Three measurands that are the components of one quantity.
fn readings_of_vectors(names: &Names) -> Vec<[&str; 3]> {
    let component = |of: &str, wanted: Axis| {
        let is_own = |formula: &Formula| match &formula.root.kind {
            ExpressionKind::Member(base, axis) => {
                *axis == wanted && matches!(&base.kind, ExpressionKind::Name(name) if name == of)
            }
            _ => false,
        };
        let mut all = names.measurands.iter();
        all.find(|one| is_own(&one.formula)).map(|one| one.name.as_str())
    };
    let all = [Axis::X, Axis::Y, Axis::Z];
    let of = |quantity: &String| {
        let [x, y, z] = all.map(|axis| component(quantity, axis));
        Some([x?, y?, z?])
    };
    names.quantities.keys().filter_map(of).collect()
}

fn is_reading(one: &Channel) -> bool {
    matches!(one.source, Source::Reading(_))
}

/// Numbers or vectors each by itself, and all readings and all inputs that are alike, together: whole
/// files are in another unit, whole sensors in another frame.
fn with_all_together(
    each: Vec<Vec<Channel>>,
    are_alike: impl Fn(&Channel, &Channel) -> bool,
) -> Vec<Vec<Channel>> {
    let mut all = each.clone();
    for first in &each {
        let is_like = |one: &&Vec<Channel>| {
            is_reading(&first[0]) == is_reading(&one[0]) && are_alike(&first[0], &one[0])
        };
        let like: Vec<&Vec<Channel>> = each.iter().filter(is_like).collect();
        let together: Vec<Channel> = like.iter().copied().flatten().cloned().collect();
        let is_once = |one: &Channel| together.iter().filter(|other| *other == one).count() == 1;
        if like.len() > 1 && together.iter().all(is_once) && !all.contains(&together) {
            all.push(together);
        }
    }
    all
}

/// Whether numbers may belong together: all read or all inputs, of one dimension.
fn is_alike(all: &[Channel]) -> bool {
    let dimension = |one: &Channel| -> Dimension { one.unit.dimension };
    all.windows(2).all(|two| {
        is_reading(&two[0]) == is_reading(&two[1]) && dimension(&two[0]) == dimension(&two[1])
    })
}

fn pairs(numbers: &[Channel]) -> Vec<Vec<Channel>> {
    let later = |at: usize| numbers[at + 1..].iter();
    let all = numbers
        .iter()
        .enumerate()
        .flat_map(|(at, first)| later(at).map(move |second| vec![first.clone(), second.clone()]));
    all.filter(|two| is_alike(two)).collect()
}
