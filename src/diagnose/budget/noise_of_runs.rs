//! Runs whose noise differs from that of the others: the likelihood decides, at the price of one value
//! among all runs and measurands.
//!
//! A run of twenty readings has a robust scatter that is known to a quarter; its likelihood is that of all
//! its readings. A few outliers are no noise of a run: they compete with it. Where noise is correlated,
//! has long tails or holds structure, the scatter of all runs differs by more than chance gives: whether
//! one of them is apart is judged by gains that are divided by how much more.

use std::collections::BTreeMap;
use std::ops::{Add, Sub};

use super::autocorrelation::Component;
use super::linear::Linear;
use super::noise::Components;
use crate::diagnose::price::{Gain, ln_bayes_factor, price};
use crate::diagnose::thresholds::{ENTER, NOISE, NOISE_OF_A_RUN, TIE};
use crate::statistics::{robust, upper_median};

/// Noise of a run: campaign, run in it, measurand in it, factor on the noise of the others.
pub type OfRun = (usize, usize, usize, f64);

/// Readings of a run of which the noise is judged at least.
const LEAST_OF_RUN: usize = 10;
/// Standard deviations of the mean gain of the other runs that chance may give.
const CHANCE: f64 = 2.0;
/// Outliers that compete with the noise of a run.
const MOST_FAR: usize = 3;

/// Number and sum of the squares of residuals.
#[derive(Clone, Copy, Debug, Default)]
struct Squares {
    count: f64,
    sum: f64,
}

/// The residuals of a run.
#[derive(Clone, Copy, Debug)]
struct Run {
    all: Squares,
    /// The squares of the farthest.
    far: [f64; MOST_FAR],
}

impl Add for Squares {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { count: self.count + other.count, sum: self.sum + other.sum }
    }
}

impl Sub for Squares {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { count: self.count - other.count, sum: self.sum - other.sum }
    }
}

impl Squares {
    fn variance(self) -> f64 {
        self.sum / self.count
    }

    /// Log likelihood under noise of their own, but for a constant.
    fn ln_likelihood(self) -> f64 {
        -0.5 * self.count * self.variance().ln()
    }

    /// Twice the log likelihood ratio of noise of their own against that of others.
    fn gain(self, others: Self) -> f64 {
        let all = (self + others).ln_likelihood();
        2.0 * (self.ln_likelihood() + others.ln_likelihood() - all)
    }

    /// Whether the noise differs by as much as matters from one of this variance.
    fn is_apart(self, usual: f64) -> bool {
        0.5 * (self.variance() / usual).ln().abs() > NOISE_OF_A_RUN.ln()
    }
}

impl Run {
    /// Of the sizes of its residuals, without what is left out anyway; `None` of few, and where half of
    /// them are zero, such as those of counts, so that their scatter is not known.
    fn of(sizes: &[f64]) -> Option<Self> {
        let deviation = robust(sizes).filter(|one| sizes.len() >= LEAST_OF_RUN && *one > 0.0)?;
        let kept = sizes.iter().filter(|size| **size <= NOISE * deviation);
        let mut squares: Vec<f64> = kept.map(|size| size * size).collect();
        squares.sort_by(|a, b| b.total_cmp(a));
        let far = *squares.first_chunk()?;
        Some(Self { all: Squares { count: squares.len() as f64, sum: squares.iter().sum() }, far })
    }

    /// The log Bayes factor of a few outliers in the place of noise of its own, beside other runs.
    fn ln_bayes_of_outliers(&self, others: Squares) -> f64 {
        let all = self.all + others;
        let (mut left, mut choices, mut best) = (all, 1_usize, f64::NEG_INFINITY);
        for (at, square) in self.far.iter().enumerate() {
            left = left - Squares { count: 1.0, sum: *square };
            choices = choices.saturating_mul(all.count as usize) / (at + 1);
            let gain = all.count * (all.variance() / left.variance()).ln();
            best = best.max(ln_bayes_factor(Gain { gain, degrees: at + 1 }, choices, 1));
        }
        best
    }
}

/// Runs whose noise differs from the others', and by how much their own factors raise the log likelihood,
/// less their price.
pub fn noise_of_runs(linear: &Linear, components: &Components) -> (f64, Vec<OfRun>) {
    let mut by_measurand: BTreeMap<(usize, usize), Vec<&Component>> = BTreeMap::new();
    for ((part, measurand, _), runs) in components {
        by_measurand.entry((*part, *measurand)).or_default().push(runs);
    }
    let measurands = by_measurand.len();
    let (mut gained, mut found) = (0.0, Vec::new());
    for ((part, measurand), components) in by_measurand {
        let mut sizes: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for (run, values) in components.into_iter().flatten() {
            sizes.entry(*run).or_default().extend(values.iter().map(|(.., value)| value.abs()));
        }
        let of_run = |(run, sizes): (&usize, &Vec<f64>)| Some((*run, Run::of(sizes)?));
        let runs: BTreeMap<usize, Run> = sizes.iter().filter_map(of_run).collect();
        let (own_gain, own) = own_noise(&runs, measurands);
        gained += own_gain;
        let first = linear.sums.first_measurand[part];
        let of_part = |run| linear.fitted.problem.run_at(run).1;
        let own = own.into_iter().map(|(run, by)| (part, of_part(run), measurand - first, by));
        found.extend(own);
    }
    (gained, found)
}

