//! The arrow against the dense matrix and against the rows themselves.

use homepoint::engine::gram::{Columns, LeastSquares};
use homepoint::estimate::arrow::{Arrow, LinearError, cost, covariance, normal_matrix};
use nalgebra::{DMatrix, DVector};

use crate::problems::linear::{constant_rate, random_arrow};

fn shapes() -> Vec<Columns> {
    let columns = |global, setups: &[usize], runs: &[(usize, usize)]| Columns {
        global,
        setups: setups.to_vec(),
        runs: runs.to_vec(),
    };
    vec![
        columns(3, &[2, 4], &[(0, 1), (1, 2), (0, 3), (1, 0)]),
        columns(0, &[2], &[(0, 2), (0, 1)]),
        columns(4, &[0, 0], &[(0, 0), (1, 0)]),
        columns(2, &[0, 3], &[(1, 0), (0, 2), (1, 1)]),
        columns(1, &[6], &[(0, 0)]),
    ]
}

/// Largest relative difference, each entry measured by its row's and column's scale.
fn apart(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    let scale = b.diagonal().map(f64::sqrt);
    (0..a.nrows())
        .flat_map(|i| (0..a.ncols()).map(move |j| (i, j)))
        .map(|(i, j)| (a[(i, j)] - b[(i, j)]).abs() / (scale[i] * scale[j]))
        .fold(0.0, f64::max)
}

#[test]
fn step_covariance_and_cost_agree_with_the_rows() {
    for (seed, columns) in shapes().into_iter().enumerate() {
        let problem = random_arrow(seed as u64, columns);
        let n = problem.columns.len();
        let normal = problem.normal(&vec![0.0; n]);
        let (j, y) = problem.rows();
        let arrow = Arrow::assemble(&normal).unwrap();
        let (h, g) = normal_matrix(&normal).unwrap();
        assert!(apart(&h, &j.tr_mul(&j)) < 1e-14);
        assert!((cost(&normal) - y.norm_squared()).abs() < 1e-12 * y.norm_squared());
        assert_eq!(&g, arrow.gradient());
        for share in [0.0, 0.1] {
            let damping = arrow.diagonal() * share;
            let step = arrow.solve(&damping).unwrap();
            let scale = arrow.diagonal().map(f64::sqrt);
            let scaled = DMatrix::from_fn(n, n, |i, k| {
                (h[(i, k)] + if i == k { damping[i] } else { 0.0 }) / (scale[i] * scale[k])
            });
            let dense = scaled.lu().solve(&g.component_div(&scale)).unwrap();
            assert!((step.component_mul(&scale) - &dense).amax() < 1e-12 * dense.amax());
            let length = (&j * &step).norm_squared();
            assert!((arrow.squared_length(&step) - length).abs() < 1e-11 * length);
        }
        let scale = arrow.diagonal().map(f64::sqrt);
        let scaled = DMatrix::from_fn(n, n, |i, k| h[(i, k)] / (scale[i] * scale[k]));
        let inverse = scaled.try_inverse().unwrap();
        let dense = DMatrix::from_fn(n, n, |i, k| inverse[(i, k)] / (scale[i] * scale[k]));
        assert!(apart(&covariance(&normal).unwrap(), &dense) < 1e-12);
    }
}

#[test]
fn a_dependent_column_is_an_error_that_names_it() {
    let problem = constant_rate(3.0);
    let normal = problem.normal(&vec![0.0; 4]);
    assert_eq!(covariance(&normal).unwrap_err(), LinearError::Singular { column: 3 });
    let arrow = Arrow::assemble(&normal).unwrap();
    let held = DVector::from_vec(vec![0.0, 0.0, 0.0, 1.0]);
    assert_eq!(arrow.solve(&held).unwrap_err(), LinearError::Singular { column: 1 });
}

#[test]
fn sums_that_do_not_fit_are_errors() {
    let problem = random_arrow(1, shapes().remove(0));
    let good = problem.normal(&vec![0.0; problem.columns.len()]);
    let mut short = good.clone();
    short.runs.pop();
    let mut narrow = good.clone();
    narrow.runs[0].gram = DMatrix::zeros(2, 2);
    let mut across = good.clone();
    across.priors[0].coefficients =
        vec![(good.columns.setup_start(0), 1.0), (good.columns.setup_start(1), 1.0)];
    let mut beyond = good.clone();
    beyond.priors[0].coefficients = vec![(good.columns.len(), 1.0)];
    let mut homeless = good;
    homeless.columns.runs[0].0 = 7;
    for bad in [short, narrow, across, beyond, homeless] {
        assert!(matches!(Arrow::assemble(&bad), Err(LinearError::Shape { .. })));
    }
}

#[test]
fn nothing_to_solve_is_solved() {
    let problem = random_arrow(0, Columns { global: 0, setups: vec![0], runs: vec![(0, 0)] });
    let normal = problem.normal(&vec![]);
    assert_eq!(covariance(&normal).unwrap().shape(), (0, 0));
    assert_eq!(Arrow::assemble(&normal).unwrap().solve(&DVector::zeros(0)).unwrap().len(), 0);
}
