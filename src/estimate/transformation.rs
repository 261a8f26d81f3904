//! Where the delays take their transformation from, and what that does to them.
//!
//! - *Reference runs*: the slow or static runs alone, with their own delays. Needs both directions
//!   of a slow run, or a static one.
//! - *Joint fit*: all runs together; where the reference runs alone do not determine everything.
//! - *Paper*: the reference runs alone as if nothing were delayed (Depenthal 2009, 3.4): Horn's
//!   closed form, refined by least squares. A slow run's delay goes into it as a turn `ω_slow τ`
//!   about the arm axis, and a run at ω gets its delays wrong by `-τ ω_slow / ω`.
//! - *Iterated*: the paper's way again and again, each time with the delays found, until
//!   transformation and delays agree. One direction of one slow run will do. What errors do there:
//!   `iteration`.
//!
//! Residuals of the reference runs give each measurand's standard uncertainty, the paper's boundary
//! values.

use std::convert::Infallible;

use nalgebra::DMatrix;

use crate::campaign::Role;
use crate::campaign::record::Change;
use crate::engine::{Point, Problem};
use crate::estimate::batch::Options;
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::delays::{Delays, each};
use crate::estimate::newton::{Given, ReadingDelay};

mod held;
mod iteration;

use held::Held;
use iteration::{Gain, iterated};

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// Reference runs, else the joint fit.
    #[default]
    Best,
    /// The joint fit of all runs.
    Joint,
    /// The paper's way.
    Paper,
    /// The paper's way, iterated.
    Iterated,
}

/// Where the transformation is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum From {
    /// From the reference runs alone.
    ReferenceRuns,
    /// From the joint fit of all runs.
    JointFit,
    /// From the reference runs, as if nothing were delayed.
    Paper,
    /// From the reference runs with the delays of the others, in turn.
    Iterated,
}

impl From {
    /// The word programs read.
    pub fn word(self) -> &'static str {
        match self {
            Self::ReferenceRuns => "reference_runs",
            Self::JointFit => "joint_fit",
            Self::Paper => "paper",
            Self::Iterated => "iterated",
        }
    }
}

/// A transformation with whatever else was estimated beside it.
#[derive(Clone, Debug)]
pub struct Transformation {
    /// Where it is from.
    pub from: From,
    /// All readings, in the layout of point and covariance.
    pub problem: Problem,
    /// Its values.
    pub point: Point,
    fit: Calibration,
    /// Its covariance, which after an iteration holds what the delays found bring in.
    pub covariance: DMatrix<f64>,
    /// Standard deviation of each measurand's residuals in the runs it is from (SI), degrees of
    /// freedom counted: the paper's boundary values.
    pub residuals: Vec<(String, f64)>,
    /// Rounds that were needed.
    pub rounds: usize,
    /// What the iteration does to errors, if there was one.
    gain: Option<Gain>,
}

/// Why there is no such transformation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoTransformation {
    /// Some setup has no slow or static run, or there is no other.
    #[error(
        "this transformation needs runs with role = \"reference\" in every setup, and others to solve for delays"
    )]
    NoReference,
    /// They do not determine everything.
    #[error("the reference runs do not determine the transformation: {0}")]
    NotDetermined(String),
    /// Delays and transformation run away from each other.
    #[error(
        "delays and transformation do not come to agree: the kinematic runs are hardly faster than the reference runs"
    )]
    NotConverged,
}

/// The transformation asked for. The paper's way and its iteration take nothing but levels of noise
/// from the joint fit, which slow runs may not show; it need not be sound for them.
///
/// # Errors
/// [`NoTransformation`], for the paper's way and its iteration.
pub fn transformation(
    problem: &Problem,
    joint: Option<&Calibration>,
    part: usize,
    choice: Choice,
) -> Result<Transformation, NoTransformation> {
    match (choice, joint) {
        (Choice::Paper, _) => Held::new(problem, joint.map(|joint| &joint.problem), part)?
            .fit(&[])
            .map(|found| Transformation { from: From::Paper, ..found }),
        (Choice::Iterated, _) => iterated(problem, joint.map(|joint| &joint.problem), part),
        (Choice::Best, Some(joint)) => Ok(Transformation::of(problem, joint, part)),
        (_, Some(joint)) => Ok(of_fit(From::JointFit, joint.problem.clone(), joint)),
        (_, None) => Err(NoTransformation::NotDetermined("there is no joint fit".to_owned())),
    }
}

impl Transformation {
    /// The reference runs of a campaign if they determine it, else the joint fit.
    pub fn of(problem: &Problem, joint: &Calibration, part: usize) -> Self {
        reference(problem, joint, part)
            .unwrap_or_else(|| of_fit(From::JointFit, joint.problem.clone(), joint))
    }

    /// Where it is from.
    pub fn from(&self) -> From {
        self.from
    }

