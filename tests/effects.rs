//! Every effect of the library on planned campaigns: its parameters change predictions as their
//! derivatives say, random ones scatter readings, and the order of listing changes nothing.
#![expect(clippy::unwrap_used, reason = "a failed test should stop")]

use std::path::{Path, PathBuf};

use homepoint::engine::gram::LeastSquares;
use homepoint::engine::open::{Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::library::Library;
use homepoint::system::testable;

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

fn folder() -> PathBuf {
    let folder = std::env::temp_dir().join(format!("homepoint_effects_{}", std::process::id()));
    for (name, text) in [("arm", ARM), ("robot", ROBOT), ("stations", STATIONS)] {
        std::fs::create_dir_all(folder.join(name)).unwrap();
        std::fs::write(folder.join(name).join("campaign.toml"), text).unwrap();
    }
    folder
}

fn problem(campaign: &Path, with: &[&str]) -> Problem {
    let mut request = Request::new([campaign]);
    request.with = with.iter().map(|name| (*name).to_owned()).collect();
    let mut problem = open(&request).unwrap().problem;
    // Every reading there: zeros do, only predictions are compared.
    for part in &mut problem.parts {
        for run in &mut part.runs {
            run.samples.readings.iter_mut().for_each(|column| column.fill(0.0));
        }
    }
    Problem::new(problem.parts)
}

/// The point with every parameter of effects at a size typical for it.
fn typical(problem: &Problem) -> Point {
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
fn effect_columns(problem: &Problem) -> Vec<(usize, f64, String)> {
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

#[test]
fn every_effect_changes_readings_as_its_derivatives_say() {
    let folder = folder();
    let library = Library::builtin().unwrap();
    let mut seen = Vec::new();
    for effect in library.effects().filter(|effect| !effect.builtin) {
        let mut fits = false;
        for campaign in ["arm", "robot", "stations"] {
            let campaign = folder.join(campaign);
            let nominal = open(&Request::new([&campaign])).unwrap();
            let overrides = &nominal.campaigns[0].parameters;
            if testable(&nominal.models[0], effect, overrides).is_err() {
                continue;
            }
            fits = true;
            let problem = problem(&campaign, &[&effect.name]);
            let columns = effect_columns(&problem);
            let randoms =
                problem.parts[0].system.randoms.iter().filter(|r| r.effect.is_some()).count();
            let noise =
                (0..problem.layout.instances.len()).any(|i| problem.layout.is_noise_only(i));
            assert!(
                !columns.is_empty() || randoms > 0 || noise,
                "{} has nothing to estimate",
                effect.name
            );
            compare(&problem, &columns, &effect.name);
            if randoms > 0 || noise {
                scatters(&problem, &effect.name);
            }
        }
        assert!(fits, "{} fits none of the campaigns", effect.name);
        seen.push(effect.name.clone());
    }
    drop(std::fs::remove_dir_all(&folder));
    assert!(seen.len() > 60, "{seen:?}");
}

/// Jacobian columns against the change of predictions by a small step.
fn compare(problem: &Problem, columns: &[(usize, f64, String)], effect: &str) {
    let point = typical(problem);
    let n = problem.columns().len();
    let mut acted = vec![false; columns.len()];
    for run in 0..problem.parts[0].runs.len() {
        let touched = problem.columns().touched_by(run);
        let mut jacobians = Vec::new();
        problem.visit_run(0, run, &point, &mut |_, jacobian, _| jacobians.push(jacobian.clone()));
        for (number, (column, size, name)) in columns.iter().enumerate() {
            let Some(local) = touched.iter().position(|t| t == column) else { continue };
            let h = size * 1e-3;
            let shifted = |sign: f64| {
                let mut step = vec![0.0; n];
                step[*column] = sign * h;
                problem.residuals(0, run, &problem.moved(&point, &step))
            };
            let (plus, minus) = (shifted(1.0), shifted(-1.0));
            for (sample, jacobian) in jacobians.iter().enumerate() {
                for row in 0..jacobian.nrows() {
                    let exact = jacobian[(row, local)];
                    acted[number] |= exact != 0.0;
                    let change = -(plus[sample][row] - minus[sample][row]);
                    let expected = 2.0 * h * exact;
                    // Readings of order 1 leave 1e-15 of rounding; the rest is the third derivative.
                    let tolerance = 5e-15 + 1e-4 * expected.abs();
                    assert!(
                        (change - expected).abs() < tolerance,
                        "{effect} {name}: {change:e} {expected:e} run {run} sample {sample}"
                    );
                }
            }
        }
    }
    for ((_, _, name), acted) in columns.iter().zip(acted) {
        assert!(acted, "{effect}: {name} changes no reading");
    }
}

/// Drawn readings scatter otherwise with the effect than without it, under the same seed.
fn scatters(problem: &Problem, effect: &str) {
    let point = typical(problem);
    let drawn = |on: bool| {
        let mut changed = problem.clone();
        for part in &mut changed.parts {
            for (sigma, random) in part.random_sigma.iter_mut().zip(&part.system.randoms) {
                *sigma = if on { random.typical.unwrap_or(0.0) } else { 0.0 };
            }
        }
        let at = if on { point.clone() } else { Point::stated(&problem.layout) };
        simulate(&mut changed, &at, 7, true);
        changed.parts[0].runs[0].samples.readings.clone()
    };
    let (with, without) = (drawn(true), drawn(false));
    assert!(with.iter().flatten().all(|reading| reading.is_finite()), "{effect}");
    assert_ne!(with, without, "{effect} changes no drawn reading");
}

#[test]
fn the_order_of_listing_changes_nothing() {
    let folder = folder().join("arm");
    let effects = [
        "trunnion_tilt",
        "encoder_eccentricity",
        "rate_dependent_delay",
        "gravity_sag",
        "arm_radius",
    ];
    let forwards = problem(&folder, &effects);
    let mut reversed = effects;
    reversed.reverse();
    let backwards = problem(&folder, &reversed);
    let (a, b) = (typical(&forwards), typical(&backwards));
    for run in 0..3 {
        assert_eq!(forwards.residuals(0, run, &a), backwards.residuals(0, run, &b));
    }
    let names = |problem: &Problem| -> Vec<String> {
        problem.layout.instances.iter().map(|instance| instance.name.clone()).collect()
    };
    assert_eq!(names(&forwards), names(&backwards));
}
