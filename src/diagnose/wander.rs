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

use nalgebra::linalg::SymmetricTridiagonal;
use nalgebra::{DMatrix, DVector};

use crate::diagnostic::Source;
use crate::effect::Effect;
use crate::engine::Problem;
use crate::model::Process;
use crate::system::Selected;
use crate::units::{Dimension, Exponent, Unit};

use super::candidates::{Candidate, join};
use super::displaced::{Displaced, Suspect};
use super::evidence::{Entry, Evidence, Owner, Projected};
use super::memory::likelihood_of_memory;
use super::score::of_gain;
use super::stage::Stage;
use super::tail::ln_gamma_tail;
use super::whiten::{NoiseEffect, sequences};

/// Sines of each run: 93 % of a walk's variance.
const TERMS: usize = 3;
/// Cuts in search of a variance.
const POLISH: usize = 16;

/// A walk that was found.
pub(super) struct Found {
    pub(super) effect: NoiseEffect,
    /// The logarithm of its likelihood ratio against white noise of unit variance, a memory of what it
    /// leaves included.
    pub(super) likelihood: f64,
    /// The displacements that do for it, if it is no walk.
    pub(super) displaced: Option<Displaced>,
}

/// The walk of the library that shows, if one does. `level` is the logarithm of its share of the false
/// alarms.
pub(super) fn walk(stage: &Stage, level: f64) -> Option<Found> {
    let mut best: Option<Found> = None;
    for candidate in &stage.noise {
        let effect = &candidate.selected.effect;
        let walks = !effect.parameters.is_empty()
            && effect.parameters.iter().all(|one| one.process == Process::Walk);
        if !walks {
            continue;
        }
        let Some(found) = tested(stage, candidate, level) else { continue };
        if best.as_ref().is_none_or(|known| found.likelihood > known.likelihood) {
            best = Some(found);
        }
    }
    best
}

