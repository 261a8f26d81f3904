//! Where the delays take their transformation from, and what that does to them.
//!
//! - *Reference runs*: the slow or static runs alone, with their own delays. Needs both directions of
//!   a slow run, or a static one.
//! - *Joint fit*: all runs together; where the reference runs alone do not determine everything.
//! - *Paper*: the reference runs alone as if nothing were delayed (Depenthal 2009, 3.4): Horn's closed
//!   form, refined by least squares. A slow run's delay goes into it as a turn `ω_slow τ` about the arm
//!   axis, and a run at ω gets its delays wrong by `-τ ω_slow / ω`.
//! - *Iterated*: the paper's way again and again, each time with the delays found, until transformation
//!   and delays agree. One direction of one slow run will do. With `τ = D(T(τ))` at the end, errors
//!   grow by `(1 - ∂D/∂τ)⁻¹`, which [`Summary`]s carry; those of single readings do not.
//!
//! Residuals of the reference runs give each measurand's standard uncertainty, the paper's boundary
//! values.

use std::convert::Infallible;

use nalgebra::{DMatrix, DVector};

use crate::campaign::Role;
use crate::campaign::record::Change;
use crate::engine::{Point, Problem};
use crate::estimate::batch::Options;
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::delays::{Delays, Summary, each};
use crate::estimate::newton::{Given, ReadingDelay};

/// Rounds of the iteration before giving up.
const ROUNDS: usize = 60;
/// Delays that change by less (s) stand.
const STANDS: f64 = 1e-13;
/// Change of a delay (s) from which the iteration's gain is found.
const TRIAL: f64 = 1e-6;

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
    /// Its covariance.
    pub covariance: DMatrix<f64>,
    /// Standard deviation of each measurand's residuals in the runs it is from (SI), degrees of
    /// freedom counted: the paper's boundary values.
    pub residuals: Vec<(String, f64)>,
    /// Rounds that were needed.
    pub rounds: usize,
    /// `∂D/∂τ` of the iteration, and the delay parameter's measurands in its order.
    gain: Option<Gain>,
}

/// How delays found answer to delays put in.
#[derive(Clone, Debug)]
struct Gain {
    measurands: Vec<usize>,
    answer: DMatrix<f64>,
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

/// The transformation asked for. The paper's way and its iteration take nothing but levels of noise from
/// the joint fit, which slow runs may not show; it need not be sound for them.
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
        (Choice::Paper, _) => paper(problem, joint.map(|joint| &joint.problem), part, &[])
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

    /// The fit. Its layout is that of [`Transformation::problem`]; readings may have been taken away.
    pub fn fit(&self) -> &Calibration {
        &self.fit
    }

    /// All readings, with their weights.
    pub fn problem(&self) -> &Problem {
        &self.problem
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
        let range = problem.parts[part].delay_range;
        let given = Given { problem, point, covariance, range };
        let mut found = each(&given, part, runs, visit)?;
        if let Some(gain) = &self.gain {
            gain.widen(&mut found.measurands, covariance, |summary| {
                let names = &self.problem.parts[part].system.assembly.names;
                names.measurands.iter().position(|one| one.name == summary.measurand)
            });
        }
        Ok(found)
    }

    /// The iterated transformation of the same campaign, with the levels of noise that this one has.
    ///
    /// # Errors
    /// As for [`transformation`].
    pub fn iterated(&self, problem: &Problem, part: usize) -> Result<Self, NoTransformation> {
        iterated(problem, Some(&self.problem), part)
    }

    /// The runs of a campaign whose delays are wanted: its kinematic ones, or all if it has no others.
    pub fn wanted(&self, part: usize) -> Vec<usize> {
        wanted(&self.problem, part)
    }
}

