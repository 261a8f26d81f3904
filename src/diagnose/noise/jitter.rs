//! Random quantities that the readings of one sample share: jitter of time stamps, steps of an
//! encoder.
//!
//! They show in the products of different readings of a sample: with whitened derivatives `a` the
//! sum of `a_m a_n z_m z_n` over pairs has mean `s² Σ (a_m a_n)²` and, without the effect, the
//! variance `Σ (a_m a_n z_m z_n)²`, whatever the levels of the single readings are. So neither a
//! wrong level nor a wild reading is taken for jitter. A model with a single reading a sample shows
//! none. What shows in one part of the runs alone, as what swings from their beginning on until it
//! has come to rest, or in one run, as where a logged stream stood still, is no jitter.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::fitted::rebuilt;
use crate::diagnose::found::NoiseEffect;
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::stage::Stage;
use crate::engine::noise::{active_randoms, covariance_of};
use crate::engine::stretches::Left;
use crate::engine::{Part, Problem};
use crate::model::Process;
use crate::statistics::ln_normal;
use crate::system::RandomSetting;
use crate::units::Unit;

use super::variances::own_randoms;

/// Relative difference below which two effects explain the same.
const SAME: f64 = 0.01;
/// Samples looked at at most.
const MOST_SAMPLES: usize = 20_000;

/// A standard deviation with its standard uncertainty.
struct Size {
    value: f64,
    sigma: f64,
}

/// The random quantity shared by the readings of a sample that shows best, if any does, and is not
/// in the model yet: an effect that is one with what is there (`known`, or the campaigns' own) is
/// not named beside it. `alike` is the part of the samples that counts where neighbours are alike.
pub(super) fn jitter<'s>(
    stage: &'s Stage,
    left: &[Left],
    level: f64,
    alike: f64,
    known: &[NoiseEffect],
) -> Option<(NoiseEffect, &'s Candidate)> {
    let mut found: Vec<Found<'s>> = Vec::new();
    let named = known.iter().map(|one| one.parameter.clone());
    for name in named.chain(own_randoms(stage, known)) {
        let own = |_, part: &Part| Some(part.clone());
        let pairs = pairs(stage, left, &own, &name);
        found.extend(pairs.map(|pairs| Found { of: Of::Model, pairs }));
    }
    for candidate in &stage.noise {
        for (name, unit) in white_randoms(candidate) {
            let with = |p: usize, part: &Part| {
                let system = candidate.systems[p].as_deref()?;
                // An effect that is random through and through has no parameters of its own.
                let random = system.settings.len() == part.system.settings.len();
                random.then(|| rebuilt(part, system.clone()))
            };
            let pairs = pairs(stage, left, &with, &name);
            let of = Of::Candidate(candidate, name, unit);
            found.extend(pairs.map(|pairs| Found { of, pairs }));
        }
    }
    found.retain(|one| one.pairs.ln_p(alike) <= level && one.pairs.whole().sum > 0.0);
    found.retain(|one| one.pairs.is_all_along());
    let most = found.iter().map(|one| one.pairs.explained()).fold(0.0, f64::max);
    found.retain(|one| one.pairs.explained() >= most * (1.0 - SAME));
    // Of those that look the same the one that is there, else the one whose usual size is nearest.
    found.sort_by(|a, b| a.strange().total_cmp(&b.strange()));
    let same = found.iter().skip(1).filter_map(|one| match &one.of {
        Of::Candidate(candidate, ..) => Some(candidate.name.clone()),
        Of::Model => None,
    });
    let mut aliases: Vec<String> = same.collect();
    aliases.dedup();
    let Found { of, pairs } = found.into_iter().next()?;
    let Of::Candidate(candidate, parameter, unit) = of else { return None };
    let size = pairs.size();
    aliases.retain(|one| *one != candidate.name);
    let effect = NoiseEffect {
        selected: Some(candidate.selected.clone()),
        name: candidate.name.clone(),
        parameter,
        of: None,
        unit,
        value: size.value,
        sigma: size.sigma,
        also: Vec::new(),
        aliases,
        memory: None,
        ln_p: pairs.ln_p(alike),
    };
    Some((effect, candidate))
}

/// Whose random quantity.
enum Of<'s> {
    /// One that is in the model already.
    Model,
    /// That of a candidate, by its name and unit.
    Candidate(&'s Candidate, String, Unit),
}

