//! Whether residuals are correlated from reading to reading, and by how much standard uncertainties
//! are too small if they are.
//!
//! Means of `B` consecutive residuals scatter by `σ/√B` where they are independent. By how many
//! times more their variance is (the batch means of Fishman and Yarberry 1997, of all powers of two)
//! is by how many times the variance of a parameter is too small that acts evenly over as many
//! readings. It does not tell noise with a memory from an effect that the model lacks.

use crate::engine::{Point, Problem};
use crate::estimate::calibrate::Calibration;

/// Batches that a size needs to count.
const BATCHES: u64 = 24;
/// Standard deviations by which a ratio of variances must exceed 1.
const SURE: f64 = 5.0;
/// A smaller ratio of standard deviations is not worth a word.
const LEAST: f64 = 1.5;
/// Sizes that are looked at: powers of two up to this.
const SIZES: usize = 24;

/// A measurand whose residuals are correlated.
#[derive(Clone, Debug, PartialEq)]
pub struct Autocorrelated {
    /// The measurand.
    pub measurand: String,
    /// By how many times standard uncertainties may be too small for the correlation.
    pub times: f64,
    /// By how many times residuals are as large as stated (rms).
    pub level: f64,
    /// Over how many readings residuals are correlated.
    pub readings: u64,
}

impl Autocorrelated {
    /// By how many times the standard uncertainty of what acts evenly over so many readings is too small,
    /// for both.
    pub fn of_both(&self) -> f64 {
        self.times * self.level
    }
}

/// Sums over batches of one size.
#[derive(Clone, Copy, Debug, Default)]
struct Size {
    /// Sum of the residuals of the batch that is not full.
    open: f64,
    /// Sum of squares of the sums of full batches, and how many there are.
    squares: f64,
    count: u64,
}

/// Batches of all sizes of one measurand.
#[derive(Clone, Debug, Default)]
struct Batches {
    sizes: [Size; SIZES],
    /// Residuals so far in the run.
    seen: u64,
}

impl Batches {
    fn see(&mut self, residual: f64) {
        self.seen += 1;
        for (power, size) in self.sizes.iter_mut().enumerate() {
            size.open += residual;
            if self.seen.is_multiple_of(1 << power) {
                size.squares += size.open.powi(2);
                size.count += 1;
                size.open = 0.0;
            }
        }
    }

    /// rms of the residuals.
    fn rms(&self) -> f64 {
        (self.sizes[0].squares / self.sizes[0].count.max(1) as f64).sqrt()
    }

    /// Batches do not go from run to run.
    fn end_of_run(&mut self) {
        self.seen = 0;
        self.sizes.iter_mut().for_each(|size| size.open = 0.0);
    }

    /// The size at which means scatter most, and the ratio of variances there.
    fn most(&self) -> Option<(u64, f64)> {
        let single = self.sizes[0].squares / self.sizes[0].count.max(1) as f64;
        let ratios = self.sizes.iter().enumerate().skip(1).filter_map(|(power, size)| {
            let length = 1_u64 << power;
            let ratio = size.squares / (size.count as f64 * length as f64 * single);
            let by_chance = SURE * (2.0 / size.count as f64).sqrt();
            (size.count >= BATCHES && ratio > 1.0 + by_chance).then_some((length, ratio))
        });
        ratios.max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Over how many readings residuals are correlated at most; 0 where they are not.
pub fn longest(fit: &Calibration) -> u64 {
    all(&fit.problem, &fit.fit.point).iter().map(|one| one.readings).max().unwrap_or(0)
}

/// By how many times fewer independent readings are worth as much as those at a point; 1 where
/// residuals are not correlated.
pub(crate) fn fewer(problem: &Problem, point: &Point) -> f64 {
    all(problem, point).iter().map(|one| one.times.powi(2)).fold(1.0, f64::max)
}

/// The measurands whose residuals are correlated at an estimate, the worst first.
pub fn autocorrelated(fit: &Calibration) -> Vec<Autocorrelated> {
    let mut found = all(&fit.problem, &fit.fit.point);
    found.retain(|one| one.times > LEAST);
    found.sort_by(|a, b| b.of_both().total_cmp(&a.of_both()));
    found
}

/// The measurands whose residuals are correlated, worth a word or not.
fn all(problem: &Problem, point: &Point) -> Vec<Autocorrelated> {
    let mut found: Vec<Autocorrelated> = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        let names = &part.system.assembly.names.measurands;
        let components: Vec<(usize, usize)> = part
            .slots()
            .iter()
            .enumerate()
            .flat_map(|(m, slot)| (0..slot.components).map(move |c| (m, slot.residual + c)))
            .collect();
        let mut all = vec![Batches::default(); components.len()];
        for r in 0..part.runs.len() {
            problem.visit_residuals(p, r, point, &mut |_, values| {
                for ((_, place), batches) in components.iter().zip(&mut all) {
                    let residual = values[*place];
                    if residual.is_finite() {
                        batches.see(residual);
                    }
                }
            });
            all.iter_mut().for_each(Batches::end_of_run);
        }
        for ((m, _), batches) in components.iter().zip(&all) {
            let Some((readings, ratio)) = batches.most() else { continue };
            let (measurand, times) = (names[*m].name.clone(), ratio.sqrt());
            let level = batches.rms() / problem.rms_sigma(point, p, *m);
            let own = Autocorrelated { measurand, times, level, readings };
            match found.iter_mut().find(|one| one.measurand == own.measurand) {
                Some(one) if one.times >= times => {}
                Some(one) => *one = own,
                None => found.push(own),
            }
        }
    }
    found
}
