//! Every effect of the library in whole campaigns: absent at zero, present in drawn readings as its
//! derivatives and its standard deviations say, and the same however listed.

use std::path::Path;

use homepoint::campaign::Samples;
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::noise::covariance_of;
use homepoint::engine::open::{Request, open};
use homepoint::engine::part::wrapped;
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::graph::MeasurandKind;
use homepoint::model::{Process, Shape};

use crate::planned::{effect_columns, fitting, folder, jacobians, problem, typical};

const CAMPAIGNS: [&str; 3] = ["arm", "robot", "stations"];

/// Every effect in company of others from all over the list, five or six together.
fn companies(names: &[String]) -> Vec<Vec<String>> {
    let groups = names.len().div_ceil(6);
    (0..groups).map(|first| names.iter().skip(first).step_by(groups).cloned().collect()).collect()
}

/// Readings drawn at a point, by run; random quantities with their typical size where `random`.
fn drawn(problem: &Problem, point: &Point, random: bool) -> Vec<Vec<Vec<f64>>> {
    let mut changed = problem.clone();
    for part in &mut changed.parts {
        for (sigma, one) in part.random_sigma.iter_mut().zip(&part.system.randoms) {
            *sigma = if random { one.typical.unwrap_or(0.0) } else { 0.0 };
        }
    }
    simulate(&mut changed, point, 11, true);
    changed.parts[0].runs.iter().map(|run| run.held().readings.clone()).collect()
}

/// Residuals by the definition; in bulk, sums are fused with products otherwise where an effect
/// takes part.
fn residuals(problem: &Problem, run: usize, point: &Point) -> Vec<Vec<f64>> {
    let mut all = Vec::new();
    problem.visit_run_pointwise(0, run, point, &mut |_, _, values| all.push(values.to_vec()));
    all
}

#[test]
fn with_all_parameters_zero_nothing_changes_by_a_bit() {
    let folder = folder("zero");
    for campaign in CAMPAIGNS {
        let path = folder.join(campaign);
        let nominal = problem(&path, &[]);
        let at = Point::stated(&nominal.layout);
        for effect in fitting(&path) {
            let with = problem(&path, &[&effect]);
            let zero = Point::stated(&with.layout);
            for run in 0..nominal.parts[0].runs.len() {
                let expected = residuals(&nominal, run, &at);
                assert_eq!(residuals(&with, run, &zero), expected, "{effect} in {campaign}");
            }
        }
        for names in companies(&fitting(&path)) {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let with = problem(&path, &names);
            let zero = Point::stated(&with.layout);
            for run in 0..nominal.parts[0].runs.len() {
                let expected = residuals(&nominal, run, &at);
                assert_eq!(residuals(&with, run, &zero), expected, "{campaign} {names:?}");
            }
        }
    }
}

/// Drawn with the same noise, readings with and without an effect differ by the effect alone. The
/// change is that of the derivatives at both ends and halfway (Simpson's rule), whose error is of
/// fifth order.
#[test]
fn drawn_readings_change_as_the_derivatives_say() {
    let folder = folder("drawn");
    let mut compared = 0;
    for campaign in CAMPAIGNS {
        let path = folder.join(campaign);
        for effect in fitting(&path) {
            let problem = problem(&path, &[&effect]);
            let columns = effect_columns(&problem);
            if (0..problem.layout.instances.len()).any(|i| problem.layout.is_noise_only(i)) {
                continue;
            }
            // Along the columns: values that sum to zero over the setups stay so.
            let zero = Point::stated(&problem.layout);
            let mut step = vec![0.0; problem.columns().len()];
            columns.iter().for_each(|(column, size, _)| step[*column] = *size);
            let point = problem.moved(&zero, &step);
            let half: Vec<f64> = step.iter().map(|size| 0.5 * size).collect();
            let halfway = problem.moved(&zero, &half);
            let (without, with) = (drawn(&problem, &zero, false), drawn(&problem, &point, false));
            for run in 0..problem.parts[0].runs.len() {
                let touched = problem.columns().touched_by(run);
                let [a, m, b] =
                    [&zero, &halfway, &point].map(|point| jacobians(&problem, run, point));
                let mut pairs = Vec::new();
                for sample in 0..a.len() {
                    for slot in problem.parts[0].slots() {
                        let row = slot.residual;
                        let expected: f64 = columns
                            .iter()
                            .filter_map(|(column, size, _)| {
                                let local = touched.iter().position(|t| t == column)?;
                                let [a, m, b] = [&a, &m, &b].map(|all| all[sample][(row, local)]);
                                Some(size * (a + 4.0 * m + b) / 6.0)
                            })
                            .sum();
                        let change =
                            with[run][slot.column][sample] - without[run][slot.column][sample];
                        let change = match slot.kind {
                            MeasurandKind::Angle { period } => wrapped(change, period),
                            _ => change,
                        };
                        pairs.push((change, expected));
                    }
                }
                let most = pairs.iter().fold(0.0_f64, |most, pair| most.max(pair.1.abs()));
                for (change, expected) in pairs {
                    assert!(
                        (change - expected).abs() <= 1e-14 + 1e-6 * most,
                        "{effect} in {campaign}, run {run}: {change:e} {expected:e} of {most:e}"
                    );
                }
            }
            compared += usize::from(!columns.is_empty());
        }
    }
    assert!(compared > 60, "{compared}");
}

