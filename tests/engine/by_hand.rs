//! The model written by hand, against which the engine's speed is measured, gives the engine's
//! numbers: otherwise the comparison would be of different things.

#[path = "../../benches/by_hand/mod.rs"]
#[expect(dead_code, reason = "the benches time it, this test does not")]
mod model;

use homepoint::engine::gram::LeastSquares;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::newton::{Given, ReadingDelay, State, delays_of_run};
use model::data::{Plan, SIGMA, covariance};
use model::delay::Delay;
use model::jacobian::{
    COMMON, COMMON_COLUMNS, DISTANCE_COLUMNS, HORIZONTAL_COLUMNS, Model, Row, VERTICAL_COLUMNS,
};
use model::{COLUMNS, Columns, Parameters, column, delay, generic, normal};
use nalgebra::DMatrix;

/// Relative to what the rounding of the operands can do.
const TOLERANCE: f64 = 1e-12;

/// Common places, and those where angles turn over: the z-axis a centimetre away, the instrument in
/// the plane of the arm (the zenith angle at 90 degrees), the horizontal angle's cut, arm on the
/// axes.
fn plans() -> Vec<Plan<'static>> {
    let with = |orientation, position| Plan { orientation, position, ..Plan::of(4000) };
    vec![
        Plan::of(4000),
        with([0.0; 3], [0.0, 0.0, 1.4]),
        with([0.0; 3], [-1.136, 0.0, 0.5]),
        with([0.0, 0.0, 0.4], [2.0, 0.1, 0.0]),
        with([0.7, 0.1, 2.9], [-2.0, 0.01, -0.3]),
    ]
}

/// A row over all columns, the residual last.
fn full<const N: usize>(row: &Row<N>, own: [usize; N]) -> [f64; COLUMNS + 1] {
    let mut full = [0.0; COLUMNS + 1];
    for (column, value) in COMMON_COLUMNS.into_iter().zip(row.common) {
        full[column] = value;
    }
    for (column, value) in own.into_iter().zip(row.own) {
        full[column] = value;
    }
    full
}

/// So far off the simulated truth that residuals keep their digits.
fn displaced(problem: &Problem, truth: &Point) -> Point {
    let step: Vec<f64> = (0..COLUMNS).map(|i| 1e-3 * (1.0 + i as f64)).collect();
    truth.moved(&problem.layout, &step)
}

/// The arm is turned by six degrees and the instrument moved by centimetres.
fn far_off(problem: &Problem, truth: &Point) -> Point {
    let step: Vec<f64> = (0..COLUMNS)
        .map(|k| {
            let last = column::ORIENTATION[2] == k;
            if last {
                0.1
            } else if column::POSITION.contains(&k) {
                0.03
            } else {
                0.0
            }
        })
        .collect();
    truth.moved(&problem.layout, &step)
}

#[test]
fn the_columns_are_in_the_engines_order() {
    let (problem, _) = Plan::of(80).make().unwrap();
    let names: Vec<(&str, usize)> = [
        ("radius", column::RADIUS),
        ("horizontal.delay", column::DELAY[0]),
        ("vertical.delay", column::DELAY[1]),
        ("distance.delay", column::DELAY[2]),
        ("collimation.offset", column::COLLIMATION),
        ("vertical_index.index_error", column::INDEX_ERROR),
        ("distance_offset.offset", column::DISTANCE_OFFSET),
        ("orientation", column::ORIENTATION[0]),
        ("position", column::POSITION[0]),
    ]
    .into();
    assert_eq!(problem.layout.columns.len(), COLUMNS);
    for (name, first) in names {
        let at = problem.layout.instances.iter().position(|one| one.name == name).unwrap();
        assert_eq!(problem.layout.own_columns(at).next().unwrap().1, first, "{name}");
    }
}

#[test]
fn residuals_and_derivatives_agree() {
    for plan in plans() {
        let (problem, truth) = plan.make().unwrap();
        let point = displaced(&problem, &truth);
        for (r, run) in problem.parts[0].runs.iter().enumerate() {
            let data = Columns::of(run).unwrap();
            let parameters = Parameters::of(&problem, r, &point);
            let model = Model::new(parameters);
            problem.visit_run(0, r, &point, &mut |sample, jacobian, residual| {
                let rows = model.rows(&data, sample, [1.0; 3]);
                let by_hand = [
                    full(&rows.horizontal, HORIZONTAL_COLUMNS),
                    full(&rows.vertical, VERTICAL_COLUMNS),
                    full(&rows.distance, DISTANCE_COLUMNS),
                ];
                for (m, row) in by_hand.iter().enumerate() {
                    let gradient = column::POSITION.map(|k| jacobian[(m, k)].powi(2));
                    let gradient = gradient.iter().sum::<f64>().sqrt();
                    let lever = parameters.radius * gradient;
                    for (k, value) in row.iter().enumerate() {
                        let (engine, scale) = match k {
                            // Readings are up to a turn, or metres.
                            column::RESIDUAL => (residual[m], 6.3 + 1e-3 * gradient),
                            // A sum of products of the gradient with lengths up to the radius.
                            k if column::DELAY.contains(&k) => {
                                (jacobian[(m, k)], lever * data.rate[sample].abs())
                            }
                            k if column::ORIENTATION.contains(&k) => (jacobian[(m, k)], lever),
                            k if k < COLUMNS => (jacobian[(m, k)], gradient),
                            _ => unreachable!(),
                        };
                        let scale = scale.max(engine.abs());
                        assert!(
                            (engine - value).abs() <= TOLERANCE * scale,
                            "{plan:?} run {r} sample {sample} measurand {m} column {k}: {engine:e} by hand {value:e}"
                        );
                    }
                }
            });
        }
    }
}