/// A random quantity with what shows of it.
struct Found<'s> {
    of: Of<'s>,
    pairs: Pairs,
}

impl Found<'_> {
    /// How far its size is from the usual one.
    fn strange(&self) -> f64 {
        match self.of {
            Of::Model => -1.0,
            Of::Candidate(..) => (self.pairs.size().value / self.pairs.typical).ln().abs(),
        }
    }
}

/// The random quantities of an effect that are independent from sample to sample.
pub(in crate::diagnose) fn white_randoms(candidate: &Candidate) -> Vec<(String, Unit)> {
    let Some(system) = candidate.systems.iter().flatten().next() else { return Vec::new() };
    let name = &candidate.name;
    let own = |effect: &Option<String>| effect.as_ref().is_some_and(|own| own == name);
    system
        .randoms
        .iter()
        .filter(|random| own(&random.effect) && random.process == Process::White)
        .map(|random| (random.name.clone(), random.unit.clone()))
        .collect()
}

impl Pairs {
    /// Those of so many runs.
    fn new(runs: usize) -> Self {
        Self { parts: [Sums::default(); PARTS], runs: vec![Sums::default(); runs], typical: 1.0 }
    }

    /// Those of all parts of the runs.
    fn whole(&self) -> Sums {
        let mut all = Sums::default();
        self.parts.iter().for_each(|one| all.add(*one));
        all
    }

    /// Logarithm of the probability of such products by chance.
    fn ln_p(&self, alike: f64) -> f64 {
        let Sums { sum, scatter, .. } = self.whole();
        ln_normal(sum / scatter.sqrt() * alike.sqrt())
    }

    /// Whether it may be as large without any one part of the runs, and without any one run.
    fn is_all_along(&self) -> bool {
        let whole = self.whole();
        let variance = whole.sum / whole.weights;
        self.parts.iter().chain(&self.runs).all(|one| {
            let weights = whole.weights - one.weights;
            let scatter = (whole.scatter - one.scatter).max(0.0);
            let most = whole.sum - one.sum + DEVIATIONS * scatter.sqrt();
            weights <= ROUNDING * whole.weights || most >= ALL_ALONG * variance * weights
        })
    }

    /// What it takes off the sum of squares.
    fn explained(&self) -> f64 {
        let Sums { sum, weights, .. } = self.whole();
        0.5 * sum * sum / weights
    }

    /// The standard deviation that they show.
    fn size(&self) -> Size {
        let Sums { sum, weights, scatter } = self.whole();
        let value = (sum / weights).sqrt();
        Size { value, sigma: 0.5 * scatter.sqrt() / (weights * value) }
    }
}

impl Sums {
    /// Those of a sample: of its whitened residuals (NaN where there is no reading), the covariance
    /// that whitened them, and the derivatives that are not whitened yet.
    fn of(z: &[f64], covariance: DMatrix<f64>, g: &DVector<f64>) -> Self {
        let mut own = Self::default();
        let whitened = covariance.cholesky().and_then(|by| by.l_dirty().solve_lower_triangular(g));
        let Some(a) = whitened else { return own };
        for m in 0..z.len() {
            for n in 0..m {
                let (product, weight) = (z[m] * z[n], a[m] * a[n]);
                if product.is_finite() {
                    own.sum += weight * product;
                    own.weights += weight * weight;
                    own.scatter += (weight * product).powi(2);
                }
            }
        }
        own
    }

    /// Adds others.
    fn add(&mut self, other: Self) {
        self.sum += other.sum;
        self.weights += other.weights;
        self.scatter += other.scatter;
    }
}

/// Parts of each run that are compared.
const PARTS: usize = 8;
/// Part of the variance that must be there without any of them, and standard deviations that it may
/// be off.
const ALL_ALONG: f64 = 0.6;
const DEVIATIONS: f64 = 2.0;
/// A part of all weights that is none.
const ROUNDING: f64 = 1e-9;

/// Sums over pairs of readings of a sample, by parts of the runs and by runs.
struct Pairs {
    parts: [Sums; PARTS],
    runs: Vec<Sums>,
    /// The usual size of the effect.
    typical: f64,
}

