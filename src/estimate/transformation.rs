//! Where the delays take their transformation from: the reference runs, else the joint fit.
//!
//! The reference runs (slow or static) are fitted with their own delays, so that a slow run's delay
//! does not end up in the transformation (the seed's way carries it there). Where they alone do not
//! determine everything, say one direction of one slow run, the joint fit of all runs is taken.

use std::convert::Infallible;

use nalgebra::DMatrix;

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

/// The fit that a campaign's transformation is taken from.
#[derive(Debug)]
pub struct Transformation<'a> {
    joint: &'a Calibration,
    reference: Option<Calibration>,
}

impl<'a> Transformation<'a> {
    /// From the reference runs of a campaign if they determine it, else from the joint fit.
    pub fn of(problem: &Problem, joint: &'a Calibration, part: usize) -> Self {
        Self { joint, reference: reference_fit(problem, part) }
    }

    /// Which of the two.
    pub fn from(&self) -> From {
        if self.reference.is_some() { From::ReferenceRuns } else { From::JointFit }
    }

    /// The fit. That of reference runs has the same layout; only readings were taken away.
    pub fn fit(&self) -> &Calibration {
        self.reference.as_ref().unwrap_or(self.joint)
    }

    /// The joint fit's problem: all readings, with their weights.
    pub fn problem(&self) -> &Problem {
        &self.joint.problem
    }

    /// The delays of one campaign's readings, of its kinematic runs, or of all if it has no others; with
    /// the fit's own covariance unless another is given. `visit` sees every reading once, see [`each`].
    ///
    /// # Errors
    /// The first that `visit` gives; nothing more is solved then.
    pub fn delays<E>(
        &self,
        part: usize,
        covariance: Option<&DMatrix<f64>>,
        visit: &mut dyn FnMut(&ReadingDelay) -> Result<(), E>,
    ) -> Result<Delays, E> {
        let data = &self.problem().parts[part];
        let kinematic: Vec<usize> =
            (0..data.runs.len()).filter(|r| data.runs[*r].role == Role::Kinematic).collect();
        let wanted = if kinematic.is_empty() { (0..data.runs.len()).collect() } else { kinematic };
        let given = Given {
            problem: self.problem(),
            point: &self.fit().fit.point,
            covariance: covariance.unwrap_or(&self.fit().covariance),
            range: data.delay_range,
        };
        each(&given, part, &wanted, visit)
    }
}

/// The delays of one campaign's readings, see [`Transformation::delays`].
pub fn delays_of(problem: &Problem, joint: &Calibration, part: usize) -> (From, Delays) {
    let Ok(found) = each_delay_of(problem, joint, part, &mut |_| Ok::<_, Infallible>(()));
    found
}

/// The same; `visit` sees every reading once.
///
/// # Errors
/// The first that `visit` gives; nothing more is solved then.
pub fn each_delay_of<E>(
    problem: &Problem,
    joint: &Calibration,
    part: usize,
    visit: &mut dyn FnMut(&ReadingDelay) -> Result<(), E>,
) -> Result<(From, Delays), E> {
    let transformation = Transformation::of(problem, joint, part);
    Ok((transformation.from(), transformation.delays(part, None, visit)?))
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
