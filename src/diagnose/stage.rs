//! A stage of the search: the campaigns with the effects adopted so far, fitted, and the evidence of
//! everything that is not in the model yet.

use nalgebra::DVector;

use crate::engine::gram::LeastSquares;
use crate::engine::open::Recipe;
use crate::engine::{Part, Point, Problem};
use crate::estimate::batch::{Fit, FitError, Options, Outcome, fit};
use crate::system::Selected;

use super::candidates::{Candidate, NotTestable, Wanted, offer};
use super::evidence::{Entry, Evidence};
use super::score::{Score, score};
use super::structure::blocks;

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
                let here = instance.of == *of || instance.of.is_none() || of.is_none();
                if instance.name == *name && here && !instance.setting.fixed {
                    point.values[index][*component] = *value;
                }
            }
        }
        let fit = fit(&mut problem, point, options)?;
        Ok(Some(Self { recipes, problem, fit }))
    }

    /// The sum of squares of the residuals and priors.
    pub fn cost(&self) -> f64 {
        self.fit.cost
    }
}

/// A part with another system; readings, stated uncertainties and levels of noise as they are.
pub fn rebuilt(part: &Part, system: crate::system::System) -> Part {
    let levels: Vec<(String, f64)> = part
        .system
        .randoms
        .iter()
        .zip(&part.random_sigma)
        .map(|(random, sigma)| (random.name.clone(), *sigma))
        .collect();
    let mut made = Part::new(system, part.setups.clone(), part.runs.clone(), part.sigma.clone());
    for (random, sigma) in made.system.randoms.iter().zip(&mut made.random_sigma) {
        if let Some((_, level)) = levels.iter().find(|(name, _)| *name == random.name) {
            *sigma = *level;
        }
    }
    made.label.clone_from(&part.label);
    made.instrument.clone_from(&part.instrument);
    made.rig.clone_from(&part.rig);
    made.delay_range = part.delay_range;
    made
}

/// The values of one problem's point in another problem; what is new starts at what is stated, else
/// at zero.
pub fn carried(from: &Problem, point: &Point, to: &Problem) -> Point {
    let mut carried = Point::start(&to.layout);
    for (index, instance) in to.layout.instances.iter().enumerate() {
        let same = from
            .layout
            .instances
            .iter()
            .position(|one| one.name == instance.name && one.of == instance.of);
        if let Some(same) = same {
            carried.values[index] = point.values[same];
        }
    }
    carried
}

/// A fitted model with the evidence for all that is not in it.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The model.
    pub fitted: Fitted,
    /// Effects of the library, one member of each family, then blocks of unknown structure.
    pub candidates: Vec<Candidate>,
    /// Number of effects among the candidates.
    pub effects: usize,
    /// Effects on the noise.
    pub noise: Vec<Candidate>,
    /// Effects that cannot be tested.
    pub not_testable: Vec<NotTestable>,
    /// Evidence of each candidate.
    pub evidence: Evidence,
    /// Score of each candidate.
    pub scores: Vec<Score>,
}

impl Stage {
    /// Looks at everything that is not in a fitted model. `None` where its parameters are not
    /// determined.
    pub fn new(fitted: Fitted, wanted: &Wanted) -> Option<Self> {
        let offer = offer(&fitted.recipes, wanted);
        let (mut candidates, tried) = best_members(&fitted, offer.effects)?;
        let effects = candidates.len();
        candidates.extend(blocks(&fitted.recipes));
        let all: Vec<&Candidate> = candidates.iter().collect();
        let evidence = Evidence::new(&fitted.problem, &fitted.fit.normal, &fitted.fit.point, &all)?;
        let scores = evidence
            .entries
            .iter()
            .enumerate()
            .map(|(number, entry)| score(entry, tried.get(number).copied().unwrap_or(1)))
            .collect();
        Some(Self {
            fitted,
            candidates,
            effects,
            noise: offer.noise,
            not_testable: offer.not_testable,
            evidence,
            scores,
        })
    }

    /// The entry of a candidate.
    pub fn entry(&self, candidate: usize) -> &Entry {
        &self.evidence.entries[candidate]
    }

    /// The values of a candidate's parameters that the linearised problem finds best.
    pub fn start(&self, candidate: usize) -> Vec<(String, usize, Option<String>, f64)> {
        let entry = self.entry(candidate);
        let values: DVector<f64> = entry.values();
        entry
            .owners
            .iter()
            .zip(values.iter())
            .map(|(owner, value)| {
                (owner.parameter.clone(), owner.component, owner.of.clone(), *value)
            })
            .collect()
    }
}

/// Of each family the member that explains most, with the number of members tried.
fn best_members(fitted: &Fitted, offered: Vec<Candidate>) -> Option<(Vec<Candidate>, Vec<usize>)> {
    let mut best: Vec<Candidate> = Vec::new();
    let mut tried = Vec::new();
    let mut rest = offered.as_slice();
    while let Some(first) = rest.first() {
        let count = rest.iter().take_while(|one| one.name == first.name).count();
        let (family, after) = rest.split_at(count);
        rest = after;
        let mut winner = 0;
        if count > 1 {
            let members: Vec<&Candidate> = family.iter().collect();
            let fit = &fitted.fit;
            let evidence = Evidence::new(&fitted.problem, &fit.normal, &fit.point, &members)?;
            let gain = |k: &usize| score(&evidence.entries[*k], 1).ln_p;
            winner = (0..count).min_by(|a, b| gain(a).total_cmp(&gain(b))).unwrap_or(0);
        }
        best.push(family[winner].clone());
        tried.push(count);
    }
    Some((best, tried))
}

/// Fits campaigns as they are.
///
/// # Errors
/// [`FitError`] where the problem cannot be fitted at all.
pub fn fitted(
    recipes: Vec<Recipe>,
    mut problem: Problem,
    start: Point,
    options: &Options,
) -> Result<Fitted, FitError> {
    problem.reweight(&start);
    let fit = fit(&mut problem, start, options)?;
    Ok(Fitted { recipes, problem, fit })
}