#[test]
fn normal_equations_agree() {
    for plan in plans() {
        let (problem, truth) = plan.make().unwrap();
        let point = displaced(&problem, &truth);
        let engine = problem.normal(&point);
        for (r, run) in problem.parts[0].runs.iter().enumerate() {
            let data = Columns::of(run).unwrap();
            let model = Model::new(Parameters::of(&problem, r, &point));
            let by_hand = normal::gram(&model, &data, SIGMA);
            let gram = &engine.runs[r].gram;
            for i in 0..=COLUMNS {
                for j in i..=COLUMNS {
                    // Cauchy and Schwarz: the largest that the sum can be.
                    let scale = (gram[(i, i)] * gram[(j, j)]).sqrt();
                    let (engine, value) = (gram[(i, j)], by_hand[i][j]);
                    assert!(
                        (engine - value).abs() <= TOLERANCE * scale,
                        "{plan:?} run {r} ({i}, {j}): {engine:e} by hand {value:e}"
                    );
                }
            }
        }
    }
}

/// Compares where both say the delay well; returns the number compared.
fn compare(engine: &[ReadingDelay], by_hand: &[Delay], readings: &[f64], about: &str) -> usize {
    assert_eq!(engine.len(), by_hand.len());
    let steepest = engine.iter().map(|one| one.slope.abs()).fold(0.0, f64::max);
    let mut compared = 0;
    for ((one, other), reading) in engine.iter().zip(by_hand).zip(readings) {
        // Blind readings have no delay worth comparing.
        if one.state != State::Solved || one.slope.abs() < 0.1 * steepest {
            continue;
        }
        compared += 1;
        let close = |what: &str, engine: f64, value: f64, scale: f64| {
            assert!(
                (engine - value).abs() <= TOLERANCE * scale,
                "{about} {what}: {engine:e} by hand {value:e}, at {one:?}"
            );
        };
        // The delay is known as well as reading and slope tell it.
        close("delay", one.delay, other.delay, one.delay.abs() + reading.abs() / one.slope.abs());
        close("slope", one.slope, other.slope, steepest);
        close("random", one.random, other.random, 10.0 * one.random);
        close("common", one.common, other.common, 10.0 * one.common);
    }
    compared
}

#[test]
fn delays_of_readings_agree() {
    for plan in plans() {
        let (problem, point) = plan.make().unwrap();
        compare_delays(&plan, &problem, &point);
    }
}

/// Far from the truth the delays are long, and the way to them winds.
#[test]
fn long_delays_agree() {
    for plan in plans() {
        let (problem, truth) = plan.make().unwrap();
        compare_delays(&plan, &problem, &far_off(&problem, &truth));
    }
}

fn compare_delays(plan: &Plan<'_>, problem: &Problem, point: &Point) {
    let covariance = covariance();
    let matrix = DMatrix::from_fn(COLUMNS, COLUMNS, |i, j| covariance[i][j]);
    let given = Given { problem, point, covariance: &matrix, range: 0.5 };
    let (mut compared, mut all) = (0, 0);
    for (r, run) in problem.parts[0].runs.iter().enumerate() {
        let data = Columns::of(run).unwrap();
        let parameters = Parameters::of(problem, r, point);
        let analytic =
            delay::delays(&Model::new(parameters), &data, &covariance, SIGMA, given.range);
        let dual = generic::delays(&parameters, &data, &covariance, SIGMA, given.range);
        for m in 0..3 {
            let engine = delays_of_run(&given, 0, r, m).readings;
            let about = format!("{plan:?} run {r} measurand {m}");
            let readings = data.readings[m];
            all += readings.len();
            compared += compare(&engine, &analytic[m], readings, &format!("analytic, {about}"));
            compare(&engine, &dual[m], readings, &format!("dual, {about}"));
        }
    }
    assert!(compared > all / 4, "{plan:?}: {compared} of {all}");
}

#[test]
fn rows_hold_no_column_twice() {
    let mut columns: Vec<usize> = COMMON_COLUMNS[..COMMON].to_vec();
    columns.extend(HORIZONTAL_COLUMNS);
    columns.extend([VERTICAL_COLUMNS[0], DISTANCE_COLUMNS[0], DISTANCE_COLUMNS[1]]);
    columns.sort_unstable();
    assert_eq!(columns, (0..COLUMNS).collect::<Vec<_>>());
}
