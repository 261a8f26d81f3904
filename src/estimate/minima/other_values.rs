//! Minima at which one scalar or one component of a vector has another value: a parameter that acts
//! by its square, an anchor above or below the plane from which ranges to it are taken.
//!
//! Each component is tried by itself: a scalar from the other sign, an angle from all around
//! ([`around`]), and all others from where the sum of squares along it, all else held, should have
//! its other minimum. Where readings lose their sensitivity to it at a distance d, that is 2 d away,
//! and two values beside the estimate say how far: with J(p + s) = J(p) (1 + s / d) the sum of
//! squares grows as s^2 (1 + s / (2 d))^2. Along a parameter in which the model is linear there is
//! none, which costs no fit. What is found on some samples is compared on more.

use rayon::prelude::*;

use crate::engine::Point;
use crate::engine::gram::LeastSquares;
use crate::estimate::calibrate::Calibration;
use crate::estimate::minima::Other;
use crate::estimate::minima::compared::{APART, Compared, ITERATIONS};
use crate::estimate::minima::signs::{lost_signs, stated_signs};
use crate::estimate::minima::thinned::Tried;

use super::SAMPLES;

mod around;
mod components;

use components::{Component, components, is_same_attitude, tried};

/// Where the other minimum may lie, relative to where it is expected: sensitivities are no straight
/// lines. Of two wells one of three neighbouring values lies in the other, and lower.
const FACTORS: [f64; 8] = [0.11, 0.17, 0.26, 0.38, 0.58, 0.87, 1.3, 1.95];
/// Most values of an angle that are reported: of many at even steps the nearest ones.
const ANGLES: usize = 2;

/// A minimum on a part of the samples, and for which component it was looked for.
struct Candidate {
    own: Component,
    there: Tried,
}

/// Minima at which a scalar or a component of a vector has another value, each by itself; of several
/// that lead to the same minimum the first.
pub(super) fn other_values(fit: &Calibration) -> Vec<Other> {
    let (problem, point) = (&fit.problem, &fit.fit.point);
    let every = components(fit);
    let all = tried(fit, &every);
    if all.is_empty() {
        return Vec::new();
    }
    let some = |most: usize| Compared::of(problem, point, most);
    let Some(few) = some(SAMPLES[0]) else { return Vec::new() };
    // One by one: an angle takes far longer than other components.
    let each = all.par_iter().with_max_len(1);
    let found: Vec<Candidate> = each.flat_map_iter(|own| few.minima(own)).collect();
    if found.is_empty() {
        return Vec::new();
    }
    let Some(many) = some(SAMPLES[2]) else { return Vec::new() };
    let stated = stated_signs(problem);
    let lost = lost_signs(&stated, point);
    let [every, all] = [every, all]
        .map(|all| all.iter().map(|one| one.from(&many.here.point)).collect::<Vec<_>>());
    let mut others: Vec<Other> = Vec::new();
    for Candidate { own, there } in found {
        let is_own =
            |other: &&Other| (other.instance, other.component) == (own.instance, own.component);
        if own.is_angle && others.iter().filter(is_own).count() == ANGLES {
            continue;
        }
        let own = own.from(&many.here.point);
        let there = Tried::fit(many.problem.clone(), there.point, 0.0, ITERATIONS[1]);
        let is_another = |there: &Tried| {
            own.is_elsewhere(&there.point)
                && !is_same_attitude(&every, &there.point)
                && lost_signs(&stated, &there.point).iter().all(|one| lost.contains(one))
                && many.is_another(there)
        };
        let Some(there) = there.filter(is_another) else { continue };
        let value = own.at(&there.point);
        let with = all.iter().filter(|one| {
            let is_own = (one.instance, one.component) == (own.instance, own.component);
            !is_own && one.goes_with(&there.point)
        });
        let with: Vec<(usize, usize, f64)> =
            with.map(|one| (one.instance, one.component, one.at(&there.point))).collect();
        let is_known = others.iter().any(|other| {
            let is_same = (other.instance, other.component) == (own.instance, own.component)
                && !own.differ(other.values[0], value);
            let is_among = |all: &[(usize, usize, f64)], instance, component| {
                all.iter().any(|one| (one.0, one.1) == (instance, component))
            };
            let is_joint = is_among(&other.with, own.instance, own.component)
                && is_among(&with, other.instance, other.component);
            is_same || is_joint
        });
        if !is_known {
            others.push(Other {
                instance: own.instance,
                component: own.component,
                values: [value, own.at(point)],
                chi_squared: many.excess(&there),
                with,
            });
        }
    }
    others.sort_by_key(|one| (one.instance, one.component));
    others
}

impl Compared {
    /// Minima at which a component is elsewhere and that may fit alike on all samples.
    fn minima(&self, own: &Component) -> Vec<Candidate> {
        let own = own.from(&self.here.point);
        let mut found: Vec<Candidate> = Vec::new();
        for start in self.starts(&own) {
            let there = Tried::fit(self.problem.clone(), start, 0.0, ITERATIONS[0]);
            let is_near =
                |there: &Tried| self.may_be_another(there) && own.is_elsewhere(&there.point);
            let Some(there) = there.filter(is_near) else { continue };
            let is_new =
                found.iter().all(|one| own.differ(own.at(&one.there.point), own.at(&there.point)));
            if is_new {
                found.push(Candidate { own, there });
            }
        }
        found
    }

    /// Where a fit of another value of a component begins.
    fn starts(&self, own: &Component) -> Vec<Point> {
        if own.is_angle {
            return self.around(own);
        }
        let mirrored = own.is_searched.then_some(-own.value);
        let values = self.along(own).into_iter().chain(mirrored);
        values.map(|value| own.moved(&self.here.point, value)).collect()
    }

    /// The value of a component at which the sum of squares along it has its other minimum, roughly;
    /// `None` where that is farther away than its reach, or the sum only grows on the way there.
    fn along(&self, own: &Component) -> Option<f64> {
        let (here, step) = (own.at(&self.here.point), APART * own.sigma);
        let cost = |value: f64| self.problem.cost(&own.moved(&self.here.point, value));
        let growth = |step: f64| cost(here + step) - self.here.chi_squared;
        let [above, below] = [growth(step), growth(-step)];
        let distance = -2.0 * step * (above + below) / (above - below);
        if distance.is_nan() || distance.abs() > own.reach {
            return None;
        }
        let values = FACTORS.map(|factor| here + factor * distance);
        let costs = values.map(cost);
        let is_lowest = |at: &usize| costs[*at] < costs[at - 1] && costs[*at] <= costs[at + 1];
        let minima = (1..FACTORS.len() - 1).filter(is_lowest);
        minima.min_by(|a, b| costs[*a].total_cmp(&costs[*b])).map(|at| values[at])
    }
}
