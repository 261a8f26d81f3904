//! Unknown structure: what an effect that no file describes could look like, as effects made here.
//!
//! A block is a displacement of the target, its pedestal or the rig, an error in the time of a
//! reading, of the reading itself or of an input, as a free function of one covariate: an angle (waves
//! up to an order), a rate, the sense of rotation, time, setup, run; or of two together. Blocks are
//! effects like any other and go through the same machine; the best of them says where the unknown
//! sits. (A plain Fourier series in the arm angle would miss clocks and platforms.) Those whose scale
//! nobody knows are families.

use std::collections::BTreeMap;

use rayon::prelude::*;

use covariate::{
    Covariate, few_move, of_motion, of_the_rig, over_runs, over_time, reading_by_sense,
};

use crate::engine::open::Recipe;
use crate::graph::MeasurandKind;
use crate::model::{MeasurandDeclaration, Model};
use crate::system::Selected;
use crate::units::{Dimension, Unit};

use super::candidate::{Candidate, Joined};
use super::place::{ALL_READINGS, Of, TIME_OF};
use made::{Block, blocks_over};
pub(in crate::diagnose) use oscillation::FAST;
use parameters::{of_parameters, of_the_pose};
use readings::{attitudes, errors, of_inputs, readings};
use sensitivities::without_sensitivities;
use spread::Spread;

mod covariate;
mod made;
mod oscillation;
mod parameters;
mod readings;
mod sensitivities;
pub(in crate::diagnose) mod spread;
mod together;
mod waves;

/// Waves over a signal, where few things move and where many do.
const ORDERS: (usize, usize) = (8, 3);
/// Inputs with a value for each of many places, at most.
const MOST_WITH_LEVELS: usize = 4;
/// Waves of an error in time and of a pedestal.
const COARSE_ORDERS: usize = 2;
/// Waves of what goes otherwise there than back, at most.
const SENSE_ORDERS: usize = 4;
/// Where the instrument and the rig stand to each other, in models that know it.
const POSITION: &str = "position";
const ORIENTATION: &str = "orientation";

/// The blocks of the campaigns' models.
pub fn blocks(recipes: &[Recipe]) -> Vec<Candidate> {
    offered(recipes, effects)
}

/// Direction-dependent errors (hysteresis, backlash, a cable's drag); too many where many things move.
fn by_sense(model: &Model) -> Vec<Block> {
    if !few_move(model) {
        return Vec::new();
    }
    let covariates = covariate::by_sense(model, orders(model).min(SENSE_ORDERS));
    let errors = |measurand: &MeasurandDeclaration| {
        let own = reading_by_sense(measurand);
        let loads = together::loads_by_sense(model, measurand);
        let covariates: Vec<Covariate> =
            covariates.iter().cloned().chain(loads).chain(own).collect();
        errors(measurand, &covariates)
    };
    let displacements = displacements(model, &covariates).into_iter();
    displacements.chain(plain(model).flat_map(errors)).collect()
}

/// Blocks that depend on the values of inputs: a line over an input that bends at places among them,
/// products of two inputs about the middle of theirs, and waves of any order over what turns many times,
/// of any length over what is long or short. A form that powers and waves do not have is seen so, a value
/// of its own for each of a few places, and what neither of two inputs does by itself.
pub(in crate::diagnose) fn over_values(recipes: &[Recipe], spreads: &[Spread]) -> Vec<Candidate> {
    offered(recipes, |model| {
        let bent = |Spread { input, knots, .. }: &Spread| {
            if knots.is_empty() {
                return None;
            }
            let input = model.inputs.iter().find(|one| one.name == *input)?;
            Some(covariate::bent(input, knots))
        };
        let covariates: Vec<Covariate> = spreads.iter().filter_map(bent).collect();
        let mut all = displacements(model, &covariates);
        if directions(model).is_empty() || !few_move(model) {
            all.extend(plain(model).flat_map(|one| errors(one, &covariates)));
        }
        let mut of_readings = together::products(model, spreads);
        let levels = spreads.iter().filter(|one| !one.levels.is_empty()).filter_map(|own| {
            let input = model.inputs.iter().find(|one| one.name == own.input)?;
            Some(covariate::levels(input, own))
        });
        of_readings.extend(levels.take(MOST_WITH_LEVELS));
        of_readings.extend(together::of_pairs(model, spreads));
        of_readings.extend(waves::of_any_order(model, spreads));
        of_readings.extend(waves::of_any_length(model, spreads));
        of_readings.extend(waves::over_counts(model, spreads));
        all.extend(plain(model).flat_map(|one| errors(one, &of_readings)));
        all
    })
}

