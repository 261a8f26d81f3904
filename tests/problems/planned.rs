//! Planned campaigns on which every effect of the library can act: accelerations, two setups,
//! several rates, both senses of rotation; an arm with a platform, a robot, two stations.
//!
//! Include it with `#[path = "problems/planned.rs"] mod planned;`.

use std::path::Path;

use homepoint::engine::open::{Request, open};
use homepoint::engine::{Point, Problem};
use homepoint::library::Library;
use homepoint::system::candidates;
use nalgebra::DMatrix;

use crate::folder::Folder;

const ARM: &str = r#"
model = "polar_two_rotations"
[parameters]
radius      = { value = "1.15 m", sigma = "10 um" }
orientation = { start = ["0.3 rad", "1.2 rad", "-0.4 rad"] }
position    = { start = ["0.3 m", "1.6 m", "0.2 m"] }
"encoder_interpolation.lines" = { value = "2048", fixed = true }
"sampling_grid.period"        = { value = "1 ms", fixed = true }
[measurands]
horizontal = { sigma = "6 urad" }
vertical   = { sigma = "6 urad" }
distance   = { sigma = "8 um" }
[[runs]]
name = "fast"
plan = { trigger = "9.7 Hz", duration = "8 s", arm_angle = { start = "10 deg", rate = "100 deg/s" }, platform_angle = { start = "5 deg", rate = "20 deg/s" } }
[[runs]]
name = "back"
plan = { trigger = "9.7 Hz", duration = "8 s", arm_angle = { start = "10 deg", rate = "-60 deg/s" }, platform_angle = { start = "5 deg", rate = "-10 deg/s" } }
[[runs]]
name = "ramp"
setup = "B"
plan = { trigger = "9.7 Hz", duration = "4 s", arm_angle = { start = "0 deg", rate = "10 deg/s", acceleration = "20 deg/s^2" }, platform_angle = { start = "0 deg", rate = "15 deg/s" } }
[[runs]]
name = "slow"
setup = "B"
plan = { trigger = "9.7 Hz", duration = "6 s", arm_angle = { start = "40 deg", rate = "-70 deg/s" }, platform_angle = { start = "-30 deg", rate = "8 deg/s" } }
"#;

const ROBOT: &str = r#"
model = "ur5_laser_tracker"
[parameters]
orientation = { start = ["0.1 rad", "0.2 rad", "-0.4 rad"] }
position    = { start = ["1.3 m", "1.6 m", "0.2 m"] }
lever       = { start = ["0.02 m", "0.03 m", "0.05 m"] }
[measurands]
x = { sigma = "0.1 mm" }
y = { sigma = "0.1 mm" }
z = { sigma = "0.1 mm" }
[[runs]]
name = "swing"
plan = { trigger = "11 Hz", duration = "5 s", q1 = { start = "0 deg", rate = "10 deg/s", acceleration = "8 deg/s^2" }, q2 = { start = "-50 deg", rate = "3 deg/s" }, q3 = { start = "30 deg", rate = "5 deg/s" }, q4 = { start = "-70 deg", rate = "-4 deg/s" }, q5 = { start = "90 deg", rate = "6 deg/s" }, q6 = { start = "-80 deg", rate = "-20 deg/s" } }
[[runs]]
name = "again"
setup = "B"
plan = { trigger = "11 Hz", duration = "5 s", q1 = { start = "0 deg", rate = "-30 deg/s", acceleration = "8 deg/s^2" }, q2 = { start = "-50 deg", rate = "3 deg/s" }, q3 = { start = "30 deg", rate = "5 deg/s" }, q4 = { start = "-70 deg", rate = "-4 deg/s" }, q5 = { start = "90 deg", rate = "6 deg/s" }, q6 = { start = "-80 deg", rate = "-20 deg/s" } }
"#;

