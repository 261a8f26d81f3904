//! How long do residual, Jacobian and whitened normal equations of one sample take, against the
//! model written by hand?
//!
//! Three readings, 13 unknowns, one thread. The residuals alone (the cost) beside it. See
//! docs/performance.md.

#[path = "by_hand/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod by_hand;
#[path = "by_hand/timing.rs"]
mod timing;

use std::error::Error;
use std::hint::black_box;

use by_hand::data::{Plan, SIGMA};
use by_hand::engine::Engine;
use by_hand::jacobian::Model;
use by_hand::process::on_threads;
use by_hand::{Columns, Parameters, normal};
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::rows::Sweep;
use timing::{Way, compare, criterion};

const SAMPLES: usize = 100_000;

fn main() -> Result<(), Box<dyn Error>> {
    let (problem, point) = Plan::of(SAMPLES).make()?;
    let runs = Columns::of_all(&problem);
    let parameters = Parameters::of(&problem, 0, &point);
    let engines = Engine::all(&problem, &[Sweep::Backward]);
    let cost = || {
        black_box(problem.cost(black_box(&point)));
    };
    let by_hand = || {
        let model = Model::new(black_box(parameters));
        for data in &runs {
            black_box(&normal::gram(&model, data, SIGMA));
        }
    };
    on_threads(1, || {
        let normal = |engine: &Engine| {
            black_box(engine.problem.normal(black_box(&point)));
        };
        let mut ways: Vec<Way<'_>> = engines
            .iter()
            .map(|engine| Way::new(&engine.name, move || normal(engine)))
            .chain([Way::new("homepoint, cost alone", cost), Way::new("by hand", by_hand)])
            .collect();
        compare(&mut criterion(), "normal equations", (SAMPLES, "sample"), &mut ways)
    })??;
    Ok(())
}