impl Gain {
    /// Lets the uncertainties of means grow as errors do at the end of the iteration.
    fn widen(
        &self,
        summaries: &mut [Summary],
        covariance: &DMatrix<f64>,
        measurand: impl Fn(&Summary) -> Option<usize>,
    ) {
        let count = self.measurands.len();
        let Some(growth) = (DMatrix::identity(count, count) - &self.answer).try_inverse() else {
            return;
        };
        let place: Vec<Option<usize>> = summaries
            .iter()
            .map(|one| self.measurands.iter().position(|m| measurand(one) == Some(*m)))
            .collect();
        let columns = covariance.nrows();
        let mut sensitivity = DMatrix::zeros(count, columns);
        let mut random = DVector::zeros(count);
        for (summary, place) in summaries.iter().zip(&place) {
            let Some(row) = *place else { continue };
            sensitivity.row_mut(row).copy_from(&summary.sensitivity.transpose());
            random[row] = summary.random.unwrap_or(0.0).powi(2);
        }
        let grown = &growth * sensitivity;
        let common = &grown * covariance * grown.transpose();
        let random = &growth * DMatrix::from_diagonal(&random) * growth.transpose();
        for (summary, place) in summaries.iter_mut().zip(&place) {
            let (Some(row), Some(_)) = (*place, summary.mean) else { continue };
            let part = |of: &DMatrix<f64>| of[(row, row)].max(0.0).sqrt();
            summary.sensitivity = grown.row(row).transpose();
            summary.common = Some(part(&common));
            summary.random = Some(part(&random));
            summary.sigma_of_mean = Some(part(&common).hypot(part(&random)));
        }
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

/// The reference runs alone with delays held: each parameter's as given, else zero.
fn paper(
    problem: &Problem,
    levels: Option<&Problem>,
    part: usize,
    held: &[(usize, f64)],
) -> Result<Transformation, NoTransformation> {
    let mut parts = problem.parts.clone();
    for (p, part_held) in parts.iter_mut().enumerate() {
        for index in free_delays(problem, p) {
            let given = held.iter().find(|(parameter, _)| p == part && *parameter == index);
            let setting = &mut part_held.system.settings[index];
            setting.fixed = true;
            setting.sigma = None;
            setting.value = Some(vec![given.map_or(0.0, |(_, delay)| *delay)]);
        }
    }
    let mut whole = Problem::new(parts);
    let alone = alone(&whole, part).ok_or(NoTransformation::NoReference)?;
    let undetermined = |why: String| NoTransformation::NotDetermined(why);
    let fit =
        calibrate(alone, &Options::default()).map_err(|error| undetermined(error.to_string()))?;
    if !fit.is_sound() {
        let words: Vec<&str> = fit.unobservable.iter().map(|one| one.words.as_str()).collect();
        let why = if words.is_empty() { fit.fit.outcome.to_string() } else { words.join("; ") };
        return Err(undetermined(why));
    }
    let levels = levels.unwrap_or(&fit.problem);
    for (part, fitted) in whole.parts.iter_mut().zip(&levels.parts) {
        part.random_sigma.clone_from(&fitted.random_sigma);
    }
    Ok(of_fit(From::Iterated, whole, &fit))
}

/// The delay parameters of a campaign that are not held already.
fn free_delays(problem: &Problem, part: usize) -> Vec<usize> {
    let system = &problem.parts[part].system;
    let is_free = |index: &usize| {
        !system.declared[*index].delay_of.is_empty() && !system.settings[*index].fixed
    };
    (0..system.settings.len()).filter(is_free).collect()
}

/// Transformation and delays in turn.
fn iterated(
    problem: &Problem,
    levels: Option<&Problem>,
    part: usize,
) -> Result<Transformation, NoTransformation> {
    let free = free_delays(problem, part);
    let runs = wanted(problem, part);
    let system = &problem.parts[part].system;
    let found = |held: &[(usize, f64)]| -> Result<(Transformation, Vec<(usize, f64)>), _> {
        let given = paper(problem, levels, part, held)?;
        let solved = given.means(part, &runs).measurands;
        let names = &system.assembly.names.measurands;
        let mean_of = |parameter: &usize| {
            let own = system.declared[*parameter].delay_of.iter();
            let means: Vec<f64> = own
                .filter_map(|m| solved.iter().find(|one| one.measurand == names[*m].name)?.mean)
                .collect();
            (*parameter, means.iter().sum::<f64>() / means.len().max(1) as f64)
        };
        Ok((given, free.iter().map(mean_of).collect()))
    };
    let farthest = |a: &[(usize, f64)], b: &[(usize, f64)]| {
        a.iter().zip(b).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max)
    };
    let mut held: Vec<(usize, f64)> = free.iter().map(|index| (*index, 0.0)).collect();
    for round in 1..=ROUNDS {
        let (mut given, next) = found(&held)?;
        if farthest(&held, &next) > STANDS {
            held = next;
            continue;
        }
        let mut answer = DMatrix::zeros(free.len(), free.len());
        for column in 0..free.len() {
            let mut tried = held.clone();
            tried[column].1 += TRIAL;
            let (_, moved) = found(&tried)?;
            for row in 0..free.len() {
                answer[(row, column)] = (moved[row].1 - next[row].1) / TRIAL;
            }
        }
        given.rounds = round;
        // A delay that measurands share has no mean of its own: their summaries stay as they are.
        let single = free.iter().all(|index| system.declared[*index].delay_of.len() == 1);
        let measurands = free.iter().flat_map(|i| system.declared[*i].delay_of.clone()).collect();
        given.gain = single.then_some(Gain { measurands, answer });
        return Ok(given);
    }
    Err(NoTransformation::NotConverged)
}
