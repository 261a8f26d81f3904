//! Autocorrelated noise: what the engine's filter makes of rows against the
//! covariance matrix written out.

use homepoint::engine::gauss_markov::{GaussMarkov, Process};
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::open::{Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use nalgebra::{DMatrix, DVector};

/// Relative to the largest entry of a Gram matrix's row and column.
const TOLERANCE: f64 = 1e-11;

/// Runs of several chunks of the lanes.
const PLAN: &str = r#"
model = "polar_one_rotation"
[parameters]
radius      = { value = "1 m", fixed = true }
orientation = { start = ["0.3 rad", "1.2 rad", "-0.4 rad"] }
position    = { start = ["3 m", "1 m", "0.2 m"] }
[measurands]
horizontal = { sigma = "6 urad" }
vertical   = { sigma = "6 urad" }
distance   = { sigma = "8 um" }
[[runs]]
name = "there"
plan = { trigger = "20 Hz", duration = "20 s", arm_angle = { start = "0 deg", rate = "50 deg/s" } }
[[runs]]
name = "back"
plan = { trigger = "20 Hz", duration = "10 s", arm_angle = { start = "0 deg", rate = "-30 deg/s" } }
"#;

fn problem() -> (Problem, Point) {
    let folder = tempfile::tempdir().unwrap();
    let campaign = folder.path().join("campaign.toml");
    std::fs::write(&campaign, PLAN).unwrap();
    let mut problem = open(&Request::new([campaign])).unwrap().problem;
    let point = Point::stated(&problem.layout);
    simulate(&mut problem, &point, 3, true);
    let part = &mut problem.parts[0];
    part.gauss_markov = vec![
        Some(GaussMarkov::two(
            Process { share: 0.5, time: 0.3 },
            Process { share: 0.2, time: 4.0 },
        )),
        None,
        Some(GaussMarkov::one(0.2, 5.0)),
    ];
    // Readings that are missing are passed over.
    part.runs[0].record.edit(|samples| {
        samples.readings[0][3] = f64::NAN;
        samples.readings[0][4] = f64::NAN;
        samples.readings[2][200] = f64::NAN;
    });
    problem.reweight(&point);
    (problem, point)
}

/// The Gram matrix of a run's columns, the residual last, with the inverse of the covariance of
/// each residual component written out.
fn written_out(problem: &Problem, run: usize, point: &Point) -> DMatrix<f64> {
    let part = &problem.parts[0];
    let mut times = Vec::new();
    part.runs[run].record.walk(|stretch| times.extend(stretch.each().map(|one| one.time())));
    let mut rows: Vec<Vec<(f64, DVector<f64>)>> = vec![Vec::new(); part.residual_count()];
    problem.visit_run_pointwise(0, run, point, &mut |number, jacobian, values| {
        for (row, value) in values.iter().enumerate() {
            let mut columns: Vec<f64> = jacobian.row(row).iter().copied().collect();
            columns.push(*value);
            // A reading that is missing has a row of zeros.
            if columns.iter().any(|one| *one != 0.0) {
                let weight = part.sigma[part.measurand_of(row)].recip();
                rows[row].push((times[number], weight * DVector::from_vec(columns)));
            }
        }
    });
    let width = rows[0][0].1.len();
    let mut gram = DMatrix::zeros(width, width);
    for (own, noise) in rows.iter().zip(&part.gauss_markov) {
        let noise = noise.unwrap_or(GaussMarkov::one(0.0, 1.0));
        let covariance = DMatrix::from_fn(own.len(), own.len(), |i, j| {
            let white = if i == j { 1.0 - noise.share() } else { 0.0 };
            let apart = (own[i].0 - own[j].0).abs();
            white + noise.processes().map(|one| one.share * (-apart / one.time).exp()).sum::<f64>()
        });
        let columns = DMatrix::from_fn(own.len(), width, |i, j| own[i].1[j]);
        gram += columns.tr_mul(&covariance.cholesky().unwrap().solve(&columns));
    }
    gram
}

#[test]
fn rows_are_weighed_as_the_covariance_matrix_says() {
    let (problem, point) = problem();
    let normal = problem.normal(&point);
    let mut cost = 0.0;
    for run in 0..problem.parts[0].runs.len() {
        let expected = written_out(&problem, run, &point);
        let found = &normal.runs[run].gram;
        for i in 0..expected.nrows() {
            for j in 0..expected.ncols() {
                let scale = (expected[(i, i)] * expected[(j, j)]).sqrt();
                let apart = (found[(i, j)] - expected[(i, j)]).abs();
                assert!(
                    apart <= TOLERANCE * scale,
                    "run {run}, ({i}, {j}): {apart:e} of {scale:e}"
                );
            }
        }
        cost += expected[(expected.nrows() - 1, expected.ncols() - 1)];
    }
    let priors: f64 = point.priors(&problem.layout).iter().map(|row| row.residual.powi(2)).sum();
    let found = problem.cost(&point);
    assert!((found - cost - priors).abs() <= TOLERANCE * found, "{found} {cost}");
}

#[test]
fn noise_without_a_memory_is_left_as_it_is() {
    let (mut problem, point) = problem();
    problem.parts[0].gauss_markov.fill(None);
    let plain = problem.cost(&point);
    problem.parts[0].gauss_markov.fill(Some(GaussMarkov::one(0.0, 1.0)));
    let white = problem.cost(&point);
    assert!((plain - white).abs() <= 1e-12 * plain, "{plain} {white}");
}
