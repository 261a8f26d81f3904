//! The gap of a campaign that the fit never saw.
//!
//! What belongs to the instrument and the rig is held at the values of the first campaign, for each
//! model: without the effects, with the first of them, with the first two, and so on. Lost samples
//! and outliers (beyond 3.5 robust standard deviations of their campaign and run), as the
//! model with all effects sees them, are left out for every model, and counted. Parameters of
//! setups and runs are then fitted to every other eighth of each run, and the eighths between are
//! judged: a clock's rate extrapolated from first halves would hide what effects do in second ones.
//! Where those eighths do not determine them, whole runs are fitted and judged.

use crate::diagnose::fitted::Fitted;
use crate::diagnose::outliers::lost;
use crate::engine::gram::LeastSquares;
use crate::engine::open::{Opened, Recipe};
use crate::engine::{Part, Point, Problem};
use crate::estimate::batch::{Fit, FitError, Options, fit};
use crate::estimate::calibrate::rms;
use crate::estimate::start::start;
use crate::graph::Scope;
use crate::model::Override;
use crate::system::{Selected, System};

use super::{Drop, Gap, Step, Steps, taken};

/// Stretches that a run is cut into.
const EIGHTHS: usize = 8;

/// Why a held-out campaign cannot be judged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HoldoutError {
    /// It cannot be fitted at all.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// It has the model, but does not take an effect that was found with it.
    #[error("the held-out campaign does not take the effect `{name}`: {why}")]
    Effect {
        /// The effect.
        name: String,
        /// What is wrong.
        why: String,
    },
}

/// The gap of a held-out campaign, without and with the effects that were adopted elsewhere.
pub fn holdout(opened: &Opened, models: &Steps, options: &Options) -> Result<Gap, HoldoutError> {
    let held = Held { parts: &opened.problem.parts, recipes: &opened.recipes, options };
    let parts = held.sound(models.last())?;
    let readings = |parts: &[Part]| parts.iter().flat_map(Part::present).sum::<usize>();
    let left_out = readings(held.parts) - readings(&parts);
    let held = Held { parts: &parts, ..held };
    let all = std::iter::once(&models.nominal).chain(models.with.iter().map(|(_, model)| model));
    let learnt = all.map(|model| {
        let whole = held.learns(model)?;
        let learnt = held.learns_in_part(&whole)?;
        Ok::<_, HoldoutError>((whole, learnt))
    });
    let learnt = learnt.collect::<Result<Vec<_>, _>>()?;
    let by_eighths = learnt.iter().all(|(_, learnt)| learnt.is_sound());
    let scored = learnt.into_iter().map(|(whole, learnt)| {
        if by_eighths { Scored::of_the_rest(&whole, learnt) } else { Scored::of(whole) }
    });
    let scored: Vec<Scored> = scored.collect();
    let steps = models.with.iter().zip(scored.windows(2)).map(|((effect, _), pair)| Step {
        effect: effect.clone(),
        rms: pair[1].rms.clone(),
        held_out_drop: taken(&pair[0].drops(&pair[1])),
    });
    let (before, last) = (&scored[0], &scored[scored.len() - 1]);
    let drops = before.drops(last);
    Ok(Gap {
        held_out: opened.campaigns.first().map(|campaign| campaign.name.clone()),
        before: before.rms.clone(),
        steps: steps.collect(),
        lambda: taken(&drops).max(0.0).sqrt(),
        left_out,
        ..Gap::of(&last.judged, &drops, last.leftover())
    })
}

/// A campaign that others were not fitted to.
#[derive(Clone, Copy)]
struct Held<'a> {
    parts: &'a [Part],
    recipes: &'a [Recipe],
    options: &'a Options,
}

/// How well a model predicts.
struct Scored {
    /// Of what is judged.
    rms: Vec<(String, f64)>,
    /// Sum of squares of each run.
    squares: Vec<f64>,
    /// The model with the readings that are judged.
    judged: Fitted,
}

