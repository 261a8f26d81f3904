//! Uncertainties where noise is not as stated, against repeated simulation.

use homepoint::engine::Problem;
use homepoint::engine::gauss_markov::Process;
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::Calibration;
use homepoint::estimate::noise::{Clusters, Noise};
use homepoint::estimate::noise_model::{NoiseModel, calibrate_with};

use crate::problems::Stream;
use crate::problems::line::line;

const SAMPLES: usize = 2000;
const INTERVAL: f64 = 0.02;
const DRAWS: u64 = 150;
const TRUE: [f64; 2] = [0.5, 2.0];

/// Where the readings are taken: slow waves.
fn place(at: usize) -> f64 {
    (0.7 * INTERVAL * at as f64).sin()
}

/// White noise of a standard deviation, and processes beside it.
fn with_processes(level: f64, processes: &[Process], seed: u64) -> Vec<f64> {
    let mut stream = Stream(seed);
    let white = 1.0 - processes.iter().map(|one| one.share).sum::<f64>();
    let mut states: Vec<f64> = processes.iter().map(|_| stream.normal()).collect();
    let next = |_| {
        let mut value = 0.0;
        for (state, Process { share, time }) in states.iter_mut().zip(processes) {
            let keep = (-INTERVAL / time).exp();
            *state = keep * *state + (1.0 - keep * keep).sqrt() * stream.normal();
            value += share.sqrt() * *state;
        }
        level * (value + white.sqrt() * stream.normal())
    };
    (0..SAMPLES).map(next).collect()
}

/// Noise of this standard deviation of which a half is white and a half has a correlation time (s).
fn noise(level: f64, time: f64, seed: u64) -> Vec<f64> {
    with_processes(level, &[Process { share: 0.5, time }], seed)
}

fn drawn(problem: &Problem, level: f64, seed: u64) -> Problem {
    let mut parts = problem.parts.clone();
    let noise = noise(level, 0.4, seed);
    parts[0].runs[0].record.edit(|samples| {
        for (at, value) in samples.readings[0].iter_mut().enumerate() {
            *value = TRUE[0] * place(at) + TRUE[1] + noise[at];
        }
    });
    Problem::new(parts)
}

/// Of how many draws the truth lies within two standard uncertainties, for each parameter.
fn coverage(level: f64, model: NoiseModel) -> [f64; 2] {
    let at = (0..SAMPLES).map(|at| (INTERVAL * at as f64, place(at), 0.0));
    let (_folder, problem) = line(at);
    let mut covered = [0.0; 2];
    for draw in 0..DRAWS {
        let fit = calibrate_with(drawn(&problem, level, 7 + draw), &Options::default(), model);
        let fit = fit.unwrap();
        assert!(fit.is_sound());
        let estimates = fit.estimates();
        for (which, name) in ["slope", "height"].iter().enumerate() {
            let one = estimates.iter().find(|one| one.name == *name).unwrap();
            let off = (one.value.unwrap() - TRUE[which]).abs();
            covered[which] += f64::from(u8::from(off <= 2.0 * one.sigma.unwrap()));
        }
    }
    covered.map(|count| count / DRAWS as f64)
}

#[test]
fn two_standard_uncertainties_hold_what_they_should() {
    for share in coverage(1.0, NoiseModel::Stated) {
        assert!(share < 0.6, "noise with a memory is no noise as stated: {share}");
    }
    // 95.4 %, with 1.7 % of chance; a cluster-robust one rests on few clusters.
    for (level, model, least) in [
        (1.0, NoiseModel::Autocorrelated, 0.90),
        (5.0, NoiseModel::Autocorrelated, 0.90),
        (1.0, NoiseModel::Sandwich, 0.88),
        (5.0, NoiseModel::Sandwich, 0.88),
    ] {
        for share in coverage(level, model) {
            assert!((least..0.995).contains(&share), "{model} {level}: {share}");
        }
    }
}

fn one(level: f64, memory: f64, model: NoiseModel) -> Calibration {
    with(&noise(level, memory, 5), model)
}

fn with(noise: &[f64], model: NoiseModel) -> Calibration {
    let at = (0..SAMPLES).map(|at| (INTERVAL * at as f64, place(at), 0.0));
    let (_folder, problem) = line(at);
    let mut parts = drawn(&problem, 1.0, 3).parts;
    parts[0].runs[0].record.edit(|samples| samples.readings[0].copy_from_slice(noise));
    calibrate_with(Problem::new(parts), &Options::default(), model).unwrap()
}

#[test]
fn the_noise_that_is_there_is_found() {
    let found = one(3.0, 0.4, NoiseModel::Autocorrelated);
    let Noise::Autocorrelated(all) = &found.noise else { panic!("{:?}", found.noise) };
    let [of_y] = &all[..] else { panic!("{all:?}") };
    let [Process { share, time }] = processes(&found)[..] else { panic!("{of_y:?}") };
    assert!((of_y.level / 3.0 - 1.0).abs() < 0.1, "{of_y:?}");
    assert!((share - 0.5).abs() < 0.12 && (time / 0.4).ln().abs() < 0.5, "{share} {time}");
    // Chi squared is what it should be then.
    assert!((found.variance_factor().unwrap() - 1.0).abs() < 0.05);
    // A memory of far less than an interval is none.
    let white = one(1.0, 1e-4, NoiseModel::Autocorrelated);
    assert_eq!(processes(&white), []);
}

fn processes(fit: &Calibration) -> Vec<Process> {
    let Noise::Autocorrelated(all) = &fit.noise else { panic!("{:?}", fit.noise) };
    all[0].components[0].iter().flat_map(|one| one.processes()).collect()
}

/// Of one process alone the time would be between the two, and the values too certain.
#[test]
fn noise_that_is_correlated_over_two_times_has_two_processes() {
    let due = [Process { share: 0.45, time: 0.04 }, Process { share: 0.5, time: 0.8 }];
    for seed in [11, 12, 13] {
        let found = with(&with_processes(2.0, &due, seed), NoiseModel::Autocorrelated);
        let processes = processes(&found);
        assert_eq!(processes.len(), 2, "{processes:?}");
        for (own, due) in processes.iter().zip(due) {
            assert!((own.share - due.share).abs() < 0.25, "{processes:?}");
            assert!((own.time / due.time).ln().abs() < 1.2, "{processes:?}");
        }
    }
}

#[test]
fn a_sandwich_keeps_values_and_needs_clusters() {
    let plain = one(1.0, 0.4, NoiseModel::Stated);
    let robust = one(1.0, 0.4, NoiseModel::Sandwich);
    let Noise::Sandwich(Clusters { count, samples: Some(samples) }) = robust.noise else {
        panic!("{:?}", robust.noise)
    };
    assert!(count >= 24 && samples >= 40, "{count} of {samples}");
    let free = |fit: &Calibration| {
        fit.estimates().into_iter().filter(|one| !one.fixed).collect::<Vec<_>>()
    };
    for (a, b) in free(&plain).iter().zip(free(&robust)) {
        assert_eq!(a.value, b.value);
        assert!(b.sigma.unwrap() > 2.0 * a.sigma.unwrap(), "{a:?} {b:?}");
    }
    let few = (0..6).map(|at| (f64::from(at), f64::from(at), 1.0 + f64::from(at % 2)));
    let (_folder, problem) = line(few);
    let refused = calibrate_with(problem, &Options::default(), NoiseModel::Sandwich).unwrap_err();
    assert!(refused.to_string().contains("found 6"), "{refused}");
}
