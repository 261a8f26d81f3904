//! What the uncertainty of a delay is made of: a budget after the GUM (JCGM 100:2008, 5.1 and
//! H.1.7).
//!
//! For each measurand, of the delay of one reading (root mean square over the solved ones) and of
//! the weighted mean of all, in seconds:
//!
//! | part | contribution | of one reading |
//! |---|---|---|
//! | random | the reading itself | `σ / m'` |
//! | random | an input's noise and resolution, the timing chain, random effects | `s g / m'` |
//! | common | prior knowledge k (a certificate) | `√(J Σ_k Jᵀ) / m'`, `Σ_k = Σ c_k c_kᵀ Σ` |
//! | common | the transformation: all else that the fit left open | `√(J (Σ - Σ_k Σ_k) Jᵀ) / m'` |
//! | common | what an input's calibration leaves open | [`crate::estimate::systematic`] |
//!
//! `c_k` is the whitened row of prior knowledge, so that the parts add up to Σ exactly: squares add
//! up to those of the delays. The random part of a mean shrinks with the number of readings, the
//! common part does not. Degrees of freedom are those that certificates state.

use std::convert::Infallible;

use nalgebra::{DMatrix, DVector};

use crate::campaign::load::Campaign;
use crate::campaign::timing::chain::Link;
use crate::campaign::timing::enter::EFFECT;
use crate::engine::noise::active_randoms;
use crate::engine::problem::Problem;
use crate::estimate::coverage::Combined;
use crate::estimate::delays::Delays;
use crate::estimate::differences::{Differences, boundary};
use crate::estimate::median::Median;
use crate::estimate::newton::{ReadingDelay, State};
use crate::estimate::systematic::{Sensitivities, Systematic, Widening};
use crate::estimate::transformation::Transformation;

/// One line of a budget.
#[derive(Clone, Debug, PartialEq)]
pub struct Contribution {
    /// Where it is from: `reading`, `transformation`, `encoder`, `input`, `timing`, `parameter` or
    /// `effect`.
    pub source: &'static str,
    /// Its name: `arm_angle.resolution`, `timing.edge`, `radius`.
    pub name: String,
    /// The same for all readings, else new in every sample.
    pub is_common: bool,
    /// In the delay of one reading (s), root mean square.
    pub reading: f64,
    /// In the mean delay (s).
    pub mean: f64,
    /// Degrees of freedom stated for it.
    pub degrees_of_freedom: Option<f64>,
}

/// The budget of one measurand's delays.
#[derive(Clone, Debug)]
pub struct Budget {
    /// The measurand.
    pub measurand: String,
    /// Its lines, the largest of one reading first.
    pub contributions: Vec<Contribution>,
    /// One reading.
    pub reading: Combined,
    /// The mean.
    pub mean: Combined,
    /// The seed's way beside the exact one.
    pub differences: Option<BothWays>,
}

/// Both ways to the expanded uncertainty of one reading's delay, k = 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BothWays {
    /// The boundary value (SI).
    pub boundary: f64,
    /// Median by differences over 1 ms (s), over the solved readings.
    pub median: f64,
    /// Smallest (s).
    pub smallest: f64,
    /// Median of the exact ones (s).
    pub exact_median: f64,
    /// Smallest (s).
    pub exact_smallest: f64,
    /// Largest ratio of the two, the greater over the smaller.
    pub worst_ratio: f64,
}