fn tested(stage: &Stage, candidate: &Candidate, level: f64) -> Option<Found> {
    let walking = &candidate.selected.effect;
    let times = Times::of(&stage.fitted.problem);
    let of = |sigma| Some(select(candidate, columns(walking, times, sigma)?));
    let selected: Selected = of(None)?;
    let recipes = &stage.fitted.recipes;
    let mut made = Vec::new();
    for (campaign, recipe) in recipes.iter().enumerate() {
        if let Ok(system) = recipe.with(std::slice::from_ref(&selected)) {
            join(&mut made, (campaign, recipes.len()), selected.clone(), None, system);
        }
    }
    let columns = made.pop()?;
    let structures = stage.structures_beside_noise();
    let mut all: Vec<&Candidate> = structures.iter().map(|n| &stage.candidates[*n]).collect();
    all.push(&columns);
    let fit = &stage.fitted.fit;
    let (evidence, own) = Evidence::beside(&stage.fitted.problem, &fit.normal, &fit.point, &all)?;
    let owners = own.owners();
    let weights = DVector::from_fn(owners.len(), |k, _| times.term(&owners[k].parameter));
    let acts = own.left.trace() > 0.0;
    if !acts || ln_plain(&own, &weights) > level {
        return None;
    }
    let entries: Vec<&Entry> = evidence.entries.iter().collect();
    // Structure is taken off only as long as it is more than the walk would make of it.
    let (mut walk, mut known) = (None, 0);
    while known <= entries.len() {
        let whole = evidence.together(&entries[..known]);
        let beyond = Walk::beyond(&evidence, &whole, &own, &weights)?;
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
    let taken = known.min(entries.len());
    let begins = |owner: &Owner| number_of(&owner.parameter) == 0;
    let displaced = Suspect {
        evidence: &evidence,
        known: &entries[..taken],
        own: &own,
        weights: &weights,
        begins,
        likelihood: walk.likelihood(),
        level,
    }
    .displaced(&stage.fitted.problem);
    let (variance, spread) = walk.variance();
    let sigma = variance.sqrt();
    let parameter = walking.parameters.first()?;
    let mut taken: Vec<&Entry> = entries[..taken].to_vec();
    let own = Entry::of(own);
    taken.push(&own);
    let rest = evidence.together(&taken);
    let (problem, point) = (&stage.fitted.problem, &fit.point);
    let rest = sequences(problem, &evidence.left(problem, point, &rest, usize::MAX));
    let likelihood = walk.likelihood() + likelihood_of_memory(&rest);
    let effect = NoiseEffect {
        name: candidate.name.clone(),
        selected: of(Some(sigma)),
        parameter: format!("{}.{}", candidate.name, parameter.name),
        unit: parameter.unit.clone(),
        value: sigma,
        sigma: if sigma > 0.0 { spread / (2.0 * sigma) } else { 0.0 },
        aliases: Vec::new(),
        memory: None,
        ln_p: walk.ln_p(),
    };
    Some(Found { effect, likelihood, displaced })
}

/// Scores of a walk's coefficients, each divided by its share of the walk, in a basis in which their
/// covariance without a walk has three diagonals: all that is asked of it then takes one pass along them.
pub(super) struct Walk {
    diagonal: DVector<f64>,
    beside: DVector<f64>,
    scores: DVector<f64>,
}

/// What a variance of the walk makes of the scores `s` with their covariance `M`.
struct Weighed {
    /// `sᵀ (1 + v M)⁻¹ s`.
    square: f64,
    /// `ln det (1 + v M)`.
    ln_determinant: f64,
    /// `tr (M (1 + v M)⁻¹)²`, the negative second derivative of that.
    curvature: f64,
}

impl Walk {
    /// Beyond the nominal parameters and something known.
    pub(super) fn beyond(
        evidence: &Evidence,
        known: &Entry,
        own: &Projected,
        weights: &DVector<f64>,
    ) -> Option<Self> {
        let shared = evidence.shared(known, own);
        let scores = (&own.score - shared.tr_mul(&known.score)).component_mul(weights);
        let covariance = weighted(&own.left - shared.tr_mul(&shared), weights);
        if !covariance.iter().chain(scores.iter()).all(|value| value.is_finite()) {
            return None;
        }
        let (basis, diagonal, beside) = SymmetricTridiagonal::new(covariance).unpack();
        let acts = diagonal.sum() > 0.0;
        acts.then(|| Self { scores: basis.tr_mul(&scores), diagonal, beside })
    }

    /// The traces of the first three powers of the covariance.
    fn powers(&self) -> [f64; 3] {
        let mut powers = [self.diagonal.sum(), self.diagonal.norm_squared(), 0.0];
        powers[2] = self.diagonal.iter().map(|one| one.powi(3)).sum();
        for (k, beside) in self.beside.iter().enumerate() {
            powers[1] += 2.0 * beside.powi(2);
            powers[2] += 3.0 * beside.powi(2) * (self.diagonal[k] + self.diagonal[k + 1]);
        }
        powers
    }

    /// Logarithm of the probability of such scores without a walk.
    pub(super) fn ln_p(&self) -> f64 {
        ln_tail(self.scores.norm_squared(), self.powers())
    }

    /// The pivots of `1 + v M` one after the other, with their first two derivatives along `v`.
    fn weighed(&self, variance: f64) -> Weighed {
        let mut weighed = Weighed { square: 0.0, ln_determinant: 0.0, curvature: 0.0 };
        let (mut pivot, mut score) = ([1.0, 0.0, 0.0], 0.0);
        for (k, diagonal) in self.diagonal.iter().enumerate() {
            let beside = if k > 0 { self.beside[k - 1] } else { 0.0 };
            let [last, slope, bend] = pivot;
            score = self.scores[k] - variance * beside / last * score;
            // What is taken off: (v b)² / last.
            let taken = (variance * beside).powi(2) / last;
            let along = (2.0 * variance * beside.powi(2) - taken * slope) / last;
            let bent = (2.0 * beside.powi(2) - 2.0 * along * slope - taken * bend) / last;
            pivot = [1.0 + variance * diagonal - taken, diagonal - along, -bent];
            weighed.square += score * score / pivot[0];
            weighed.ln_determinant += pivot[0].ln();
            weighed.curvature += (pivot[1] / pivot[0]).powi(2) - pivot[2] / pivot[0];
        }
        weighed
    }

    /// Logarithm of the likelihood ratio of a walk of some variance.
    fn likelihood_at(&self, variance: f64) -> f64 {
        let Weighed { square, ln_determinant, .. } = self.weighed(variance);
        0.5 * variance * square - 0.5 * ln_determinant
    }

    /// The variance of largest likelihood: the best of a grid, polished by cutting off thirds.
    fn best(&self) -> f64 {
        let typical = 1.0 / self.diagonal.max();
        let at = |logarithm: f64| typical * logarithm.exp();
        let step = 0.5;
        // What is taken up is rounding, and may be less than nothing where a walk is very strong.
        let grid = (-16..32)
            .map(|k| step * f64::from(k))
            .filter(|k| self.likelihood_at(at(*k)).is_finite());
        let better =
            |a: &f64, b: &f64| self.likelihood_at(at(*a)).total_cmp(&self.likelihood_at(at(*b)));
        let best = grid.max_by(better).unwrap_or(0.0);
        let (mut low, mut high) = (best - step, best + step);
        for _ in 0..POLISH {
            let third = (high - low) / 3.0;
            if better(&(low + third), &(high - third)).is_lt() {
                low += third;
            } else {
                high -= third;
            }
        }
        at(0.5 * (low + high))
    }

    /// Logarithm of the largest likelihood ratio.
    fn likelihood(&self) -> f64 {
        self.likelihood_at(self.best())
    }

    /// The variance of a walk of one unit, and its standard uncertainty (Fisher's information).
    fn variance(&self) -> (f64, f64) {
        let variance = self.best();
        let information = 0.5 * self.weighed(variance).curvature;
        (variance, information.sqrt().recip())
    }
}

/// Logarithm of the probability of scores by chance with nothing else known, without their axes: of most
/// campaigns that is all one needs.
fn ln_plain(own: &Projected, weights: &DVector<f64>) -> f64 {
    let matrix = weighted(own.left.clone(), weights);
    let third = (&matrix * &matrix).component_mul(&matrix).sum();
    let square = own.score.component_mul(weights).norm_squared();
    ln_tail(square, [matrix.trace(), matrix.norm_squared(), third])
}

/// Rows and columns of a matrix times the share of each in the walk.
fn weighted(mut matrix: DMatrix<f64>, weights: &DVector<f64>) -> DMatrix<f64> {
    for (mut column, weight) in matrix.column_iter_mut().zip(weights.iter()) {
        column.component_mul_assign(weights);
        column *= *weight;
    }
    matrix
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
        match number_of(parameter) {
            0 => (0.5 * self.setup).sqrt(),
            k => (2.0 * self.run).sqrt() / ((f64::from(k) - 0.5) * std::f64::consts::PI),
        }
    }
}

