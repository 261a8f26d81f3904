//! tiny-solver: one factor a sample, its own dual numbers, rotation manifold and
//! Levenberg-Marquardt.
//!
//! `tiny-solver-peer JOB FOLDER` prints one JSON line, as every peer does.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::hint::black_box;
use std::ops::Mul;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::{DVector, RealField, dvector};
use serde_json::{Value, json};
use tiny_solver::Optimizer;
use tiny_solver::factors::Factor;
use tiny_solver::levenberg_marquardt_optimizer::LevenbergMarquardtOptimizer;
use tiny_solver::manifold::so3::QuaternionManifold;
use tiny_solver::optimizer::OptimizerOptions;
use tiny_solver::problem::Problem;

/// One sample: angle, rate, readings.
struct Sample {
    angle: f64,
    rate: f64,
    reading: [f64; 3],
    sigma: [f64; 3],
}

/// Parameters: quaternion x y z w; radius, position, delays, collimation, index, offset.
impl<T: RealField> Factor<T> for Sample {
    fn residual_func(&self, parameters: &[DVector<T>]) -> DVector<T> {
        let c = |value: f64| T::from_f64(value).unwrap();
        let [i, j, k, w] = [0, 1, 2, 3].map(|n| parameters[0][n].clone());
        let rest = &parameters[1];
        let two = |a: &T, b: &T| c(2.0) * a.clone() * b.clone();
        let first = [
            c(1.0) - two(&j, &j) - two(&k, &k),
            two(&i, &j) + two(&w, &k),
            two(&i, &k) - two(&w, &j),
        ];
        let second = [
            two(&i, &j) - two(&w, &k),
            c(1.0) - two(&i, &i) - two(&k, &k),
            two(&j, &k) + two(&w, &i),
        ];
        let point = |delay: &T| {
            let angle = c(self.angle) + delay.clone() * c(self.rate);
            let x = rest[0].clone() * angle.clone().cos();
            let y = rest[0].clone() * angle.sin();
            [0, 1, 2].map(|n| {
                first[n].clone() * x.clone() + second[n].clone() * y.clone() + rest[1 + n].clone()
            })
        };
        let square = |a: &T| a.clone() * a.clone();
        let [x, y, z] = point(&rest[4]);
        let sine = (c(1.0) + square(&z) / (square(&x) + square(&y))).sqrt();
        let horizontal = y.atan2(x) + rest[7].clone() * sine;
        let [x, y, z] = point(&rest[5]);
        let vertical = (square(&x) + square(&y)).sqrt().atan2(z) + rest[8].clone();
        let [x, y, z] = point(&rest[6]);
        let distance = (square(&x) + square(&y) + square(&z)).sqrt() + rest[9].clone();
        let mut difference = c(self.reading[0]) - horizontal;
        // Whole turns; a dual number compares by its value.
        while difference > c(PI) {
            difference -= c(2.0 * PI);
        }
        while difference <= c(-PI) {
            difference += c(2.0 * PI);
        }
        dvector![
            difference / c(self.sigma[0]),
            (c(self.reading[1]) - vertical) / c(self.sigma[1]),
            (c(self.reading[2]) - distance) / c(self.sigma[2])
        ]
    }
}

fn read(folder: &Path, name: &str) -> Vec<f64> {
    let bytes = std::fs::read(folder.join(name)).unwrap();
    bytes.chunks_exact(8).map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap())).collect()
}

/// The data's samples as one problem.
fn problem(folder: &Path) -> Problem {
    let (all, sigma) = (read(folder, "samples.f64"), read(folder, "sigma.f64"));
    let count = all.len() / 5;
    let mut problem = Problem::new();
    for n in 0..count {
        let sample = Sample {
            angle: all[n],
            rate: all[count + n],
            reading: [2, 3, 4].map(|row| all[row * count + n]),
            sigma: [sigma[0], sigma[1], sigma[2]],
        };
        problem.add_residual_block(3, &["q", "rest"], Box::new(sample), None);
    }
    problem.set_variable_manifold("q", Arc::new(QuaternionManifold));
    problem
}

/// The peers' common state as tiny-solver's parameters.
fn split(state: &[f64]) -> HashMap<String, DVector<f64>> {
    let rest = std::iter::once(state[0]).chain(state[5..].iter().copied());
    HashMap::from([
        ("q".to_owned(), dvector![state[2], state[3], state[4], state[1]]),
        ("rest".to_owned(), DVector::from_iterator(10, rest)),
    ])
}

fn timed<T>(mut work: impl FnMut() -> T) -> f64 {
    black_box(work());
    let (mut times, begin) = (Vec::new(), Instant::now());
    while times.len() < 5 || begin.elapsed() < Duration::from_millis(500) {
        let start = Instant::now();
        black_box(work());
        times.push(start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn batch(folder: &Path) -> Value {
    let begin = Instant::now();
    let problem = problem(folder);
    let options = OptimizerOptions {
        min_abs_error_decrease_threshold: 0.0,
        min_rel_error_decrease_threshold: 1e-10,
        ..OptimizerOptions::default()
    };
    let start = split(&read(folder, "start.f64"));
    let found = LevenbergMarquardtOptimizer::default().optimize(&problem, &start, Some(options));
    let seconds = begin.elapsed().as_secs_f64();
    let found = found.unwrap();
    let (q, rest) = (&found["q"], &found["rest"]);
    let mut state = vec![rest[0], q[3], q[0], q[1], q[2]];
    state.extend(rest.iter().skip(1));
    json!({"job": "batch", "seconds": seconds, "state": state})
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let (job, folder) = (arguments[1].as_str(), Path::new(&arguments[2]));
    if job == "batch" {
        println!("{}", batch(folder));
        return;
    }
    let problem = problem(folder);
    let blocks = problem.initialize_parameter_blocks(&split(&read(folder, "truth.f64")));
    let columns = problem.get_variable_name_to_col_idx_dict(&blocks);
    let structure = problem.build_symbolic_structure(&blocks, 13, &columns);
    let linearise = || problem.compute_residual_and_jacobian(&blocks, &columns, &structure);
    let count = problem.total_residual_dimension / 3;
    let tell = |seconds: f64| json!({"job": "time", "ns_per_sample": seconds / count as f64 * 1e9});
    let line = match job {
        "check" => {
            let (residual, jacobian) = linearise();
            // tiny-solver's columns: turn, radius, position, ...
            let dense = jacobian.to_dense();
            let order = [3, 0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11, 12];
            let rows = 0..3 * count;
            let residuals: Vec<f64> = rows.clone().map(|row| residual[(row, 0)]).collect();
            let jacobians: Vec<f64> =
                rows.flat_map(|row| order.map(|column| dense[(row, column)])).collect();
            json!({"job": "check", "residual": residuals, "jacobian": jacobians})
        }
        "J" => tell(timed(linearise)),
        "J+NE" => tell(timed(|| {
            // As its sparse Cholesky solver forms them.
            let (residual, jacobian) = linearise();
            let transposed = jacobian.as_ref().transpose();
            let hessian = transposed.to_col_major().unwrap().mul(jacobian.as_ref());
            let gradient = transposed.mul(&residual);
            (hessian, gradient)
        })),
        other => panic!("no job `{other}`"),
    };
    println!("{line}");
}
