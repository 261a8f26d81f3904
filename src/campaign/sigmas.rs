//! Standard uncertainties that a campaign states as formulas: `sigma = "1 arcsec / cos(elevation)"`,
//! or as a column of its data: `sigma = "azimuth_sigma"`.

use crate::campaign::file::CampaignFile;
use crate::document::entries::get;
use crate::model::name::{fault_of, is_built_in};
use crate::model::{InputDeclaration, Model};

impl CampaignFile {
    /// The model with what this campaign states over its standard uncertainties. A name in a formula
    /// that the model does not have is a column of the data, in the unit of the measurand.
    #[must_use]
    pub fn with_sigmas(&self, mut model: Model) -> Model {
        let mut columns: Vec<InputDeclaration> = Vec::new();
        for over in &self.measurands {
            let is_own = |name: &String| *name == over.name.text;
            let Some(at) = model.measurands.iter().position(|one| is_own(&one.name)) else {
                continue;
            };
            if let Some(formula) = &over.sigma {
                for (name, _) in formula.root.names() {
                    if !is_known(&model, name) && !columns.iter().any(|one| one.name == name) {
                        columns.push(InputDeclaration {
                            name: name.to_owned(),
                            span: over.name.span,
                            unit: model.measurands[at].unit.clone(),
                            signal: false,
                            period: None,
                            sigma: None,
                            smooth: None,
                            about: format!("standard uncertainty of `{}`", over.name.text),
                        });
                    }
                }
                model.measurands[at].sigma_formula = Some(formula.clone());
            } else if get(&over.said, "sigma").or(get(&over.said, "U")).is_some() {
                model.measurands[at].sigma_formula = None;
            }
        }
        model.inputs.extend(columns);
        model
    }
}

/// Whether a formula of a model may use a name, or nobody may.
fn is_known(model: &Model, name: &str) -> bool {
    is_built_in(name)
        || fault_of(name).is_some()
        || model.inputs.iter().any(|one| one.name == name)
        || model.parameters.iter().any(|one| one.name == name)
        || model.measurands.iter().any(|one| one.name == name)
        || model.quantities.contains_key(name)
}