/// The budgets of one campaign's delays.
pub fn budgets(transformation: &Transformation, part: usize, campaign: &Campaign) -> Vec<Budget> {
    let problem = transformation.problem();
    let data = &problem.parts[part];
    let point = &transformation.fit().fit.point;
    let names = &data.system.assembly.names.measurands;
    let active = active_randoms(data);
    let boundaries: Vec<Option<f64>> =
        names.iter().map(|one| boundary(transformation.fit(), &one.name)).collect();
    let mut sums = vec![Sums::new(active.len() + 1); names.len()];
    let mut sensitivities = Sensitivities::new(problem, part, point);
    let mut widening = Widening::new(problem, part, point);
    let mut table = Differences::new(problem, part, point);
    let Ok(found) = transformation.delays(part, None, &mut |reading| {
        if reading.state == State::Solved {
            let measurand = reading.measurand;
            let (factor, slopes) = sensitivities.of(reading, &active);
            let own = std::iter::once(data.sigma[measurand] * factor);
            let shared = active.iter().zip(&slopes);
            let shared = shared.map(|(k, slope)| data.random_sigma_in(reading.run, *k) * slope);
            sums[measurand].see(reading, own.chain(shared));
            let exact = widening.see(reading).expanded_uncertainty();
            if let Some(boundary) = boundaries[measurand] {
                sums[measurand].compare(table.expanded(boundary, reading), exact);
            }
        }
        Ok::<_, Infallible>(())
    });
    let common = common_parts(transformation, part);
    let given = Given { problem, part, campaign, active: &active };
    let seen = sums.iter().enumerate().filter(|(_, sums)| sums.count > 0.0);
    seen.map(|(measurand, sums)| {
        let whole = found.measurands.iter().find(|one| one.measurand == names[measurand].name);
        let random = whole.and_then(|one| one.random).unwrap_or(0.0);
        let mut contributions = given.random(measurand, sums, random);
        contributions.extend(given.common(measurand, &common, sums.count));
        contributions.extend(given.calibration(&widening.parts(measurand)));
        contributions.retain(|one| one.reading > 0.0 || one.mean > 0.0);
        contributions.sort_by(|a, b| b.reading.total_cmp(&a.reading));
        let combined = |of: fn(&Contribution) -> f64| {
            Combined::of(contributions.iter().map(|one| (of(one), one.degrees_of_freedom)))
        };
        Budget {
            measurand: names[measurand].name.clone(),
            reading: combined(|one| one.reading),
            mean: combined(|one| one.mean),
            differences: boundaries[measurand].and_then(|boundary| sums.both_ways(boundary)),
            contributions,
        }
    })
    .collect()
}

/// Sums over the solved readings of one measurand.
#[derive(Clone, Debug)]
struct Sums {
    count: f64,
    weights: f64,
    /// For the reading itself and each active random, `Σ u²` and `Σ w² u²`.
    squares: Vec<(f64, f64)>,
    /// By differences and exactly: medians and smallest.
    table: (Median, f64),
    exact: (Median, f64),
    worst_ratio: f64,
}

impl Sums {
    fn new(parts: usize) -> Self {
        let nothing = (Median::default(), f64::INFINITY);
        let (table, exact) = (nothing.clone(), nothing);
        let squares = vec![(0.0, 0.0); parts];
        Self { count: 0.0, weights: 0.0, squares, table, exact, worst_ratio: 1.0 }
    }

    /// Takes a reading; `parts` in the measurand's unit.
    fn see(&mut self, reading: &ReadingDelay, parts: impl Iterator<Item = f64>) {
        let weight = reading.random_at_reference.powi(-2);
        self.count += 1.0;
        self.weights += weight;
        for (sum, sigma) in self.squares.iter_mut().zip(parts) {
            let variance = (sigma / reading.slope).powi(2);
            sum.0 += variance;
            sum.1 += weight * weight * variance;
        }
    }

    fn compare(&mut self, table: f64, exact: f64) {
        for ((median, least), value) in [(&mut self.table, table), (&mut self.exact, exact)] {
            median.see(value);
            *least = least.min(value);
        }
        self.worst_ratio = self.worst_ratio.max(table / exact).max(exact / table);
    }

    fn both_ways(&self, boundary: f64) -> Option<BothWays> {
        Some(BothWays {
            boundary,
            median: self.table.0.value()?,
            smallest: self.table.1,
            exact_median: self.exact.0.value()?,
            exact_smallest: self.exact.1,
            worst_ratio: self.worst_ratio,
        })
    }
}