fn offered(recipes: &[Recipe], effects: impl Fn(&Model) -> Vec<Block>) -> Vec<Candidate> {
    let mut joined = Joined::new(recipes.len());
    for (campaign, recipe) in recipes.iter().enumerate() {
        let model = without_sensitivities(&recipe.model, &recipe.library);
        let made = effects(&model).into_par_iter().filter_map(|(effect, place)| {
            let selected = Selected { effect, head: None, member: BTreeMap::new() };
            let system = recipe.with_first(&selected).ok()?;
            Some((selected, place, system))
        });
        for (selected, place, system) in made.collect::<Vec<_>>() {
            joined.add(campaign, selected, Some(place), system);
        }
    }
    joined.found
}

fn effects(model: &Model) -> Vec<Block> {
    let of_readings = [readings, of_inputs, attitudes, by_sense, oscillation::in_time];
    let of_the_rig = [channels, rig, pedestal, timing, of_parameters, of_the_pose];
    of_the_rig.iter().chain(&of_readings).flat_map(|of| of(model)).collect()
}

/// Measurands that are no rotations.
fn plain(model: &Model) -> impl Iterator<Item = &MeasurandDeclaration> {
    model.measurands.iter().filter(|one| one.kind != MeasurandKind::Rotation)
}

/// Waves over a signal.
fn orders(model: &Model) -> usize {
    if few_move(model) { ORDERS.0 } else { ORDERS.1 }
}

/// The directions in which a target may be displaced, by channel; none where a model has no target.
fn directions(model: &Model) -> &'static [(&'static str, &'static str)] {
    match (has_quantity(model, "target"), turns_its_target(model)) {
        (false, _) => &[],
        (true, true) => &[
            ("target tangential", "rotate(arm_turn, [0, 1, 0])"),
            ("target radial", "rotate(arm_turn, [1, 0, 0])"),
            ("target axial", "[0, 0, 1]"),
        ],
        (true, false) => {
            &[("target x", "[1, 0, 0]"), ("target y", "[0, 1, 0]"), ("target z", "[0, 0, 1]")]
        }
    }
}

/// Whether the target goes round on an arm.
fn turns_its_target(model: &Model) -> bool {
    ["target", "arm_turn"].iter().all(|name| has_quantity(model, name))
}

/// Whether a model has a quantity of the library's, under that name or another.
fn has_quantity(model: &Model, name: &str) -> bool {
    model.quantities.contains_key(model.called(name))
}

/// Displacements of the target.
fn channels(model: &Model) -> Vec<Block> {
    let mut covariates = of_the_rig(model, orders(model));
    covariates.extend(waves::over_signals(model));
    covariates.extend(waves::slow());
    covariates.push(waves::settling(model));
    displacements(model, &covariates)
}

/// Displacements of the target as functions of these.
fn displacements(model: &Model, covariates: &[Covariate]) -> Vec<Block> {
    let along = |(channel, direction): &(&str, &str)| {
        let of = Of::Channel((*channel).to_owned());
        let patch = |sum: &str| format!("target = 'target + ({sum}) * {direction}'");
        blocks_over(
            &of,
            &displacement(channel),
            covariates,
            &Unit::coherent(Dimension::LENGTH),
            patch,
        )
    };
    directions(model).iter().flat_map(along).collect()
}

/// Displacements of the instrument, or of all that it looks at.
fn rig(model: &Model) -> Vec<Block> {
    let position = model.called(POSITION);
    if !model.parameters.iter().any(|one| one.name == position) {
        return Vec::new();
    }
    let [slow, slowest] = waves::slow();
    let covariates = [over_time(), slow, slowest, over_runs()].map(Covariate::along_axes);
    let (of, what) = ("rig".to_owned(), "a displacement of the instrument or the rig");
    let patch = |sum: &str| format!("{position} = '{position} + {sum}'");
    blocks_over(&Of::Channel(of), what, &covariates, &Unit::coherent(Dimension::LENGTH), patch)
}

