//! A point: the value of every instance, and how a step in the tangent space moves it.

use nalgebra::{DMatrix, DVector};

use crate::engine::gram::PriorRow;
use crate::engine::layout::{Instance, Layout};
use crate::graph::Kind;
use crate::model::Setting;
use crate::number::{Gradient, Number, partial, partials};
use crate::quaternion::Quaternion;

/// A component of a parameter by its name, whose value it is (`None`: of all), and the value (SI).
pub type NamedValue = (String, usize, Option<String>, f64);

/// The value of each instance of a [`Layout`]: a scalar uses the first number, a vector three, a
/// rotation four (w, x, y, z). SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// One for each instance.
    pub values: Vec<[f64; 4]>,
}

impl Point {
    /// Where iteration starts: `start`, else `value`, else zero (identity); a fixed parameter's
    /// `value`. Values that sum to zero do so from the start.
    pub fn start(layout: &Layout) -> Self {
        let mut point = Self::from(layout, |setting, component| {
            let (start, value) = (setting.start_of(component), setting.value_of(component));
            if setting.is_fixed(component) { value.or(start) } else { start.or(value) }
        });
        point.balance(layout);
        point.enter_bounds(layout);
        point
    }

    /// Moves what lies outside its bounds to the nearer one. Bounds of a rotation vector or of
    /// contrasts are not bounds of a column, and do not count.
    pub fn enter_bounds(&mut self, layout: &Layout) {
        for (index, value) in self.values.iter_mut().enumerate() {
            for (component, _) in layout.own_columns(index) {
                let (lower, upper) = layout.bounds_of(index, component);
                value[component] = value[component].max(lower).min(upper);
            }
        }
    }

    /// Takes the mean off values that sum to zero over their scope: a fit moves them along
    /// contrasts only.
    pub fn balance(&mut self, layout: &Layout) {
        for members in layout.sums_to_zero() {
            for component in 0..layout.instances[members[0]].dimension() {
                let sum: f64 = members.iter().map(|n| self.values[*n][component]).sum();
                for n in &members {
                    self.values[*n][component] -= sum / members.len() as f64;
                }
            }
        }
    }

    /// What is stated: `value`, else `start`, else zero.
    pub fn stated(layout: &Layout) -> Self {
        Self::from(layout, |setting, component| {
            setting.value_of(component).or(setting.start_of(component))
        })
    }

    fn from(layout: &Layout, given: impl Fn(&Setting, usize) -> Option<f64>) -> Self {
        let values = layout.instances.iter().map(|instance| {
            let components = [0, 1, 2].map(|k| given(&instance.setting, k).unwrap_or(0.0));
            from_components(instance.kind, &components)
        });
        Self { values: values.collect() }
    }

    /// The values of this point, of one layout, in another one; what is new starts at what is stated,
    /// else at zero.
    pub fn carried(&self, from: &Layout, to: &Layout) -> Self {
        self.carried_onto(from, to, Self::start(to))
    }

    /// The same where what is new stays as it is.
    pub fn carried_onto(&self, from: &Layout, to: &Layout, mut onto: Self) -> Self {
        for (value, instance) in onto.values.iter_mut().zip(&to.instances) {
            let is_same =
                |one: &Instance| one.name == instance.name && one.whose() == instance.whose();
            if let Some(same) = from.instances.iter().position(is_same) {
                *value = self.values[same];
            }
        }
        onto
    }

    /// The point moved by `step` (one number a column).
    pub fn moved(&self, layout: &Layout, step: &[f64]) -> Self {
        let mut values = self.values.clone();
        for (index, (instance, value)) in layout.instances.iter().zip(&mut values).enumerate() {
            let mut tangent = [0.0; 3];
            for (component, entry) in tangent.iter_mut().enumerate().take(instance.dimension()) {
                for (column, coefficient) in layout.columns_of(index, component) {
                    *entry += coefficient * step[column];
                }
            }
            *value = retract(instance.kind, *value, tangent);
        }
        Self { values }
    }