/// The delays as if a part of the covariance were all of it.
struct CommonPart {
    source: &'static str,
    name: String,
    degrees_of_freedom: Option<f64>,
    delays: Delays,
    /// For each measurand the sum of its squares over the solved readings.
    squares: Vec<f64>,
}

/// The covariance of the transformation's fit taken apart: prior knowledge, parameter by parameter,
/// and the rest.
fn common_parts(transformation: &Transformation, part: usize) -> Vec<CommonPart> {
    let (problem, fit) = (transformation.problem(), transformation.fit());
    let covariance = &fit.covariance;
    let mut rest = transformation.covariance.clone();
    let mut known: Vec<(usize, DMatrix<f64>)> = Vec::new();
    for row in &fit.fit.normal.priors {
        let mut coefficients = DVector::zeros(covariance.nrows());
        for (column, value) in &row.coefficients {
            coefficients[*column] = *value;
        }
        let along = covariance * coefficients;
        let own = transformation.carried(&(&along * along.transpose()));
        rest -= &own;
        let column = row.coefficients.first().map_or(0, |(column, _)| *column);
        let instance = instance_of(problem, column);
        match known.iter_mut().find(|(other, _)| *other == instance) {
            Some((_, sum)) => *sum += own,
            None => known.push((instance, own)),
        }
    }
    let part_of = |source, name: String, degrees_of_freedom, covariance: &DMatrix<f64>| {
        let mut squares = vec![0.0; problem.parts[part].slots().len()];
        let Ok(delays) = transformation.delays(part, Some(covariance), &mut |reading| {
            if reading.state == State::Solved {
                squares[reading.measurand] += reading.common.powi(2);
            }
            Ok::<_, Infallible>(())
        });
        CommonPart { source, name, degrees_of_freedom, delays, squares }
    };
    let mut parts = Vec::with_capacity(known.len() + 1);
    for (instance, covariance) in &known {
        let instance = &problem.layout.instances[*instance];
        let degrees = instance.setting.degrees_of_freedom;
        parts.push(part_of("parameter", instance.name.clone(), degrees, covariance));
    }
    parts.push(part_of("transformation", "transformation".into(), None, &rest));
    parts
}

/// The instance that a column moves.
fn instance_of(problem: &Problem, column: usize) -> usize {
    let layout = &problem.layout;
    let moves = |instance: &usize| {
        (0..layout.instances[*instance].dimension()).any(|component| {
            layout.columns_of(*instance, component).iter().any(|(other, _)| *other == column)
        })
    };
    (0..layout.instances.len()).find(moves).unwrap_or(0)
}

/// What is known of the campaign whose delays they are.
struct Given<'a> {
    problem: &'a Problem,
    part: usize,
    campaign: &'a Campaign,
    active: &'a [usize],
}

