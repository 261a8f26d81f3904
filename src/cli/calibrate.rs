//! `homepoint calibrate`: the joint estimate.

use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use super::arguments::{CampaignArguments, Format};
use super::load::{notices, refusals};
use super::{Failure, doubts, load, output};
use crate::diagnose::evidence::members::choose;
use crate::engine::undefined::Farthest;
use crate::engine::{Point, Problem};
use crate::estimate::absorbed::calibrate_holding;
use crate::estimate::batch::{Options, Outcome};
use crate::estimate::calibrate::Calibration;
use crate::estimate::correlations::covariance_of_estimates;
use crate::estimate::minima::others;
use crate::estimate::nested::against_nominal;
use crate::estimate::noise_model::{NoiseModel, with_noise};
use crate::estimate::planned;
use crate::estimate::stream_bias::stream_biases;
use crate::report;

/// The tables that `--out` asks for.
const PARAMETERS: &str = "parameters.csv";
const RESIDUALS: &str = "residuals.csv";
const COVARIANCE: &str = "covariance.csv";

/// A variance factor beyond which it is asked whether a convention was mistaken.
const BAD: f64 = 4.0;

#[derive(Debug, Args)]
pub(super) struct CalibrateCommand {
    #[command(flatten)]
    pub(super) common: CampaignArguments,
    /// For which noise uncertainties hold
    #[arg(long, value_enum, default_value_t)]
    pub(super) noise: NoiseChoice,
}

/// For which noise uncertainties hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum NoiseChoice {
    /// As stated, independent from reading to reading
    #[default]
    Stated,
    /// Level and correlation in time of each measurand are estimated, and enter the weights
    Autocorrelated,
    /// Values as with `stated`; uncertainties from how runs, or stretches of time, scatter
    /// (cluster-robust)
    Sandwich,
}

impl From<NoiseChoice> for NoiseModel {
    fn from(choice: NoiseChoice) -> Self {
        match choice {
            NoiseChoice::Stated => Self::Stated,
            NoiseChoice::Autocorrelated => Self::Autocorrelated,
            NoiseChoice::Sandwich => Self::Sandwich,
        }
    }
}

impl CalibrateCommand {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let mut loaded = load::load(&self.common)?;
        let suspicion = loaded.suspicion();
        loaded.keep_files(self.common.out.as_ref(), [PARAMETERS, RESIDUALS, COVARIANCE])?;
        refusals::refuse_correlated(&loaded.problem)?;
        notices::tell_not_put_in(&loaded, false);
        let (problem, chosen) =
            choose(loaded.problem, &loaded.recipes, &self.common.with, &Options::default())?;
        let result = estimate_with(problem, &self.common.with)?;
        let result = against_nominal(result, &self.common.with, &Options::default())
            .map_err(|error| Failure::Could(error.to_string()))?;
        doubts::tell(&result, self.common.quiet);
        let others = others(&result);
        let is_bad = result.variance_factor().is_none_or(|factor| factor > BAD);
        let mistaken =
            if is_bad { suspicion.mistaken(&result.problem, &result.fit.point) } else { None };
        let result = with_noise(result, &Options::default(), self.noise.into())
            .map_err(|error| Failure::Could(error.to_string()))?;
        let covariance = covariance_of_estimates(&result);
        let biases = stream_biases(&result);
        let runs = load::runs(&loaded.campaigns);
        match self.common.format {
            Format::Json => {
                let mut value = loaded.head.clone();
                load::merge(&mut value, report::json::calibration(&result));
                load::merge(&mut value, report::minima::json(&result, &others));
                let correlated = report::autocorrelation::correlated(&result);
                load::merge(&mut value, report::autocorrelation::json(&correlated));
                load::merge(&mut value, report::conventions::json_for(mistaken.as_ref(), runs));
                load::merge(&mut value, report::members::json(&chosen));
                load::merge(&mut value, report::smoothing::json(&result));
                load::merge(&mut value, report::smoothing::json_of_bias(&biases));
                load::merge(&mut value, report::noise::json(&result.noise));
                load::merge(&mut value, report::correlations::json(covariance.as_ref()));
                output::json(&value)?;
            }
            Format::Text => {
                let mistaken = report::conventions::text_for(mistaken.as_ref(), runs);
                let text = report::text::calibration_with(&loaded.title, &result, &mistaken);
                let text = text + &report::smoothing::text_of_bias(&biases);
                let text = text + &report::members::text(&chosen);
                output::text(&(text + &report::minima::text(&result, &others)))?;
            }
        }
        if let Some(folder) = &self.common.out {
            let parameters = report::table::parameters(&result);
            output::file(&folder.join(PARAMETERS), &parameters, &loaded.files)?;
            if let Some(covariance) = &covariance {
                let table = report::correlations::table(covariance);
                output::file(&folder.join(COVARIANCE), &table, &loaded.files)?;
            }
            output::written(&folder.join(RESIDUALS), &loaded.files, |file| {
                report::table::residuals(&result, file)?;
                refusals::read_back(&result.problem)
            })?;
        }
        verdict(&result)
    }
}

