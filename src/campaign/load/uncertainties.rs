//! The standard uncertainties of readings, by measurand, and which of them must be stated.

use crate::campaign::columns::reading_columns;
use crate::campaign::file::CampaignFile;
use crate::campaign::loader::Loader;
use crate::campaign::run::Run;
use crate::campaign::statement;
use crate::diagnostic::Span;
use crate::document::entries::get;
use crate::formula::Formula;
use crate::formula::angles::brings_angle;
use crate::model::Model;
use crate::units::Unit;

impl CampaignFile {
    /// Standard uncertainty of a reading of each measurand, and the degrees of freedom it rests on.
    pub(super) fn measurand_sigmas(
        &self,
        model: &Model,
        loader: &mut Loader<'_>,
    ) -> (Vec<f64>, Vec<Option<f64>>) {
        let known: Vec<&str> = model.measurands.iter().map(|m| m.name.as_str()).collect();
        let rates = self.specification.rates.iter().map(|(name, _)| name);
        for name in self.measurands.iter().map(|over| &over.name).chain(rates) {
            if !known.contains(&name.text.as_str()) {
                loader.reader.unknown(name.span, "measurand", &name.text, &known);
            }
        }
        let (mut sigmas, mut degrees) = (Vec::new(), Vec::new());
        for measurand in &model.measurands {
            let name = &measurand.name;
            if measurand.sigma_formula.is_some() {
                // The formula has all of it.
                let over = self.measurands.iter().find(|over| &over.name.text == name);
                let said = over.map_or(&[][..], |over| &over.said);
                if let Some(also) = said.iter().find(|entry| entry.key != "sigma") {
                    let message =
                        format!("`{}` stands beside a `sigma` that is a formula", also.key);
                    loader.reader.fault(also.span, message, "state one of them");
                }
                if let Some(formula) = over.and_then(|over| over.sigma.as_ref()) {
                    check_angles(model, loader, (name, formula), &measurand.unit);
                }
                sigmas.push(1.0);
                degrees.push(None);
                continue;
            }
            let over = self.measurands.iter().find(|over| &over.name.text == name);
            let said = over.map_or(&[][..], |over| &over.said);
            let stated = get(said, "sigma").or(get(said, "U"));
            let what = format!("`{name}`");
            let spread = statement::spread(&mut loader.reader, said, &what, &measurand.unit);
            let own = if stated.is_none() { measurand.sigma } else { None };
            let sigma = spread.map(|spread| spread.sigma).or(own);
            degrees.push(spread.and_then(|spread| spread.degrees_of_freedom));
            sigmas.push(match (sigma, stated) {
                (None, None) => f64::NAN,
                // A fault is noted already.
                (None, Some(_)) => 1.0,
                (Some(sigma), _) => sigma,
            });
        }
        (sigmas, degrees)
    }

    /// A sigma is needed of every measurand that is read, or may be: then a fault, else 1.
    pub(super) fn need_sigmas(
        &self,
        model: &Model,
        loader: &mut Loader<'_>,
        runs: &[Run],
        sigmas: &mut [f64],
    ) {
        let planned = self.runs.iter().any(|run| !run.plan.is_empty());
        let columns = reading_columns(model);
        for (index, (measurand, sigma)) in model.measurands.iter().zip(sigmas).enumerate() {
            let read = |run: &Run| {
                let mut read = false;
                run.record.walk(|stretch| {
                    let all = columns.iter().zip(&stretch.samples.readings);
                    let mut own = all.filter(|((of, _), _)| *of == index);
                    read |= own.any(|(_, v)| v[stretch.range()].iter().any(|v| !v.is_nan()));
                });
                read
            };
            if !sigma.is_nan() {
                continue;
            }
            *sigma = 1.0;
            if planned || runs.iter().any(read) {
                let name = &measurand.name;
                let over = self.measurands.iter().find(|over| &over.name.text == name);
                let span = over.map_or(Span::default(), |over| over.name.span);
                let message = format!("the standard uncertainty of `{name}` is not stated");
                let symbol = &measurand.unit.symbol;
                let help = format!("in [measurands] write {name} = {{ sigma = \"... {symbol}\" }}");
                loader.reader.fault(span, message, help);
            }
        }
    }
}

/// A formula for the sigma of an angle needs a unit of angles.
fn check_angles(
    model: &Model,
    loader: &mut Loader<'_>,
    (name, formula): (&str, &Formula),
    unit: &Unit,
) {
    // What a quantity is, only the graph finds out.
    let may_be_angle = |name: &str| {
        let inputs = model.inputs.iter().map(|one| (&one.name, &one.unit));
        let parameters = model.parameters.iter().map(|one| (&one.name, &one.unit));
        let read = model.measurands.iter().map(|one| (&one.name, &one.unit));
        let mut known = inputs.chain(parameters).chain(read);
        let known = known.find(|(own, _)| *own == name);
        known.map_or(model.quantities.contains_key(name), |(_, unit)| unit.is_angle())
    };
    if unit.is_angle() && !brings_angle(&formula.root, &may_be_angle) {
        let span = Span::new(formula.offset, formula.offset + formula.text.len());
        let message =
            format!("the standard uncertainty of the angle `{name}` has no unit of angles");
        let help = "write the number with its unit, as in \"1 arcsec / cos(elevation)\"";
        loader.reader.fault(span, message, help);
    }
}
