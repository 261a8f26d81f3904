//! The readings of one trial.
//!
//! Effects act through the graph, as everywhere.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;

use crate::engine::gram::LeastSquares;
use crate::engine::open::Recipe;
use crate::engine::simulate::simulate;
use crate::engine::{Point, Problem};
use crate::system::Selected;

use super::design::{Cause, Design, Dose};
use super::doses::{dose, pick};
use super::mixture::{Mixture, mixture};
use super::noise::simulate_misstated;
use super::plan::{Kind, Trial};
use super::simulated::{noiseless, take_readings, with};

/// Part of the effects of a library's kind that have a form of their own.
const OWN_FORMS: f64 = 0.4;
/// Part of the withheld effects that nobody named.
const NAMELESS: f64 = 0.5;
/// Part of pairs of which one effect has a form of its own.
const PAIRS_WITH_OWN_FORM: f64 = 1.0 / 3.0;
/// Two effects of a pair share no more of their signatures than this.
const APART: f64 = 0.5;

/// A campaign with drawn readings, and what is true of it.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// What the diagnosis sees.
    pub problem: Problem,
    /// The effects in it.
    pub doses: Vec<Dose>,
    /// How many of these, the last ones, are mixed in from outside the library.
    pub outside: usize,
    /// The noise, where it is not what is stated.
    pub noise: Option<String>,
    /// Standard deviation of the noise, in units of what is stated.
    pub noise_factor: f64,
    /// What the diagnosis may put its models together from.
    pub recipes: Vec<Recipe>,
    /// The same campaign with its effects, and its true point.
    full: Option<(Problem, Point)>,
}

impl Drawn {
    /// What the readings would be without noise; `None` where nothing was put in.
    pub fn noiseless(&self) -> Option<Problem> {
        let (full, point) = self.full.as_ref()?;
        Some(noiseless(full, point))
    }
}

/// Draws a trial.
pub fn draw(design: &Design, trial: &Trial) -> Drawn {
    let mut chance = trial.generator.clone();
    let Mixture { doses, outside, noise: noise_factor } = causes(design, trial, &mut chance);
    let mut drawn = Drawn {
        problem: design.problem.clone(),
        doses,
        outside,
        noise: None,
        noise_factor,
        recipes: design.recipes.clone(),
        full: None,
    };
    if trial.kind == Kind::Noise {
        let name = simulate_misstated(design, trial.seed, &mut drawn.problem, &mut chance);
        drawn.noise = Some(name);
    } else if drawn.doses.is_empty() && trial.situation.is_none() {
        simulate(&mut drawn.problem, &design.truth, trial.seed, design.planned);
    } else {
        let selected: Vec<Selected> = drawn.doses.iter().map(|one| one.selected.clone()).collect();
        let values = drawn.doses.iter().flat_map(|one| one.values.clone()).collect::<Vec<_>>();
        let (mut full, point) = with(design, &selected, &values);
        let mut noisy = with_noise(full.clone(), noise_factor);
        simulate(&mut noisy, &point, trial.seed, design.planned);
        take_readings(&mut full, &noisy);
        if let Some(situation) = &trial.situation {
            situation.disturb(&mut full, &point, &mut chance);
        }
        take_readings(&mut drawn.problem, &full);
        drawn.full = Some((full, point));
        if let Some(situation) = &trial.situation {
            situation.misstate(&mut drawn.problem, &mut drawn.recipes, &mut chance);
        }
    }
    let start = Point::start(&drawn.problem.layout);
    drawn.problem.reweight(&start);
    drawn
}

/// The effects of a trial.
fn causes(design: &Design, trial: &Trial, chance: &mut ChaCha12Rng) -> Mixture {
    let beside = trial.situation.as_ref().map_or(0, |situation| situation.effects);
    let doses = match trial.kind {
        Kind::None | Kind::Noise => Vec::new(),
        Kind::One => {
            let own_form = chance.random::<f64>() < OWN_FORMS;
            one(design, own_form, trial.lambda, chance).into_iter().collect()
        }
        Kind::Withheld => {
            let nameless = chance.random::<f64>() < NAMELESS;
            withheld(design, nameless, trial.lambda, chance).into_iter().collect()
        }
        Kind::Two => two(design, trial.lambda, chance),
        Kind::Situation if beside == 0 => Vec::new(),
        Kind::Situation => one(design, false, trial.lambda, chance).into_iter().collect(),
        Kind::Mixture => return mixture(design, trial.size, chance),
    };
    Mixture { doses, outside: 0, noise: 1.0 }
}

/// Campaigns whose noise is so many times what they state.
fn with_noise(mut problem: Problem, factor: f64) -> Problem {
    for part in &mut problem.parts {
        part.sigma.iter_mut().for_each(|sigma| *sigma *= factor);
    }
    problem
}

/// An effect of the library, in its form or another one.
fn one(design: &Design, own_form: bool, lambda: f64, chance: &mut ChaCha12Rng) -> Option<Dose> {
    let of = |foreign: bool| -> Vec<&Cause> {
        let known = |cause: &&Cause| {
            if foreign { !cause.in_library && !cause.names.is_empty() } else { cause.in_library }
        };
        design.causes.iter().filter(known).collect()
    };
    let cause = pick(&of(own_form), chance).or_else(|| pick(&of(!own_form), chance))?;
    Some(dose(design, cause, lambda, chance))
}

/// An effect that is to be withheld: one that nobody named, or one of the library, in its form.
fn withheld(
    design: &Design,
    nameless: bool,
    lambda: f64,
    chance: &mut ChaCha12Rng,
) -> Option<Dose> {
    let of = |nameless: bool| -> Vec<&Cause> {
        let known = |cause: &&Cause| {
            if nameless { cause.names.is_empty() } else { cause.in_library }
        };
        design.causes.iter().filter(known).collect()
    };
    let cause = pick(&of(nameless), chance).or_else(|| pick(&of(!nameless), chance))?;
    Some(dose(design, cause, lambda, chance))
}

/// Two effects that are not too much alike; at most one has a form of its own.
fn two(design: &Design, lambda: f64, chance: &mut ChaCha12Rng) -> Vec<Dose> {
    let own_form = chance.random::<f64>() < PAIRS_WITH_OWN_FORM;
    let mut doses: Vec<Dose> = one(design, own_form, lambda, chance).into_iter().collect();
    for _ in 0..100 {
        let (Some(first), Some(second)) = (doses.first(), one(design, false, lambda, chance))
        else {
            break;
        };
        let same = second.cause.names.iter().any(|name| design.is_named(first, name));
        if !same && design.alike_parts(first, &second) < APART {
            doses.push(second);
            break;
        }
    }
    doses
}
