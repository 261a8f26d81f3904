//! Which effects of a library can be tested on a model, and which names would let more be.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::sync::Arc;

use crate::effect::Effect;
use crate::graph::quantities::quantities;
use crate::graph::{Kind, MeasurandKind};
use crate::model::{Model, Override};
use crate::system::needs::{heads_for, lacks_of, missing_at, names_in, roles_at};
use crate::system::{System, stand_ins};
use crate::units::Dimension;

/// What of a library can be tested on a model.
#[derive(Clone, Debug, Default)]
pub struct Testable {
    /// The effects that can be, by name.
    pub effects: Vec<String>,
    /// How many there are.
    pub of: usize,
    /// Names that the model lacks and has something of the same dimension for: those that it has something
    /// of the same kind for first, then those that would add most effects.
    pub lacking: Vec<Lacking>,
}

/// Names that a model lacks, and the effects that need these, or some of them, and no others.
#[derive(Clone, Debug)]
pub struct Lacking {
    /// As the library calls them.
    pub names: Vec<String>,
    /// By name.
    pub effects: Vec<String>,
    /// For how many of the names the model has nothing of their kind.
    pub unmatched: usize,
}

/// What of these effects can be tested on a model; `known` are the models of the library, whose names
/// effects use. Constants that only a campaign can state count as stated; built-in detectors need no names
/// and look at every campaign.
pub fn testable<'e>(
    model: &Model,
    effects: impl Iterator<Item = &'e Arc<Effect>>,
    overrides: &[Override],
    known: &[Model],
) -> Testable {
    let mut found = Testable::default();
    let mut asked = BTreeSet::new();
    for effect in effects {
        found.of += 1;
        asked.extend(names_in(effect));
        if effect.builtin {
            found.effects.push(effect.name.clone());
            continue;
        }
        let heads = heads_for(model, effect);
        let fits = |head: &Option<String>| lacks_of(model, effect, head.as_deref()).is_empty();
        let stated = [overrides, stand_ins(effect).as_slice()].concat();
        if heads.iter().any(fits) {
            if super::candidates(model, effect, &stated).is_ok() {
                found.effects.push(effect.name.clone());
            }
            continue;
        }
        let missing =
            |head: &Option<String>| missing_at(model, effect, &roles_at(model, head.as_deref()));
        let Some(mut names) = heads.iter().map(missing).min_by_key(Vec::len) else { continue };
        names.sort_unstable();
        names.dedup();
        if names.is_empty() {
            continue;
        }
        match found.lacking.iter_mut().find(|one| one.names == names) {
            Some(one) => one.effects.push(effect.name.clone()),
            None => found.lacking.push(Lacking {
                names,
                effects: vec![effect.name.clone()],
                unmatched: 0,
            }),
        }
    }
    let (has, of_library) = (measures(model), known.iter().flat_map(measures).collect::<Vec<_>>());
    let may_be = |name: &String| {
        let mut due = of_library.iter().filter(|(known, _)| known == name).peekable();
        due.peek().is_none() || due.any(|(_, due)| has.iter().any(|(_, own)| own == due))
    };
    found.lacking.retain(|one| one.names.iter().all(may_be));
    found.lacking = joined(found.lacking);
    for one in &mut found.lacking {
        one.unmatched = unmatched(&one.names, model, known, &asked);
    }
    // Several names of which each has its kind fit a model better than one.
    let weight = |one: &Lacking| one.effects.len() + one.names.len();
    found.lacking.sort_by_key(|one| (one.unmatched, Reverse(weight(one))));
    found
}

/// Names that one effect alone needs join those of which they are a part.
fn joined(mut all: Vec<Lacking>) -> Vec<Lacking> {
    all.sort_by_key(|one| one.names.len());
    let mut found: Vec<Lacking> = Vec::new();
    while let Some(mut largest) = all.pop() {
        let is_part = |one: &Lacking| {
            one.effects.len() == 1 && one.names.iter().all(|name| largest.names.contains(name))
        };
        let parts: Vec<Lacking> = all.extract_if(.., |one| is_part(one)).collect();
        largest.effects.extend(parts.into_iter().flat_map(|part| part.effects));
        largest.effects.sort_unstable();
        found.push(largest);
    }
    found
}

/// For how many of these names a model has nothing of their kind: an input for an input, a reading for a
/// reading, a parameter for a parameter, each of the dimension that it has in the library's models, and of
/// another name than those `asked` for by effects. For a quantity it may have a formula.
fn unmatched(names: &[String], model: &Model, known: &[Model], asked: &BTreeSet<String>) -> usize {
    let has_role = |name: &str| {
        let heads = model.heads.values();
        heads.chain([&model.roles]).flat_map(|roles| roles.values()).any(|one| one.owner == name)
    };
    let of_library: Vec<(&str, Sort)> = known.iter().flat_map(sorts).collect();
    let own = sorts(model).filter(|(name, _)| !has_role(name) && !asked.contains(*name));
    let mut free: Vec<Sort> = own.map(|(_, sort)| sort).collect();
    let is_unmatched = |name: &&String| {
        let mut of_name = of_library.iter().filter(|(known, _)| known == name).peekable();
        if of_name.peek().is_none() {
            return model.quantities.is_empty();
        }
        let place = of_name.find_map(|(_, sort)| free.iter().position(|own| own == sort));
        place.map(|place| free.swap_remove(place)).is_none()
    };
    names.iter().filter(is_unmatched).count()
}

/// What a value is made of.
#[derive(Clone, Copy, PartialEq)]
enum Measure {
    /// Angles: it is one, or a rotation.
    Turn,
    /// A number or numbers of this dimension.
    Of(Dimension),
}

/// What each name of a model is made of. A quantity without a dimension may be an angle.
fn measures(model: &Model) -> Vec<(String, Measure)> {
    let measure = |name: &str, is_turn: bool, dimension: Dimension| {
        (name.to_owned(), if is_turn { Measure::Turn } else { Measure::Of(dimension) })
    };
    let declared = sorts(model).map(|(name, (is, dimension, is_angle))| {
        let is_rotation =
            matches!(is, Is::Parameter(Kind::Rotation) | Is::Reading { is_rotation: true });
        measure(name, is_angle || is_rotation, dimension)
    });
    let mut all: Vec<(String, Measure)> = declared.collect();
    if let Ok(system) = System::build(model, &[], &[], &[]) {
        all.extend(quantities(&system.assembly.names).map(|(name, kind, dimension)| {
            measure(name, kind != Kind::Vector && dimension == Dimension::NONE, dimension)
        }));
    }
    all
}

/// What a name of a model is, its dimension, and whether it is an angle.
type Sort = (Is, Dimension, bool);

/// What a model declares under a name.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Is {
    Input,
    Reading { is_rotation: bool },
    Parameter(Kind),
}

/// The inputs, readings and parameters of a model, by name.
fn sorts(model: &Model) -> impl Iterator<Item = (&str, Sort)> {
    let inputs = model.inputs.iter().map(|one| (one.name.as_str(), &one.unit, Is::Input));
    let readings = model.measurands.iter().map(|one| {
        let is_rotation = one.kind == MeasurandKind::Rotation;
        (one.name.as_str(), &one.unit, Is::Reading { is_rotation })
    });
    let parameters = model.parameters.iter();
    let parameters = parameters.map(|one| (one.name.as_str(), &one.unit, Is::Parameter(one.kind)));
    let all = inputs.chain(readings).chain(parameters);
    all.map(|(name, unit, is)| (name, (is, unit.dimension, unit.is_angle())))
}
