//! Random walks, tested in the variance.
//!
//! A walk `W` over a time `T` is a sum of sines with independent coefficients (Karhunen and Loève):
//! `W(t) = σ Σ ξ_k √(2 T) / ((k - ½) π) sin((k - ½) π t / T)`. The first `TERMS` of every run, and where
//! the walk has come to when the run begins, are columns like those of an effect. With the scores `g` of
//! coefficients over their share, beyond the nominal parameters, `Q = gᵀ g` has the mean `tr M` without a
//! walk, `M` being the covariance of `g`: a test of the variance, one-sided. The tail of `Q`, a sum of chi
//! squared numbers with unequal weights, is that of the chi squared number with the same three first
//! cumulants (Pearson 1959; Imhof 1961). The size is that of largest likelihood.
//!
//! A walk looks like structure over time and runs, and structure like a walk: significant structure is
//! taken off first as long as it is less probable by chance than the walk's likelihood could make it.
//! What is accepted joins the model as those columns with their prior, so that everything that comes
//! later is judged against it.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::diagnostic::Source;
use crate::effect::Effect;
use crate::engine::Problem;
use crate::model::Process;
use crate::system::Selected;
use crate::units::{Dimension, Exponent, Unit};

use super::candidates::{Candidate, join};
use super::evidence::{Entry, Evidence};
use super::memory::likelihood_of_memory;
use super::score::of_gain;
use super::stage::Stage;
use super::tail::ln_gamma_tail;
use super::whiten::{NoiseEffect, sequences};

/// Sines of each run: 93 % of a walk's variance.
const TERMS: usize = 3;

/// The walk of the library that shows, if one does. `level` is the logarithm of its share of the false
/// alarms.
/// The logarithm of its likelihood ratio against white noise of unit variance comes with it, a memory of
/// what it leaves included.
pub fn walk(stage: &Stage, level: f64) -> Option<(NoiseEffect, f64)> {
    let mut best: Option<(NoiseEffect, f64)> = None;
    for candidate in &stage.noise {
        let effect = &candidate.selected.effect;
        let walks = !effect.parameters.is_empty()
            && effect.parameters.iter().all(|one| one.process == Process::Walk);
        if !walks {
            continue;
        }
        let Some((found, likelihood)) = tested(stage, candidate, level) else { continue };
        if best.as_ref().is_none_or(|(_, known)| likelihood > *known) {
            best = Some((found, likelihood));
        }
    }
    best
}

fn tested(stage: &Stage, candidate: &Candidate, level: f64) -> Option<(NoiseEffect, f64)> {
    let effect = &candidate.selected.effect;
    let times = Times::of(&stage.fitted.problem);
    let of = |sigma| Some(select(candidate, columns(effect, times, sigma)?));
    let selected: Selected = of(None)?;
    let recipes = &stage.fitted.recipes;
    let mut made = Vec::new();
    for (campaign, recipe) in recipes.iter().enumerate() {
        if let Ok(system) = recipe.with(std::slice::from_ref(&selected)) {
            join(&mut made, (campaign, recipes.len()), selected.clone(), None, system);
        }
    }
    let columns = made.pop()?;
    let structures = stage.structures();
    let mut all: Vec<&Candidate> = structures.iter().map(|n| &stage.candidates[*n]).collect();
    all.push(&columns);
    let fit = &stage.fitted.fit;
    let evidence = Evidence::new(&stage.fitted.problem, &fit.normal, &fit.point, &all)?;
    let (own, structures) = evidence.entries.split_last()?;
    if own.degrees() == 0 {
        return None;
    }
    let weights = DVector::from_fn(own.owners.len(), |k, _| times.term(&own.owners[k].parameter));
    if ln_plain(own, &weights) > level {
        return None;
    }
    let entries: Vec<&Entry> = structures.iter().collect();
    // Structure is taken off only as long as it is more than the walk would make of it.
    let (mut walk, mut known) = (None, 0);
    while known <= entries.len() {
        let whole = evidence.together(&entries[..known]);
        let beyond = Walk::beyond(&evidence, &whole, own, &weights)?;
        let next = entries.get(known).map_or(0.0, |next| {
            let (gain, degrees) = evidence.beyond(&whole, next);
            -of_gain(gain, degrees, 1).ln_p
        });
        let wins = beyond.likelihood() > next;
        walk = Some(beyond);
        if wins {
            break;
        }
        known += 1;
    }
    let walk = walk.filter(|walk| walk.ln_p() <= level)?;
    let (variance, spread) = walk.variance();
    let sigma = variance.sqrt();
    let parameter = effect.parameters.first()?;
    let mut taken: Vec<&Entry> = entries[..known.min(entries.len())].to_vec();
    taken.push(own);
    let rest = evidence.together(&taken);
    let (problem, point) = (&stage.fitted.problem, &fit.point);
    let rest = sequences(problem, &evidence.left(problem, point, &rest, usize::MAX));
    let likelihood = walk.likelihood() + likelihood_of_memory(&rest);
    let found = NoiseEffect {
        name: candidate.name.clone(),
        selected: of(Some(sigma)),
        parameter: format!("{}.{}", candidate.name, parameter.name),
        unit: parameter.unit.clone(),
        value: sigma,
        sigma: if sigma > 0.0 { spread / (2.0 * sigma) } else { 0.0 },
        memory: None,
        ln_p: walk.ln_p(),
    };
    Some((found, likelihood))
}

