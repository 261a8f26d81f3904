//! What is said of one component of a vector, over what is said of all of it.
//!
//! A tape gives the height of a lever arm and nothing else; flat ground leaves one component of
//! three open. So `fixed`, `value` with `sigma`, bounds and `start` may be said of `lever.z` alone.
//! Whoever asks what is known of a component asks here, and need not know where it was said.

use crate::graph::Kind;
use crate::model::declaration::{Component, Override, Setting};
use crate::units::Unit;

/// The members of a vector, in order.
pub const AXES: [&str; 3] = ["x", "y", "z"];

impl Component {
    /// Lays what is said of it over what was said before, by the rules of [`Override::apply`].
    fn apply(&mut self, said: &Override) {
        let first = |said: &Option<Vec<(f64, Unit)>>| Some(said.as_ref()?.first()?.0);
        self.value = first(&said.value).or(self.value);
        self.sigma = first(&said.sigma).or(self.sigma);
        self.lower = first(&said.lower).or(self.lower);
        self.upper = first(&said.upper).or(self.upper);
        if said.value.is_some() {
            self.start = None;
        }
        self.start = first(&said.start).or(self.start);
        match said.fixed {
            Some(true) => self.sigma = None,
            None if said.sigma.is_some() => self.fixed = Some(false),
            _ => {}
        }
        self.fixed = said.fixed.or(self.fixed);
    }
}

impl Override {
    /// The vector and the component that the name means, if it ends like one: `lever.z`.
    pub fn component(&self) -> Option<(&str, usize)> {
        let (vector, member) = self.name.rsplit_once('.')?;
        Some((vector, AXES.iter().position(|axis| *axis == member)?))
    }

    /// Changes what a setting says of one component.
    pub fn apply_to_component(&self, component: usize, setting: &mut Setting) {
        let all = setting.components.get_or_insert_with(Box::default);
        if let Some(own) = all.get_mut(component) {
            own.apply(self);
        }
    }
}

impl Setting {
    /// The name of a component's own statement.
    fn own(&self, component: usize) -> Option<&Component> {
        self.components.as_ref()?.get(component)
    }

    /// Whether a component is not estimated.
    pub fn is_fixed(&self, component: usize) -> bool {
        self.own(component).and_then(|own| own.fixed).unwrap_or(self.fixed)
    }

    /// The known value of a component.
    pub fn value_of(&self, component: usize) -> Option<f64> {
        let own = self.own(component).and_then(|own| own.value);
        own.or_else(|| self.value.as_ref()?.get(component).copied())
    }

    /// Its standard uncertainty; `None` where it is fixed or nothing is known of it.
    pub fn sigma_of(&self, component: usize) -> Option<f64> {
        if self.is_fixed(component) {
            return None;
        }
        match self.own(component) {
            Some(own) if own.value.is_some() || own.sigma.is_some() => own.sigma,
            _ => self.sigma.as_ref()?.get(component).copied(),
        }
    }

    /// Where iteration starts, if that is said.
    pub fn start_of(&self, component: usize) -> Option<f64> {
        match self.own(component) {
            Some(Component { start: Some(start), .. }) => Some(*start),
            Some(Component { value: Some(_), .. }) => None,
            _ => self.start.as_ref()?.get(component).copied(),
        }
    }

    /// Lower and upper bound of a component; infinite where there are none.
    pub fn bounds_of(&self, component: usize) -> (f64, f64) {
        let at = |own: Option<f64>, all: &Option<Vec<f64>>| {
            own.or_else(|| all.as_ref()?.get(component).copied())
        };
        let lower = at(self.own(component).and_then(|own| own.lower), &self.lower);
        let upper = at(self.own(component).and_then(|own| own.upper), &self.upper);
        (lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY))
    }

    /// Whether anything is said of where a component is: a value, a start, that it is fixed.
    pub fn is_placed(&self, component: usize) -> bool {
        self.is_fixed(component)
            || self.value_of(component).is_some()
            || self.start_of(component).is_some()
    }

    /// Holds all of it at a value.
    pub fn hold_at(&mut self, value: Vec<f64>) {
        (self.value, self.sigma, self.start, self.components) = (Some(value), None, None, None);
        self.fixed = true;
    }

    /// Lets iteration start at a value.
    pub fn begin_at(&mut self, start: Vec<f64>) {
        self.start = Some(start);
        self.components.iter_mut().flat_map(|all| all.iter_mut()).for_each(|own| own.start = None);
    }

    /// Drops what was said of components of what is now said of all of them.
    pub(super) fn forget_components(&mut self, said: &Override) {
        let Some(all) = &mut self.components else { return };
        for own in all.iter_mut() {
            if said.value.is_some() || said.sigma.is_some() || said.fixed.is_some() {
                (own.value, own.sigma, own.fixed) = (None, None, None);
            }
            if said.value.is_some() || said.start.is_some() {
                own.start = None;
            }
            own.lower = own.lower.filter(|_| said.lower.is_none());
            own.upper = own.upper.filter(|_| said.upper.is_none());
        }
        if all.iter().all(|own| *own == Component::default()) {
            self.components = None;
        }
    }

    /// The components of which a value is stated with a standard uncertainty.
    pub fn stated_components(&self, kind: Kind) -> Vec<usize> {
        let is_stated = |k: &usize| self.value_of(*k).is_some() && self.sigma_of(*k).is_some();
        (0..kind.dimension()).filter(is_stated).collect()
    }
}
