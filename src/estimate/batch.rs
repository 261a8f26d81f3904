//! Batch least squares: fits all unknowns to all readings at once, on their manifolds.
//!
//! Levenberg-Marquardt, cut into *search* (how strongly to damp) and *descent* (which step follows
//! from a linearisation and a damping; free, or within bounds). Each round: weights follow the
//! point and freeze, the problem is linearised, steps are tried until one lowers the cost about as
//! predicted. The first step of a round is mostly good, so where weights stand still the point it
//! leads to is linearised at once, which gives its cost, too: one pass over the readings a round.
//!
//! It stops on the size of the **undamped** step, measured in noise: `|J step| = √(gᵀ H⁻¹ g)`
//! bounds how far *any* combination of unknowns still has to go, in its own standard uncertainty. A
//! small step under strong damping, or a cost that has stopped falling, is not convergence. The
//! same number is the gradient's length in the metric of `H⁻¹`, so there is no separate test for
//! it. The one secondary criterion is relative: if the undamped step promises less than
//! [`Options::decrease_tolerance`] of the cost, rounding of the cost hides all further progress.
//!
//! It does not judge whether the unknowns are determined: it also converges where some are not
//! (they stay put along such directions). Ask `observability`. Nor does it weigh outliers: a
//! problem's `reweight` does.

use std::fmt;

use nalgebra::DVector;

use super::arrow::{Arrow, LinearError, cost};
use super::conic::BoundedError;
use crate::engine::gram::{LeastSquares, Normal};

mod descent;
mod ending;
mod rounding;
mod search;

use ending::{Blind, Shrinking};
use rounding::Rounding;
use search::{ACCEPT, Search, ridge};

/// Damping, relative to the columns, that keeps the stopping test regular where unknowns are not
/// determined; far below what any determined combination has (1e-8).
const PROBE: f64 = 1e-12;
/// Relative change of the cost below which a comparison of two costs says nothing.
const COST_ROUNDING: f64 = 1e-12;

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Most rounds; up to three times as many where the way left shrinks each time.
    pub max_iterations: usize,
    /// Largest step left to go, in standard uncertainties.
    pub step_tolerance: f64,
    /// Least share of the cost worth a further step.
    pub decrease_tolerance: f64,
    /// Least noise the residuals are believed to have: 1 as they are whitened. The standard
    /// uncertainties of `step_tolerance` use this or the residuals' own scatter, if larger. 0 for
    /// residuals of unknown scale.
    pub noise_floor: f64,
    /// First damping, relative to the columns.
    pub damping: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_iterations: 100,
            step_tolerance: 1e-6,
            decrease_tolerance: 1e-14,
            noise_floor: 1.0,
            damping: 1e-3,
        }
    }
}

/// Where no step helps any more, a way left below this part of the standard uncertainties is none.
const SETTLED: f64 = 1e-3;
/// ... and one below this part of them small beside them, where the model jumps.
const NEAR: f64 = 0.2;

/// How a fit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// The unknowns settled.
    Converged,
    /// No step helped, near to the solution.
    Near,
    /// No step helped.
    Stalled,
    /// Out of iterations.
    IterationLimit,
    /// The model is undefined where the fit stands.
    NotFinite,
}

impl Outcome {
    /// Whether the numbers are a solution.
    pub fn is_result(self) -> bool {
        matches!(self, Self::Converged | Self::Near)
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Converged => {
                "The fit converged: what is left to go is far below the standard uncertainties."
            }
            Self::Near => {
                "The fit ended less than a fifth of the standard uncertainties from its solution."
            }
            Self::Stalled => {
                "The fit stalled: no step lowers the sum of squares any more, but the unknowns \
                 had not settled. Look for a start nearer to the solution, or for a model that \
                 jumps."
            }
            Self::IterationLimit => {
                "The fit used up its iterations before the unknowns settled. Its numbers are not \
                 a solution."
            }
            Self::NotFinite => {
                "The fit stopped where the model has no finite value or derivative. Check start \
                 values and readings."
            }
        })
    }
}

/// Where a fit ended.
#[derive(Clone, Debug)]
pub struct Fit<Point> {
    /// The unknowns.
    pub point: Point,
    /// Sum of squares there, with the weights of that point.
    pub cost: f64,
    /// The problem linearised there, undamped.
    pub normal: Normal,
    /// Points from which steps were looked for.
    pub iterations: usize,
    /// Passes over the readings, with derivatives or without.
    pub evaluations: usize,
    /// The step left to go, in standard uncertainties.
    pub remaining: f64,
    /// How it ended.
    pub outcome: Outcome,
}

