//! How long does one linearisation of a campaign take, and how long the whole joint estimate?

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::start::start;

fn rotating_arm(criterion: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
    let Ok(opened) = open(&Request::new([folder])) else { return };
    let problem = opened.problem;
    let (point, _) = start(&problem);
    criterion.bench_function("residuals, 4284 readings", |bench| {
        bench.iter(|| problem.cost(black_box(&point)))
    });
    criterion.bench_function("Gram sums, 16 unknowns", |bench| {
        bench.iter(|| problem.normal(black_box(&point)))
    });
    criterion.bench_function("joint estimate", |bench| {
        bench.iter(|| {
            calibrate(black_box(problem.clone()), &Options::default()).map(|found| found.fit.cost)
        });
    });
}

criterion_group!(benches, rotating_arm);
criterion_main!(benches);