    /// The step that leads to another point, one number a column: the inverse of [`Point::moved`].
    pub fn step_to(&self, layout: &Layout, other: &Self) -> DVector<f64> {
        // Contrasts move several instances by one column: least squares over all of them.
        let count = layout.columns.len();
        let (mut normal, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
        for (index, instance) in layout.instances.iter().enumerate() {
            let step = difference(instance.kind, other.values[index], self.values[index]);
            for (component, step) in step.iter().enumerate().take(instance.dimension()) {
                let columns = layout.columns_of(index, component);
                for (a, p) in &columns {
                    right[*a] += p * step;
                    for (b, q) in &columns {
                        normal[(*a, *b)] += p * q;
                    }
                }
            }
        }
        // Every column moves some instance.
        normal.cholesky().map_or(right.clone(), |factor| factor.solve(&right))
    }

    /// The components a person reads: a rotation as its rotation vector.
    pub fn components(&self, layout: &Layout, instance: usize) -> Vec<f64> {
        let value = self.values[instance];
        match layout.instances[instance].kind {
            Kind::Scalar => vec![value[0]],
            Kind::Vector => value[..3].to_vec(),
            Kind::Rotation => quaternion(value).to_rotation_vector().to_vec(),
        }
    }

    /// Gives one of the components that a person reads another value.
    pub fn set_component(
        &mut self,
        layout: &Layout,
        instance: usize,
        component: usize,
        value: f64,
    ) {
        let mut components = self.components(layout, instance);
        if let Some(own) = components.get_mut(component) {
            *own = value;
            self.values[instance] = from_components(layout.instances[instance].kind, &components);
        }
    }

    /// Gives components of parameters, named with the component and whose value it is, other values.
    pub fn set_named(&mut self, layout: &Layout, values: &[NamedValue]) {
        for (name, component, of, value) in values {
            for (index, instance) in layout.instances.iter().enumerate() {
                if instance.name == *name && instance.whose() == of.as_deref() {
                    self.set_component(layout, index, *component, *value);
                }
            }
        }
    }

    /// Derivatives of those components with respect to the instance's tangent (rows: components).
    pub fn component_jacobian(&self, layout: &Layout, instance: usize) -> Vec<Vec<f64>> {
        match layout.instances[instance].kind {
            Kind::Scalar => vec![vec![1.0]],
            Kind::Vector => {
                (0..3).map(|i| (0..3).map(|j| f64::from(u8::from(i == j))).collect()).collect()
            }
            Kind::Rotation => {
                let moved = seeded::<3>(Kind::Rotation, self.values[instance], [0, 1, 2]);
                let turned = Quaternion { w: moved[0], v: [moved[1], moved[2], moved[3]] };
                turned.to_rotation_vector().iter().map(|row| partials(row).to_vec()).collect()
            }
        }
    }

    /// The whitened rows of prior knowledge at this point.
    pub fn priors(&self, layout: &Layout) -> Vec<PriorRow> {
        (0..layout.instances.len()).flat_map(|index| self.priors_of(layout, index)).collect()
    }

    /// Those of one instance: a row for each component of which a value with its sigma is stated.
    pub fn priors_of(&self, layout: &Layout, index: usize) -> Vec<PriorRow> {
        let instance = &layout.instances[index];
        let setting = &instance.setting;
        let stated = setting.stated_components(instance.kind);
        if stated.is_empty() {
            return Vec::new();
        }
        let value = [0, 1, 2].map(|component| setting.value_of(component).unwrap_or(0.0));
        let value = from_components(instance.kind, &value);
        let difference = difference(instance.kind, value, self.values[index]);
        let each = stated.into_iter().filter_map(|k| Some((k, setting.sigma_of(k)?)));
        each.map(|(component, sigma)| PriorRow {
            coefficients: layout
                .columns_of(index, component)
                .into_iter()
                .map(|(column, coefficient)| (column, coefficient / sigma))
                .collect(),
            residual: difference[component] / sigma,
        })
        .collect()
    }
}

/// A rotation's numbers as a quaternion.
fn quaternion(value: [f64; 4]) -> Quaternion<f64> {
    Quaternion { w: value[0], v: [value[1], value[2], value[3]] }
}

fn from_quaternion(q: Quaternion<f64>) -> [f64; 4] {
    [q.w, q.v[0], q.v[1], q.v[2]]
}

/// The internal numbers of components as a person states them; missing ones are zero.
pub fn from_components(kind: Kind, components: &[f64]) -> [f64; 4] {
    let at = |i: usize| components.get(i).copied().unwrap_or(0.0);
    match kind {
        Kind::Scalar => [at(0), 0.0, 0.0, 0.0],
        Kind::Vector => [at(0), at(1), at(2), 0.0],
        Kind::Rotation => from_quaternion(Quaternion::turn([at(0), at(1), at(2)])),
    }
}

/// The value moved along its tangent: rotations by `q turn(δ)`, so δ is seen in the frame that the
/// rotation turns from.
fn retract(kind: Kind, value: [f64; 4], tangent: [f64; 3]) -> [f64; 4] {
    match kind {
        Kind::Scalar => [value[0] + tangent[0], 0.0, 0.0, 0.0],
        Kind::Vector => [value[0] + tangent[0], value[1] + tangent[1], value[2] + tangent[2], 0.0],
        Kind::Rotation => {
            from_quaternion((quaternion(value) * Quaternion::turn(tangent)).normalise())
        }
    }
}

/// The tangent that leads from `from` to `to` (inverse of [`retract`]).
fn difference(kind: Kind, to: [f64; 4], from: [f64; 4]) -> [f64; 3] {
    match kind {
        Kind::Scalar => [to[0] - from[0], 0.0, 0.0],
        Kind::Vector => [to[0] - from[0], to[1] - from[1], to[2] - from[2]],
        Kind::Rotation => (quaternion(from).conjugate() * quaternion(to)).to_rotation_vector(),
    }
}

/// An instance's numbers with its tangent components as variables `seeds[i]` of `N` (an index of N
/// or more leaves that component constant).
pub fn seeded<const N: usize>(kind: Kind, value: [f64; 4], seeds: [usize; 3]) -> [Gradient<N>; 4] {
    let constant = Gradient::<N>::constant;
    match kind {
        Kind::Scalar => [partial(value[0], seeds[0]), constant(0.0), constant(0.0), constant(0.0)],
        Kind::Vector => [
            partial(value[0], seeds[0]),
            partial(value[1], seeds[1]),
            partial(value[2], seeds[2]),
            constant(0.0),
        ],
        Kind::Rotation if seeds.iter().all(|seed| *seed >= N) => value.map(constant),
        Kind::Rotation => {
            let turn = Quaternion::turn(seeds.map(|seed| partial::<N>(0.0, seed)));
            let q = Quaternion {
                w: constant(value[0]),
                v: [value[1], value[2], value[3]].map(constant),
            };
            let moved = q * turn;
            [moved.w, moved.v[0], moved.v[1], moved.v[2]]
        }
    }
}
