//! Minima at which a rotation is another one: the two poses of a flat target that is small or far
//! away (Schweighofer and Pinz 2006).
//!
//! Each rotation is turned by itself, about axes in the plane of the two in which the readings
//! determine it least, and all else is held. Where the sum of squares along such a turn has another
//! minimum, a fit of everything begins. Rotations that measured coordinates determine have one
//! minimum (Horn), and cost nothing.

use std::f64::consts::PI;

use nalgebra::{DMatrix, Quaternion, UnitQuaternion};
use rayon::prelude::*;

use crate::engine::gram::LeastSquares;
use crate::engine::layout::Layout;
use crate::engine::{Point, Problem};
use crate::estimate::calibrate::Calibration;
use crate::estimate::eigen::symmetric;
use crate::estimate::minima::Other;
use crate::estimate::minima::compared::{APART, Compared, ITERATIONS};
use crate::estimate::minima::thinned::Tried;
use crate::graph::Kind;

use super::SAMPLES;

/// Rotations that are tried at most, those that are determined least.
const MOST: usize = 8;
/// Axes of turns, and their angles (rad): of two wells one of three neighbouring angles lies in the
/// other, and lower.
const AXES: usize = 8;
const ANGLES: [f64; 9] = [0.12, 0.2, 0.33, 0.55, 0.85, 1.25, 1.75, 2.4, PI];
/// Fits from other turns at most.
const STARTS: usize = 6;
/// A start that is stated decides where another minimum is so many times as far from it as the
/// estimate.
const DECIDES: f64 = 3.0;

/// A rotation that is tried.
struct Turning {
    instance: usize,
    /// The columns of its tangent.
    columns: [usize; 3],
    /// The two axes about which it is determined least.
    axes: [[f64; 3]; 2],
    /// The larger standard uncertainty (rad).
    sigma: f64,
}

/// Minima at which a rotation is another one, each by itself.
pub(super) fn other_turns(fit: &Calibration) -> Vec<Other> {
    let (problem, point) = (&fit.problem, &fit.fit.point);
    let all = rotations(fit);
    if all.is_empty() {
        return Vec::new();
    }
    let some = |most: usize| Compared::of(problem, point, most);
    let Some(few) = some(SAMPLES[0]) else { return Vec::new() };
    let of = |own: &Turning| few.turned(own).map(|there| (own.instance, own.sigma, there));
    let found: Vec<(usize, f64, Tried)> = all.par_iter().filter_map(of).collect();
    if found.is_empty() {
        return Vec::new();
    }
    let Some(many) = some(SAMPLES[2]) else { return Vec::new() };
    let other = |(instance, sigma, there): (usize, f64, Tried)| {
        let there = Tried::fit(many.problem.clone(), there.point, 0.0, ITERATIONS[1])?;
        let is_elsewhere = angle(&many.here.point, &there.point, instance) > APART * sigma;
        let is_another = is_elsewhere && many.is_another(&there);
        let is_left = !is_decided(&problem.layout, instance, point, &there.point);
        (is_another && is_left).then(|| described(problem, point, &there, instance, sigma, &many))
    };
    found.into_iter().filter_map(other).collect()
}

