//! Certifies the batch fit on NIST's Statistical Reference Datasets: 27 nonlinear problems, two
//! starts each, certified to eleven digits.

use std::fmt::Write as _;
use std::marker::PhantomData;

use homepoint::engine::gram::{Columns, LeastSquares, Normal, RunGram};
use homepoint::estimate::arrow::covariance;
use homepoint::estimate::batch::{Options, Outcome, fit};
use homepoint::number::{Gradient, partial, partials};
use nalgebra::DMatrix;

mod models;
use models::Model;

/// One data set as published.
struct Published {
    starts: [Vec<f64>; 2],
    certified: Vec<f64>,
    deviations: Vec<f64>,
    residual_squares: f64,
    /// Response and predictors.
    data: Vec<(f64, [f64; 2])>,
}

fn read(name: &str) -> Published {
    let path = format!("{}/tests/data/nist_strd/{name}.dat", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let numbers = |line: &str| -> Option<Vec<f64>> {
        line.split_whitespace().map(|word| word.parse().ok()).collect()
    };
    let mut published = Published {
        starts: [vec![], vec![]],
        certified: vec![],
        deviations: vec![],
        residual_squares: f64::NAN,
        data: vec![],
    };
    let mut in_data = false;
    for line in text.lines().skip(40) {
        if let Some((left, right)) = line.split_once('=')
            && left.trim().starts_with('b')
            && let Some(values) = numbers(right)
        {
            published.starts[0].push(values[0]);
            published.starts[1].push(values[1]);
            published.certified.push(values[2]);
            published.deviations.push(values[3]);
        } else if let Some(value) = line.strip_prefix("Residual Sum of Squares:") {
            published.residual_squares = value.trim().parse().unwrap();
        } else if line.starts_with("Data:") {
            in_data = true;
        } else if in_data && let Some(values) = numbers(line).filter(|v| v.len() > 1) {
            published.data.push((values[0], [values[1], values.get(2).copied().unwrap_or(0.0)]));
        }
    }
    published
}

struct Regression<'a, M, const N: usize> {
    columns: Columns,
    data: &'a [(f64, [f64; 2])],
    model: PhantomData<M>,
}

impl<M: Model<N>, const N: usize> LeastSquares for Regression<'_, M, N> {
    type Point = [f64; N];

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn reweight(&mut self, _: &[f64; N]) {}

    fn weights_move(&self) -> bool {
        false
    }

    fn cost(&self, point: &[f64; N]) -> f64 {
        self.data.iter().map(|(y, x)| (M::response(*y) - M::predict(*point, *x)).powi(2)).sum()
    }

    fn normal(&self, point: &[f64; N]) -> Normal {
        let mut index = 0;
        let unknowns: [Gradient<N>; N] = point.map(|value| {
            index += 1;
            partial(value, index - 1)
        });
        let rows = DMatrix::from_row_iterator(
            self.data.len(),
            N + 1,
            self.data.iter().flat_map(|(y, x)| {
                let predicted = M::predict(unknowns, *x);
                let residual = M::response(*y) - predicted.re;
                partials(&predicted).into_iter().chain([residual])
            }),
        );
        let gram = rows.tr_mul(&rows);
        Normal {
            columns: self.columns.clone(),
            runs: vec![RunGram { gram, readings: self.data.len() }],
            priors: vec![],
        }
    }

    fn moved(&self, point: &[f64; N], step: &[f64]) -> [f64; N] {
        std::array::from_fn(|i| point[i] + step[i])
    }
}

/// Correct digits: -log10 of the largest relative error, at most 11 (as certified).
fn digits(found: impl IntoIterator<Item = f64>, certified: &[f64]) -> f64 {
    let error = found
        .into_iter()
        .zip(certified)
        .map(|(x, c)| ((x - c) / c).abs())
        .fold(0.0, |worst: f64, e| if e.is_nan() { f64::INFINITY } else { worst.max(e) });
    (-error.log10()).clamp(0.0, 11.0)
}

struct Row {
    name: &'static str,
    start: usize,
    outcome: Outcome,
    iterations: usize,
    evaluations: usize,
    parameters: f64,
    deviations: f64,
    squares: f64,
}

