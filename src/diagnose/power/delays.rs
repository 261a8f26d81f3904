//! The delays of a design: how well they will be known, and which columns they are.

use crate::estimate::calibrate::Calibration;

use super::design::Prospect;

/// How well a delay will be known.
#[derive(Clone, Debug, PartialEq)]
pub struct DelaySigma {
    /// The measurand.
    pub measurand: String,
    /// The parameter that is its delay; measurands may share one.
    pub parameter: String,
    /// Its delay's largest standard uncertainty over the scope (s); `None` where it is not
    /// determined.
    pub sigma: Option<f64>,
}

/// Each free delay with its columns and their coefficients.
pub(super) fn delay_rows(stage: &Prospect) -> Vec<(String, Vec<(usize, f64)>)> {
    let layout = &stage.fitted.problem.layout;
    let delays = layout.instances.iter().enumerate();
    let delays = delays.filter(|(_, instance)| instance.name.ends_with(".delay"));
    let rows = delays.map(|(index, instance)| {
        let of = instance.of.as_ref().map_or_else(String::new, |of| format!(" ({of})"));
        (format!("{}{of}", instance.name), layout.columns_of(index, 0))
    });
    rows.filter(|(_, row)| !row.is_empty()).collect()
}

/// The standard uncertainty of each measurand's delay, the largest where there are several.
pub(super) fn delays(nominal: &Calibration) -> Vec<DelaySigma> {
    let estimates = nominal.estimates();
    let mut found: Vec<DelaySigma> = Vec::new();
    for part in &nominal.problem.parts {
        let names = &part.system.assembly.names;
        for (parameter, declared) in names.parameters.iter().zip(&part.system.declared) {
            for measurand in &declared.delay_of {
                let own = || estimates.iter().filter(|one| one.name == parameter.name);
                let known = own().all(|one| one.sigma.is_some());
                let most = own().filter_map(|one| one.sigma).fold(0.0, f64::max);
                let measurand = names.measurands[*measurand].name.clone();
                if !found.iter().any(|one| one.measurand == measurand) {
                    let (parameter, sigma) = (parameter.name.clone(), known.then_some(most));
                    found.push(DelaySigma { measurand, parameter, sigma });
                }
            }
        }
    }
    found
}
