//! What the uncertainty of a delay is made of: a budget after the GUM (JCGM 100:2008, 5.1 and H.1.7).
//!
//! For each measurand, of the delay of one reading (root mean square over the solved ones) and of the
//! weighted mean of all, in seconds:
//!
//! | part | contribution | of one reading |
//! |---|---|---|
//! | random | the reading itself | `σ / m'` |
//! | random | an input's noise and resolution, the timing chain, random effects | `s g / m'` |
//! | common | prior knowledge k (a certificate) | `√(J Σ_k Jᵀ) / m'`, `Σ_k = Σ c_k c_kᵀ Σ` |
//! | common | the transformation: all else that the fit left open | `√(J (Σ - Σ_k Σ_k) Jᵀ) / m'` |
//! | common | what an input's calibration leaves open | [`crate::estimate::systematic`] |
//!
//! `c_k` is the whitened row of prior knowledge, so that the parts add up to Σ exactly: squares add up to
//! those of the delays. The random part of a mean shrinks with the number of readings, the common
//! part does not. Degrees of freedom are those that certificates state.

use nalgebra::{DMatrix, DVector};

use crate::campaign::load::Campaign;
use crate::campaign::timing::chain::Link;
use crate::campaign::timing::enter::EFFECT;
use crate::engine::problem::Problem;
use crate::estimate::coverage::Combined;
use crate::estimate::delays::{Delays, median};
use crate::estimate::differences;
use crate::estimate::newton::{ReadingDelay, State};
use crate::estimate::systematic::{self, Sensitivities};
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
    pub differences: Option<Differences>,
}

/// Both ways to the expanded uncertainty of one reading's delay, k = 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
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

/// The budgets of one campaign's delays. `delays` are those of `transformation`.
pub fn budgets(
    transformation: &Transformation<'_>,
    part: usize,
    campaign: &Campaign,
    delays: &Delays,
) -> Vec<Budget> {
    let common = common_parts(transformation, part);
    let problem = transformation.problem();
    let names = &problem.parts[part].system.assembly.names.measurands;
    let mut all = Vec::new();
    for (measurand, declared) in names.iter().enumerate() {
        let is_solved =
            |one: &&ReadingDelay| one.measurand == measurand && one.state == State::Solved;
        let readings: Vec<&ReadingDelay> = delays.readings.iter().filter(is_solved).collect();
        if readings.is_empty() {
            continue;
        }
        let given = Given { transformation, part, campaign, measurand, readings: &readings };
        let mut contributions = given.random();
        contributions.extend(given.common(&common, &declared.name));
        contributions.extend(given.calibration());
        contributions.retain(|one| one.reading > 0.0 || one.mean > 0.0);
        contributions.sort_by(|a, b| b.reading.total_cmp(&a.reading));
        let combined = |of: fn(&Contribution) -> f64| {
            Combined::of(contributions.iter().map(|one| (of(one), one.degrees_of_freedom)))
        };
        all.push(Budget {
            measurand: declared.name.clone(),
            reading: combined(|one| one.reading),
            mean: combined(|one| one.mean),
            differences: given.differences(&declared.name),
            contributions,
        });
    }
    all
}

/// The delays as if a part of the covariance were all of it.
struct CommonPart {
    source: &'static str,
    name: String,
    degrees_of_freedom: Option<f64>,
    delays: Delays,
}

/// The covariance of the transformation's fit taken apart: prior knowledge, parameter by parameter, and
/// the rest.
fn common_parts(transformation: &Transformation<'_>, part: usize) -> Vec<CommonPart> {
    let (problem, fit) = (transformation.problem(), transformation.fit());
    let covariance = &fit.covariance;
    let mut rest = covariance.clone();
    let mut known: Vec<(usize, DMatrix<f64>)> = Vec::new();
    for row in &fit.fit.normal.priors {
        let mut coefficients = DVector::zeros(covariance.nrows());
        for (column, value) in &row.coefficients {
            coefficients[*column] = *value;
        }
        let along = covariance * coefficients;
        let own = &along * along.transpose();
        rest -= &own;
        let column = row.coefficients.first().map_or(0, |(column, _)| *column);
        let instance = instance_of(problem, column);
        match known.iter_mut().find(|(other, _)| *other == instance) {
            Some((_, sum)) => *sum += own,
            None => known.push((instance, own)),
        }
    }
    let instances = &problem.layout.instances;
    let mut parts: Vec<CommonPart> = known
        .into_iter()
        .map(|(instance, covariance)| CommonPart {
            source: "parameter",
            name: instances[instance].name.clone(),
            degrees_of_freedom: instances[instance].setting.degrees_of_freedom,
            delays: transformation.delays(part, Some(&covariance)),
        })
        .collect();
    parts.push(CommonPart {
        source: "transformation",
        name: "transformation".into(),
        degrees_of_freedom: None,
        delays: transformation.delays(part, Some(&rest)),
    });
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

/// The solved readings of one measurand, and what is known of their campaign.
struct Given<'a> {
    transformation: &'a Transformation<'a>,
    part: usize,
    campaign: &'a Campaign,
    measurand: usize,
    readings: &'a [&'a ReadingDelay],
}

