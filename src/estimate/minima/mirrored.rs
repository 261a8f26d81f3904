//! Minima at which one scalar or one component of a vector has another value: a parameter that acts
//! by its square, an anchor above or below the plane from which ranges to it are taken.
//!
//! Each component is tried by itself: a scalar from the other sign, and all from where the sum of
//! squares along it, all else held, should have its other minimum. Where readings lose their
//! sensitivity to it at a distance d, that is 2 d away, and two values beside the estimate say how
//! far: with J(p + s) = J(p) (1 + s / d) the sum of squares grows as s^2 (1 + s / (2 d))^2. Along a
//! parameter in which the model is linear there is none, which costs no fit. What is found on some
//! samples is compared on more.

use rayon::prelude::*;

use crate::engine::gram::LeastSquares;
use crate::engine::layout::Layout;
use crate::engine::{Point, Problem};
use crate::estimate::calibrate::Calibration;
use crate::estimate::minima::Other;
use crate::estimate::minima::compared::{APART, Compared, ITERATIONS};
use crate::estimate::minima::thinned::Tried;
use crate::graph::Kind;

use super::SAMPLES;

/// Most components that are tried, those that are determined least, and most scalars of the other
/// sign.
const MOST: [usize; 2] = [64, 12];
/// Where the other minimum may lie, relative to where it is expected: sensitivities are no straight
/// lines. Of two wells one of three neighbouring values lies in the other, and lower.
const FACTORS: [f64; 8] = [0.11, 0.17, 0.26, 0.38, 0.58, 0.87, 1.3, 1.95];
/// The other minimum lies within so many times the largest value of a parameter in the same unit.
const REACH: f64 = 4.0;

/// A component that is tried.
#[derive(Clone, Copy, Debug)]
struct Component {
    instance: usize,
    component: usize,
    value: f64,
    sigma: f64,
    /// Whether it starts from the other sign, too.
    is_mirrored: bool,
}

impl Component {
    fn at(&self, point: &Point) -> f64 {
        point.values[self.instance][self.component]
    }

    /// The point with another value of it alone.
    fn moved(&self, point: &Point, value: f64) -> Point {
        let mut point = point.clone();
        point.values[self.instance][self.component] = value;
        point
    }

    fn is_elsewhere(&self, point: &Point) -> bool {
        (self.at(point) - self.value).abs() > APART * self.sigma
    }
}

/// A minimum on a part of the samples, and for which component it was looked for.
struct Candidate {
    own: Component,
    there: Tried,
}

/// Minima at which a scalar or a component of a vector has another value, each by itself; of several
/// that lead to the same minimum the first.
pub(super) fn other_values(fit: &Calibration) -> Vec<Other> {
    let (problem, point) = (&fit.problem, &fit.fit.point);
    let all = components(fit);
    if all.is_empty() {
        return Vec::new();
    }
    let some = |most: usize| Compared::of(problem, point, most);
    let Some(few) = some(SAMPLES[0]) else { return Vec::new() };
    let found: Vec<Candidate> =
        all.par_iter().flat_map_iter(|own| few.minima(*own, reach(problem, point, *own))).collect();
    if found.is_empty() {
        return Vec::new();
    }
    let Some(many) = some(SAMPLES[2]) else { return Vec::new() };
    let mut others: Vec<Other> = Vec::new();
    for Candidate { own, there } in found {
        let there = Tried::fit(many.problem.clone(), there.point, 0.0, ITERATIONS[1]);
        let is_another = |there: &Tried| own.is_elsewhere(&there.point) && many.is_another(there);
        let Some(there) = there.filter(is_another) else { continue };
        let value = own.at(&there.point);
        let with = all.iter().filter(|one| {
            let is_own = (one.instance, one.component) == (own.instance, own.component);
            let far = (one.at(&there.point) - one.value).abs() > 0.5 * one.value.abs();
            !is_own && far && one.is_elsewhere(&there.point)
        });
        let with: Vec<(usize, usize, f64)> =
            with.map(|one| (one.instance, one.component, one.at(&there.point))).collect();
        let is_known = others.iter().any(|other| {
            let is_same = (other.instance, other.component) == (own.instance, own.component)
                && (other.values[0] - value).abs() <= APART * own.sigma;
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
                values: [value, own.value],
                chi_squared: many.excess(&there),
                with,
            });
        }
    }
    others.sort_by_key(|one| (one.instance, one.component));
    others
}