fn certify<M: Model<N>, const N: usize>(name: &'static str, _: M, rows: &mut Vec<Row>) {
    let published = read(name);
    assert_eq!(published.certified.len(), N, "{name}");
    for start in 0..2 {
        let mut problem = Regression::<M, N> {
            columns: Columns { global: N, setups: vec![0], runs: vec![(0, 0)] },
            data: &published.data,
            model: PhantomData,
        };
        let options = Options {
            max_iterations: 1000,
            step_tolerance: 1e-9,
            decrease_tolerance: 0.0,
            noise_floor: 0.0,
            ..Options::default()
        };
        let from: [f64; N] = std::array::from_fn(|i| published.starts[start][i]);
        let fit = fit(&mut problem, from, &options).unwrap();
        let variance = fit.cost / (published.data.len() - N) as f64;
        let deviations = covariance(&fit.normal).map_or(0.0, |c| {
            digits((0..N).map(|i| (variance * c[(i, i)]).sqrt()), &published.deviations)
        });
        rows.push(Row {
            name,
            start: start + 1,
            outcome: fit.outcome,
            iterations: fit.iterations,
            evaluations: fit.evaluations,
            parameters: digits(fit.point, &published.certified),
            deviations,
            squares: digits([fit.cost], &[published.residual_squares]),
        });
    }
}

fn all() -> Vec<Row> {
    let mut rows = Vec::new();
    let r = &mut rows;
    certify("Misra1a", models::Saturation, r);
    certify("Chwirut2", models::Chwirut, r);
    certify("Chwirut1", models::Chwirut, r);
    certify("Lanczos3", models::Lanczos, r);
    certify("Gauss1", models::Gauss, r);
    certify("Gauss2", models::Gauss, r);
    certify("DanWood", models::DanWood, r);
    certify("Misra1b", models::Misra1b, r);
    certify("Kirby2", models::Kirby2, r);
    certify("Hahn1", models::Cubic, r);
    certify("Nelson", models::Nelson, r);
    certify("MGH17", models::Mgh17, r);
    certify("Lanczos1", models::Lanczos, r);
    certify("Lanczos2", models::Lanczos, r);
    certify("Gauss3", models::Gauss, r);
    certify("Misra1c", models::Misra1c, r);
    certify("Misra1d", models::Misra1d, r);
    certify("Roszman1", models::Roszman1, r);
    certify("ENSO", models::Enso, r);
    certify("MGH09", models::Mgh09, r);
    certify("Thurber", models::Cubic, r);
    certify("BoxBOD", models::Saturation, r);
    certify("Rat42", models::Rat42, r);
    certify("MGH10", models::Mgh10, r);
    certify("Eckerle4", models::Eckerle4, r);
    certify("Rat43", models::Rat43, r);
    certify("Bennett5", models::Bennett5, r);
    rows
}

/// Starts from which the certified minimum is not found, and why.
const NOT_FOUND: [(&str, usize, &str); 2] = [
    ("BoxBOD", 1, "first steps carry b2 to where the decay is over before the first reading"),
    ("MGH10", 1, "follows a valley so narrow that thousands of steps do not reach its end"),
];

/// Problems whose standard deviations cannot be compared to five digits, and why.
const ROUNDED: [(&str, &str); 1] =
    [("Lanczos1", "residuals of 1e-13 on readings of order 1 carry three digits")];

/// Problems whose last steps hang on rounding: their counters differ between machines.
const UNSTEADY: [&str; 5] = ["MGH17", "Lanczos1", "Lanczos2", "MGH10", "Bennett5"];

#[test]
fn certified_values_are_reached() {
    let rows = all();
    assert_eq!(rows.len(), 54);
    for row in rows {
        let about = format!(
            "{} from start {}: {:?}, digits {:.1} {:.1} {:.1}",
            row.name, row.start, row.outcome, row.parameters, row.deviations, row.squares
        );
        if NOT_FOUND.iter().any(|(name, start, _)| (*name, *start) == (row.name, row.start)) {
            assert!(row.parameters < 1.0, "found after all, take it off the list: {about}");
            continue;
        }
        assert!(row.parameters >= 6.0, "{about}");
        if ROUNDED.iter().any(|(name, _)| *name == row.name) {
            assert!((2.0..5.0).contains(&row.deviations), "take it off the list: {about}");
        } else {
            assert!(row.deviations >= 5.0 && row.squares >= 6.0, "{about}");
        }
    }
}

#[test]
fn work_counters() {
    let mut table = String::from("problem, start, outcome, rounds, passes\n");
    for row in all().iter().filter(|row| !UNSTEADY.contains(&row.name)) {
        let (name, start) = (row.name, row.start);
        let (outcome, rounds, passes) = (row.outcome, row.iterations, row.evaluations);
        writeln!(table, "{name:8} {start} {outcome:?} {rounds} {passes}").unwrap();
    }
    insta::assert_snapshot!(table);
}