/// A standard uncertainty as it is stated, to share out what became of it.
type Share = (&'static str, String, f64, Option<f64>);

impl Given<'_> {
    /// What is new in every sample.
    fn random(&self) -> Vec<Contribution> {
        let data = &self.transformation.problem().parts[self.part];
        let point = &self.transformation.fit().fit.point;
        let active = crate::engine::noise::active_randoms(data);
        let mut squares = vec![(0.0, 0.0); active.len() + 1];
        let mut weights = 0.0;
        let mut sensitivities = Sensitivities::new(self.transformation.problem(), self.part, point);
        for reading in self.readings {
            let (factor, slopes) = sensitivities.of(reading, &active);
            let weight = reading.random_at_reference.powi(-2);
            weights += weight;
            let own = std::iter::once(data.sigma[self.measurand] * factor);
            let shared = active
                .iter()
                .zip(&slopes)
                .map(|(random, slope)| data.random_sigma_in(reading.run, *random) * slope);
            for (sum, sigma) in squares.iter_mut().zip(own.chain(shared)) {
                let variance = (sigma / reading.slope).powi(2);
                sum.0 += variance;
                sum.1 += weight * weight * variance;
            }
        }
        let count = self.readings.len() as f64;
        let degrees =
            self.campaign.measurand_degrees_of_freedom.get(self.measurand).copied().flatten();
        let shares = std::iter::once(vec![("reading", "reading".to_owned(), 1.0, degrees)])
            .chain(active.iter().map(|random| self.shares_of_random(*random)));
        squares
            .iter()
            .zip(shares)
            .flat_map(|((single, mean), shares)| {
                shared_out(shares, (single / count).sqrt(), mean.sqrt() / weights, false)
            })
            .collect()
    }

    /// What a random quantity is made of.
    fn shares_of_random(&self, random: usize) -> Vec<Share> {
        let system = &self.transformation.problem().parts[self.part].system;
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
    fn common(&self, parts: &[CommonPart], measurand: &str) -> Vec<Contribution> {
        let mut found = Vec::new();
        for part in parts {
            let own =
                |one: &&ReadingDelay| one.measurand == self.measurand && one.state == State::Solved;
            let readings = part.delays.readings.iter().filter(own);
            let square: f64 = readings.map(|reading| reading.common.powi(2)).sum();
            let mut summaries = part.delays.measurands.iter();
            let summary = summaries.find(|summary| summary.measurand == measurand);
            let mean = summary.and_then(|summary| summary.common).unwrap_or(0.0);
            let single = (square / self.readings.len() as f64).sqrt();
            let is_timing = part.name.split('.').next() == Some(EFFECT);
            let shares = self.chain(is_timing, true).unwrap_or_else(|| {
                vec![(part.source, part.name.clone(), 1.0, part.degrees_of_freedom)]
            });
            found.extend(shared_out(shares, single, mean, true));
        }
        found
    }

    /// What calibration leaves open.
    fn calibration(&self) -> Vec<Contribution> {
        let problem = self.transformation.problem();
        let point = &self.transformation.fit().fit.point;
        let inputs = &problem.parts[self.part].system.assembly.names.inputs;
        systematic::of_measurand(problem, self.part, point, self.readings)
            .into_iter()
            .map(|one| {
                let name = &inputs[one.input].name;
                let squares: f64 = one.readings.iter().map(|sigma| sigma * sigma).sum();
                let spread = self.campaign.input_spread[one.input].calibration;
                Contribution {
                    source: source_of_input(name),
                    name: format!("{name}.calibration"),
                    is_common: true,
                    reading: (squares / self.readings.len() as f64).sqrt(),
                    mean: one.mean,
                    degrees_of_freedom: spread.and_then(|spread| spread.degrees_of_freedom),
                }
            })
            .collect()
    }

    /// The seed's way beside the exact one.
    fn differences(&self, measurand: &str) -> Option<Differences> {
        let fit = self.transformation.fit();
        let boundary = differences::boundary(fit, measurand)?;
        let problem = self.transformation.problem();
        let point = &fit.fit.point;
        let mut table = differences::expanded(problem, self.part, point, boundary, self.readings);
        let mut exact: Vec<f64> =
            self.readings.iter().map(|reading| reading.expanded_uncertainty()).collect();
        let ratios = table.iter().zip(&exact).map(|(a, b)| (a / b).max(b / a));
        let worst_ratio = ratios.fold(1.0, f64::max);
        let (median_of, exact_median) = (median(&mut table)?, median(&mut exact)?);
        Some(Differences {
            boundary,
            median: median_of,
            smallest: *table.first()?,
            exact_median,
            exact_smallest: *exact.first()?,
            worst_ratio,
        })
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
