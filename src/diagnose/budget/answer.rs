//! The answer as data.

use std::collections::BTreeMap;

use crate::diagnose::found::{AutocorrelatedNoise, LeftOut, Level, NoiseEffect};
use crate::diagnose::gap::{Gap, Steps};
use crate::diagnose::library::candidate::NotTestable;
use crate::diagnose::library::place::Place;
use crate::diagnose::library::variant::Variant;
use crate::diagnose::outliers::compared_delays::ComparedDelay;
use crate::estimate::calibrate::{Calibration, Estimate};
use crate::estimate::contradicted::Contradicted;
use crate::estimate::conventions::Mistaken;
use crate::estimate::linear_range::BeyondRange;
use crate::units::Unit;

use super::absorbed::Absorbed;
use super::judge::Objection;
use super::stamp_jumps::StampJump;

pub use super::sizes::{Size, WellDetermined};
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::CONFOUNDED;

pub use super::verdict::{Findings, Verdict, decide};
pub use crate::diagnose::thresholds::FAR_BEYOND_STATED;

/// Part of what it is compared with that the nearest effect explains at least.
pub const NEAREST: f64 = 0.01;

/// A row of the budget: an effect that explains a part of the gap.
#[derive(Clone, Debug)]
pub struct Row {
    /// The effect, with its head.
    pub name: String,
    /// The relaxed form in which it stands, if it does not in the library's.
    pub variant: Option<Variant>,
    /// The member of each of its families.
    pub member: BTreeMap<String, f64>,
    /// Standard uncertainty (SI) of members that are ranges.
    pub member_sigma: BTreeMap<String, f64>,
    /// Its values beside the whole budget, the remainder among it.
    pub values: Vec<Estimate>,
    /// What it takes off chi squared beside all others.
    pub gain: Gain,
    /// Log Bayes factor of the budget with and without it.
    pub ln_bayes: f64,
    /// Part of the gap that it closes on held-out readings, beside all others.
    pub closes: f64,
    /// Part of the gap that it would close alone.
    pub alone: f64,
    /// Posterior probability that it, and not an alias or an unmodelled effect, is there.
    pub posterior: f64,
    /// Rise of twice the log predictive density of held-out readings.
    pub predictive_gain: f64,
    /// Effects that these readings do not distinguish from it.
    pub aliases: Vec<String>,
    /// The unmodelled effect that would explain as much in its place, if there is one.
    pub unmodelled_alias: Option<String>,
    /// Effects that the readings hardly separate from it: rows, and near aliases outside the fit.
    pub confounded: Vec<Confounded>,
    /// What of these together is far better determined than the row's value.
    pub well_determined: Option<WellDetermined>,
    /// The jumps of stamps at which it acts.
    pub stamp_jumps: Vec<StampJump>,
    /// Ratio of its largest value to the typical magnitude.
    pub ratio_to_typical: Option<f64>,
}

impl Row {
    /// Effects outside the fit that are reported with the row: those that the readings do not distinguish
    /// from it, and near ones that are there more probably than not.
    pub fn grouped(&self) -> impl Iterator<Item = &Confounded> {
        let is_close = |one: &&Confounded| {
            let is_alias = one.correlation.abs() >= CONFOUNDED || self.aliases.contains(&one.name);
            !one.is_row && (is_alias || one.is_probable)
        };
        self.confounded.iter().filter(is_close)
    }

    /// Those with which its value is reported together: rows, and effects of its group.
    pub fn together(&self) -> impl Iterator<Item = &Confounded> {
        self.confounded.iter().filter(|one| one.is_row).chain(self.grouped())
    }
}

/// Another effect that is confounded with a row.
#[derive(Clone, Debug)]
pub struct Confounded {
    /// The effect.
    pub name: String,
    /// Whether it is a row itself.
    pub is_row: bool,
    /// Whether it is there more probably than not.
    pub is_probable: bool,
    /// Correlation of their values where both are in the fit; of effects with several values that of
    /// their forms.
    pub correlation: f64,
    /// Where both have one value: how much of the other one the row's value holds for each unit of
    /// it (SI). `row + factor * other` is well determined.
    pub factor: Option<f64>,
    /// Values of the row and of the other effect where both are in the fit, with standard
    /// uncertainties; empty where the two are not determined separately.
    pub joint: Vec<(Size, f64)>,
}

/// A part of the remainder.
#[derive(Clone, Debug)]
pub struct Remainder {
    /// Where it sits.
    pub place: Place,
    /// What it takes off chi squared beside all others.
    pub gain: Gain,
    /// Its part of the gap.
    pub share: f64,
    /// Its rms in the measurand in which it is largest (SI), and that measurand.
    pub rms: Option<(f64, String)>,
    /// Amplitude of a wave, or the largest of several (SI), and the unit in which it is shown.
    pub amplitude: Option<(f64, Unit)>,
    /// Of waves over a turn the orders that are most of it, each with its amplitude in that unit.
    pub orders: Vec<(usize, f64)>,
    /// By how much something changes at a moment, where it does; along axes how far.
    pub change: Option<StepChange>,
    /// By how much it turns beside that.
    pub turn: Option<StepChange>,
    /// The effect that is nearest to it, and the part of its gain that this explains.
    pub nearest: Option<(String, f64)>,
}

impl Remainder {
    /// At a place, of which nothing else is known.
    pub fn at(place: Place) -> Self {
        Self {
            place,
            gain: Gain::default(),
            share: 0.0,
            rms: None,
            amplitude: None,
            orders: Vec::new(),
            change: None,
            turn: None,
            nearest: None,
        }
    }
}