/// Those of one part.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// `Σ a_m a_n z_m z_n`.
    sum: f64,
    /// `Σ (a_m a_n)²`.
    weights: f64,
    /// `Σ (a_m a_n z_m z_n)²`: the variance of the sum, wild readings or not.
    scatter: f64,
}

/// One sample of so many is looked at.
pub(in crate::diagnose) fn stride(problem: &Problem) -> usize {
    let runs = problem.parts.iter().flat_map(|part| &part.runs);
    runs.map(|run| run.record.len()).sum::<usize>().div_ceil(MOST_SAMPLES).max(1)
}

/// The sums over all campaigns that have the random quantity of a name; `with` gives a campaign's
/// model with it.
fn pairs(
    stage: &Stage,
    left: &[Left],
    with: &dyn Fn(usize, &Part) -> Option<Part>,
    name: &str,
) -> Option<Pairs> {
    let fitted = &stage.fitted;
    let runs = fitted.problem.parts.iter().map(|part| part.runs.len()).sum();
    let mut pairs = Pairs::new(runs);
    let stride = stride(&fitted.problem);
    for (p, part) in fitted.problem.parts.iter().enumerate() {
        let Some(with) = with(p, part) else { continue };
        let is_it =
            |random: &RandomSetting| random.name == name && random.process == Process::White;
        let Some(k) = with.system.randoms.iter().position(is_it) else { continue };
        pairs.typical = with.system.randoms[k].typical.unwrap_or(1.0);
        let active = active_randoms(part);
        for (run, data) in part.runs.iter().enumerate() {
            let index = fitted.problem.run_index(p, run);
            let residuals = &left[index].residuals;
            let parameters = fitted.problem.parameters(p, run, &fitted.fit.point);
            let mut memory = Vec::new();
            data.record.walk(|stretch| {
                for sample in stretch.each().filter(|sample| sample.number % stride == 0) {
                    let z: Vec<f64> = residuals.iter().map(|row| row[sample.number]).collect();
                    let covariance =
                        covariance_of(part, run, sample, &parameters, &active, &mut memory)
                            .covariance;
                    let slopes = covariance_of(&with, run, sample, &parameters, &[k], &mut memory);
                    let g = slopes.sensitivities.column(0).into_owned();
                    let part = PARTS * sample.number / data.record.len().max(1);
                    let sums = Sums::of(&z, covariance, &g);
                    pairs.parts[part.min(PARTS - 1)].add(sums);
                    pairs.runs[index].add(sums);
                }
            });
        }
    }
    (pairs.whole().scatter > 0.0).then_some(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;

    /// Products of two readings of unit noise that share a draw of this standard deviation in some
    /// samples, of ten runs in turn.
    fn drawn(shared: impl Fn(usize) -> f64) -> Pairs {
        let mut pairs = Pairs::new(10);
        let mut stream = Stream(1);
        let mut normal = || stream.normal();
        for sample in 0..8000 {
            let both = shared(sample) * normal();
            let z = [normal() + both, normal() + both];
            let slopes = DVector::from_vec(vec![1.0, 1.0]);
            let sums = Sums::of(&z, DMatrix::identity(2, 2), &slopes);
            pairs.parts[PARTS * sample / 8000].add(sums);
            pairs.runs[sample % 10].add(sums);
        }
        pairs
    }

    #[test]
    fn what_comes_to_rest_is_no_jitter() {
        let steady = drawn(|_| 0.4);
        assert!(steady.ln_p(1.0) < -20.0 && steady.is_all_along());
        assert!((steady.size().value - 0.4).abs() < 0.05);
        let falling = drawn(|sample| if sample < 4000 { 0.5 } else { 0.3 });
        assert!(falling.is_all_along());
        let at_rest = drawn(|sample| if sample < 800 { 1.2 } else { 0.0 });
        assert!(at_rest.ln_p(1.0) < -20.0 && !at_rest.is_all_along());
        // Where a stream of one run stood still for three samples.
        let still =
            drawn(
                |sample| if sample == 83 || sample == 4703 || sample == 6003 { 30.0 } else { 0.0 },
            );
        assert!(still.whole().sum > 100.0 && !still.is_all_along());
        // What hardly shows is not refused for how it scatters.
        assert!(drawn(|_| 0.15).is_all_along());
    }
}