    /// The fit. Its layout is that of [`Transformation::problem`]; readings may have been taken
    /// away.
    pub fn fit(&self) -> &Calibration {
        &self.fit
    }

    /// All readings, with their weights.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The delays of one campaign's readings, of its kinematic runs, or of all if it has no others;
    /// with the fit's own covariance unless another is given. `visit` sees every reading once, see
    /// [`each`].
    ///
    /// # Errors
    /// The first that `visit` gives; nothing more is solved then.
    pub fn delays<E>(
        &self,
        part: usize,
        covariance: Option<&DMatrix<f64>>,
        visit: &mut dyn FnMut(&ReadingDelay) -> Result<(), E>,
    ) -> Result<Delays, E> {
        let covariance = covariance.unwrap_or(&self.covariance);
        self.solve(part, &self.wanted(part), covariance, visit)
    }

    /// The delays of one campaign's readings in some runs.
    pub fn means(&self, part: usize, runs: &[usize]) -> Delays {
        let Ok(found) = self.each_delay(part, runs, &mut |_| Ok::<_, Infallible>(()));
        found
    }

    /// The same; `visit` sees every reading once, see [`each`].
    ///
    /// # Errors
    /// The first that `visit` gives; nothing more is solved then.
    pub fn each_delay<E>(
        &self,
        part: usize,
        runs: &[usize],
        visit: &mut dyn FnMut(&ReadingDelay) -> Result<(), E>,
    ) -> Result<Delays, E> {
        self.solve(part, runs, &self.covariance, visit)
    }

    fn solve<E>(
        &self,
        part: usize,
        runs: &[usize],
        covariance: &DMatrix<f64>,
        visit: &mut dyn FnMut(&ReadingDelay) -> Result<(), E>,
    ) -> Result<Delays, E> {
        let Self { problem, point, .. } = self;
        let [low, high] = problem.parts[part].delay_range.hull();
        let range = high.max(-low);
        let given = Given { problem, point, covariance, range };
        let mut found = each(&given, part, runs, visit)?;
        if let Some(gain) = &self.gain {
            gain.correlate(&mut found, &self.problem, part);
        }
        Ok(found)
    }

    /// The iterated transformation of the same campaign, with the levels of noise that this one
    /// has.
    ///
    /// # Errors
    /// As for [`transformation`].
    pub fn iterated(&self, problem: &Problem, part: usize) -> Result<Self, NoTransformation> {
        iterated(problem, Some(&self.problem), part)
    }

    /// Some part of the fit's covariance as it is at the end of the iteration, if there was one.
    pub fn carried(&self, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        self.gain.as_ref().map_or_else(|| covariance.clone(), |gain| gain.carried(covariance))
    }

    /// The runs of a campaign whose delays are wanted: its kinematic ones, or all if it has no
    /// others.
    pub fn wanted(&self, part: usize) -> Vec<usize> {
        wanted(&self.problem, part)
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

fn wanted(problem: &Problem, part: usize) -> Vec<usize> {
    let runs = &problem.parts[part].runs;
    let kinematic: Vec<usize> =
        (0..runs.len()).filter(|r| runs[*r].role == Role::Kinematic).collect();
    if kinematic.is_empty() { (0..runs.len()).collect() } else { kinematic }
}

fn of_fit(from: From, problem: Problem, fit: &Calibration) -> Transformation {
    // All unknowns share the loss of degrees of freedom evenly.
    let free = fit.degrees_of_freedom().max(1) as f64 / fit.readings.max(1) as f64;
    Transformation {
        from,
        problem,
        point: fit.fit.point.clone(),
        fit: fit.clone(),
        covariance: fit.covariance.clone(),
        residuals: fit.rms.iter().map(|(name, rms)| (name.clone(), rms / free.sqrt())).collect(),
        rounds: 1,
        gain: None,
    }
}

/// A fit of the reference runs alone, with their own delays, if they determine what they must.
fn reference(problem: &Problem, joint: &Calibration, part: usize) -> Option<Transformation> {
    let fit = calibrate(alone(problem, part)?, &Options::default()).ok()?;
    // The reference fit has the same layout; only readings were taken away.
    fit.is_sound().then(|| of_fit(From::ReferenceRuns, joint.problem.clone(), &fit))
}

/// The problem with the readings of the reference runs alone, if every setup has some.
fn alone(problem: &Problem, part: usize) -> Option<Problem> {
    let data = &problem.parts[part];
    let covered = (0..data.setups.len())
        .all(|setup| data.runs.iter().any(|run| run.setup == setup && run.role == Role::Reference));
    let separate = data.runs.iter().any(|run| run.role == Role::Kinematic);
    if !covered || !separate {
        return None;
    }
    let mut alone = problem.clone();
    for run in alone.parts.iter_mut().flat_map(|part| &mut part.runs) {
        if run.role != Role::Reference {
            run.record = run.record.changed(Change::WithoutReadings);
        }
    }
    Some(alone)
}
