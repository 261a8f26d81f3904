//! The readings of one trial.
//!
//! Effects act through the graph, as everywhere; noise that is not what is stated is an effect of
//! the library on the noise, or one of two kinds that no effect describes: a share of wild
//! readings, and long tails.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::diagnose::fitted::{carried, rebuilt};
use crate::engine::gram::LeastSquares;
use crate::engine::part::wrapped;
use crate::engine::simulate::simulate;
use crate::engine::{Point, Problem};
use crate::graph::MeasurandKind;
use crate::system::Selected;

use super::design::{Cause, Design, Dose};
use super::plan::{Kind, Trial};

/// Part of the effects of a library's kind that have a form of their own.
const OWN_FORMS: f64 = 0.4;
/// Part of the withheld effects that nobody named.
const NAMELESS: f64 = 0.5;
/// Part of pairs of which one effect has a form of its own.
const PAIRS_WITH_OWN_FORM: f64 = 1.0 / 3.0;
/// Two effects of a pair share no more of their signatures than this.
const APART: f64 = 0.5;
/// rms of what noise adds to the readings, in units of the stated noise.
const NOISE_SIZES: (f64, f64) = (0.5, 3.0);
/// Factors on the usual size of a wrong level.
const LEVEL_SIZES: (f64, f64) = (0.5, 2.0);
/// Noise that no effect describes.
const FOREIGN: [&str; 2] = ["wild_readings", "long_tails"];
/// Share of wild readings, and how far out they are, in standard deviations.
const WILD: (f64, f64) = (0.01, 30.0);
/// Share of the readings in long tails, and how wide those are.
const TAILS: (f64, f64) = (0.10, 3.0);

/// A campaign with drawn readings, and what is true of it.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// What the diagnosis sees.
    pub problem: Problem,
    /// The effects in it.
    pub doses: Vec<Dose>,
    /// The noise, where it is not what is stated.
    pub noise: Option<String>,
    /// The same campaign with its effects, and its true point.
    full: Option<(Problem, Point)>,
}

impl Drawn {
    /// What the readings would be without noise; `None` where nothing was put in.
    pub fn noiseless(&self) -> Option<Problem> {
        let (full, point) = self.full.as_ref()?;
        let mut quiet = full.clone();
        for part in &mut quiet.parts {
            part.sigma.fill(0.0);
            part.random_sigma.fill(0.0);
        }
        simulate(&mut quiet, point, 0, true);
        Some(quiet)
    }
}

/// Draws a trial.
pub fn draw(design: &Design, trial: &Trial) -> Drawn {
    let mut chance = trial.generator.clone();
    let doses = match trial.kind {
        Kind::None | Kind::Noise => Vec::new(),
        Kind::One => {
            let own_form = chance.random::<f64>() < OWN_FORMS;
            one(design, own_form, trial.lambda, &mut chance).into_iter().collect()
        }
        Kind::Withheld => {
            let nameless = chance.random::<f64>() < NAMELESS;
            withheld(design, nameless, trial.lambda, &mut chance).into_iter().collect()
        }
        Kind::Two => two(design, trial.lambda, &mut chance),
    };
    let mut drawn = Drawn { problem: design.problem.clone(), doses, noise: None, full: None };
    if trial.kind == Kind::Noise {
        make_noise(design, trial, &mut drawn, &mut chance);
    } else if drawn.doses.is_empty() {
        simulate(&mut drawn.problem, &design.truth, trial.seed, design.planned);
    } else {
        let selected: Vec<Selected> = drawn.doses.iter().map(|one| one.selected.clone()).collect();
        let values = drawn.doses.iter().flat_map(|one| one.values.clone()).collect::<Vec<_>>();
        let (mut full, point) = with(design, &selected, &values);
        simulate(&mut full, &point, trial.seed, design.planned);
        take_readings(&mut drawn.problem, &full);
        drawn.full = Some((full, point));
    }
    let start = Point::start(&drawn.problem.layout);
    drawn.problem.reweight(&start);
    drawn
}

/// One of some causes.
fn pick<'c>(causes: &[&'c Cause], chance: &mut ChaCha12Rng) -> Option<&'c Cause> {
    (!causes.is_empty()).then(|| causes[chance.random_range(0..causes.len())])
}

