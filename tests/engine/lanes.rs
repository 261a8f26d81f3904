//! The lanes against the definition: every model, every effect of the library, every instruction
//! set that the machine has, both sweeps, at random points, on the axes, with readings missing.

use std::path::Path;

use homepoint::campaign::Samples;
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::lanes::InstructionSet;
use homepoint::engine::noise::{active_randoms, covariance_of};
use homepoint::engine::open::{Request, open};
use homepoint::engine::rows::Sweep;
use homepoint::engine::{Point, Problem};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::planned;

/// Relative to the largest entry of the same column (residuals: to the largest, a turn apart the
/// same).
const TOLERANCE: f64 = 1e-12;

type Rows = Vec<(DMatrix<f64>, Vec<f64>)>;

fn rows(problem: &Problem, part: usize, run: usize, point: &Point, lanes: bool) -> Rows {
    let mut rows = Vec::new();
    let mut visit = |_: usize, jacobian: &DMatrix<f64>, values: &[f64]| {
        rows.push((jacobian.clone(), values.to_vec()));
    };
    if lanes {
        problem.visit_run(part, run, point, &mut visit);
    } else {
        problem.visit_run_pointwise(part, run, point, &mut visit);
    }
    rows
}

/// A point somewhere near the stated one.
fn near(problem: &Problem, point: &Point, random: &mut ChaCha8Rng) -> Point {
    let step: Vec<f64> = (0..problem.layout.columns.len())
        .map(|column| {
            let small = problem.layout.instances.iter().enumerate().any(|(index, instance)| {
                instance.setting.typical.is_some()
                    && problem.layout.own_columns(index).any(|(_, own)| own == column)
            });
            let size = if small { 0.0 } else { 0.05 };
            size * random.random_range(-1.0..1.0)
        })
        .collect();
    // Delays stay delays.
    let mut moved = problem.moved(point, &step);
    for (index, instance) in problem.layout.instances.iter().enumerate() {
        if instance.name.ends_with("delay") {
            moved.values[index][0] = 2e-3 * random.random_range(-1.0..1.0);
        }
    }
    moved
}

/// The tolerance for an effect. `fract(time / period)` of a time of some thousand periods has lost
/// as many digits as the quotient has before the point, whoever computes it.
fn tolerance(effect: &str) -> f64 {
    if effect == "sampling_grid" { 10.0 * TOLERANCE } else { TOLERANCE }
}

