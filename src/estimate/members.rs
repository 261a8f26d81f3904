//! Which member of a family fits best, where an effect is put in and nobody says which.
//!
//! A wave has a period, a lag a time constant: an effect of one member alone says nothing of the
//! others, and the middle of a range is nobody's guess. So members are tried: all of a list, of a
//! range a grid of them and then what lies between. What one would take off chi squared follows from
//! the sums at the optimum without the effects, linearised; the fit itself is made with the best.

use nalgebra::{DMatrix, DVector};

use crate::diagnostic::Diagnostics;
use crate::effect::Members;
use crate::engine::gram::LeastSquares;
use crate::engine::open::Recipe;
use crate::engine::{Point, Problem};
use crate::estimate::arrow::normal_matrix;
use crate::estimate::batch::Options;
use crate::estimate::calibrate::calibrate;
use crate::estimate::eigen;
use crate::estimate::nested::without;
use crate::units::Unit;

/// Members of a range that are tried at first.
const GRID: usize = 160;
/// Halvings of the interval about the best.
const REFINED: usize = 24;
/// Singular values below this part of the largest say nothing.
const RANK: f64 = 1e-7;

/// A member that was chosen.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// `EFFECT.FAMILY`.
    pub name: String,
    /// The member (SI).
    pub value: f64,
    /// Its unit.
    pub unit: Unit,
    /// How many were tried.
    pub tried: usize,
    /// Whether it is one of a range; else of a list.
    pub is_of_range: bool,
    /// What it takes off chi squared, and the best of the others of a list.
    pub gains: [Option<f64>; 2],
}

/// The problem with the best member of each family that nobody chose, of effects (`NAME` or
/// `NAME.HEAD`) that are put in.
///
/// # Errors
/// What putting the model together again finds.
pub fn choose(
    problem: Problem,
    recipes: &[Recipe],
    effects: &[String],
) -> Result<(Problem, Vec<Chosen>), Diagnostics> {
    let open = open(recipes, effects);
    if open.is_empty() {
        return Ok((problem, Vec::new()));
    }
    let Ok(nominal) = calibrate(without(&problem, effects), &Options::default()) else {
        return Ok((problem, Vec::new()));
    };
    if !nominal.fit.outcome.is_result() {
        return Ok((problem, Vec::new()));
    }
    let point = nominal.fit.point;
    let mut recipes = recipes.to_vec();
    let (mut problem, mut chosen) = (problem, Vec::new());
    for Open { effect, family, unit, members } in open {
        let gain = |value: f64| -> Result<f64, Diagnostics> {
            let mut recipes = recipes.clone();
            set(&mut recipes, &effect, &family, value);
            Ok(gain(&put_together(&problem, &recipes)?, &point))
        };
        let (value, tried, gains) = best(&members, gain)?;
        set(&mut recipes, &effect, &family, value);
        problem = put_together(&problem, &recipes)?;
        chosen.push(Chosen {
            name: format!("{effect}.{family}"),
            value,
            unit,
            tried,
            is_of_range: matches!(members, Members::Range { .. }),
            gains,
        });
    }
    Ok((problem, chosen))
}

/// A family of which no member is chosen.
struct Open {
    effect: String,
    family: String,
    unit: Unit,
    members: Members,
}

fn open(recipes: &[Recipe], effects: &[String]) -> Vec<Open> {
    let mut found: Vec<Open> = Vec::new();
    for recipe in recipes {
        for selected in &recipe.effects {
            let name = &selected.effect.name;
            let is_put_in = effects.iter().any(|one| one.split('.').next() == Some(name.as_str()));
            let families = selected.effect.shape.iter().filter(|_| is_put_in);
            for (family, declared) in families {
                let full = format!("{name}.{family}");
                let is_chosen = selected.member.contains_key(family)
                    || recipe.overrides.iter().any(|said| said.name == full);
                let known = found.iter().any(|one| one.effect == *name && one.family == *family);
                // A memory is a matter of the noise: no reading follows it.
                if !is_chosen
                    && !known
                    && !selected.effect.parameters.is_empty()
                    && family != "memory"
                {
                    found.push(Open {
                        effect: name.clone(),
                        family: family.clone(),
                        unit: declared.unit.clone(),
                        members: declared.members.clone(),
                    });
                }
            }
        }
    }
    found
}

fn set(recipes: &mut [Recipe], effect: &str, family: &str, value: f64) {
    for selected in recipes.iter_mut().flat_map(|recipe| &mut recipe.effects) {
        if selected.effect.name == effect {
            selected.member.insert(family.to_owned(), value);
        }
    }
}

/// The problem with systems put together anew.
fn put_together(problem: &Problem, recipes: &[Recipe]) -> Result<Problem, Diagnostics> {
    let parts = problem.parts.iter().zip(recipes);
    let parts = parts.map(|(part, recipe)| Ok(part.with_system(recipe.with(&[])?)));
    let mut made = Problem::new(parts.collect::<Result<Vec<_>, Diagnostics>>()?);
    made.progress = problem.progress.clone();
    Ok(made)
}

/// What a linear step takes off chi squared.
fn gain(problem: &Problem, point: &Point) -> f64 {
    let mut problem = problem.clone();
    problem.refresh_weights(point);
    let Ok((hessian, gradient)) = normal_matrix(&problem.normal(point)) else { return 0.0 };
    let n = hessian.nrows();
    let length =
        DVector::from_fn(
            n,
            |i, _| {
                if hessian[(i, i)] > 0.0 { hessian[(i, i)].sqrt() } else { 1.0 }
            },
        );
    let scaled = DMatrix::from_fn(n, n, |i, j| hessian[(i, j)] / (length[i] * length[j]));
    let right = gradient.component_div(&length);
    let Some(eigen) = eigen::symmetric(scaled) else { return 0.0 };
    let least = RANK * RANK * eigen.eigenvalues.max();
    let pairs = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    pairs.filter(|(value, _)| **value > least).map(|(value, v)| v.dot(&right).powi(2) / value).sum()
}

/// The member with the largest gain, how many were tried, its gain and the next of a list.
fn best(
    members: &Members,
    gain: impl Fn(f64) -> Result<f64, Diagnostics>,
) -> Result<(f64, usize, [Option<f64>; 2]), Diagnostics> {
    let tried = members.series(GRID);
    let gains = tried.iter().map(|value| gain(*value)).collect::<Result<Vec<_>, _>>()?;
    let order = |a: &usize, b: &usize| gains[*a].total_cmp(&gains[*b]).then(b.cmp(a));
    let Some(first) = (0..tried.len()).max_by(order) else {
        return Ok((members.default_member(), 0, [None, None]));
    };
    if let Members::List(_) = members {
        let next = (0..tried.len()).filter(|other| *other != first).max_by(order);
        return Ok((tried[first], tried.len(), [Some(gains[first]), next.map(|n| gains[n])]));
    }
    let (mut low, mut high) =
        (tried[first.saturating_sub(1)], tried[(first + 1).min(tried.len() - 1)]);
    let mut found = (tried[first], gains[first]);
    for _ in 0..REFINED / 2 {
        for value in [0.5 * (low + found.0), 0.5 * (found.0 + high)] {
            let own = gain(value)?;
            if own > found.1 {
                (low, high) = if value < found.0 { (low, found.0) } else { (found.0, high) };
                found = (value, own);
            } else if value < found.0 {
                low = value;
            } else {
                high = value;
            }
        }
    }
    Ok((found.0, GRID + REFINED, [Some(found.1), None]))
}
