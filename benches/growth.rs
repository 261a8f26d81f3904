//! How does time grow with samples, runs, setups and effects?
//!
//! Fits `time = constant · size^exponent` to the medians over a range of sizes and prints the
//! exponents. Expected: 1 for samples, near 0 for runs and setups at a fixed number of samples (the
//! normal matrix is an arrow), at most 1 for effects.

#[path = "by_hand/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod by_hand;
#[path = "by_hand/timing.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod timing;

use std::error::Error;
use std::fmt::Write as _;
use std::hint::black_box;

use by_hand::data::Plan;
use by_hand::process::{on_threads, say};
use homepoint::engine::Point;
use homepoint::engine::gram::LeastSquares;
use homepoint::estimate::batch::{Options, fit};
use timing::{Way, medians};

/// Effects with parameters of their own that act on the polar instrument.
const EFFECTS: [&str; 16] = [
    "collimation",
    "vertical_index",
    "distance_offset",
    "encoder_eccentricity",
    "encoder_second_harmonic",
    "trunnion_tilt",
    "horizontal_circle_eccentricity",
    "horizontal_circle_second",
    "vertical_circle_eccentricity",
    "vertical_circle_second",
    "transit_offset",
    "beam_offset",
    "distance_cyclic",
    "bearing_wobble",
    "radial_runout_second",
    "gravity_sag",
];

/// Slope of a straight line through the logarithms.
fn exponent(sizes: &[usize], seconds: &[f64]) -> f64 {
    let n = sizes.len() as f64;
    let points: Vec<(f64, f64)> =
        sizes.iter().zip(seconds).map(|(size, time)| ((*size as f64).ln(), time.ln())).collect();
    let mean_x = points.iter().map(|point| point.0).sum::<f64>() / n;
    let mean_y = points.iter().map(|point| point.1).sum::<f64>() / n;
    let product: f64 = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let square: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    product / square
}

/// Times one linearisation, and one whole fit from the truth, of a plan at each size.
fn grow<'a>(
    what: &str,
    sizes: &[usize],
    plan: impl Fn(usize) -> Plan<'a>,
) -> Result<(), Box<dyn Error>> {
    let (mut linear, mut fitted) = (Vec::new(), Vec::new());
    let mut text = format!("\ngrowth with {what}\n");
    for size in sizes {
        let (problem, truth) = plan(*size).make()?;
        let once = Options { max_iterations: 1, ..Options::default() };
        let mut fitting = problem.clone();
        let start: Point = truth.clone();
        let mut ways = [
            Way::new("linearisation", || drop(black_box(problem.normal(black_box(&truth))))),
            Way::new("iteration", || drop(black_box(fit(&mut fitting, start.clone(), &once)))),
        ];
        let seconds = medians(&mut ways);
        linear.push(seconds[0]);
        fitted.push(seconds[1]);
        let columns = problem.layout.columns.len();
        let _ = writeln!(
            text,
            "  {size:>7}: {columns:>4} unknowns, linearisation {:.2} ms, iteration of a fit {:.2} ms",
            1e3 * seconds[0],
            1e3 * seconds[1]
        );
    }
    let (a, b) = (exponent(sizes, &linear), exponent(sizes, &fitted));
    let _ = writeln!(text, "  exponent: linearisation {a:.2}, iteration {b:.2}");
    say(&text)?;
    Ok(())
}

fn all() -> Result<(), Box<dyn Error>> {
    grow("samples", &[4_000, 16_000, 64_000], Plan::of)?;
    grow("runs with delays of their own, 16,000 samples", &[4, 16, 64], |runs| Plan {
        runs,
        delays_by_run: true,
        ..Plan::of(16_000)
    })?;
    grow("setups, 8 runs each, 16,000 samples", &[2, 8, 32], |setups| Plan {
        setups,
        runs: 8 * setups,
        ..Plan::of(16_000)
    })?;
    grow("effects, 4,000 samples", &[2, 4, 8, 16], |effects| Plan {
        effects: &EFFECTS[..effects],
        ..Plan::of(4_000)
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    on_threads(1, || all().map_err(|error| error.to_string()))??;
    Ok(())
}
