//! Campaigns with some effects of the library, fitted; with one more, and without some.

pub mod planned;

use crate::engine::open::Recipe;
use crate::engine::{Part, Point, Problem};
use crate::estimate::batch::{Fit, FitError, Options, Outcome, fit};
use crate::system::Selected;

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
        self.fit.outcome == Outcome::Converged
    }

    /// The same campaigns with one more effect, fitted from here. `None` where the effect fits no
    /// campaign.
    ///
    /// # Errors
    /// [`FitError`] where the problem cannot be fitted at all.
    pub fn with(
        &self,
        more: &Selected,
        start: &[(String, usize, Option<String>, f64)],
        options: &Options,
    ) -> Result<Option<Self>, FitError> {
        let mut recipes = self.recipes.clone();
        let mut parts = Vec::with_capacity(recipes.len());
        let mut fits = false;
        for (recipe, part) in recipes.iter_mut().zip(&self.problem.parts) {
            if let Ok(system) = recipe.with(std::slice::from_ref(more)) {
                fits = true;
                recipe.effects.push(more.clone());
                parts.push(rebuilt(part, system));
            } else {
                parts.push(part.clone());
            }
        }
        if !fits {
            return Ok(None);
        }
        let mut problem = Problem::new(parts);
        let mut point = carried(&self.problem, &self.fit.point, &problem);
        for (name, component, of, value) in start {
            for (index, instance) in problem.layout.instances.iter().enumerate() {
                let here = instance.whose() == of.as_deref();
                if instance.name == *name && here && !instance.setting.fixed {
                    point.set_component(&problem.layout, index, *component, *value);
                }
            }
        }
        point.balance(&problem.layout);
        let fit = fit(&mut problem, point, options)?;
        Ok(Some(Self { recipes, problem, fit }))
    }

    /// The same campaigns, readings and weights without some effects, fitted from here.
    ///
    /// # Errors
    /// [`FitError`] where the problem cannot be fitted at all.
    pub fn without(&self, less: &[&Selected], options: &Options) -> Result<Self, FitError> {
        let mut recipes = self.recipes.clone();
        let mut parts = Vec::with_capacity(recipes.len());
        for (recipe, part) in recipes.iter_mut().zip(&self.problem.parts) {
            let dropped = |one: &Selected| {
                less.iter().any(|gone| {
                    gone.effect.name == one.effect.name
                        && gone.head == one.head
                        && gone.member == one.member
                })
            };
            let kept = recipe.effects.iter().filter(|one| !dropped(one)).cloned().collect();
            let known = std::mem::replace(&mut recipe.effects, kept);
            parts.push(if let Ok(system) = recipe.with(&[]) {
                rebuilt(part, system)
            } else {
                recipe.effects = known;
                part.clone()
            });
        }
        let mut problem = Problem::new(parts);
        let point = carried(&self.problem, &self.fit.point, &problem);
        let fit = fit(&mut problem, point, options)?;
        Ok(Self { recipes, problem, fit })
    }

    /// Fitted again from where it stands, with the readings and uncertainties of the problem.
    ///
    /// # Errors
    /// [`FitError`] where the problem cannot be fitted at all.
    pub fn again(self, options: &Options) -> Result<Self, FitError> {
        let Self { recipes, mut problem, fit: old } = self;
        let fit = fit(&mut problem, old.point, options)?;
        Ok(Self { recipes, problem, fit })
    }

    /// The standard deviation of a random quantity.
    pub fn random(&self, name: &str) -> Option<f64> {
        self.problem.parts.iter().find_map(|part| {
            let mut randoms = part.system.randoms.iter().zip(&part.random_sigma);
            randoms.find(|(random, _)| random.name == name).map(|(_, sigma)| *sigma)
        })
    }

    /// Gives a random quantity a standard deviation in every campaign that has it.
    pub fn set_random(&mut self, name: &str, value: f64) {
        let mut parts = std::mem::take(&mut self.problem.parts);
        for part in &mut parts {
            for (random, sigma) in part.system.randoms.iter().zip(&mut part.random_sigma) {
                if random.name == name {
                    *sigma = value;
                }
            }
        }
        self.problem = Problem::new(parts);
    }

    /// The sum of squares of the residuals and priors.
    pub fn cost(&self) -> f64 {
        self.fit.cost
    }
}

/// The name of an effect with its head.
pub fn name_of(selected: &Selected) -> String {
    match &selected.head {
        Some(head) => format!("{}.{head}", selected.effect.name),
        None => selected.effect.name.clone(),
    }
}

/// A part with another system; readings, stated uncertainties, levels and memory of noise as they
/// are.
pub fn rebuilt(part: &Part, system: crate::system::System) -> Part {
    part.with_system(system)
}

/// The values of one problem's point in another problem; what is new starts at what is stated, else
/// at zero.
pub fn carried(from: &Problem, point: &Point, to: &Problem) -> Point {
    carried_onto(from, point, to, Point::start(&to.layout))
}

/// The same where what is new stays as it is.
pub fn carried_onto(from: &Problem, point: &Point, to: &Problem, onto: Point) -> Point {
    let mut carried = onto;
    for (index, instance) in to.layout.instances.iter().enumerate() {
        let same = from
            .layout
            .instances
            .iter()
            .position(|one| one.name == instance.name && one.whose() == instance.whose());
        if let Some(same) = same {
            carried.values[index] = point.values[same];
        }
    }
    carried
}
