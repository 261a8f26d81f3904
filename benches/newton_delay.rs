//! How long does the delay of one reading with its standard uncertainty take, against the model
//! written by hand, analytically and over dual numbers?
//!
//! Newton to a last step of 1e-14 s, then `u² = (u_m² + J Σ Jᵀ) / m'²` with a full covariance of 13
//! unknowns; one thread. See docs/performance.md.

#[path = "by_hand/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod by_hand;
#[path = "by_hand/timing.rs"]
mod timing;

use std::error::Error;
use std::hint::black_box;

use by_hand::data::{Plan, SIGMA, covariance};
use by_hand::jacobian::Model;
use by_hand::process::on_threads;
use by_hand::{COLUMNS, Columns, Parameters, delay, generic};
use homepoint::estimate::newton::{Given, delays_of_run};
use nalgebra::DMatrix;
use timing::{Way, compare, criterion};

const SAMPLES: usize = 20_000;
/// Farthest delay looked for (s).
const RANGE: f64 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let (problem, point) = Plan::of(SAMPLES).make()?;
    let runs = Columns::of_all(&problem);
    let parameters = Parameters::of(&problem, 0, &point);
    let sigma = covariance();
    let matrix = DMatrix::from_fn(COLUMNS, COLUMNS, |i, j| sigma[i][j]);
    let given = Given { problem: &problem, point: &point, covariance: &matrix, range: RANGE };
    let homepoint = || {
        for run in 0..runs.len() {
            for measurand in 0..3 {
                black_box(delays_of_run(black_box(&given), 0, run, measurand));
            }
        }
    };
    let dual = || {
        for data in &runs {
            black_box(generic::delays(black_box(&parameters), data, &sigma, SIGMA, RANGE));
        }
    };
    let analytic = || {
        let model = Model::new(black_box(parameters));
        for data in &runs {
            black_box(delay::delays(&model, data, &sigma, SIGMA, RANGE));
        }
    };
    on_threads(1, || {
        let mut ways = [
            Way::new("homepoint", homepoint),
            Way::new("by hand, dual numbers", dual),
            Way::new("by hand, analytic", analytic),
        ];
        compare(&mut criterion(), "Newton delay", (3 * SAMPLES, "reading"), &mut ways)
    })??;
    Ok(())
}