/// Why a problem cannot be fitted at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Sums and blocks do not fit together.
    #[error(transparent)]
    Linear(#[from] LinearError),
    /// Bounds that cannot be kept.
    #[error(transparent)]
    Bounded(#[from] BoundedError),
}

/// Fits a problem from a start. A poor end is a [`Fit`] with its [`Outcome`], not an error.
///
/// # Errors
/// [`FitError`] if sums do not fit their blocks or bounds exclude each other.
pub fn fit<P: LeastSquares>(
    problem: &mut P,
    start: P::Point,
    options: &Options,
) -> Result<Fit<P::Point>, FitError> {
    let mut search = Search::new(problem.columns().len(), options.damping);
    let mut rounding = Rounding::new(problem.columns().len());
    let (mut blind, mut shrinking) = (Blind::default(), Shrinking::default());
    let (mut point, mut known) = (start, None);
    let (mut iterations, mut evaluations) = (0, 0);
    loop {
        iterations += 1;
        problem.begins(iterations);
        problem.reweight(&point);
        let normal = known.take().unwrap_or_else(|| {
            evaluations += 1;
            problem.normal(&point)
        });
        let here_cost = cost(&normal);
        let mut here = Fit {
            cost: here_cost,
            normal,
            point,
            iterations,
            evaluations,
            remaining: f64::INFINITY,
            outcome: Outcome::NotFinite,
        };
        let mut arrow = Arrow::assemble(&here.normal)?;
        let finite = |v: &DVector<f64>| v.iter().all(|x| x.is_finite());
        if !(here_cost.is_finite() && finite(arrow.gradient()) && finite(arrow.diagonal())) {
            return Ok(here);
        }
        let linearised = (&mut here.normal, &arrow, here_cost);
        if rounding.zero_columns(problem, &here.point, linearised, &mut evaluations) {
            arrow = Arrow::assemble(&here.normal)?;
        }
        here.evaluations = evaluations;
        let bounds = problem.step_bounds(&here.point);
        let way = undamped_length(&arrow, &bounds)?;
        let unit = noise(&here.normal, here_cost).max(options.noise_floor);
        here.remaining = if way == 0.0 { 0.0 } else { way / unit };
        let is_there = here.remaining <= options.step_tolerance
            || way.powi(2) <= options.decrease_tolerance * here_cost;
        // Residuals of a thousand times the stated noise would call a way converged that is long in
        // stated standard uncertainties.
        let is_near = options.noise_floor == 0.0 || way <= SETTLED * options.noise_floor;
        if is_there && (is_near || iterations > options.max_iterations) {
            here.outcome = Outcome::Converged;
            return Ok(here);
        }
        if shrinking.may_end(way, iterations, options.max_iterations) {
            here.outcome = if here.remaining <= SETTLED && is_near {
                Outcome::Converged
            } else {
                Outcome::IterationLimit
            };
            return Ok(here);
        }
        let is_blind = way.powi(2) <= COST_ROUNDING * here_cost;
        search.rescale(arrow.diagonal());
        let mut next = None;
        // The first point that is tried is linearised at once; others cost less.
        let mut at_once = !problem.weights_move();
        while search.alive() && !(is_blind && blind.is_lost(way)) {
            let damping = search.terms();
            let Some(step) = descent::step(&arrow, &damping, &bounds)? else {
                search.reject();
                continue;
            };
            let predicted = predicted_decrease(&arrow, &damping, &step);
            if !is_blind && predicted.is_nan() | (predicted <= f64::EPSILON * here_cost) {
                break;
            }
            let candidate = problem.moved(&here.point, step.as_slice());
            evaluations += 1;
            let there = std::mem::take(&mut at_once).then(|| problem.normal(&candidate));
            let decrease =
                here_cost - there.as_ref().map_or_else(|| problem.cost(&candidate), cost);
            let (wanted, ratio) = if is_blind {
                (-2.0 * COST_ROUNDING * here_cost, 1.0)
            } else {
                (ACCEPT * predicted, decrease / predicted)
            };
            if decrease >= wanted {
                search.accept(ratio);
                next = Some((candidate, there));
                break;
            }
            search.reject();
        }
        let Some(found) = next else {
            here.evaluations = evaluations;
            // Readings have a rounding of their own (an angle of 1 rad against an uncertainty of 1
            // µrad leaves ten digits), so the cost may stop to tell steps apart before they are
            // tiny.
            // In stated standard uncertainties, too: those of the results are not scaled.
            let is_stated = options.noise_floor == 0.0 || way <= NEAR * options.noise_floor;
            here.outcome = match here.remaining {
                left if left <= SETTLED => Outcome::Converged,
                left if left <= NEAR && is_stated => Outcome::Near,
                _ => Outcome::Stalled,
            };
            return Ok(here);
        };
        (point, known) = found;
    }
}

/// Scatter of the residuals: √(cost / degrees of freedom).
fn noise(normal: &Normal, cost: f64) -> f64 {
    let readings = normal.runs.iter().map(|run| run.readings).sum::<usize>() + normal.priors.len();
    let freedom = readings.saturating_sub(normal.columns.len()).max(1);
    (cost / freedom as f64).sqrt()
}

/// How much a damped step should lower the cost: `2 gᵀ s - |J s|²`. As `(H + D) s = g`, that is
/// also `gᵀ s + sᵀ D s` (no more than it, if a bound holds the step), a sum without cancellation.
fn predicted_decrease(arrow: &Arrow, damping: &DVector<f64>, step: &DVector<f64>) -> f64 {
    let slope = arrow.gradient().dot(step);
    let damped = slope + step.component_mul(damping).dot(step);
    damped.max(2.0 * slope - arrow.squared_length(step))
}

/// `|J step|` of the undamped step (within bounds), in residual units.
fn undamped_length(arrow: &Arrow, bounds: &[(f64, f64)]) -> Result<f64, FitError> {
    let mut share = PROBE;
    while share < 1.0 {
        if let Some(step) = descent::step(arrow, &ridge(arrow.diagonal(), share), bounds)? {
            // `gᵀ step` is the same but for the probe, and no less at a bound; it is computed
            // without the cancellation that `|J step|²` suffers along a narrow valley.
            return Ok(arrow.squared_length(&step).max(arrow.gradient().dot(&step)).sqrt());
        }
        share *= 10.0;
    }
    Ok(f64::INFINITY)
}
