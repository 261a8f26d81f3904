//! The batch fit and the bounded step.

use homepoint::engine::gram::{Columns, LeastSquares, Normal, RunGram, UNBOUNDED};
use homepoint::estimate::arrow::cost;
use homepoint::estimate::batch::{FitError, Options, Outcome, fit};
use homepoint::estimate::conic::{BoundedError, Held, bounded_step};
use homepoint::quaternion::Quaternion;
use nalgebra::{DMatrix, DVector};

use crate::problems::Stream;
use crate::problems::linear::{bounded, constant_rate, random_arrow};
use crate::problems::wahba::{Wahba, product, turned};

#[test]
fn a_linear_problem_ends_at_its_least_squares_solution() {
    let columns = Columns { global: 3, setups: vec![2, 1], runs: vec![(0, 1), (1, 0), (1, 2)] };
    let mut problem = random_arrow(4, columns);
    let n = problem.columns.len();
    let options = Options { step_tolerance: 1e-10, ..Options::default() };
    let found = fit(&mut problem, vec![0.0; n], &options).unwrap();
    let (j, y) = problem.rows();
    let scale = DVector::from_fn(n, |i, _| j.column(i).norm());
    let scaled = DMatrix::from_fn(j.nrows(), n, |i, k| j[(i, k)] / scale[k]);
    let x = scaled.svd(true, true).solve(&y, 1e-14).unwrap();
    for i in 0..n {
        assert!((found.point[i] * scale[i] - x[i]).abs() < 1e-9, "{i}");
    }
    assert_eq!(found.outcome, Outcome::Converged);
    insta::assert_snapshot!(format!("{} {}", found.iterations, found.evaluations), @"4 5");
}

#[test]
fn a_rank_deficient_problem_converges_and_leaves_the_open_direction_alone() {
    let mut problem = constant_rate(3.0);
    let found = fit(&mut problem, vec![0.0; 4], &Options::default()).unwrap();
    assert_eq!(found.outcome, Outcome::Converged);
    let (delay, orientation) = (found.point[0], found.point[1]);
    let (_, y) = problem.rows();
    let mean = y.iter().step_by(2).sum::<f64>() / 40.0 / 1e5;
    assert!((3.0 * delay + orientation - mean).abs() < 1e-11, "the sum is determined");
    assert_eq!(found.point[3], 0.0, "no effect, no step");
}

#[test]
fn bounds_hold_exactly() {
    let (mut problem, solution) = bounded();
    let found = fit(&mut problem, vec![0.0; 3], &Options::default()).unwrap();
    assert_eq!(found.outcome, Outcome::Converged);
    assert_eq!(found.point[..2], solution[..2]);
    assert!((found.point[2] - solution[2]).abs() < 1e-6);
    problem.bounds[1] = (2.0, 1.0);
    assert!(matches!(
        fit(&mut problem, vec![0.0; 3], &Options::default()),
        Err(FitError::Bounded(BoundedError::Empty { column: 1, .. }))
    ));
}

/// The conditions of Karush, Kuhn and Tucker on random problems of widely different units.
#[test]
fn bounded_steps_satisfy_the_optimality_conditions() {
    let mut stream = Stream(3);
    for n in 1..12 {
        let units = DVector::from_fn(n, |_, _| 10f64.powf(4.0 * stream.next()));
        let rows = DMatrix::from_fn(2 * n, n, |_, k| stream.next() * units[k]);
        let h = rows.tr_mul(&rows);
        let g = rows.tr_mul(&DVector::from_fn(2 * n, |_, _| 3.0 * stream.next()));
        let bounds: Vec<_> = (0..n)
            .map(|i| {
                let (a, b) = (stream.next() / units[i], stream.next() / units[i]);
                match i % 4 {
                    0 => (a.min(b), a.max(b)),
                    1 => (f64::NEG_INFINITY, a),
                    2 => (a, a),
                    _ => UNBOUNDED,
                }
            })
            .collect();
        let found = bounded_step(&h, &g, &bounds).unwrap();
        assert!(found.polished);
        let pull = &g - &h * &found.step;
        for i in 0..n {
            let pull = pull[i] / h[(i, i)].sqrt();
            let (lower, upper) = bounds[i];
            assert!(lower <= found.step[i] && found.step[i] <= upper);
            match found.held[i] {
                Held::Free => assert!(pull.abs() < 1e-11, "{n} {i} {pull}"),
                _ if lower == upper => assert_eq!(found.step[i], lower),
                Held::Lower => assert!(found.step[i] == lower && pull < 1e-11),
                Held::Upper => assert!(found.step[i] == upper && pull > -1e-11),
            }
        }
    }
}

#[test]
fn a_rotation_is_found_from_half_a_turn_away() {
    let truth = [0.4, -1.9, 1.1];
    let mut problem = Wahba::new(truth, 30, 0.0);
    let start = product(Quaternion::turn(truth), Quaternion::turn([2.9, 0.3, 0.0]));
    let found = fit(&mut problem, start, &Options::default()).unwrap();
    assert_eq!(found.outcome, Outcome::Converged);
    for v in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        let (a, b) = (turned(found.point, v), turned(Quaternion::turn(truth), v));
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-9), "{a:?} {b:?}");
    }
    insta::assert_snapshot!(format!("{} {}", found.iterations, found.evaluations), @"8 8");
}

