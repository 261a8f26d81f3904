//! Campaigns with some effects of the library, fitted; with one more, and without some.

use crate::engine::layout::Instance;
use crate::engine::open::Recipe;
use crate::engine::point::NamedValue;
use crate::engine::{Point, Problem};
use crate::estimate::batch::{Fit, FitError, Options, fit};
use crate::system::Selected;
use crate::units::Unit;

/// The campaigns with some effects, fitted.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// From what its models were put together.
    pub recipes: Vec<Recipe>,
    /// The campaigns.
    pub problem: Problem,
    /// The fit.
    pub fit: Fit<Point>,
}

impl Fitted {
    /// Whether the fit can be built on.
    pub fn is_sound(&self) -> bool {
        self.fit.outcome.is_result()
    }

    /// The unit in which results give a parameter that is declared in another one, perhaps.
    pub fn unit_of_parameter(&self, parameter: &str, declared: Unit) -> Unit {
        let first = self.problem.parts.first();
        first.map_or_else(|| declared.clone(), |part| part.unit_of_parameter(parameter, &declared))
    }

    /// Chi squared for each degree of freedom.
    pub fn variance_factor(&self) -> f64 {
        let columns = self.problem.layout.columns.len();
        let freedom = self.problem.component_count().saturating_sub(columns).max(1);
        self.fit.cost / freedom as f64
    }

    /// The value of a component of the same parameter here, as of another layout.
    pub fn value(&self, one: &Instance, component: usize) -> Option<f64> {
        let (layout, point) = (&self.problem.layout, &self.fit.point);
        let is_same = |own: &Instance| own.name == one.name && own.whose() == one.whose();
        let same = layout.instances.iter().position(is_same)?;
        point.components(layout, same).get(component).copied()
    }

    /// The same campaigns with one more effect, fitted from here. `None` where the effect fits no
    /// campaign.
    pub fn with(
        &self,
        more: &Selected,
        start: &[NamedValue],
        options: &Options,
    ) -> Result<Option<Self>, FitError> {
        let start = |one: &Instance, component: usize| {
            let is_of = |(name, at, of, _): &&NamedValue| {
                *name == one.name && *at == component && of.as_deref() == one.whose()
            };
            start.iter().find(is_of).map(|(.., value)| *value)
        };
        self.with_starts(more, start, options)
    }

    /// The same where every component of a parameter begins at what is said of it, if anything is; a
    /// constant stays there.
    pub fn with_starts(
        &self,
        more: &Selected,
        start: impl Fn(&Instance, usize) -> Option<f64>,
        options: &Options,
    ) -> Result<Option<Self>, FitError> {
        self.changed(|effects| effects.push(more.clone()), start, options)
    }

    /// The same campaigns, readings and weights without some effects, fitted from here.
    pub fn without(&self, less: &[&Selected], options: &Options) -> Result<Self, FitError> {
        let is_kept = |one: &Selected| {
            !less.iter().any(|gone| gone.name() == one.name() && gone.member == one.member)
        };
        let changed = self.changed(|effects| effects.retain(is_kept), |_, _| None, options)?;
        changed.map_or_else(|| self.clone().again(options), Ok)
    }

    /// The same campaigns with other effects, fitted from here; a campaign that cannot have them
    /// stays as it is. `None` where none can.
    fn changed(
        &self,
        change: impl Fn(&mut Vec<Selected>),
        start: impl Fn(&Instance, usize) -> Option<f64>,
        options: &Options,
    ) -> Result<Option<Self>, FitError> {
        let mut recipes = self.recipes.clone();
        let mut parts = self.problem.parts.clone();
        let mut fits = false;
        for (recipe, part) in recipes.iter_mut().zip(&mut parts) {
            let mut other = recipe.clone();
            change(&mut other.effects);
            if let Ok(system) = other.with(&[]) {
                fits = true;
                *recipe = other;
                *part = part.with_system(system);
            }
        }
        if !fits {
            return Ok(None);
        }
        let mut problem = self.problem.with_parts(parts);
        let mut point = self.fit.point.carried(&self.problem.layout, &problem.layout);
        let layout = &problem.layout;
        for (index, one) in layout.instances.iter().enumerate() {
            for component in 0..one.dimension() {
                if let Some(value) = start(one, component) {
                    point.set_component(layout, index, component, value);
                }
            }
        }
        point.balance(layout);
        let fit = fit(&mut problem, point, options)?;
        Ok(Some(Self { recipes, problem, fit }))
    }

    /// Fitted again from where it stands, with the readings and uncertainties of the problem.
    pub fn again(self, options: &Options) -> Result<Self, FitError> {
        let Self { recipes, mut problem, fit: old } = self;
        let fit = fit(&mut problem, old.point, options)?;
        Ok(Self { recipes, problem, fit })
    }
}