const STATIONS: &str = r#"
model = "angular_intersection"
[parameters]
radius      = { value = "1.15 m", fixed = true }
orientation = { start = ["0.3 rad", "1.2 rad", "-0.4 rad"] }
position    = { start = ["0.3 m", "2.6 m", "0.2 m"] }
[measurands]
horizontal_a = { sigma = "8 urad" }
vertical_a   = { sigma = "8 urad" }
horizontal_b = { sigma = "8 urad" }
vertical_b   = { sigma = "8 urad" }
[[runs]]
name = "fast"
plan = { trigger = "9.7 Hz", duration = "8 s", arm_angle = { start = "10 deg", rate = "100 deg/s", acceleration = "9 deg/s^2" } }
[[runs]]
name = "back"
setup = "B"
plan = { trigger = "9.7 Hz", duration = "8 s", arm_angle = { start = "10 deg", rate = "-80 deg/s" } }
"#;

/// The campaigns `arm`, `robot` and `stations` in a folder of the test's own.
pub(crate) fn folder(test: &str) -> Folder {
    Folder::new(
        test,
        &[
            ("arm/campaign.toml", ARM),
            ("robot/campaign.toml", ROBOT),
            ("stations/campaign.toml", STATIONS),
        ],
    )
}

/// A campaign with effects, every reading there.
pub(crate) fn problem(campaign: &Path, with: &[&str]) -> Problem {
    problem_stated(campaign, with, &[])
}

/// The same with what is stated.
pub(crate) fn problem_stated(campaign: &Path, with: &[&str], set: &[&str]) -> Problem {
    let mut request = Request::new([campaign]);
    request.set = set.iter().map(|stated| (*stated).to_owned()).collect();
    request.with = with.iter().map(|name| (*name).to_owned()).collect();
    let mut problem = open(&request).unwrap().problem;
    // Every reading there: zeros do, only predictions are compared.
    for part in &mut problem.parts {
        for run in &mut part.runs {
            run.record.edit(|samples| {
                samples.readings.iter_mut().for_each(|column| column.fill(0.0));
                // Stamps of a plan are uniform; here they arrive in bursts of five, 0.2 ms off.
                for (i, time) in samples.uniform_time.iter_mut().enumerate() {
                    *time += 2e-4 * (i % 5) as f64 - 4e-4;
                }
                // They jump by 0.3 ms.
                let count = samples.len();
                samples.jump_time =
                    (0..count).map(|i| if 3 * i > count { 3e-4 } else { 0.0 }).collect();
                samples.jump_ends = [1e-4, 3e-4];
            });
        }
    }
    Problem::new(problem.parts)
}

/// The point with every parameter of effects at a size typical for it.
pub(crate) fn typical(problem: &Problem) -> Point {
    let mut point = Point::stated(&problem.layout);
    for (index, instance) in problem.layout.instances.iter().enumerate() {
        if let Some(size) = instance.setting.typical
            && instance.setting.value.is_none()
        {
            let count = instance.dimension();
            point.values[index][..count].fill(size);
        }
    }
    point
}

/// Columns of the effect's parameters, with their size.
pub(crate) fn effect_columns(problem: &Problem) -> Vec<(usize, f64, String)> {
    let mut columns = Vec::new();
    for (index, instance) in problem.layout.instances.iter().enumerate() {
        let Some(size) = instance.setting.typical else { continue };
        for component in 0..instance.dimension() {
            for (column, _) in problem.layout.columns_of(index, component) {
                columns.push((column, size, instance.name.clone()));
            }
        }
    }
    columns.sort_by_key(|one| one.0);
    columns.dedup_by_key(|one| one.0);
    columns
}

/// Names of the effects that fit a campaign.
pub(crate) fn fitting(campaign: &Path) -> Vec<String> {
    let nominal = open(&Request::new([campaign])).unwrap();
    let overrides = &nominal.campaigns[0].parameters;
    Library::builtin()
        .unwrap()
        .effects()
        .filter(|effect| {
            !effect.builtin && candidates(&nominal.models[0], effect, overrides).is_ok()
        })
        .map(|effect| effect.name.clone())
        .collect()
}

/// Jacobians of all samples of a run.
pub(crate) fn jacobians(problem: &Problem, run: usize, point: &Point) -> Vec<DMatrix<f64>> {
    let mut all = Vec::new();
    problem.visit_run(0, run, point, &mut |_, jacobian, _| all.push(jacobian.clone()));
    all
}
