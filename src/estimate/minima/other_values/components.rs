//! Scalars and components of vectors of which other values are tried.

use std::collections::HashSet;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::engine::Point;
use crate::engine::layout::Layout;
use crate::estimate::calibrate::Calibration;
use crate::estimate::minima::compared::APART;
use crate::graph::Kind;

/// Most angles that are tried all around, those that are determined least.
const MOST_ANGLES: usize = 12;
/// Most other components that are tried, those that are determined least.
const MOST_OTHERS: usize = 64;
/// Most scalars among them that start from the other sign, too.
const MOST_SIGNS: usize = 12;
/// The other minimum lies within so many times the largest value of a parameter in the same unit.
const REACH: f64 = 4.0;

/// A component that is tried.
#[derive(Clone, Copy, Debug)]
pub(super) struct Component {
    pub(super) instance: usize,
    pub(super) component: usize,
    pub(super) column: usize,
    /// The estimate (SI) from the samples that are looked at, and the standard uncertainty of the
    /// estimate from all of them.
    pub(super) value: f64,
    pub(super) sigma: f64,
    /// How far away a minimum is looked for.
    pub(super) reach: f64,
    pub(super) is_angle: bool,
    /// Whether a scalar starts from the other sign, too.
    pub(super) is_searched: bool,
}

impl Component {
    pub(super) fn at(&self, point: &Point) -> f64 {
        point.values[self.instance][self.component]
    }

    /// The same beside an estimate from other samples. Minima are compared with the estimate from
    /// the same samples: that from few of them scatters by more than the uncertainty of all.
    pub(super) fn from(&self, here: &Point) -> Self {
        Self { value: self.at(here), ..*self }
    }

    /// The point with another value of it alone.
    pub(super) fn moved(&self, point: &Point, value: f64) -> Point {
        let mut point = point.clone();
        point.values[self.instance][self.component] = value;
        point
    }

    /// How far apart two values are; angles a whole turn apart are the same.
    pub(super) fn distance(&self, one: f64, other: f64) -> f64 {
        let far = (one - other).abs();
        let rest = far.rem_euclid(TAU);
        if self.is_angle { rest.min(TAU - rest) } else { far }
    }

    /// Whether two values differ by more than their uncertainty explains.
    pub(super) fn differ(&self, one: f64, other: f64) -> bool {
        self.distance(one, other) > APART * self.sigma
    }

    pub(super) fn is_elsewhere(&self, point: &Point) -> bool {
        self.differ(self.at(point), self.value)
    }

    /// Whether it changes by much of its size together with another one.
    pub(super) fn goes_with(&self, point: &Point) -> bool {
        let most = if self.is_angle { FRAC_PI_2 } else { f64::INFINITY };
        let size = self.distance(self.value, 0.0).min(most);
        let far = self.distance(self.at(point), self.value) > 0.5 * size;
        far && self.is_elsewhere(point)
    }

    /// Whether it is an angle that has the same sine or the same cosine as at the estimate.
    fn is_reflected(&self, point: &Point) -> bool {
        let is_at = |value: f64| !self.differ(self.at(point), value);
        self.is_angle && (is_at(-self.value) || is_at(PI - self.value))
    }

    fn is_half_a_turn_away(&self, point: &Point) -> bool {
        self.is_angle && !self.differ(self.at(point), self.value + PI)
    }

    /// Its value over its standard uncertainty; half a turn of an angle, whose zero means nothing.
    fn determined(&self) -> f64 {
        let size = if self.is_angle { PI } else { self.value.abs() };
        size / self.sigma
    }
}

/// Whether a point has the same direction or attitude by other angles: azimuth and elevation of one
/// direction have two pairs of values, three angles of an attitude two triples. One of them is
/// reflected there, and more where directions share an azimuth; the others differ by half a turn,
/// and nothing else differs.
pub(super) fn is_same_attitude(all: &[Component], point: &Point) -> bool {
    let far = all.iter().filter(|one| one.is_elsewhere(point));
    let (turned, rest): (Vec<&Component>, Vec<&Component>) =
        far.partition(|one| one.is_half_a_turn_away(point));
    !turned.is_empty() && !rest.is_empty() && rest.iter().all(|one| one.is_reflected(point))
}

/// The components that are tried, those that are determined least first: of all those of which
/// nothing is stated. Of an angle that each run or setup has for itself, that of one of them is
/// tried: in the others readings depend on it alike.
pub(super) fn tried(fit: &Calibration, all: &[Component]) -> Vec<Component> {
    let layout = &fit.problem.layout;
    let is_open = |one: &&Component| is_open(layout, one.instance, one.component);
    let mut all: Vec<Component> = all.iter().filter(is_open).copied().collect();
    all.sort_by(|a, b| a.determined().total_cmp(&b.determined()));
    let (mut angles, mut others): (Vec<Component>, Vec<Component>) =
        all.into_iter().partition(|one| one.is_angle);
    let mut seen: HashSet<(&str, usize)> = HashSet::new();
    angles.retain(|one| seen.insert((&layout.instances[one.instance].name, one.component)));
    angles.truncate(MOST_ANGLES);
    others.truncate(MOST_OTHERS);
    let scalars = others.iter_mut().filter(|one| one.is_searched);
    scalars.skip(MOST_SIGNS).for_each(|one| one.is_searched = false);
    angles.extend(others);
    angles
}

/// All free scalars and components of vectors, but no delays.
pub(super) fn components(fit: &Calibration) -> Vec<Component> {
    let layout = &fit.problem.layout;
    let mut all = Vec::new();
    for (instance, one) in layout.instances.iter().enumerate() {
        if one.kind == Kind::Rotation || one.is_delay() {
            continue;
        }
        let is_angle = one.unit.is_angle();
        let reach = if is_angle { PI } else { reach(layout, &fit.fit.point, instance) };
        for (component, column) in layout.own_columns(instance) {
            let value = fit.fit.point.values[instance][component];
            let sigma = fit.covariance[(column, column)].sqrt();
            if sigma > 0.0 && sigma.is_finite() {
                let is_searched = !is_angle && one.kind == Kind::Scalar;
                all.push(Component {
                    instance,
                    component,
                    column,
                    value,
                    sigma,
                    reach,
                    is_angle,
                    is_searched,
                });
            }
        }
    }
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
fn reach(layout: &Layout, point: &Point, own: usize) -> f64 {
    let instances = &layout.instances;
    let dimension = instances[own].unit.dimension;
    let is_alike = |index: &usize| {
        instances[*index].kind != Kind::Rotation && instances[*index].unit.dimension == dimension
    };
    let values = (0..instances.len()).filter(is_alike).flat_map(|index| point.values[index]);
    REACH * values.map(f64::abs).fold(0.0, f64::max)
}
