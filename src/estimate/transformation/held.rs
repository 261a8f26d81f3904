//! The reference runs alone with delays held: the paper's way, for any delays.
//!
//! The models are compiled once; another fit is another value of the delays.

use crate::engine::Problem;
use crate::estimate::batch::Options;
use crate::estimate::calibrate::calibrate;
use crate::estimate::transformation::{From, NoTransformation, Transformation, alone, of_fit};

/// A campaign whose delays are held.
pub(super) struct Held<'a> {
    /// All readings.
    whole: Problem,
    /// Those of the reference runs.
    alone: Problem,
    /// Where levels of noise are from, if not from the reference runs.
    levels: Option<&'a Problem>,
    part: usize,
    /// The delay parameters that are held for it.
    pub(super) delays: Vec<usize>,
    /// Where the campaign itself holds one of them: parameter and setup.
    stated: Vec<(usize, String)>,
}

impl<'a> Held<'a> {
    /// Of one campaign; the delays of others that are estimated with it are held at zero.
    pub(super) fn new(
        problem: &Problem,
        levels: Option<&'a Problem>,
        part: usize,
    ) -> Result<Self, NoTransformation> {
        let delays = free_delays(problem, part);
        let mut parts = problem.parts.clone();
        for (p, held) in parts.iter_mut().enumerate() {
            for index in free_delays(problem, p) {
                for setting in held.system.settings_mut(index).filter(|one| !one.fixed) {
                    (setting.fixed, setting.sigma, setting.value) = (true, None, Some(vec![0.0]));
                }
            }
        }
        let whole = Problem::new(parts);
        let alone = alone(&whole, part).ok_or(NoTransformation::NoReference)?;
        let own = problem.parts[part].system.of_setups.iter().filter(|one| one.setting.fixed);
        let stated = own.map(|one| (one.parameter, one.setup.clone())).collect();
        Ok(Self { whole, alone, levels, part, delays, stated })
    }

    /// The fit with these values (s) of the delay parameters; zero without.
    pub(super) fn fit(&mut self, values: &[f64]) -> Result<Transformation, NoTransformation> {
        for (index, parameter) in self.delays.iter().enumerate() {
            let value = values.get(index).copied().unwrap_or(0.0);
            for problem in [&mut self.whole, &mut self.alone] {
                hold(problem, self.part, (*parameter, value), &self.stated);
            }
        }
        let undetermined = |why: String| NoTransformation::NotDetermined(why);
        let fit = calibrate(self.alone.clone(), &Options::default())
            .map_err(|error| undetermined(error.to_string()))?;
        if !fit.is_sound() {
            let words: Vec<&str> = fit.unobservable.iter().map(|one| one.words.as_str()).collect();
            let why = if words.is_empty() { fit.fit.outcome.to_string() } else { words.join("; ") };
            return Err(undetermined(why));
        }
        let mut whole = self.whole.clone();
        let levels = self.levels.unwrap_or(&fit.problem);
        for (part, fitted) in whole.parts.iter_mut().zip(&levels.parts) {
            part.random_sigma.clone_from(&fitted.random_sigma);
        }
        Ok(of_fit(From::Iterated, whole, &fit))
    }
}

/// Gives a delay that is held another value, but where the campaign itself holds it.
fn hold(
    problem: &mut Problem,
    part: usize,
    (parameter, value): (usize, f64),
    stated: &[(usize, String)],
) {
    let is_free = |setup: &str| !stated.iter().any(|(own, of)| *own == parameter && of == setup);
    let own = &mut problem.parts[part];
    own.system.settings[parameter].value = Some(vec![value]);
    let of_setups = own.system.of_setups.iter_mut();
    for one in of_setups.filter(|one| one.parameter == parameter && is_free(&one.setup)) {
        one.setting.value = Some(vec![value]);
    }
    for (run, used) in own.runs.iter().zip(&problem.layout.used[part]) {
        if is_free(&own.setups[run.setup]) {
            problem.layout.instances[used[parameter]].setting.value = Some(vec![value]);
        }
    }
}

/// The delay parameters of a campaign that are not held already.
fn free_delays(problem: &Problem, part: usize) -> Vec<usize> {
    let system = &problem.parts[part].system;
    let is_free = |index: &usize| {
        !system.declared[*index].delay_of.is_empty() && !system.settings[*index].fixed
    };
    (0..system.settings.len()).filter(is_free).collect()
}
