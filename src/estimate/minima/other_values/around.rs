//! Where the fit of other values of an angle begins: the zero of an encoder before a gear, an axis
//! that acts by a multiple of its angle, a phase beside an amplitude of either sign.
//!
//! Near the estimate the sum of squares grows with the square of the step. Where it grows by less
//! than half of that, the readings have gone through about half a period. Around the turn, in steps
//! of a small part of that way, the angle is held and the other unknowns follow by one step. The
//! lowest places of that profile are the starts. An angle that acts in proportion has none.

use std::f64::consts::PI;

use crate::engine::Point;
use crate::engine::gram::LeastSquares;
use crate::estimate::batch::{Options, fit};
use crate::estimate::minima::compared::{APART, Compared};
use crate::estimate::minima::held::Held;
use crate::estimate::minima::other_values::Component;

/// The first step, in standard uncertainties of these samples with all else held.
const SMALL: f64 = 0.1;
/// Growth, relative to that square, with which readings have gone through about half a period.
const TURNED: f64 = 0.5;
/// Steps of the profile in that way, and most of them to either side.
const STEPS: f64 = 12.0;
const MOST_STEPS: usize = 64;
/// Steps to either side of a large problem: somewhat more than a period.
const LEAST_STEPS: usize = 26;
/// Most steps, times the readings, times the unknowns.
const WORK: usize = 10_000_000;
/// Places up to so high a part of the profile may be the bottom of a minimum.
const DEEP: f64 = 0.1;
/// Fits at most.
const STARTS: usize = 6;

impl Compared {
    /// Points from which other values of an angle are fitted: deep places of the profile first, the
    /// nearest of them first.
    pub(super) fn around(&self, own: &Component) -> Vec<Point> {
        let Some(half_period) = self.half_period(own) else { return Vec::new() };
        let step = half_period / STEPS;
        // One more to either side shows whether half a turn is a minimum.
        let count = (((PI / step).round() as usize).saturating_add(1)).min(self.most_steps());
        let from = -(count as f64);
        let profile: Vec<(f64, Point)> =
            (0..=2 * count).map(|at| self.with_held(own, (from + at as f64) * step)).collect();
        let here = self.here.chi_squared;
        let finite = profile.iter().map(|one| one.0).filter(|cost| cost.is_finite());
        let deep = here + DEEP * (finite.fold(here, f64::max) - here);
        let is_lowest =
            |at: &usize| profile[*at].0 < profile[at - 1].0 && profile[*at].0 <= profile[at + 1].0;
        let mut lowest: Vec<usize> =
            (1..2 * count).filter(|at| *at != count).filter(is_lowest).collect();
        lowest.sort_by(|a, b| {
            let height = |at: usize| profile[at].0.max(deep);
            height(*a).total_cmp(&height(*b)).then(a.abs_diff(count).cmp(&b.abs_diff(count)))
        });
        lowest.into_iter().take(STARTS).map(|at| profile[at].1.clone()).collect()
    }

    /// Steps to either side that the size of the problem allows.
    fn most_steps(&self) -> usize {
        let size = self.here.readings * self.problem.layout.columns.len();
        (WORK / (2 * size).max(1)).clamp(LEAST_STEPS, MOST_STEPS)
    }

    /// How far (rad) readings go through about half a period, or less, with all else held; `None`
    /// where half a turn is less than that.
    fn half_period(&self, own: &Component) -> Option<f64> {
        if APART * own.sigma > PI {
            return None;
        }
        let here = own.at(&self.here.point);
        let growth = |step: f64| {
            let cost = |value: f64| self.problem.cost(&own.moved(&self.here.point, value));
            [cost(here + step), cost(here - step)].map(|cost| cost - self.here.chi_squared)
        };
        let curvature = self.curvature(own.column);
        let small = SMALL / curvature.sqrt();
        if !(small > 0.0 && small.is_finite()) {
            return None;
        }
        let halvings = (PI / small).log2().floor() as i32;
        let steps = (0..halvings).rev().map(|halving| PI * 0.5_f64.powi(halving));
        let is_turned = |step: &f64| {
            let [above, below] = growth(*step);
            above.min(below) < TURNED * curvature * step.powi(2)
        };
        steps.into_iter().find(is_turned)
    }

    /// The sum of squares, and where, with an angle held at a step from the estimate; the other
    /// unknowns follow in one step.
    fn with_held(&self, own: &Component, step: f64) -> (f64, Point) {
        let mut problem = self.problem.clone();
        let start = own.moved(&self.here.point, own.at(&self.here.point) + step);
        let mut held = Held::of_columns(&mut problem, vec![own.column]);
        let options = Options { max_iterations: 1, ..Options::default() };
        match fit(&mut held, start.clone(), &options) {
            Ok(found) if found.cost.is_finite() => (found.cost, found.point),
            _ => (f64::INFINITY, start),
        }
    }
}