/// Of the runs of one of so many measurands those whose noise is their own, with its factor, and what these
/// gain together.
fn own_noise(runs: &BTreeMap<usize, Run>, measurands: usize) -> (f64, Vec<(usize, f64)>) {
    let of_gain = |gain: f64| Gain { gain, degrees: 1 };
    let ln_bayes = |gain| ln_bayes_factor(of_gain(gain), runs.len(), measurands);
    let mut variances: Vec<f64> = runs.values().map(|one| one.all.variance()).collect();
    // Of two runs the quieter one is as usual.
    let usual = match variances[..] {
        [one, other] => Some(one.min(other)),
        _ => upper_median(&mut variances),
    };
    let Some(usual) = usual.filter(|_| runs.len() > 1) else { return (0.0, Vec::new()) };
    let may_be = |one: &Run| {
        let ratio = one.all.variance() / usual;
        one.all.is_apart(usual) && ln_bayes(one.all.count * (ratio - 1.0 - ratio.ln())) >= ENTER
    };
    let (mut own, others): (Vec<_>, Vec<_>) = runs.iter().partition(|(_, one)| may_be(one));
    if own.is_empty() || own.len() > others.len() {
        return (0.0, Vec::new());
    }
    let sum = |runs: &[(&usize, &Run)]| runs.iter().fold(Squares::default(), |a, b| a + b.1.all);
    let rest = sum(&others);
    // Of each of the others the mean is 1 where nothing but chance makes them differ.
    let count = others.len() as f64;
    let apart = others.iter().filter(|_| others.len() > 1);
    let gains: f64 = apart.map(|(_, one)| one.all.gain(rest - one.all)).sum();
    let by_chance = 1.0 + CHANCE * (2.0 / count).sqrt();
    let beyond_chance = (gains / count / by_chance).max(1.0);
    own.retain(|(_, one)| {
        let gain = one.all.gain(rest);
        let is_own = ln_bayes(gain / beyond_chance) >= ENTER;
        let is_noise = ln_bayes(gain) > one.ln_bayes_of_outliers(rest) + TIE;
        one.all.is_apart(rest.variance()) && is_own && is_noise
    });
    let prices = own.iter().map(|one| price(of_gain(one.1.all.gain(rest)), runs.len(), measurands));
    let own_likelihood: f64 = own.iter().map(|one| one.1.all.ln_likelihood()).sum();
    let all = (rest + sum(&own)).ln_likelihood();
    let gained = rest.ln_likelihood() + own_likelihood - all - prices.sum::<f64>();
    let factor = |(run, one): (&usize, &Run)| (*run, (one.all.variance() / rest.variance()).sqrt());
    (gained, own.into_iter().map(factor).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs of residuals that are normal as nearly as so few can be, of these standard deviations.
    fn runs(deviations: &[f64]) -> BTreeMap<usize, Run> {
        let normal = [0.06, 0.18, 0.31, 0.43, 0.57, 0.71, 0.87, 1.05, 1.27, 1.55, 2.07];
        let sizes = |by: &f64| [normal, normal].concat().iter().map(|one| by * one).collect();
        let all = deviations.iter().map(sizes);
        all.filter_map(|sizes: Vec<f64>| Run::of(&sizes)).enumerate().collect()
    }

    #[test]
    fn one_run_of_many_has_noise_of_its_own() {
        let (gained, own) = own_noise(&runs(&[1.0, 0.9, 1.1, 2.5, 1.0, 0.95]), 1);
        assert!(gained > ENTER && own.len() == 1 && own[0].0 == 3, "{gained} {own:?}");
        assert!((own[0].1 - 2.5).abs() < 0.05, "{own:?}");
        assert!(own_noise(&runs(&[1.0, 0.9, 1.1, 1.5, 1.0, 0.95]), 1).1.is_empty());
    }

    /// Noise that is slow has another scatter in each run.
    #[test]
    fn runs_that_all_differ_have_no_noise_of_their_own() {
        assert!(own_noise(&runs(&[1.0, 0.6, 1.6, 2.5, 0.7, 1.4, 0.5]), 1).1.is_empty());
    }

    /// Two outliers of 6 standard deviations, which a robust scatter of few readings may leave among the others.
    #[test]
    fn outliers_are_no_noise_of_a_run() {
        let mut all = runs(&[1.0; 8]);
        let far = [36.0, 33.6, 4.3];
        let sum = all[&3].all.sum + far[0] + far[1] - 2.0 * 4.3;
        let bent = Run { all: Squares { sum, ..all[&3].all }, far };
        assert!(bent.all.gain(Squares { count: 154.0, sum: 158.0 }) > 22.0);
        all.insert(3, bent);
        assert!(own_noise(&all, 1).1.is_empty());
        assert!(Run::of(&[0.0; 30]).is_none());
    }
}
