//! The readings of an example, `rotating_arm` unless another is asked for, drawn anew with effects
//! in them.

use std::path::{Path, PathBuf};

use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::{Diagnosis, diagnose};
use homepoint::engine::layout::Instance;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;

/// Where it is.
pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm")
}

/// Its diagnosis with the whole library.
pub(crate) fn run(problem: Problem, opened: &Opened) -> Diagnosis {
    let (recipes, wanted) = (opened.recipes.clone(), Wanted::default());
    diagnose(problem, recipes, &wanted, &Options::default()).unwrap()
}

/// The example's readings drawn with some effects of the library; what is not set has its usual
/// size.
pub(crate) fn drawn(with: &[&str], set: &[&str], seed: u64) -> (Opened, Problem) {
    let mut request = Request::new([folder()]);
    request.with = with.iter().map(|name| (*name).to_owned()).collect();
    request.set = set.iter().map(|text| (*text).to_owned()).collect();
    let is_set = |name: &str| request.set.iter().any(|text| text.starts_with(name));
    drawn_at(&request, seed, &|one| {
        (!is_set(&one.name)).then_some(one.setting.typical.unwrap_or(0.0))
    })
}

/// The same of the campaigns of a request with values of the effects' parameters as `value` says;
/// as stated where it says nothing.
pub(crate) fn drawn_at(
    request: &Request,
    seed: u64,
    value: &dyn Fn(&Instance) -> Option<f64>,
) -> (Opened, Problem) {
    let opened = open(&Request::new(&request.campaigns)).unwrap();
    let nominal = calibrate(opened.problem.clone(), &Options::default()).unwrap();
    let mut truth = open(request).unwrap().problem;
    let mut point = Point::stated(&truth.layout);
    for (index, instance) in truth.layout.instances.iter().enumerate() {
        let same = |one: &Instance| one.name == instance.name && one.of == instance.of;
        if let Some(known) = nominal.problem.layout.instances.iter().position(same) {
            point.values[index] = nominal.fit.point.values[known];
        } else if let Some(value) = value(instance) {
            point.values[index][0] = value;
        }
    }
    for part in &mut truth.parts {
        for (sigma, random) in part.random_sigma.iter_mut().zip(&part.system.randoms) {
            *sigma = random.sigma.or(random.typical).unwrap_or(0.0);
        }
    }
    simulate(&mut truth, &point, seed, true);
    let mut parts = opened.problem.parts.clone();
    for (part, other) in parts.iter_mut().zip(&truth.parts) {
        part.runs.clone_from(&other.runs);
    }
    (opened, Problem::new(parts))
}