#[test]
fn random_quantities_act_in_the_covariance_and_scatter_drawn_readings_by_as_much() {
    let folder = folder("random");
    let mut seen = Vec::new();
    for campaign in CAMPAIGNS {
        let path = folder.join(campaign);
        for effect in fitting(&path) {
            let problem = problem(&path, &[&effect]);
            let count = problem.parts[0].system.randoms.len();
            for k in 0..count {
                let random = problem.parts[0].system.randoms[k].clone();
                if random.effect.is_none() {
                    continue;
                }
                scatter_of(&problem, k);
                seen.push(random.name.clone());
            }
        }
    }
    for name in ["timestamp_jitter", "encoder_quantisation", "stamp_rounding", "correlated_noise"] {
        assert!(seen.iter().any(|one| one.starts_with(name)), "{name} is not among {seen:?}");
    }
}

/// One random quantity alone: its sensitivities, and what it does to drawn readings.
fn scatter_of(problem: &Problem, k: usize) {
    let point = typical(problem);
    let random = &problem.parts[0].system.randoms[k];
    let (name, size) = (&random.name, random.typical.unwrap());
    let mut on = problem.clone();
    on.parts[0].random_sigma.fill(0.0);
    let without = {
        let mut off = on.clone();
        simulate(&mut off, &point, 5, true);
        off
    };
    on.parts[0].random_sigma[k] = size;
    let mut with = on.clone();
    simulate(&mut with, &point, 5, true);
    let (mut squares, mut readings, mut changed) = (0.0, 0, false);
    for run in 0..on.parts[0].runs.len() {
        let parameters = on.parameters(0, run, &point);
        let mut scratch = Samples::default();
        for sample in 0..on.parts[0].runs[run].held().len() {
            let seen = on.parts[0].runs[run].record.sample(sample, &mut scratch);
            let found = covariance_of(&on.parts[0], run, seen, &parameters, &[k], &mut Vec::new());
            assert!(found.sensitivities.iter().all(|g| g.is_finite()), "{name}");
            for slot in on.parts[0].slots() {
                let row = slot.residual;
                let g = found.sensitivities[(row, 0)];
                let own = on.parts[0].sigma
                    [on.parts[0].slots().iter().position(|s| s.column == slot.column).unwrap()];
                let variance = found.covariance[(row, row)];
                let expected = own * own + (g * size).powi(2);
                assert!(
                    (variance / expected - 1.0).abs() < 1e-12,
                    "{name}: {variance:e} {expected:e}"
                );
                let change = with.parts[0].runs[run].held().readings[slot.column][sample]
                    - without.parts[0].runs[run].held().readings[slot.column][sample];
                let change = match slot.kind {
                    MeasurandKind::Angle { period } => wrapped(change, period),
                    _ => change,
                };
                changed |= change != 0.0;
                if g == 0.0 {
                    assert_eq!(change, 0.0, "{name} acts where the covariance says it does not");
                } else if g.abs() * size > 1e-12 {
                    squares += (change / (g * size)).powi(2);
                    readings += 1;
                }
            }
        }
    }
    assert!(changed && readings > 0, "{name} changes no drawn reading");
    if random.process == Process::White {
        // One draw is shared by the readings of a sample: as few as samples count for the scatter.
        let draws = (readings / on.parts[0].slots().len()).max(20) as f64;
        let spread = if random.shape == Shape::Normal { 2.0 } else { 0.8 };
        let factor = squares / readings as f64;
        let five_sigma = 5.0 * f64::sqrt(spread / draws);
        assert!((factor - 1.0).abs() < five_sigma, "{name}: {factor} +- {five_sigma}");
    }
}