/// Fits, or says which reading makes that impossible.
pub(super) fn estimate(problem: Problem) -> Result<Calibration, Failure> {
    estimate_with(problem, &[])
}

/// The same, with members of these effects held where the model absorbs them.
pub(super) fn estimate_with(problem: Problem, effects: &[String]) -> Result<Calibration, Failure> {
    refusals::refuse_empty(&problem)?;
    let result = calibrate_holding(problem, effects, &Options::default())
        .map_err(|error| Failure::Could(error.to_string()))?;
    refusals::trust(&result.problem)?;
    refusals::refuse_impossible_sigma(&result.problem, &result.fit.point)?;
    if result.fit.outcome != Outcome::NotFinite {
        return Ok(result);
    }
    Err(Failure::Could(not_finite(&result)))
}

/// Which reading makes a fit impossible.
fn not_finite(result: &Calibration) -> String {
    let (problem, point) = (&result.problem, &result.fit.point);
    let reading = |(p, r, sample, m): (usize, usize, usize, usize)| {
        let part = &problem.parts[p];
        let measurand = &part.system.assembly.names.measurands[m].name;
        let (run, row) = (&part.runs[r].name, part.runs[r].record.row(sample));
        format!("`{measurand}` in run `{run}`, row {row}")
    };
    if let Some(place) = problem.first_undefined(point) {
        return format!(
            "the model has no value for {}: the measurand is undefined at the starting point; state a better `start`, or leave the reading out",
            reading(place)
        );
    }
    let Some(Farthest { place, residual }) = problem.farthest(point) else {
        return "the model is undefined near the starting point".to_owned();
    };
    let slot = &problem.parts[place.0].system.assembly.names.measurands[place.3];
    let residual = report::figure::size(residual, &slot.unit);
    format!(
        "the model is undefined near the starting point, or its numbers are too large to compute with: {} is farthest from it, by {residual}; check that reading, its unit and its sigma, or state a better `start`",
        reading(place)
    )
}

/// A fit of the runs that have readings, where planned ones may stand beside them.
pub(super) struct Measured {
    /// The fit.
    pub(super) fit: Calibration,
    /// The point of all runs, as stated where the fit says nothing.
    pub(super) point: Point,
    /// Places and turns that neither the fit nor anybody says, in words.
    pub(super) unplaced: Vec<String>,
}

/// Fits the runs that have readings.
pub(super) fn estimate_measured(problem: &Problem) -> Result<Measured, Failure> {
    let fit = estimate(planned::measured(problem))?;
    let point = planned::placed(problem, &fit.problem, &fit.fit.point);
    let unplaced = planned::unplaced(problem, Some(&fit.problem));
    Ok(Measured { fit, point, unplaced })
}

/// Exit status 1 where the numbers cannot be used.
pub(super) fn verdict(result: &Calibration) -> Result<(), Failure> {
    if result.is_sound() { Ok(()) } else { Err(Failure::Reported) }
}

/// Tells why there are no delays, in the form asked for.
pub(super) fn unsound(result: &Calibration, about: &Value, format: Format) -> Result<(), Failure> {
    match format {
        Format::Text => output::text(&report::text::trouble(result))?,
        Format::Json => {
            let whole = report::json::calibration(result);
            output::json(&json!({
                "campaigns": about,
                "measurands": {},
                "fit": whole["fit"],
                "unobservable": whole["unobservable"],
            }))?;
        }
    }
    verdict(result)
}
