//! Errors of readings and of attitudes.

use std::sync::Arc;

use super::covariate::{CIRCLE_ORDERS, Covariate, of_the_head, of_the_rig, scale_over_campaign};
use super::made::effect;
use super::{COARSE_ORDERS, orders, waves};
use crate::diagnose::library::place::{Of, Place};
use crate::effect::Effect;
use crate::graph::MeasurandKind;
use crate::model::{MeasurandDeclaration, Model};
use crate::units::Dimension;

/// Errors of readings.
pub(super) fn readings(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    for measurand in &model.measurands {
        let name = &measurand.name;
        if measurand.kind == MeasurandKind::Rotation {
            continue;
        }
        let mut covariates = of_the_rig(model, orders(model));
        covariates.extend(of_the_head(model));
        covariates.extend([waves::slow(), waves::settling(model)]);
        if measurand.kind == MeasurandKind::Plain {
            covariates.push(scale_over_campaign(name, measurand.unit.dimension));
        }
        if matches!(measurand.kind, MeasurandKind::Angle { .. }) {
            covariates.push(waves::over_circle(name, CIRCLE_ORDERS));
        }
        errors(measurand, covariates.into_iter(), all);
    }
}

/// Errors of a reading as functions of these.
pub(super) fn errors(
    measurand: &MeasurandDeclaration,
    covariates: impl Iterator<Item = Covariate>,
    all: &mut Vec<(Arc<Effect>, Place)>,
) {
    let name = &measurand.name;
    for covariate in covariates {
        let place = Place::new(
            Of::Measurand(name.clone()),
            &covariate.over,
            format!("an error of `{name}` over {}", covariate.words),
        );
        let patch = |sum: &str| format!("{name} = '{name} + {sum}'");
        all.extend(effect(&place, &covariate, measurand.unit.dimension, patch));
    }
}

/// Errors of readings that are rotations: turns about the axes of what is looked at, and about
/// those of what it is looked at from, which are others where it turns.
pub(super) fn attitudes(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    let rotations = model.measurands.iter().filter(|one| one.kind == MeasurandKind::Rotation);
    for MeasurandDeclaration { name, .. } in rotations {
        let mut covariates = of_the_rig(model, COARSE_ORDERS);
        covariates.extend(of_the_head(model));
        covariates.extend([waves::slow(), waves::settling(model)]);
        for (axes, before, after) in [
            ("its own axes", format!("{name} * "), String::new()),
            ("fixed axes", String::new(), format!(" * {name}")),
        ] {
            for covariate in covariates.iter().cloned().map(Covariate::along_axes) {
                let place = Place::new(
                    Of::Measurand(name.clone()),
                    &covariate.over,
                    format!("an error of `{name}` about {axes} over {}", covariate.words),
                );
                let covariate =
                    Covariate { name: format!("{} {axes}", covariate.name), ..covariate };
                let patch = |sum: &str| format!("{name} = '{before}turn({sum}){after}'");
                all.extend(effect(&place, &covariate, Dimension::NONE, patch));
            }
        }
    }
}