/// A noise level of `k` is noise times `1 + k`, draw by draw, and the covariance says the same.
#[test]
fn noise_levels_scale_the_noise() {
    let folder = folder("levels");
    let mut scaled = 0;
    for campaign in CAMPAIGNS {
        let path = folder.join(campaign);
        for effect in fitting(&path) {
            let problem = problem(&path, &[&effect]);
            let layout = &problem.layout;
            if !(0..layout.instances.len()).any(|i| layout.is_noise_only(i)) {
                continue;
            }
            let (zero, point) = (Point::stated(layout), typical(&problem));
            let (quiet, loud) = (drawn(&problem, &zero, false), drawn(&problem, &point, false));
            let part = &problem.parts[0];
            for run in 0..part.runs.len() {
                let predicted = problem.residuals(0, run, &zero);
                let parameters = problem.parameters(0, run, &point);
                let mut scratch = Samples::default();
                for (sample, predicted) in predicted.iter().enumerate() {
                    let seen = part.runs[run].record.sample(sample, &mut scratch);
                    let covariance =
                        covariance_of(part, run, seen, &parameters, &[], &mut Vec::new())
                            .covariance;
                    for (slot, sigma) in part.slots().iter().zip(&part.sigma) {
                        let factor = covariance[(slot.residual, slot.residual)].sqrt() / sigma;
                        let noise = |readings: &[Vec<Vec<f64>>]| {
                            // Readings were zeros: the residual is the negative prediction.
                            let noise =
                                readings[run][slot.column][sample] + predicted[slot.residual];
                            match slot.kind {
                                MeasurandKind::Angle { period } => wrapped(noise, period),
                                _ => noise,
                            }
                        };
                        let (quiet, loud) = (noise(&quiet), noise(&loud));
                        assert!(
                            (loud - factor * quiet).abs() < 1e-14,
                            "{effect}: {loud:e} {quiet:e}"
                        );
                        scaled += usize::from((factor - 1.3).abs() < 1e-12);
                    }
                }
            }
        }
    }
    assert!(scaled > 100, "{scaled}");
}

/// Order `number` of some names: the same for the same number.
fn shuffled(names: &[String], number: u64) -> Vec<&str> {
    let mut order: Vec<(u64, &str)> = names
        .iter()
        .enumerate()
        .map(|(i, name)| {
            let key =
                (i as u64 + 1).wrapping_mul(6_364_136_223_846_793_005).wrapping_mul(2 * number + 1);
            (key.rotate_left(29) ^ key, name.as_str())
        })
        .collect();
    order.sort_unstable();
    order.into_iter().map(|one| one.1).collect()
}

#[test]
fn effects_together_predict_and_draw_the_same_in_every_order() {
    let folder = folder("orders");
    for campaign in CAMPAIGNS {
        let path = folder.join(campaign);
        for names in companies(&fitting(&path)) {
            let straight: Vec<&str> = names.iter().map(String::as_str).collect();
            let reference = problem(&path, &straight);
            let point = typical(&reference);
            let readings = drawn(&reference, &point, true);
            for number in 1..4 {
                let order = shuffled(&names, number);
                let other = problem(&path, &order);
                let at = typical(&other);
                for run in 0..reference.parts[0].runs.len() {
                    let expected = reference.residuals(0, run, &point);
                    assert_eq!(other.residuals(0, run, &at), expected, "{campaign} {order:?}");
                }
                assert_eq!(drawn(&other, &at, true), readings, "{campaign} {order:?}");
            }
        }
    }
}

#[test]
fn estimates_are_the_same_in_every_order() {
    let campaign = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
    let names =
        ["trunnion_tilt", "encoder_eccentricity", "arm_windup", "timestamp_jitter", "collimation"]
            .map(str::to_owned);
    let estimates = |order: &[&str]| {
        let mut request = Request::new([&campaign]);
        request.with = order.iter().map(|name| (*name).to_owned()).collect();
        let result = calibrate(open(&request).unwrap().problem, &Options::default()).unwrap();
        let found = result.estimates().into_iter();
        found.map(|one| (one.name.clone(), one.value, one.sigma)).collect::<Vec<_>>()
    };
    let reference = estimates(&names.each_ref().map(String::as_str));
    assert!(reference.iter().any(|one| one.0.starts_with("arm_windup")));
    for number in [1, 2] {
        assert_eq!(estimates(&shuffled(&names, number)), reference);
    }
}