impl Scored {
    /// Of all that a model was fitted to.
    fn of(judged: Fitted) -> Self {
        let runs = judged.fit.normal.runs.iter();
        let squares =
            runs.map(|run| run.gram[(run.gram.nrows() - 1, run.gram.nrows() - 1)]).collect();
        Self { rms: rms(&judged.problem, &judged.fit.point), squares, judged }
    }

    /// Of the eighths of runs that a fit did not learn from.
    fn of_the_rest(whole: &Fitted, learnt: Fitted) -> Self {
        let mut problem = eighths(&whole.problem, 1);
        problem.reweight(&learnt.fit.point);
        let normal = problem.normal(&learnt.fit.point);
        Self::of(Fitted { problem, fit: Fit { normal, ..learnt.fit }, ..learnt })
    }

    /// How much less the sum of squares of each run is with another model.
    fn drops(&self, other: &Self) -> Vec<Drop> {
        let squares = self.squares.iter().zip(&other.squares).zip(self.apart(other));
        squares.map(|((before, after), length)| Drop { taken: before - after, length }).collect()
    }

    /// For each run the squared length of the difference between two models' predictions, in what
    /// the other one leaves of each measurand.
    fn apart(&self, other: &Self) -> Vec<f64> {
        let mut apart = Vec::new();
        for (p, part) in self.judged.problem.parts.iter().enumerate() {
            let names = &part.system.assembly.names.measurands;
            let unit = |row: usize| {
                let name = &names[part.measurand_of(row)].name;
                other.rms.iter().find(|(one, _)| one == name).map_or(1.0, |(_, rms)| *rms)
            };
            let units: Vec<f64> = (0..part.residual_count()).map(unit).collect();
            for run in 0..part.runs.len() {
                let left = |one: &Fitted| one.problem.residuals(p, run, &one.fit.point);
                let (own, other) = (left(&self.judged), left(&other.judged));
                let both = own.iter().flatten().zip(other.iter().flatten());
                let square = |((own, other), unit): ((&f64, &f64), &f64)| {
                    let apart = (own - other) / unit;
                    if apart.is_finite() { apart * apart } else { 0.0 }
                };
                apart.push(both.zip(units.iter().cycle()).map(square).sum());
            }
        }
        apart
    }

    /// Squared residuals beyond those of noise.
    fn leftover(&self) -> f64 {
        let squares: f64 = self.squares.iter().sum();
        (squares - self.judged.problem.component_count() as f64).max(0.0)
    }
}

impl Held<'_> {
    /// Its campaigns without lost samples and outliers, as a model sees them.
    fn sound(self, model: &Fitted) -> Result<Vec<Part>, HoldoutError> {
        let mut parts = self.parts.to_vec();
        for _ in 0..lost::LOOKS {
            let Fitted { mut problem, fit, .. } = Held { parts: &parts, ..self }.learns(model)?;
            let freedom = problem.component_count() as f64 - problem.layout.columns.len() as f64;
            let factor = (freedom > 0.0).then(|| fit.cost / freedom);
            let found = lost::look(&problem, &fit.point, factor, self.options)?.lost;
            if found.is_empty() {
                break;
            }
            lost::leave_out(&mut problem, &found);
            take_runs(&mut parts, problem);
        }
        let Fitted { problem, fit, .. } = Held { parts: &parts, ..self }.learns(model)?;
        let robust = lost::robust_fit(&problem, &fit.point, true, self.options)?;
        take_runs(&mut parts, robust.rest);
        Ok(parts)
    }

    /// A model fitted to it; what is global is held.
    fn learns(self, model: &Fitted) -> Result<Fitted, HoldoutError> {
        let mut recipes = self.recipes.to_vec();
        let mut parts = Vec::new();
        for (recipe, part) in recipes.iter_mut().zip(self.parts) {
            let mut system = with_effects(recipe, part.system.clone(), &model.recipes)?;
            hold(&mut system, part, model);
            let mut part = part.with_system(system);
            for (random, sigma) in part.system.randoms.iter().zip(&mut part.random_sigma) {
                *sigma = model.problem.random(&random.name).unwrap_or(*sigma);
            }
            parts.push(part);
        }
        let mut problem = Problem::new(parts);
        let (point, _) = start(&problem);
        let mut found = fit(&mut problem, point, self.options)?;
        if found.outcome.is_result() && problem.count_smoothing(&found.point) {
            found = fit(&mut problem, found.point, self.options)?;
        }
        Ok(Fitted { recipes, problem, fit: found })
    }

    /// The same model fitted to every other eighth of each run.
    fn learns_in_part(self, whole: &Fitted) -> Result<Fitted, FitError> {
        let mut problem = eighths(&whole.problem, 0);
        let fit = fit(&mut problem, whole.fit.point.clone(), self.options)?;
        Ok(Fitted { recipes: whole.recipes.clone(), problem, fit })
    }
}

