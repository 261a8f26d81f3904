//! What a campaign states of the inputs of its model: how well they are known, how they are smoothed.

use crate::campaign::calibration::InputSpread;
use crate::campaign::file::CampaignFile;
use crate::campaign::loader::{InputSetting, Loader};
use crate::campaign::spline::Smoothing;
use crate::diagnostic::Diagnostic;
use crate::document::entries::Item;
use crate::model::Model;
use crate::units::Unit;

impl CampaignFile {
    pub(super) fn input_settings(
        &self,
        model: &Model,
        loader: &mut Loader<'_>,
    ) -> (Vec<InputSetting>, Vec<InputSpread>) {
        let known: Vec<&str> = model.inputs.iter().map(|input| input.name.as_str()).collect();
        for over in &self.inputs {
            if !known.contains(&over.name.text.as_str()) {
                loader.reader.unknown(over.name.span, "input", &over.name.text, &known);
            }
        }
        let mut settings = Vec::new();
        let mut spreads = Vec::new();
        for input in &model.inputs {
            let over = self.inputs.iter().find(|over| over.name.text == input.name);
            let unit = &input.unit;
            let mut say = |item: Option<&Item>, what: &str, like: &Unit| {
                let item = item?;
                loader.reader.positive_of(item, &format!("{what} of `{}`", input.name), like)
            };
            let sigma = say(over.and_then(|o| o.sigma.as_ref()), "sigma", unit).or(input.sigma);
            let resolution = say(over.and_then(|o| o.resolution.as_ref()), "resolution", unit);
            let smooth = say(over.and_then(|o| o.smooth.as_ref()), "smooth", &Unit::second())
                .or(input.smooth);
            let period = say(over.and_then(|o| o.period.as_ref()), "period", unit).or(input.period);
            let (calibration, corrections) = over
                .and_then(|o| o.calibration.as_ref())
                .map_or((None, None), |item| loader.calibration(input, item));
            let spread = InputSpread { noise: sigma, resolution, calibration };
            let smoothing = match (smooth, spread.random().filter(|sigma| *sigma > 0.0)) {
                // `smooth` is the period of an oscillation that comes out half as large.
                (Some(period), _) => Smoothing::TimeConstant(period / std::f64::consts::TAU),
                (None, Some(sigma)) => Smoothing::Noise(sigma),
                (None, None) => Smoothing::CrossValidation,
            };
            let needed = needs(model, &input.name);
            settings.push(InputSetting { smoothing, period, needed, corrections });
            spreads.push(spread);
        }
        (settings, spreads)
    }

    /// Constants of runs must be inputs of the model.
    pub(super) fn check_constants(&self, model: &Model, loader: &mut Loader<'_>) {
        let known: Vec<&str> = model.inputs.iter().map(|input| input.name.as_str()).collect();
        for (name, _) in self.runs.iter().flat_map(|run| &run.inputs) {
            if known.contains(&name.text.as_str()) {
                continue;
            }
            // A constant recorded for effects that are not in use is no fault.
            let mut warning = Diagnostic::warning(format!(
                "the input `{}` is not used: model `{}` does not declare it",
                name.text, model.name
            ))
            .at(name.place.clone());
            if let Some(near) = crate::diagnostic::nearest(&name.text, known.iter().copied()) {
                warning = warning.help(format!("did you mean `{near}`?"));
            }
            if loader.warned.insert(name.text.clone()) {
                loader.warnings.push(warning);
            }
        }
    }
}

/// Whether a formula of the model names an input.
fn needs(model: &Model, name: &str) -> bool {
    model.formulas().any(|formula| formula.root.names().iter().any(|(own, _)| *own == name))
}
