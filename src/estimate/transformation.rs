//! Where the delays take their transformation from: the reference runs, else the joint fit.
//!
//! The reference runs (slow or static) are fitted with their own delays, so that a slow run's delay
//! does not end up in the transformation (the seed's way carries it there). Where they alone do not
//! determine everything, say one direction of one slow run, the joint fit of all runs is taken.

use std::convert::Infallible;

use crate::campaign::Role;
use crate::campaign::record::Change;
use crate::engine::Problem;
use crate::estimate::batch::Options;
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::delays::{Delays, each};
use crate::estimate::newton::{Given, ReadingDelay};

/// Where the transformation is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum From {
    /// From the reference runs alone.
    ReferenceRuns,
    /// From the joint fit of all runs.
    JointFit,
}

impl From {
    /// The word programs read.
    pub fn word(self) -> &'static str {
        match self {
            Self::ReferenceRuns => "reference_runs",
            Self::JointFit => "joint_fit",
        }
    }
}

/// The delays of one campaign's readings: of its kinematic runs, or of all if it has no others.
pub fn delays_of(problem: &Problem, joint: &Calibration, part: usize) -> (From, Delays) {
    let Ok(found) = each_delay_of(problem, joint, part, &mut |_| Ok::<_, Infallible>(()));
    found
}

/// The same; `visit` sees every reading once, see [`each`].
///
/// # Errors
/// The first that `visit` gives; nothing more is solved then.
pub fn each_delay_of<E>(
    problem: &Problem,
    joint: &Calibration,
    part: usize,
    visit: &mut dyn FnMut(&ReadingDelay) -> Result<(), E>,
) -> Result<(From, Delays), E> {
    let runs = &problem.parts[part].runs;
    let kinematic: Vec<usize> =
        (0..runs.len()).filter(|r| runs[*r].role == Role::Kinematic).collect();
    let wanted = if kinematic.is_empty() { (0..runs.len()).collect() } else { kinematic };
    let range = problem.parts[part].delay_range;
    let reference = reference_fit(problem, part);
    let from = if reference.is_some() { From::ReferenceRuns } else { From::JointFit };
    // The reference fit has the same layout; only readings were taken away.
    let Calibration { fit, covariance, .. } = reference.as_ref().unwrap_or(joint);
    let given = Given { problem: &joint.problem, point: &fit.point, covariance, range };
    Ok((from, each(&given, part, &wanted, visit)?))
}

/// A fit of the reference runs alone, if every setup has some and they determine what they must.
fn reference_fit(problem: &Problem, part: usize) -> Option<Calibration> {
    let data = &problem.parts[part];
    let covered = (0..data.setups.len())
        .all(|setup| data.runs.iter().any(|run| run.setup == setup && run.role == Role::Reference));
    let separate = data.runs.iter().any(|run| run.role == Role::Kinematic);
    if !covered || !separate {
        return None;
    }
    let mut alone = problem.clone();
    for part in &mut alone.parts {
        for run in &mut part.runs {
            if run.role != Role::Reference {
                run.record = run.record.changed(Change::WithoutReadings);
            }
        }
    }
    let fit = calibrate(alone, &Options::default()).ok()?;
    fit.is_sound().then_some(fit)
}
