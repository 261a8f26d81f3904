//! homepoint's side of the comparison with other solvers: one job on one folder of data.
//!
//! `peers JOB FOLDER` prints one JSON line; `benches/peers/run` calls it, see `docs/peers.md`. Each
//! job is one short closure over the public API. Without arguments it says how it is used.

use std::error::Error;
use std::hint::black_box;
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use homepoint::engine::gram::LeastSquares;
use homepoint::engine::open::{Request, open};
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::newton::{Given, Solved, each_delay};
use nalgebra::DMatrix;
use serde_json::{Value, json};

/// The parameters in the order of every peer's state, and how many numbers each has there.
const PARAMETERS: [(&str, usize); 9] = [
    ("radius", 1),
    ("orientation", 4),
    ("position", 3),
    ("horizontal.delay", 1),
    ("vertical.delay", 1),
    ("distance.delay", 1),
    ("line_of_sight.offset", 1),
    ("vertical_index.index_error", 1),
    ("distance_offset.offset", 1),
];

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let mut out = std::io::stdout();
    let [job, folder] = arguments.as_slice() else {
        writeln!(out, "peers JOB FOLDER: see docs/peers.md")?;
        return Ok(());
    };
    let folder = Path::new(folder);
    if job == "load" {
        let seconds = timed(|| open(&Request::new([folder])).is_ok());
        writeln!(out, "{}", json!({"job": "load", "seconds": seconds}))?;
        return Ok(());
    }
    let problem = open(&Request::new([folder])).map_err(|faults| format!("{faults:?}"))?.problem;
    let truth = point(&problem, &std::fs::read(folder.join("truth.f64"))?)?;
    let samples: usize = problem.parts[0].runs.iter().map(|run| run.record.len()).sum();
    let line = match job.as_str() {
        "check" => check(&problem, &truth)?,
        "J" => per_sample(samples, || linearise(&problem, &truth)),
        "J+NE" => per_sample(samples, || problem.normal(&truth)),
        "newton" => newton(&problem, &truth, samples)?,
        "batch" => batch(problem)?,
        other => return Err(format!("no job `{other}`").into()),
    };
    writeln!(out, "{line}")?;
    Ok(())
}

/// Residuals and Jacobians of all samples, a chunk at a time.
fn linearise(problem: &Problem, point: &Point) -> f64 {
    let mut seen = 0.0;
    for run in 0..problem.parts[0].runs.len() {
        problem.visit_rows(0, run, point, &mut |rows| seen += black_box(rows.lanes)[0][0]);
    }
    seen
}

/// The joint estimate as a user gets it, with its covariance and its check for what is determined.
fn batch(problem: Problem) -> Outcome<Value> {
    let start = Instant::now();
    let found = calibrate(problem, &Options::default())?;
    let seconds = start.elapsed().as_secs_f64();
    let mut state = Vec::new();
    for (name, size) in PARAMETERS {
        state.extend_from_slice(&found.fit.point.values[instance(&found.problem, name)?][..size]);
    }
    let sound = found.is_sound();
    let iterations = found.fit.iterations;
    Ok(json!({"job": "batch", "seconds": seconds, "iterations": iterations, "state": state,
              "sound": sound}))
}

/// Each reading's own delay with its uncertainty.
fn newton(problem: &Problem, point: &Point, samples: usize) -> Outcome<Value> {
    let columns = problem.columns().len();
    let covariance = DMatrix::zeros(columns, columns);
    let given = Given { problem, point, covariance: &covariance, range: 0.5 };
    let runs: Vec<usize> = (0..problem.parts[0].runs.len()).collect();
    let all = |measurand: usize| -> Outcome<Vec<f64>> {
        let mut delays = Vec::with_capacity(samples);
        let delays_of = |_: usize, found: Solved| found.delays().collect::<Vec<f64>>();
        each_delay(&given, 0, &runs, measurand, delays_of, |_, found| {
            delays.extend(found);
            Ok::<_, Box<dyn Error>>(())
        })?;
        Ok(delays)
    };
    let seconds =
        timed(|| (0..3).map(|measurand| all(measurand).map_or(0, |all| all.len())).sum::<usize>());
    let medians: Vec<f64> =
        (0..3).map(|measurand| all(measurand).map(median)).collect::<Outcome<_>>()?;
    Ok(json!({"job": "newton", "ns_per_sample": seconds / samples as f64 * 1e9, "delays": medians}))
}

/// Whitened residuals and Jacobians in the common order of columns.
fn check(problem: &Problem, point: &Point) -> Outcome<Value> {
    let mut columns = Vec::new();
    for (name, _) in PARAMETERS {
        columns
            .extend(problem.layout.own_columns(instance(problem, name)?).map(|(_, column)| column));
    }
    let sigma = &problem.parts[0].sigma;
    let (mut residuals, mut jacobians) = (Vec::new(), Vec::new());
    for run in 0..problem.parts[0].runs.len() {
        problem.visit_run(0, run, point, &mut |_, jacobian, residual| {
            for (row, sigma) in sigma.iter().enumerate() {
                residuals.push(residual[row] / sigma);
                jacobians.extend(columns.iter().map(|c| -jacobian[(row, *c)] / sigma));
            }
        });
    }
    Ok(json!({"job": "check", "residual": residuals, "jacobian": jacobians}))
}

/// The point of a state as all peers write it: doubles, one after the other.
fn point(problem: &Problem, bytes: &[u8]) -> Outcome<Point> {
    let state: Vec<f64> = bytes
        .chunks_exact(8)
        .map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap_or_default()))
        .collect();
    let mut point = Point::start(&problem.layout);
    let mut rest = state.as_slice();
    for (name, size) in PARAMETERS {
        let (here, after) = rest.split_at_checked(size).ok_or("a state has 14 numbers")?;
        point.values[instance(problem, name)?][..size].copy_from_slice(here);
        rest = after;
    }
    Ok(point)
}

/// The only instance of a parameter.
fn instance(problem: &Problem, name: &str) -> Outcome<usize> {
    let found = problem.layout.instances.iter().position(|one| one.name == name);
    found.ok_or_else(|| format!("the campaign has no parameter `{name}`").into())
}

/// Times a job on all samples.
fn per_sample<T>(samples: usize, work: impl FnMut() -> T) -> Value {
    json!({"job": "time", "ns_per_sample": timed(work) / samples as f64 * 1e9})
}

/// Median seconds of repeated calls, after one that is not counted.
fn timed<T>(mut work: impl FnMut() -> T) -> f64 {
    black_box(work());
    let (mut times, begin) = (Vec::new(), Instant::now());
    while times.len() < 5 || begin.elapsed() < Duration::from_millis(500) {
        let start = Instant::now();
        black_box(work());
        times.push(start.elapsed().as_secs_f64());
    }
    median(times)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