/// Scores of a walk's coefficients, each divided by its share of the walk, along the axes along which
/// they are independent.
struct Walk {
    /// Variance of each without a walk.
    values: Vec<f64>,
    /// The scores squared.
    squares: Vec<f64>,
}

impl Walk {
    /// Beyond the nominal parameters and something known.
    fn beyond(
        evidence: &Evidence,
        known: &Entry,
        own: &Entry,
        weights: &DVector<f64>,
    ) -> Option<Self> {
        let cosines = evidence.overlap(known, own);
        let score = &own.score - cosines.tr_mul(&known.score);
        let left = DMatrix::identity(own.degrees(), own.degrees()) - cosines.tr_mul(&cosines);
        let back = DMatrix::from_diagonal(weights) * own.lengths.transpose();
        let eigen = SymmetricEigen::new(&back * left * back.transpose());
        let along = eigen.eigenvectors.tr_mul(&(&back * score));
        let most = eigen.eigenvalues.max();
        let pairs = eigen.eigenvalues.iter().zip(along.iter());
        let (values, squares): (Vec<f64>, Vec<f64>) = pairs
            .filter(|(value, _)| **value > 1e-9 * most)
            .map(|(value, along)| (*value, along * along))
            .unzip();
        (!values.is_empty()).then_some(Self { values, squares })
    }

    fn powers(&self) -> [f64; 3] {
        [1, 2, 3].map(|order| self.values.iter().map(|value| value.powi(order)).sum())
    }

    /// Logarithm of the probability of such scores without a walk.
    fn ln_p(&self) -> f64 {
        ln_tail(self.squares.iter().sum(), self.powers())
    }

    /// Logarithm of the likelihood ratio of a walk of some variance.
    fn likelihood_at(&self, variance: f64) -> f64 {
        let terms = self.values.iter().zip(&self.squares).map(|(value, square)| {
            let size = 1.0 + variance * value;
            0.5 * variance * square / size - 0.5 * size.ln()
        });
        terms.sum()
    }

    /// The variance of largest likelihood.
    fn best(&self) -> f64 {
        let typical = 1.0 / self.values.iter().copied().fold(0.0, f64::max);
        let grid = (0..120).map(|k| typical * 1e-3 * 1.2_f64.powi(k));
        grid.max_by(|a, b| self.likelihood_at(*a).total_cmp(&self.likelihood_at(*b)))
            .unwrap_or(typical)
    }

    /// Logarithm of the largest likelihood ratio.
    fn likelihood(&self) -> f64 {
        self.likelihood_at(self.best())
    }

    /// The variance of a walk of one unit, and its standard uncertainty (Fisher's information).
    fn variance(&self) -> (f64, f64) {
        let variance = self.best();
        let information: f64 =
            self.values.iter().map(|v| 0.5 * (v / (1.0 + variance * v)).powi(2)).sum();
        (variance, information.sqrt().recip())
    }
}

/// Logarithm of the probability of scores by chance with nothing else known, without their axes: of most
/// campaigns that is all one needs.
fn ln_plain(own: &Entry, weights: &DVector<f64>) -> f64 {
    let back = DMatrix::from_diagonal(weights) * own.lengths.transpose();
    let matrix = &back * back.transpose();
    let third = (&matrix * &matrix).component_mul(&matrix).sum();
    ln_tail((&back * &own.score).norm_squared(), [matrix.trace(), matrix.norm_squared(), third])
}

/// Logarithm of the probability that a sum of weighted chi squared numbers exceeds a value, from the
/// sums of the first three powers of its weights.
fn ln_tail(value: f64, [mean, second, third]: [f64; 3]) -> f64 {
    let degrees = second.powi(3) / third.powi(2);
    let like = (value - mean) / (2.0 * second).sqrt() * (2.0 * degrees).sqrt() + degrees;
    ln_gamma_tail(0.5 * degrees, 0.5 * like.max(0.0))
}

