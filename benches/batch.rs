//! How long does a joint estimate from a million samples take, an iteration of it, and how much
//! memory beyond the data?
//!
//! `cargo bench --bench batch -- 100000` takes another number of samples. Beside it Gauss-Newton on
//! the normal equations by hand, from the same start, on one thread. Memory is that of the whole
//! process (`VmHWM`, reset once the data are made; Linux alone).

#[path = "by_hand/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod by_hand;

use std::error::Error;
use std::fs;
use std::time::Instant;

use by_hand::data::{Plan, SIGMA};
use by_hand::jacobian::Model;
use by_hand::process::{on_threads, say, status};
use by_hand::{COLUMNS, Columns, Parameters, normal};
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::{Options, fit};
use nalgebra::{SMatrix, SVector};

/// Gauss-Newton to a step of 1e-6 standard uncertainties: the point and the number of iterations.
fn by_hand_fit(problem: &Problem, mut point: Point) -> Option<(Point, usize)> {
    let runs = Columns::of_all(problem);
    for iteration in 1..50 {
        let model = Model::new(Parameters::of(problem, 0, &point));
        let mut matrix = SMatrix::<f64, COLUMNS, COLUMNS>::zeros();
        let mut gradient = SVector::<f64, COLUMNS>::zeros();
        for data in &runs {
            let gram = normal::gram(&model, data, SIGMA);
            for i in 0..COLUMNS {
                gradient[i] += gram[i][COLUMNS];
                for j in i..COLUMNS {
                    matrix[(j, i)] += gram[i][j];
                }
            }
        }
        for prior in point.priors(&problem.layout) {
            for (i, a) in &prior.coefficients {
                gradient[*i] += a * prior.residual;
                for (j, b) in prior.coefficients.iter().filter(|(j, _)| j >= i) {
                    matrix[(*j, *i)] += a * b;
                }
            }
        }
        let step = matrix.cholesky()?.solve(&gradient);
        point = point.moved(&problem.layout, step.as_slice());
        if step.dot(&gradient).sqrt() < 1e-6 {
            return Some((point, iteration));
        }
    }
    None
}

fn main() -> Result<(), Box<dyn Error>> {
    let asked = std::env::args().skip(1).find_map(|argument| argument.parse().ok());
    let samples = asked.unwrap_or(1_000_000);
    let (mut problem, _) = Plan::of(samples).make()?;
    let start = Point::start(&problem.layout);
    let data = samples as f64 * 8.0 * 5.0 / 1e6;
    say(&format!("\nbatch: {samples} samples, {data:.0} MB in columns that the model needs\n"))?;
    let by_hand = Instant::now();
    let (point, iterations) = by_hand_fit(&problem, start.clone()).ok_or("no convergence")?;
    let baseline = by_hand.elapsed().as_secs_f64() / iterations as f64;
    let show = |who: &str, iterations: usize, each: f64| {
        say(&format!("  {who:<22} {iterations:>3} iterations of {each:.3} s\n"))
    };
    show("by hand, one thread", iterations, baseline)?;
    for threads in [1, 2] {
        // Writing 5 there resets the peak.
        let reset = fs::write("/proc/self/clear_refs", "5").is_ok();
        let before = status("VmRSS:");
        let began = Instant::now();
        let problem = &mut problem;
        let found = on_threads(threads, || fit(problem, start.clone(), &Options::default()))??;
        let each = began.elapsed().as_secs_f64() / found.iterations as f64;
        show(&format!("homepoint, {threads} thread(s)"), found.iterations, each)?;
        let memory = match (before, status("VmHWM:")) {
            (Some(before), Some(peak)) if reset => format!("{:.0} MB", peak - before),
            _ => "unknown".to_owned(),
        };
        let ratio = baseline / each;
        let apart = problem.cost(&found.point) - problem.cost(&point);
        say(&format!(
            "    {ratio:.3} x as fast as by hand; {memory} above {:.0} MB\n    {:?}; cost {:.0}, {apart:.1e} from by hand's\n",
            before.unwrap_or(f64::NAN),
            found.outcome,
            found.cost,
        ))?;
    }
    Ok(())
}