/// Gives a recipe, of which this is the system, the effects that others found, with the constants that
/// these state of them: the system with them. Effects that only other models take are left aside.
fn with_effects(
    recipe: &mut Recipe,
    mut system: System,
    from: &[Recipe],
) -> Result<System, HoldoutError> {
    for (other, effect) in from.iter().flat_map(|one| one.effects.iter().map(move |e| (one, e))) {
        let name = &effect.effect.name;
        let known = |one: &Selected| one.effect.name == *name && one.head == effect.head;
        if recipe.effects.iter().any(known) {
            continue;
        }
        let own = format!("{name}.");
        let of_all = |said: &&Override| said.setup.is_none() && said.name.starts_with(&own);
        for said in other.overrides.iter().filter(of_all) {
            let is_known = |one: &Override| one.setup.is_none() && one.name == said.name;
            if !recipe.overrides.iter().any(is_known) {
                // What the campaign says of single setups counts over it.
                recipe.overrides.insert(0, said.clone());
            }
        }
        match recipe.with(std::slice::from_ref(effect)) {
            Ok(with) => {
                system = with;
                recipe.effects.push(effect.clone());
            }
            Err(faults) if other.model.name == recipe.model.name => {
                let why: Vec<&str> = faults.0.iter().map(|one| one.message.as_str()).collect();
                return Err(HoldoutError::Effect { name: name.clone(), why: why.join("; ") });
            }
            Err(_) => {}
        }
    }
    Ok(system)
}

/// A problem with every other eighth of each run, from the one of this number on: a run's own
/// parameters are fitted to the first, the third and so on (0), and those between are judged (1).
fn eighths(problem: &Problem, first: usize) -> Problem {
    let mut rest = problem.clone();
    rest.leave_out_samples(|count| {
        let edge = |eighth: usize| (eighth * count).div_ceil(EIGHTHS);
        (1 - first..EIGHTHS).step_by(2).map(|one| edge(one)..edge(one + 1)).collect()
    });
    problem.with_parts(rest.parts)
}

/// Puts the runs of a problem in the place of those of some campaigns.
fn take_runs(parts: &mut [Part], problem: Problem) {
    for (part, from) in parts.iter_mut().zip(problem.parts) {
        part.runs = from.runs;
    }
}

/// Holds what belongs to a campaign's instrument and rig at the values of a fit: at those of the
/// same instrument or rig, else of the first campaign.
fn hold(system: &mut System, part: &Part, values: &Fitted) {
    let Problem { layout, parts, .. } = &values.problem;
    let point: &Point = &values.fit.point;
    let names = &system.assembly.names.parameters;
    for (parameter, setting) in names.iter().zip(&mut system.settings) {
        let owner: fn(&Part) -> Option<&String> = match setting.scope {
            Scope::Rig => |part| part.rig.as_ref(),
            Scope::Instrument => |part| part.instrument.as_ref(),
            Scope::Setup | Scope::Run | Scope::Sample => continue,
        };
        let known = || {
            parts.iter().zip(&layout.used).filter_map(|(one, used)| {
                let names = &one.system.assembly.names.parameters;
                let index = names.iter().position(|own| own.name == parameter.name)?;
                Some((owner(one), *used.first()?.get(index)?))
            })
        };
        let same = known().find(|(name, _)| name.is_some() && *name == owner(part));
        if let Some((_, index)) = same.or_else(|| known().next()) {
            setting.hold_at(point.components(layout, index));
        }
    }
}