/// By how much something changes at a moment: what is added to it from then on.
#[derive(Clone, Debug)]
pub struct StepChange {
    /// The value (SI).
    pub value: f64,
    /// Its standard uncertainty.
    pub sigma: f64,
    /// The unit in which it is shown.
    pub unit: Unit,
}

/// An effect that explains something, but does not stand as a row.
#[derive(Clone, Debug)]
pub struct Doubtful {
    /// The effect.
    pub name: String,
    /// What it takes off chi squared beside the nominal model and the rows.
    pub gain: Gain,
    /// Why it does not stand.
    pub objection: Objection,
    /// Its values, as the sums find them.
    pub values: Vec<Size>,
}

/// A testable effect against the nominal model.
#[derive(Clone, Debug)]
pub struct Ranked {
    /// The effect.
    pub name: String,
    /// The member of each of its families.
    pub member: BTreeMap<String, f64>,
    /// What it takes off chi squared alone.
    pub gain: Gain,
    /// Its log Bayes factor.
    pub ln_bayes: f64,
    /// Part of the gap that it explains alone.
    pub share: f64,
    /// Posterior probability that it is the cause, if one cause is all that is there.
    pub probability: f64,
    /// Its values as the sums find them.
    pub values: Vec<Size>,
}

/// The answer.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The joint estimate with the nominal model.
    pub nominal: Calibration,
    /// The verdict.
    pub verdict: Verdict,
    /// The rows of the budget, largest first.
    pub rows: Vec<Row>,
    /// The remainder, largest part first.
    pub remainder: Vec<Remainder>,
    /// What does not stand as a row.
    pub doubtful: Vec<Doubtful>,
    /// Effects on the noise.
    pub noise: Vec<NoiseEffect>,
    /// Noise scale factors that are not as stated.
    pub levels: Vec<Level>,
    /// Measurands with autocorrelated noise.
    pub autocorrelation: Vec<AutocorrelatedNoise>,
    /// The joint estimate with the rows; `None` without any.
    pub explained: Option<Calibration>,
    /// How far the gap shrinks with the rows, on readings that they were not fitted to; `None`
    /// without rows.
    pub gap: Option<Gap>,
    /// All testable effects, best first.
    pub candidates: Vec<Ranked>,
    /// Posterior probabilities of nothing, of an effect of the library and of an unmodelled effect,
    /// if one of them is all that is there.
    pub causes: Option<[f64; 3]>,
    /// Effects that nominal parameters absorb.
    pub absorbed: Vec<Absorbed>,
    /// Effects that cannot be tested here.
    pub not_testable: Vec<NotTestable>,
    /// What is left out.
    pub left_out: LeftOut,
    /// The delays with and without the readings that are left out.
    pub delays: Vec<ComparedDelay>,
    /// Stated values that the readings contradict.
    pub contradicted: Vec<Contradicted>,
    /// The parameter whose stated value is wrong altogether: it is free in all that is found.
    pub set_free: Option<String>,
    /// The convention that was mistaken.
    pub mistaken: Option<Mistaken>,
    /// Values beyond the range for which their effect's form holds.
    pub beyond_range: Vec<BeyondRange>,
    /// The fits without the rows and with one after the other.
    pub steps: Option<Steps>,
    /// The steps of the search.
    pub log: Vec<String>,
}

impl Diagnosis {
    /// Where no row stands, the effect that by itself explains most for its price.
    pub fn nearest(&self) -> Option<&Ranked> {
        let is_unknown = self.rows.is_empty() && self.verdict.has_remainder();
        let by_evidence = |a: &&Ranked, b: &&Ranked| a.ln_bayes.total_cmp(&b.ln_bayes);
        let nearest = self.candidates.iter().filter(|_| is_unknown).max_by(by_evidence);
        nearest.filter(|one| one.ln_bayes > 0.0 && one.share >= NEAREST)
    }

    /// The variance factor of what explains the gap best, by the noise as stated: noise scaled up to the
    /// size of the residuals is as bad a fit. Infinite where there are no more readings than parameters.
    pub fn variance_factor(&self) -> f64 {
        // Where no row stands nothing is explained.
        let explained = self.explained.as_ref().filter(|_| !self.rows.is_empty());
        let factor = explained.unwrap_or(&self.nominal).variance_factor().unwrap_or(f64::INFINITY);
        factor * self.levels.iter().map(|one| one.factor).fold(1.0, f64::max).powi(2)
    }

    /// The same without the changes that are in the fit: one may be how the numbers of a run are read.
    pub fn variance_factor_without_changes(&self) -> f64 {
        let of_rows = self.steps.as_ref().map_or(0.0, |steps| steps.last().variance_factor());
        of_rows.max(self.variance_factor())
    }

    /// Of a nominal model alone.
    pub fn without_search(nominal: Calibration, verdict: Verdict) -> Self {
        Self {
            nominal,
            verdict,
            rows: Vec::new(),
            remainder: Vec::new(),
            doubtful: Vec::new(),
            noise: Vec::new(),
            levels: Vec::new(),
            autocorrelation: Vec::new(),
            explained: None,
            gap: None,
            candidates: Vec::new(),
            causes: None,
            absorbed: Vec::new(),
            not_testable: Vec::new(),
            left_out: LeftOut::default(),
            delays: Vec::new(),
            contradicted: Vec::new(),
            set_free: None,
            mistaken: None,
            beyond_range: Vec::new(),
            steps: None,
            log: Vec::new(),
        }
    }
}
