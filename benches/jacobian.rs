//! How long do the residual and the Jacobian of one sample take, against the model written by hand?
//!
//! Three readings, 13 unknowns, one thread. See docs/performance.md.

#[path = "by_hand/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod by_hand;
#[path = "by_hand/timing.rs"]
mod timing;

use std::error::Error;
use std::hint::black_box;

use by_hand::data::Plan;
use by_hand::engine::Engine;
use by_hand::jacobian::Model;
use by_hand::process::on_threads;
use by_hand::{Columns, Parameters};
use homepoint::engine::Problem;
use homepoint::engine::rows::Sweep;
use timing::{Way, compare, criterion};

const SAMPLES: usize = 100_000;

fn main() -> Result<(), Box<dyn Error>> {
    let (problem, point) = Plan::of(SAMPLES).make()?;
    let engines = Engine::all(&problem, &[Sweep::Backward, Sweep::Forward]);
    let runs = Columns::of_all(&problem);
    let parameters = Parameters::of(&problem, 0, &point);
    let rows = |problem: &Problem| {
        for run in 0..runs.len() {
            problem.visit_rows(0, run, black_box(&point), &mut |rows| {
                black_box(rows.lanes);
            });
        }
    };
    let by_hand = || {
        let model = Model::new(black_box(parameters));
        for data in &runs {
            for sample in 0..data.len() {
                black_box(&model.rows(data, sample, [1.0; 3]));
            }
        }
    };
    on_threads(1, || {
        let mut ways: Vec<Way<'_>> = engines
            .iter()
            .map(|engine| Way::new(&engine.name, || rows(&engine.problem)))
            .chain([Way::new("by hand", by_hand)])
            .collect();
        compare(&mut criterion(), "residual and Jacobian", (SAMPLES, "sample"), &mut ways)
    })??;
    Ok(())
}
