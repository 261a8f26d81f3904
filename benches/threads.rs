//! How much faster are two threads than one?
//!
//! Normal equations, cost, and the delays of readings of the polar instrument.

#[path = "by_hand/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod by_hand;
#[path = "by_hand/timing.rs"]
mod timing;

use std::error::Error;
use std::hint::black_box;

use by_hand::COLUMNS;
use by_hand::data::{Plan, covariance};
use homepoint::engine::gram::LeastSquares;
use homepoint::estimate::delays::delays;
use nalgebra::DMatrix;
use rayon::{ThreadPool, ThreadPoolBuilder};
use timing::{Way, compare, criterion};

const SAMPLES: usize = 1_000_000;
const SAMPLES_OF_DELAYS: usize = 200_000;

/// Times work on two threads against the same on one.
fn question(
    pools: &[ThreadPool; 2],
    name: &str,
    samples: usize,
    work: impl Fn() + Sync,
) -> Result<(), Box<dyn Error>> {
    let [one, two] = pools;
    let mut ways = [
        Way::new("two threads", || two.install(&work)),
        Way::new("one thread", || one.install(&work)),
    ];
    compare(&mut criterion(), name, (samples, "sample"), &mut ways)?;
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build();
    let pools = [pool(1)?, pool(2)?];
    let (problem, point) = Plan::of(SAMPLES).make()?;
    question(&pools, "threads, normal equations", SAMPLES, || {
        black_box(problem.normal(black_box(&point)));
    })?;
    question(&pools, "threads, cost", SAMPLES, || {
        black_box(problem.cost(black_box(&point)));
    })?;
    let (problem, point) = Plan::of(SAMPLES_OF_DELAYS).make()?;
    let sigma = covariance();
    let matrix = DMatrix::from_fn(COLUMNS, COLUMNS, |i, j| sigma[i][j]);
    let runs: Vec<usize> = (0..problem.parts[0].runs.len()).collect();
    question(&pools, "threads, Newton delays", SAMPLES_OF_DELAYS, || {
        black_box(delays(&problem, 0, &runs, black_box(&point), &matrix, 0.5));
    })?;
    Ok(())
}