fn agree(problem: &mut Problem, point: &Point, what: &str, tolerance: f64) {
    for part in 0..problem.parts.len() {
        for run in 0..problem.parts[part].runs.len() {
            let expected = rows(problem, part, run, point, false);
            let (count, width) = expected[0].0.shape();
            let mut scale = DMatrix::<f64>::zeros(count, width);
            let mut residual_scale: f64 = 1.0;
            for (jacobian, values) in &expected {
                for j in 0..width {
                    let largest = jacobian.column(j).amax().max(scale[(0, j)]);
                    scale.column_mut(j).fill(largest);
                }
                residual_scale = values.iter().fold(residual_scale, |s, v| s.max(v.abs()));
            }
            for set in InstructionSet::available() {
                for sweep in [Sweep::Forward, Sweep::Backward] {
                    problem.compute_with(set, sweep);
                    let found = rows(problem, part, run, point, true);
                    assert_eq!(found.len(), expected.len());
                    for (sample, (one, due)) in found.iter().zip(&expected).enumerate() {
                        let place = || format!("{what}: {} {sweep:?} {run} {sample}", set.name());
                        for (i, (value, due)) in one.1.iter().zip(&due.1).enumerate() {
                            // Half a turn off, either sign is right.
                            let turn = std::f64::consts::TAU;
                            let off = (value - due).abs();
                            let off = off.min((off - turn).abs());
                            assert!(
                                off <= tolerance * residual_scale,
                                "{}: residual {i} {off:e}",
                                place()
                            );
                        }
                        for i in 0..count {
                            for j in 0..width {
                                let off = (one.0[(i, j)] - due.0[(i, j)]).abs();
                                assert!(
                                    off <= tolerance * scale[(i, j)],
                                    "{}: derivative {i} {j}: {:e} for {:e}",
                                    place(),
                                    one.0[(i, j)],
                                    due.0[(i, j)]
                                );
                            }
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn every_effect_of_the_library_agrees_with_the_definition() {
    let folder = planned::folder("lanes");
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for campaign in ["arm", "robot", "stations"] {
        let path = folder.join(campaign);
        for effect in planned::fitting(&path) {
            let mut problem = planned::problem(&path, &[&effect]);
            let point = planned::typical(&problem);
            let point = near(&problem, &point, &mut random);
            let what = format!("{effect} in {campaign}");
            agree(&mut problem, &point, &what, tolerance(&effect));
        }
    }
    for right in ["clock_steps.right=-1", "clock_steps.right=1"] {
        let mut problem = planned::problem_stated(&folder.join("arm"), &["clock_steps"], &[right]);
        let point = planned::typical(&problem);
        let point = near(&problem, &point, &mut random);
        agree(&mut problem, &point, right, TOLERANCE);
    }
}

#[test]
fn every_example_agrees_with_the_definition() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for name in ["hand_eye", "rail_car", "rotating_arm"] {
        let mut problem = open(&Request::new([examples.join(name)])).unwrap().problem;
        let (start, _) = homepoint::estimate::start::start(&problem);
        let point = near(&problem, &start, &mut random);
        agree(&mut problem, &point, name, TOLERANCE);
    }
}

/// The first sample has its target on the vertical axis of the instrument, where the horizontal
/// angle has no derivative, and later ones pass the axes of the horizontal plane.
#[test]
fn on_the_axes_the_conventions_are_those_of_the_definition() {
    let folder = planned::folder("axes");
    let text = r#"
model = "polar_one_rotation"
[parameters]
radius = { value = "1 m", sigma = "1 mm" }
orientation = { start = ["0 rad", "0 rad", "0 rad"] }
position = { start = ["-1 m", "0 m", "2 m"] }
[measurands]
horizontal = { sigma = "6 urad" }
vertical   = { sigma = "6 urad" }
distance   = { sigma = "8 um" }
[[runs]]
name = "turn"
plan = { trigger = "8 Hz", duration = "20 s", arm_angle = { start = "0 deg", rate = "90 deg/s" } }
"#;
    std::fs::create_dir_all(folder.join("axes")).unwrap();
    std::fs::write(folder.join("axes/campaign.toml"), text).unwrap();
    let mut problem = planned::problem(&folder.join("axes"), &[]);
    let point = Point::start(&problem.layout);
    let first = &rows(&problem, 0, 0, &point, false)[0].0;
    assert_eq!(first.row(0).amax(), 0.0, "{first}");
    agree(&mut problem, &point, "axes", TOLERANCE);
}

/// Gram sums made sample by sample from the definition's rows and covariance.
fn normal_by_definition(problem: &Problem, part: usize, run: usize, point: &Point) -> DMatrix<f64> {
    let data = &problem.parts[part];
    let parameters = problem.parameters(part, run, point);
    let active = active_randoms(data);
    let (mut workspace, mut scratch) = (Vec::new(), Samples::default());
    let mut sum: Option<DMatrix<f64>> = None;
    problem.visit_run_pointwise(part, run, point, &mut |sample, jacobian, values| {
        let seen = data.runs[run].record.sample(sample, &mut scratch);
        let made = covariance_of(data, run, seen, &parameters, &active, &mut workspace);
        let size = jacobian.ncols();
        let mut all = jacobian.clone().insert_column(size, 0.0);
        all.set_column(size, &DVector::from_column_slice(values));
        let whitened =
            made.covariance.cholesky().unwrap().l().solve_lower_triangular(&all).unwrap();
        let product = whitened.transpose() * whitened;
        match &mut sum {
            Some(sum) => *sum += product,
            None => sum = Some(product),
        }
    });
    sum.unwrap()
}

#[test]
fn gram_sums_and_cost_are_those_of_the_definition_with_readings_missing() {
    let folder = planned::folder("gram");
    // Independent readings; readings that share errors; a level that changes from sample to sample.
    let cases: [&[&str]; 3] = [&["collimation"], &["timestamp_jitter"], &["angle_noise_level"]];
    for names in cases {
        let mut problem = planned::problem(&folder.join("arm"), names);
        let mut random = ChaCha8Rng::seed_from_u64(9);
        for run in &mut problem.parts[0].runs {
            run.record.edit(|samples| {
                for value in samples.readings.iter_mut().flatten() {
                    if random.random_range(0.0..1.0) < 0.2 {
                        *value = f64::NAN;
                    }
                }
            });
        }
        let part = &mut problem.parts[0];
        for (sigma, one) in part.random_sigma.iter_mut().zip(&part.system.randoms) {
            *sigma = one.typical.unwrap_or(0.0);
        }
        let start = planned::typical(&problem);
        let point = near(&problem, &start, &mut random);
        for set in InstructionSet::available() {
            problem.compute_with(set, Sweep::Backward);
            problem.refresh_weights(&point);
            let normal = problem.normal(&point);
            let mut cost = 0.0;
            let mut readings = 0;
            for (run, found) in normal.runs.iter().enumerate() {
                let due = normal_by_definition(&problem, 0, run, &point);
                let size = due.nrows();
                for i in 0..size {
                    for j in 0..size {
                        let scale = (due[(i, i)] * due[(j, j)]).sqrt();
                        let off = (found.gram[(i, j)] - due[(i, j)]).abs();
                        assert!(off <= 1e-11 * scale, "{names:?} {} {i} {j} {off:e}", set.name());
                    }
                }
                cost += due[(size - 1, size - 1)];
                readings += found.readings;
            }
            let priors: f64 = normal.priors.iter().map(|row| row.residual.powi(2)).sum();
            let found = problem.cost(&point);
            assert!((found - cost - priors).abs() <= 1e-11 * found, "{found} {cost}");
            assert_eq!(readings, problem.reading_count());
        }
    }
}

#[test]
fn every_number_of_threads_gives_the_same_bits() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
    let problem = open(&Request::new([example])).unwrap().problem;
    let (point, _) = homepoint::estimate::start::start(&problem);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (problem.normal(&point), problem.cost(&point)))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}