/// The number of a coefficient by its name.
fn number_of(parameter: &str) -> u8 {
    parameter.rsplit('_').next().and_then(|number| number.parse().ok()).unwrap_or(0)
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
    fn three_diagonals_say_what_axes_say() {
        let root =
            DMatrix::from_fn(7, 7, |i, j| ((3 * i + 5 * j) as f64).sin() + f64::from(i == j));
        let matrix = &root * root.transpose();
        let scores = DVector::from_fn(7, |i, _| 1.0 + i as f64);
        let (basis, diagonal, beside) = SymmetricTridiagonal::new(matrix.clone()).unpack();
        let walk = Walk { scores: basis.tr_mul(&scores), diagonal, beside };
        let eigen = nalgebra::SymmetricEigen::new(matrix);
        let along = eigen.eigenvectors.tr_mul(&scores);
        let (values, variance) = (&eigen.eigenvalues, 0.37);
        let sum = |term: &dyn Fn(f64, f64) -> f64| -> f64 {
            values.iter().zip(along.iter()).map(|(value, along)| term(*value, *along)).sum()
        };
        let alike = |a: f64, b: f64| assert!((a - b).abs() < 1e-10 * b.abs(), "{a} {b}");
        let weighed = walk.weighed(variance);
        alike(weighed.square, sum(&|value, along| along * along / (1.0 + variance * value)));
        alike(weighed.ln_determinant, sum(&|value, _| (1.0 + variance * value).ln()));
        alike(weighed.curvature, sum(&|value, _| (value / (1.0 + variance * value)).powi(2)));
        for (order, power) in (1..).zip(walk.powers()) {
            alike(power, sum(&|value, _| value.powi(order)));
        }
        let best = walk.best();
        for by in [0.99, 1.01] {
            assert!(walk.likelihood_at(best) >= walk.likelihood_at(by * best));
        }
    }

    #[test]
    fn the_tail_of_equal_weights_is_chi_squared() {
        // Five weights of 2: twice chi squared of five degrees; 1 % beyond 2 * 15.086.
        let found = ln_tail(2.0 * 15.086_27, [10.0, 20.0, 40.0]).exp();
        assert!((found - 0.01).abs() < 1e-6, "{found}");
    }
}