fn select(candidate: &Candidate, effect: Effect) -> Selected {
    let head = candidate.selected.head.clone();
    Selected { effect: Arc::new(effect), head, member: BTreeMap::new() }
}

/// How long walks go on.
#[derive(Clone, Copy, Debug)]
struct Times {
    /// Duration of the longest run (s).
    run: f64,
    /// Of the longest setup (s).
    setup: f64,
}

impl Times {
    fn of(problem: &Problem) -> Self {
        let mut times = Self { run: 0.0, setup: 0.0 };
        for run in problem.parts.iter().flat_map(|part| &part.runs) {
            run.record.walk(|stretch| {
                let latest =
                    |column: &[f64]| column[stretch.range()].iter().copied().fold(0.0, f64::max);
                times.run = times.run.max(latest(&stretch.samples.run_time));
                times.setup = times.setup.max(latest(&stretch.samples.setup_time));
            });
        }
        times
    }

    /// Standard deviation of a coefficient for a walk of one unit; its number is the last of the name.
    /// Number 0 is where the walk has come to when a run begins.
    fn term(self, parameter: &str) -> f64 {
        let number = parameter.rsplit('_').next().and_then(|number| number.parse::<u8>().ok());
        match number.unwrap_or(0) {
            0 => (0.5 * self.setup).sqrt(),
            k => (2.0 * self.run).sqrt() / ((f64::from(k) - 0.5) * std::f64::consts::PI),
        }
    }
}

/// An effect of random walks as columns of sines in each run, with a prior if a size is given.
fn columns(effect: &Effect, times: Times, sigma: Option<f64>) -> Option<Effect> {
    let name = format!("{}_columns", effect.name);
    let mut text = format!(
        "name = \"{name}\"\ntitle = \"{}\"\nacts = \"noise\"\n[parameters]\n",
        effect.title
    );
    let mut sums: Vec<(&str, String)> = Vec::new();
    for parameter in &effect.parameters {
        let dimension = parameter.unit.dimension * Dimension::TIME.pow(Exponent::new(1, 2)?);
        let unit = Unit::coherent(dimension).si_symbol();
        let mut sum = Vec::new();
        for k in 0..=TERMS {
            let own = format!("{}_{k}", parameter.name);
            let prior = sigma.map_or_else(String::new, |sigma| {
                let sigma = (sigma * times.term(&own)).max(f64::MIN_POSITIVE);
                format!(", value = \"0 {unit}\", sigma = \"{sigma:e} {unit}\"")
            });
            let line = writeln!(
                text,
                "{own} = {{ unit = \"{unit}\", typical = \"1 {unit}\", scope = \"run\"{prior} }}"
            );
            line.ok()?;
            if k == 0 {
                sum.push(own);
                continue;
            }
            let rate = (k as f64 - 0.5) * std::f64::consts::PI / times.run;
            sum.push(format!("{own} * sin({rate} Hz * run_time)"));
        }
        sums.push((&parameter.name, format!("({})", sum.join(" + "))));
    }
    text.push_str("[patch]\n");
    for line in &effect.patches {
        let formula = replaced(&line.formula.text, &sums);
        writeln!(text, "\"{}\" = '{formula}'", line.name).ok()?;
    }
    Effect::parse(Source::new(name, text)).ok()
}

/// A formula with some of its names replaced.
fn replaced(formula: &str, by: &[(&str, String)]) -> String {
    let mut made = String::new();
    let mut rest = formula;
    while !rest.is_empty() {
        let of_name = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let end = rest.find(|c| !of_name(c)).unwrap_or(rest.len());
        let (name, after) = rest.split_at(end);
        let found = by.iter().find(|(known, _)| *known == name);
        made.push_str(found.map_or(name, |(_, sum)| sum));
        let other = after.chars().next().map_or(0, char::len_utf8);
        made.push_str(&after[..other]);
        rest = &after[other..];
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_replaced_as_wholes() {
        let by = [("walk", "(a + b)".to_owned())];
        let made = replaced("position + [walk, 2 * walk_y, -walk]", &by);
        assert_eq!(made, "position + [(a + b), 2 * walk_y, -(a + b)]");
    }

    #[test]
    fn the_tail_of_equal_weights_is_chi_squared() {
        // Five weights of 2: twice chi squared of five degrees; 1 % beyond 2 * 15.086.
        let found = ln_tail(2.0 * 15.086_27, [10.0, 20.0, 40.0]).exp();
        assert!((found - 0.01).abs() < 1e-6, "{found}");
    }
}
