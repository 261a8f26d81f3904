//! Errors of readings, of attitudes and of inputs.

use std::collections::BTreeSet;

use super::covariate::{Covariate, FEW, of_itself, of_the_head, of_the_rig, scale_over_campaign};
use super::made::{Block, blocks_over};
use super::{COARSE_ORDERS, directions, orders, plain, waves};
use crate::diagnose::library::place::Of;
use crate::formula::Formula;
use crate::graph::MeasurandKind;
use crate::model::{InputDeclaration, MeasurandDeclaration, Model};

/// Waves of an error over an input that turns.
const INPUT_ORDERS: usize = 3;

/// Errors of readings.
pub(super) fn readings(model: &Model) -> Vec<Block> {
    let of = |measurand: &MeasurandDeclaration| {
        let name = &measurand.name;
        let mut covariates = of_the_rig(model, orders(model));
        covariates.extend(of_the_head(model));
        covariates.extend(waves::slow());
        covariates.push(waves::settling(model));
        covariates.extend(waves::over_inputs(model));
        covariates.extend(waves::over_itself(model, measurand));
        if measurand.kind == MeasurandKind::Plain {
            covariates.push(scale_over_campaign(name, measurand.unit.dimension));
        }
        if matches!(measurand.kind, MeasurandKind::Angle { .. }) {
            covariates.push(waves::over_circle(name));
        }
        errors(measurand, &covariates)
    };
    plain(model).flat_map(of).collect()
}

/// Errors of a reading as functions of these.
pub(super) fn errors(measurand: &MeasurandDeclaration, covariates: &[Covariate]) -> Vec<Block> {
    let name = &measurand.name;
    let (of, what) = (Of::Measurand(name.clone()), format!("an error of `{name}`"));
    let patch = |sum: &str| format!("{name} = '{name} + {sum}'");
    blocks_over(&of, &what, covariates, &measurand.unit, patch)
}

/// Errors of readings that are rotations: turns about the axes of what is looked at, and about
/// those of what it is looked at from, which are others where it turns.
pub(super) fn attitudes(model: &Model) -> Vec<Block> {
    let mut all = Vec::new();
    let rotations = model.measurands.iter().filter(|one| one.kind == MeasurandKind::Rotation);
    for measurand in rotations {
        let name = &measurand.name;
        let mut covariates = of_the_rig(model, COARSE_ORDERS);
        covariates.extend(of_the_head(model));
        covariates.extend(waves::slow());
        covariates.push(waves::settling(model));
        for (axes, before, after) in [
            ("its own axes", format!("{name} * "), String::new()),
            ("fixed axes", String::new(), format!(" * {name}")),
        ] {
            let about = |one: &Covariate| Covariate {
                name: format!("{} {axes}", one.name),
                ..one.clone().along_axes()
            };
            let covariates: Vec<Covariate> = covariates.iter().map(about).collect();
            let what = format!("an error of `{name}` about {axes}");
            let patch = |sum: &str| format!("{name} = '{before}turn({sum}){after}'");
            let of = Of::Measurand(name.clone());
            all.extend(blocks_over(&of, &what, &covariates, &measurand.unit, patch));
        }
    }
    all
}

/// Errors of inputs over themselves, where there are many, or of those that several readings depend on in
/// models without a target: what a joint of an arm does wrong is another displacement of its tool in each
/// pose, and another error of each axis of a gyro, which no function of one covariate is. With few inputs
/// the error of one reading is as well one over the input, and a target is displaced over what moves it.
/// An input that no formula of the model uses changes readings through effects alone: its error would have
/// the form of an effect that is in the fit, and take its place.
pub(super) fn of_inputs(model: &Model) -> Vec<Block> {
    let names: BTreeSet<&str> =
        model.formulas().flat_map(|one| one.root.names()).map(|(name, _)| name).collect();
    let is_used = |input: &&InputDeclaration| names.contains(input.name.as_str());
    let mut used: Vec<&InputDeclaration> = model.inputs.iter().filter(is_used).collect();
    if used.len() <= FEW {
        let reached = model.measurands.iter().map(|one| reached(model, &one.formula));
        let reached: Vec<BTreeSet<&str>> = reached.collect();
        let readings = |name: &str| reached.iter().filter(|own| own.contains(name)).count();
        used.retain(|input| directions(model).is_empty() && readings(&input.name) > 1);
    }
    let of = |input: &InputDeclaration| {
        let name = &input.name;
        let (of, what) = (format!("input {name}"), format!("an error of the input `{name}`"));
        let mut covariates = vec![of_itself(input, INPUT_ORDERS)];
        covariates.extend(input.unit.is_angle().then(|| waves::over_circle(name)));
        let patch = |sum: &str| format!("{name} = '{name} + {sum}'");
        blocks_over(&Of::Channel(of), &what, &covariates, &input.unit, patch)
    };
    used.into_iter().flat_map(of).collect()
}

/// The names in a formula and in the quantities that it is made of.
fn reached<'a>(model: &'a Model, formula: &'a Formula) -> BTreeSet<&'a str> {
    let (mut names, mut open) = (BTreeSet::new(), vec![formula]);
    while let Some(formula) = open.pop() {
        for (name, _) in formula.root.names() {
            if names.insert(name) {
                open.extend(model.quantities.get(name));
            }
        }
    }
    names
}