fn dose(design: &Design, cause: &Cause, lambda: f64, chance: &mut ChaCha12Rng) -> Dose {
    let member = chance.random::<f64>();
    design.dose(cause, lambda, member, &mut || StandardNormal.sample(&mut *chance))
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

/// The campaigns with effects of these values, at the truth.
fn with(
    design: &Design,
    selected: &[Selected],
    values: &[(String, usize, Option<String>, f64)],
) -> (Problem, Point) {
    let parts = design.problem.parts.iter().zip(&design.recipes).map(|(part, recipe)| match recipe
        .with(selected)
    {
        Ok(system) => rebuilt(part, system),
        Err(_) => part.clone(),
    });
    let full = Problem::new(parts.collect());
    let mut point = carried(&design.problem, &design.truth, &full);
    for (name, component, of, value) in values {
        for (index, instance) in full.layout.instances.iter().enumerate() {
            if instance.name == *name && instance.whose() == of.as_deref() {
                point.set_component(&full.layout, index, *component, *value);
            }
        }
    }
    (full, point)
}

/// Gives one problem the readings of another.
pub(super) fn take_readings(problem: &mut Problem, from: &Problem) {
    for (part, other) in problem.parts.iter_mut().zip(&from.parts) {
        for (run, other) in part.runs.iter_mut().zip(&other.runs) {
            run.record.clone_from(&other.record);
        }
    }
}

/// Whether noise is of a kind that no effect describes.
pub fn is_foreign(noise: &str) -> bool {
    FOREIGN.contains(&noise)
}

/// Draws readings whose noise is not what is stated.
fn make_noise(design: &Design, trial: &Trial, drawn: &mut Drawn, chance: &mut ChaCha12Rng) {
    let mut names: Vec<&str> = design.noise.iter().map(|one| one.name.as_str()).collect();
    names.dedup();
    names.extend(FOREIGN);
    let name = names[chance.random_range(0..names.len())];
    drawn.noise = Some(name.to_owned());
    let ways: Vec<_> = design.noise.iter().filter(|one| one.name == name).collect();
    if ways.is_empty() {
        simulate(&mut drawn.problem, &design.truth, trial.seed, design.planned);
        spoil(&mut drawn.problem, name, chance);
        return;
    }
    let way = ways[chance.random_range(0..ways.len())];
    let share = chance.random::<f64>();
    let between = |(from, to): (f64, f64)| from * (to / from).powf(share);
    let (mut full, mut point) = with(design, std::slice::from_ref(&way.selected), &[]);
    for (index, instance) in full.layout.instances.iter().enumerate() {
        let own = instance.name.split('.').next() == Some(name);
        if let (true, Some(typical)) = (own, instance.setting.typical) {
            point.values[index][0] = between(LEVEL_SIZES) * typical;
        }
    }
    let added = added(&full, &point, name, trial.seed);
    let by = if added > 0.0 { between(NOISE_SIZES) / added } else { 0.0 };
    set_randoms(&mut full, name, by);
    simulate(&mut full, &point, trial.seed, design.planned);
    take_readings(&mut drawn.problem, &full);
}

/// Gives the random quantities of an effect so many times their usual size.
fn set_randoms(problem: &mut Problem, effect: &str, by: f64) {
    for part in &mut problem.parts {
        for (random, sigma) in part.system.randoms.iter().zip(&mut part.random_sigma) {
            if random.effect.as_deref() == Some(effect) {
                *sigma = by * random.typical.unwrap_or(0.0);
            }
        }
    }
}

/// rms of what an effect's random quantities of their usual size add to the readings, in units of
/// the stated noise.
fn added(full: &Problem, point: &Point, effect: &str, seed: u64) -> f64 {
    let mut quiet = full.clone();
    for part in &mut quiet.parts {
        part.sigma.fill(0.0);
        part.random_sigma.fill(0.0);
    }
    let mut moved = quiet.clone();
    // Of a tenth of the size, where it is linear.
    set_randoms(&mut moved, effect, 0.1);
    simulate(&mut quiet, point, seed, true);
    simulate(&mut moved, point, seed, true);
    let (mut squares, mut count) = (0.0, 0.0);
    for ((part, other), stated) in quiet.parts.iter().zip(&moved.parts).zip(&full.parts) {
        for (run, other) in part.runs.iter().zip(&other.runs) {
            for (slot, sigma) in part.slots().iter().zip(&stated.sigma) {
                let columns = [run, other].map(|run| &run.held().readings[slot.column]);
                let period = match slot.kind {
                    MeasurandKind::Angle { period } => period,
                    _ => 0.0,
                };
                for (a, b) in columns[0].iter().zip(columns[1]) {
                    squares += (wrapped(b - a, period) / sigma).powi(2);
                    count += 1.0;
                }
            }
        }
    }
    10.0 * (squares / f64::max(count, 1.0)).sqrt()
}

/// Adds what no normal distribution gives.
fn spoil(problem: &mut Problem, name: &str, chance: &mut ChaCha12Rng) {
    let (share, width) = if name == FOREIGN[0] { WILD } else { TAILS };
    for part in &mut problem.parts {
        let slots = part.slots().to_vec();
        let sigma = part.sigma.clone();
        for run in &mut part.runs {
            run.record.edit(|samples| {
                for (slot, sigma) in
                    slots.iter().zip(&sigma).filter(|(slot, _)| slot.components == 1)
                {
                    for reading in &mut samples.readings[slot.column] {
                        if chance.random::<f64>() < share {
                            let far: f64 = StandardNormal.sample(&mut *chance);
                            *reading += width * sigma * far;
                        }
                    }
                }
            });
        }
    }
}