/// Displacements of the rig by what moves: its pedestal gives way to imbalance and torque, in
/// directions of its own, which are others in each setup for the instrument. Where nothing turns
/// they are those of the target.
fn pedestal(model: &Model) -> Vec<Block> {
    if !turns_its_target(model) || !few_move(model) {
        return Vec::new();
    }
    let covariates = of_motion(model, COARSE_ORDERS).into_iter().map(Covariate::along_axes);
    let covariates: Vec<Covariate> = covariates.collect();
    let (of, what) = ("pedestal".to_owned(), "a displacement of the rig's pedestal");
    let patch = |sum: &str| format!("target = 'target + {sum}'");
    blocks_over(&Of::Channel(of), what, &covariates, &Unit::coherent(Dimension::LENGTH), patch)
}

fn displacement(channel: &str) -> String {
    let direction = channel.trim_start_matches("target ");
    let article = if matches!(direction, "axial" | "x") { "an" } else { "a" };
    format!("{article} {direction} displacement of the target")
}

/// Errors in the time of readings: of each measurand, and of all alike, as a clock makes them.
fn timing(model: &Model) -> Vec<Block> {
    let names: Vec<&str> = model.measurands.iter().map(|one| one.name.as_str()).collect();
    let mut groups: Vec<(&str, &[&str])> = names.iter().copied().zip(names.chunks(1)).collect();
    if names.len() > 1 {
        groups.push((ALL_READINGS, &names));
    }
    let mut covariates = of_the_rig(model, COARSE_ORDERS);
    covariates.push(waves::settling(model));
    let of_group = |(of, names): (&str, &[&str])| {
        let called = if names.len() > 1 { of.to_owned() } else { format!("`{of}`") };
        let what = format!("a timing error of {called}");
        let patch = |sum: &str| {
            let line = |name: &&str| format!("\"{name}.t\" = 't + {sum}'\n");
            names.iter().map(line).collect()
        };
        let of = Of::Channel(format!("{TIME_OF}{of}"));
        blocks_over(&of, &what, &covariates, &Unit::second(), patch)
    };
    groups.into_iter().flat_map(of_group).collect()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use crate::diagnostic::Source;

    fn blocks_of(inputs: &str, target: &str, measurands: &[&str]) -> Vec<(String, String)> {
        let lines: String = measurands
            .iter()
            .map(|name| format!("{name} = {{ value = 'target.x', unit = \"m\" }}\n"))
            .collect();
        let text = format!(
            "name = \"stage\"\ntitle = \"Stage\"\n[inputs]\n{inputs}\n[quantities]\n{target}\n[measurands]\n{lines}"
        );
        let model = Model::parse(Source::new("stage.toml", text)).unwrap();
        let made = effects(&model);
        made.into_iter().map(|(effect, place)| (effect.name.clone(), place.words)).collect()
    }

    /// What slides has waves over its length, and is displaced along fixed axes by what moves: a
    /// pedestal would say the same again.
    #[test]
    fn what_slides_has_waves_a_metre_and_no_pedestal() {
        let slides = "stage_x = { unit = \"m\", signal = true }";
        let made = blocks_of(slides, "target = '[stage_x, 0, 0]'", &["distance"]);
        let says = |words: &str| made.iter().any(|(_, one)| one.contains(words));
        assert!(says("an x displacement of the target over stage_x, {member} waves a metre"));
        assert!(!says("pedestal"));
    }

    /// Names of effects are short; those of measurands may be long, and no block is lost for that.
    #[test]
    fn no_block_is_lost_for_a_long_name() {
        let slides = "position_of_the_carriage = { unit = \"m\", signal = true }";
        let target = "target = '[position_of_the_carriage, 0, 0]'";
        let long = blocks_of(
            slides,
            target,
            &["distance_of_the_first_interferometer", "distance_of_the_second_interferometer"],
        );
        let short = blocks_of(slides, target, &["first", "second"]);
        assert_eq!(long.len(), short.len());
        let names: std::collections::BTreeSet<&String> = long.iter().map(|one| &one.0).collect();
        assert_eq!(names.len(), long.len());
    }
}