/// The free rotations that neither a stated value nor coordinates determine, those that are
/// determined least first.
fn rotations(fit: &Calibration) -> Vec<Turning> {
    let layout = &fit.problem.layout;
    let parts = fit.problem.parts.iter();
    let named = parts.filter_map(|part| {
        let names = &part.system.assembly.names;
        let coordinates = part.system.assembly.coordinates.as_ref()?;
        Some(names.parameters[coordinates.rotation].name.as_str())
    });
    let by_coordinates: Vec<&str> = named.collect();
    let mut all = Vec::new();
    for (instance, one) in layout.instances.iter().enumerate() {
        let own: Vec<usize> = layout.own_columns(instance).map(|(_, column)| column).collect();
        let is_open = one.kind == Kind::Rotation
            && one.setting.value.is_none()
            && !by_coordinates.contains(&one.name.as_str());
        let Some(columns) = own.try_into().ok().filter(|_: &[usize; 3]| is_open) else { continue };
        let covariance = DMatrix::from_fn(3, 3, |i, j| fit.covariance[(columns[i], columns[j])]);
        let Some(eigen) = symmetric(covariance) else { continue };
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let axis = |at: usize| {
            let own = eigen.eigenvectors.column(order[at]);
            [own[0], own[1], own[2]]
        };
        let sigma = eigen.eigenvalues[order[0]].sqrt();
        if sigma > 0.0 && sigma.is_finite() {
            all.push(Turning { instance, columns, axes: [axis(0), axis(1)], sigma });
        }
    }
    all.sort_by(|a, b| b.sigma.total_cmp(&a.sigma));
    all.truncate(MOST);
    all
}

impl Compared {
    /// The best fit from a turned rotation that may be another minimum.
    fn turned(&self, own: &Turning) -> Option<Tried> {
        let mut starts: Vec<(f64, Point)> = Vec::new();
        for number in 0..AXES {
            let (sin, cos) = (2.0 * PI * number as f64 / AXES as f64).sin_cos();
            let at = |angle: f64| {
                let mut step = vec![0.0; self.problem.layout.columns.len()];
                for (k, column) in own.columns.iter().enumerate() {
                    step[*column] = angle * (cos * own.axes[0][k] + sin * own.axes[1][k]);
                }
                self.here.point.moved(&self.problem.layout, &step)
            };
            let costs = ANGLES.map(|angle| self.problem.cost(&at(angle)));
            for place in 1..ANGLES.len() {
                let next = costs.get(place + 1).copied().unwrap_or(f64::INFINITY);
                // Half a turn about an axis is half a turn about the opposite one.
                let is_known = place + 1 == ANGLES.len() && 2 * number >= AXES;
                if costs[place] < costs[place - 1] && costs[place] <= next && !is_known {
                    starts.push((costs[place], at(ANGLES[place])));
                }
            }
        }
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        starts.truncate(STARTS);
        let fits = starts.into_iter().filter_map(|(_, start)| {
            let there = Tried::fit(self.problem.clone(), start, 0.0, ITERATIONS[0])?;
            let is_elsewhere =
                angle(&self.here.point, &there.point, own.instance) > APART * own.sigma;
            (is_elsewhere && self.may_be_another(&there)).then_some(there)
        });
        fits.min_by(|a, b| a.chi_squared.total_cmp(&b.chi_squared))
    }
}

/// The angle (rad) between a rotation at two points.
fn angle(one: &Point, other: &Point, instance: usize) -> f64 {
    let [a, b] = [one, other].map(|point| {
        let [w, x, y, z] = point.values[instance];
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
    });
    a.angle_to(&b)
}

/// Whether a start that is stated decides for the estimate.
fn is_decided(layout: &Layout, instance: usize, here: &Point, there: &Point) -> bool {
    let one = &layout.instances[instance];
    let start = Point::start(layout);
    one.setting.start.is_some()
        && !one.start_found
        && angle(&start, there, instance) > DECIDES * angle(&start, here, instance)
}

/// Another minimum by the component of the rotation that differs most, the others with it.
fn described(
    problem: &Problem,
    here: &Point,
    there: &Tried,
    instance: usize,
    sigma: f64,
    many: &Compared,
) -> Other {
    let of = |point: &Point| point.components(&problem.layout, instance);
    let (own, other) = (of(here), of(&there.point));
    let apart = |component: usize| (own[component] - other[component]).abs();
    let component = (0..3).max_by(|a, b| apart(*a).total_cmp(&apart(*b))).unwrap_or(0);
    let rest = (0..3).filter(|one| *one != component && apart(*one) > APART * sigma);
    let with = rest.map(|one| (instance, one, other[one])).collect();
    let values = [other[component], own[component]];
    Other { instance, component, values, chi_squared: many.excess(there), with }
}