/// A model that is undefined beyond `edge`, and one that jumps beyond a point where its derivative says
/// "go on".
struct Awkward {
    columns: Columns,
    edge: f64,
    jump: Option<f64>,
}

impl LeastSquares for Awkward {
    type Point = f64;
    fn columns(&self) -> &Columns {
        &self.columns
    }
    fn reweight(&mut self, _: &f64) {}
    fn weights_move(&self) -> bool {
        false
    }
    fn cost(&self, x: &f64) -> f64 {
        cost(&self.normal(x))
    }
    fn normal(&self, x: &f64) -> Normal {
        let residual = if *x > self.edge { f64::NAN } else { 10.0 - x };
        let jump = if self.jump.is_some_and(|at| *x > at) { 10.0 } else { 0.0 };
        let rows = DMatrix::from_row_slice(2, 2, &[1.0, residual, 0.0, jump]);
        let gram = rows.tr_mul(&rows);
        let runs = vec![RunGram { gram, readings: 1 }];
        Normal { columns: self.columns.clone(), runs, priors: vec![] }
    }
    fn moved(&self, x: &f64, step: &[f64]) -> f64 {
        x + step[0]
    }
}

#[test]
fn poor_ends_are_named() {
    let columns = Columns { global: 1, setups: vec![0], runs: vec![(0, 0)] };
    let awkward = |edge, jump| Awkward { columns: columns.clone(), edge, jump };
    let end = |mut problem: Awkward, start, max_iterations| {
        let options = Options { max_iterations, ..Options::default() };
        fit(&mut problem, start, &options).unwrap()
    };
    assert_eq!(end(awkward(20.0, None), 0.0, 100).outcome, Outcome::Converged);
    assert_eq!(end(awkward(5.0, None), 6.0, 100).outcome, Outcome::NotFinite);
    assert_eq!(end(awkward(20.0, None), 0.0, 1).outcome, Outcome::IterationLimit);
    let stalled = end(awkward(20.0, Some(0.0)), 0.0, 100);
    assert_eq!((stalled.outcome, stalled.point), (Outcome::Stalled, 0.0));
    // The solution is at 10; its standard uncertainty is 1.
    let near = end(awkward(20.0, Some(9.9)), 9.9, 100);
    assert_eq!((near.outcome, near.point), (Outcome::Near, 9.9));
    assert!((near.remaining - 0.1).abs() < 1e-9 && near.outcome.is_result());
    assert!(!stalled.outcome.is_result());
    let at_the_edge = end(awkward(5.0, None), 0.0, 100);
    assert_eq!(at_the_edge.outcome, Outcome::Stalled);
    assert!(at_the_edge.point > 4.9 && at_the_edge.point <= 5.0, "{}", at_the_edge.point);
    assert!(stalled.outcome.to_string().starts_with("The fit stalled: no step lowers"));
}

/// Readings that scatter in proportion to what they measure: weights follow the slope.
struct Proportional {
    columns: Columns,
    points: Vec<(f64, f64)>,
    frozen: f64,
}

impl LeastSquares for Proportional {
    type Point = f64;
    fn columns(&self) -> &Columns {
        &self.columns
    }
    fn reweight(&mut self, slope: &f64) {
        self.frozen = *slope;
    }
    fn weights_move(&self) -> bool {
        true
    }
    fn cost(&self, slope: &f64) -> f64 {
        let one = |(x, y): &(f64, f64)| ((y - slope * x) / (self.frozen * x)).powi(2);
        self.points.iter().map(one).sum()
    }
    fn normal(&self, slope: &f64) -> Normal {
        let row = |(x, y): &(f64, f64)| [1.0 / self.frozen, (y - slope * x) / (self.frozen * x)];
        let rows =
            DMatrix::from_row_iterator(self.points.len(), 2, self.points.iter().flat_map(row));
        let sums = RunGram { gram: rows.tr_mul(&rows), readings: self.points.len() };
        Normal { columns: self.columns.clone(), runs: vec![sums], priors: vec![] }
    }
    fn moved(&self, slope: &f64, step: &[f64]) -> f64 {
        slope + step[0]
    }
}

#[test]
fn cost_and_linearisation_have_the_weights_of_the_point_where_the_fit_ends() {
    let columns = Columns { global: 1, setups: vec![0], runs: vec![(0, 0)] };
    let points = vec![(1.0, 2.1), (2.0, 3.8), (5.0, 10.5), (-3.0, -6.0)];
    let slope = points.iter().map(|(x, y)| y / x).sum::<f64>() / 4.0;
    let mut problem = Proportional { columns, points, frozen: f64::NAN };
    let found = fit(&mut problem, 40.0, &Options::default()).unwrap();
    assert_eq!(found.outcome, Outcome::Converged);
    assert!((found.point - slope).abs() < 1e-8, "{}", found.point);
    problem.reweight(&found.point);
    let there = problem.normal(&found.point);
    assert_eq!(found.normal, there);
    assert!((found.cost / problem.cost(&found.point) - 1.0).abs() < 1e-14);
    // Nothing made before the weights followed is used again.
    assert_eq!(found.evaluations, 2 * found.iterations - 1);
}
