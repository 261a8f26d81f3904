//! Correlations of estimates, redundancy numbers and standardised residuals, against the closed
//! forms of a straight line.

use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::correlations::covariance_of_estimates;
use homepoint::estimate::redundancy::visit_checked;

use crate::problems::Stream;
use crate::problems::line::line;

fn samples(from: f64) -> Vec<(f64, f64, f64)> {
    let mut noise = Stream(9);
    let at = |n: u32| {
        let x = from + 0.1 * f64::from(n);
        (f64::from(n), x, 0.3 * x + 2.0 + noise.normal())
    };
    (0..12).map(at).collect()
}

#[test]
fn slope_and_height_far_from_zero_are_correlated_and_their_combination_is_known() {
    let all = samples(20.0);
    let (_folder, problem) = line(all.iter().copied());
    let fit = calibrate(problem, &Options::default()).unwrap();
    let covariance = covariance_of_estimates(&fit).unwrap();
    assert_eq!(covariance.names, ["slope", "height"]);
    let n = all.len() as f64;
    let mean = all.iter().map(|one| one.1).sum::<f64>() / n;
    let square = all.iter().map(|one| one.1 * one.1).sum::<f64>() / n;
    let spread: f64 = all.iter().map(|one| (one.1 - mean).powi(2)).sum();
    let near = |found: f64, due: f64| assert!((found / due - 1.0).abs() < 1e-6, "{found} {due}");
    near(covariance.matrix[(0, 0)], 1.0 / spread);
    near(covariance.matrix[(0, 1)], -mean / spread);
    near(covariance.matrix[(1, 1)], square / spread);
    let [pair] = &covariance.correlated()[..] else { panic!() };
    near(pair.correlation, -mean / square.sqrt());
    // slope + height mean / mean-square: what the readings say of it is known to 1/√Σx².
    near(pair.combination.terms[1].1, mean / square);
    near(pair.combination.sigma, 1.0 / (n * square).sqrt());
    // About zero they are not.
    let (_folder, problem) = line(samples(-0.55).into_iter());
    let fit = calibrate(problem, &Options::default()).unwrap();
    assert!(covariance_of_estimates(&fit).unwrap().correlated().is_empty());
}

#[test]
fn redundancy_numbers_are_those_of_a_straight_line() {
    let all = samples(3.0);
    let (_folder, problem) = line(all.iter().copied());
    let fit = calibrate(problem, &Options::default()).unwrap();
    let n = all.len() as f64;
    let mean = all.iter().map(|one| one.1).sum::<f64>() / n;
    let spread: f64 = all.iter().map(|one| (one.1 - mean).powi(2)).sum();
    let (mut sum, mut count) = (0.0, 0);
    visit_checked(&fit, (0, 0), &mut |sample, values| {
        let x = all[sample.number].1;
        let due = 1.0 - 1.0 / n - (x - mean).powi(2) / spread;
        let [one] = values else { panic!() };
        assert!((one.redundancy - due).abs() < 1e-9, "{one:?} {due}");
        assert!((one.standardised - one.residual / due.sqrt()).abs() < 1e-9, "{one:?}");
        sum += one.redundancy;
        count += 1;
    });
    assert_eq!(count, all.len());
    assert!((sum - fit.degrees_of_freedom() as f64).abs() < 1e-9, "{sum}");
}
