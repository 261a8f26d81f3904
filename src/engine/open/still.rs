//! Campaigns in which nothing moves: a delay changes no reading there, so none is estimated.

use crate::campaign::load::Campaign;
use crate::campaign::signal::Track;
use crate::model::{Model, Override};
use crate::system::delay_names;
use crate::units::Unit;

/// Whether anything moves while readings are taken.
pub(super) fn moves(campaign: &Campaign) -> bool {
    campaign.runs.iter().any(|run| run.record.inputs().iter().any(Track::moves))
}

/// Holds every delay of a model at zero, before what is stated of it.
pub(super) fn without_delays(model: &Model) -> impl Iterator<Item = Override> + '_ {
    delay_names(model).map(|name| Override {
        name,
        value: Some(vec![(0.0, Unit::second())]),
        fixed: Some(true),
        ..Override::default()
    })
}