/// The components that are tried, those that are determined least first: free scalars and components
/// of vectors of which nothing is stated, no angles and no delays.
fn components(fit: &Calibration) -> Vec<Component> {
    let layout = &fit.problem.layout;
    let mut all = Vec::new();
    for (instance, one) in layout.instances.iter().enumerate() {
        if one.kind == Kind::Rotation || one.unit.is_angle() || one.is_delay() {
            continue;
        }
        for (component, column) in layout.own_columns(instance) {
            let value = fit.fit.point.values[instance][component];
            let sigma = fit.covariance[(column, column)].sqrt();
            if is_open(layout, instance, component) && sigma > 0.0 && sigma.is_finite() {
                let is_mirrored = one.kind == Kind::Scalar;
                all.push(Component { instance, component, value, sigma, is_mirrored });
            }
        }
    }
    let determined = |one: &Component| one.value.abs() / one.sigma;
    all.sort_by(|a, b| determined(a).total_cmp(&determined(b)));
    all.truncate(MOST[0]);
    all.iter_mut()
        .filter(|one| one.is_mirrored)
        .skip(MOST[1])
        .for_each(|one| one.is_mirrored = false);
    all
}

/// Whether nothing is stated of a component: no value, no start, no bound.
fn is_open(layout: &Layout, instance: usize, component: usize) -> bool {
    let one = &layout.instances[instance];
    let is_started = !one.start_found && one.setting.start_of(component).is_some();
    let bounds = one.setting.bounds_of(component);
    let is_bounded = bounds.0.is_finite() || bounds.1.is_finite();
    !is_started && !is_bounded && one.setting.value_of(component).is_none()
}

/// How far away a minimum is looked for: by the largest value of a scalar or a vector in its unit.
fn reach(problem: &Problem, point: &Point, own: Component) -> f64 {
    let instances = &problem.layout.instances;
    let dimension = instances[own.instance].unit.dimension;
    let is_alike = |index: &usize| {
        instances[*index].kind != Kind::Rotation && instances[*index].unit.dimension == dimension
    };
    let values = (0..instances.len()).filter(is_alike).flat_map(|index| point.values[index]);
    REACH * values.map(f64::abs).fold(0.0, f64::max)
}

impl Compared {
    /// Minima at which a component is elsewhere and that may fit alike on all samples.
    fn minima(&self, own: Component, reach: f64) -> Vec<Candidate> {
        let mirrored = own.is_mirrored.then_some(-own.value);
        let mut found: Vec<Candidate> = Vec::new();
        for start in self.along(&own, reach).into_iter().chain(mirrored) {
            let start = own.moved(&self.here.point, start);
            let there = Tried::fit(self.problem.clone(), start, 0.0, ITERATIONS[0]);
            let is_near =
                |there: &Tried| self.may_be_another(there) && own.is_elsewhere(&there.point);
            let Some(there) = there.filter(is_near) else { continue };
            let is_new = found.iter().all(|one| {
                (own.at(&one.there.point) - own.at(&there.point)).abs() > APART * own.sigma
            });
            if is_new {
                found.push(Candidate { own, there });
            }
        }
        found
    }

    /// The value of a component at which the sum of squares along it has its other minimum, roughly;
    /// `None` where that is farther away than its reach, or the sum only grows on the way there.
    fn along(&self, own: &Component, reach: f64) -> Option<f64> {
        let (here, step) = (own.at(&self.here.point), APART * own.sigma);
        let cost = |value: f64| self.problem.cost(&own.moved(&self.here.point, value));
        let growth = |step: f64| cost(here + step) - self.here.chi_squared;
        let [above, below] = [growth(step), growth(-step)];
        let distance = -2.0 * step * (above + below) / (above - below);
        if distance.is_nan() || distance.abs() > reach {
            return None;
        }
        let values = FACTORS.map(|factor| here + factor * distance);
        let costs = values.map(cost);
        let is_lowest = |at: &usize| costs[*at] < costs[at - 1] && costs[*at] <= costs[at + 1];
        let minima = (1..FACTORS.len() - 1).filter(is_lowest);
        minima.min_by(|a, b| costs[*a].total_cmp(&costs[*b])).map(|at| values[at])
    }
}