/// A standard uncertainty as it is stated, to share out what became of it.
type Share = (&'static str, String, f64, Option<f64>);

impl Given<'_> {
    /// What is new in every sample. What it does to the mean by way of an iterated transformation
    /// is in the mean's random part, which is shared out.
    fn random(&self, measurand: usize, sums: &Sums, random: f64) -> Vec<Contribution> {
        let degrees = self.campaign.measurand_degrees_of_freedom.get(measurand).copied().flatten();
        let shares = std::iter::once(vec![("reading", "reading".to_owned(), 1.0, degrees)])
            .chain(self.active.iter().map(|random| self.shares_of_random(*random)));
        let all: f64 = sums.squares.iter().map(|(_, mean)| mean).sum();
        let squares = sums.squares.iter().zip(shares);
        squares
            .flat_map(|((single, mean), shares)| {
                let mean = random * (mean / all).sqrt();
                shared_out(shares, (single / sums.count).sqrt(), mean, false)
            })
            .collect()
    }

    /// What a random quantity is made of.
    fn shares_of_random(&self, random: usize) -> Vec<Share> {
        let system = &self.problem.parts[self.part].system;
        let setting = &system.randoms[random];
        let inputs = &system.assembly.names.inputs;
        if let Some(input) = inputs.iter().position(|input| input.error == Some(random)) {
            let name = &inputs[input].name;
            let source = source_of_input(name);
            let spread = self.campaign.input_spread.get(input).copied().unwrap_or_default();
            let resolution = spread.resolution.map(|step| step / 12.0_f64.sqrt());
            return [("noise", spread.noise), ("resolution", resolution)]
                .into_iter()
                .filter_map(|(what, sigma)| Some((source, format!("{name}.{what}"), sigma?, None)))
                .collect();
        }
        match self.chain(setting.effect.as_deref() == Some(EFFECT), false) {
            Some(links) => links,
            None => vec![("effect", setting.name.clone(), 1.0, None)],
        }
    }

    /// The links of the timing chain, if that is what is asked for.
    fn chain(&self, is_timing: bool, is_common: bool) -> Option<Vec<Share>> {
        let timing = self.campaign.timing.as_ref().filter(|_| is_timing)?;
        let links = timing.chain(self.campaign.entries.iter().map(|entry| &entry.timing));
        let share = |link: Link| {
            let degrees = link.spread.degrees_of_freedom;
            ("timing", format!("timing.{}", link.name), link.spread.sigma, degrees)
        };
        Some(links.into_iter().filter(|link| link.is_common == is_common).map(share).collect())
    }

    /// What the fit left open.
    fn common(&self, measurand: usize, parts: &[CommonPart], count: f64) -> Vec<Contribution> {
        let name = &self.problem.parts[self.part].system.assembly.names.measurands[measurand].name;
        let mut found = Vec::new();
        for part in parts {
            let mut summaries = part.delays.measurands.iter();
            let summary = summaries.find(|summary| summary.measurand == *name);
            let mean = summary.and_then(|summary| summary.common).unwrap_or(0.0);
            let single = (part.squares[measurand] / count).sqrt();
            let is_timing = part.name.split('.').next() == Some(EFFECT);
            let shares = self.chain(is_timing, true).unwrap_or_else(|| {
                vec![(part.source, part.name.clone(), 1.0, part.degrees_of_freedom)]
            });
            found.extend(shared_out(shares, single, mean, true));
        }
        found
    }

    /// What calibration leaves open.
    fn calibration(&self, parts: &[Systematic]) -> Vec<Contribution> {
        let inputs = &self.problem.parts[self.part].system.assembly.names.inputs;
        let line = |one: &Systematic| {
            let name = &inputs[one.input].name;
            let spread = self.campaign.input_spread[one.input].calibration;
            Contribution {
                source: source_of_input(name),
                name: format!("{name}.calibration"),
                is_common: true,
                reading: one.reading,
                mean: one.mean,
                degrees_of_freedom: spread.and_then(|spread| spread.degrees_of_freedom),
            }
        };
        parts.iter().map(line).collect()
    }
}

/// An angle of the rig is read by an encoder.
fn source_of_input(name: &str) -> &'static str {
    if matches!(name, "arm_angle" | "platform_angle") { "encoder" } else { "input" }
}

/// One contribution shared out, by variance, among what it is made of.
fn shared_out(shares: Vec<Share>, reading: f64, mean: f64, is_common: bool) -> Vec<Contribution> {
    let all = shares.iter().map(|(_, _, sigma, _)| *sigma).fold(0.0, f64::hypot);
    let one = |(source, name, sigma, degrees_of_freedom): Share| {
        let part = if all > 0.0 { sigma / all } else { 0.0 };
        Contribution {
            source,
            name,
            is_common,
            reading: part * reading,
            mean: part * mean,
            degrees_of_freedom,
        }
    };
    shares.into_iter().map(one).collect()
}
