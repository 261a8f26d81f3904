//! Every effect of the library on planned campaigns: its parameters change predictions as their
//! derivatives say, random ones scatter readings, and the order of listing changes nothing.

use homepoint::engine::gram::LeastSquares;
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::library::Library;

use crate::planned::{effect_columns, fitting, folder, jacobians, problem, typical};

#[test]
fn every_effect_changes_readings_as_its_derivatives_say() {
    let folder = folder("derivatives");
    let library = Library::builtin().unwrap();
    let campaigns = ["arm", "robot", "stations"].map(|name| folder.join(name));
    let campaigns = campaigns.map(|path| (path.clone(), fitting(&path)));
    let mut seen = Vec::new();
    for effect in library.effects().filter(|effect| !effect.builtin) {
        let mut fits = false;
        for (campaign, of_campaign) in &campaigns {
            if !of_campaign.contains(&effect.name) {
                continue;
            }
            fits = true;
            let problem = problem(campaign, &[&effect.name]);
            let columns = effect_columns(&problem);
            let randoms =
                problem.parts[0].system.randoms.iter().filter(|r| r.effect.is_some()).count();
            let noise =
                (0..problem.layout.instances.len()).any(|i| problem.layout.is_noise_only(i));
            assert!(
                !columns.is_empty() || randoms > 0 || noise,
                "{} has nothing to estimate",
                effect.name
            );
            compare(&problem, &columns, &effect.name);
            if randoms > 0 || noise {
                scatters(&problem, &effect.name);
            }
        }
        assert!(fits, "{} fits none of the campaigns", effect.name);
        seen.push(effect.name.clone());
    }
    assert!(seen.len() > 60, "{seen:?}");
}

/// Jacobian columns against the change of predictions by a small step.
fn compare(problem: &Problem, columns: &[(usize, f64, String)], effect: &str) {
    let point = typical(problem);
    let n = problem.columns().len();
    // Largest change of a reading by the parameter's typical size, in its standard uncertainty.
    let mut acted = vec![0.0_f64; columns.len()];
    for run in 0..problem.parts[0].runs.len() {
        let touched = problem.columns().touched_by(run);
        let jacobians = jacobians(problem, run, &point);
        for (number, (column, size, name)) in columns.iter().enumerate() {
            let Some(local) = touched.iter().position(|t| t == column) else { continue };
            let h = size * 1e-3;
            let shifted = |sign: f64| {
                let mut step = vec![0.0; n];
                step[*column] = sign * h;
                problem.residuals(0, run, &problem.moved(&point, &step))
            };
            let (plus, minus) = (shifted(1.0), shifted(-1.0));
            for (sample, jacobian) in jacobians.iter().enumerate() {
                for row in 0..jacobian.nrows() {
                    let exact = jacobian[(row, local)];
                    let sigma = problem.parts[0].sigma[row];
                    acted[number] = acted[number].max((exact * size / sigma).abs());
                    let change = -(plus[sample][row] - minus[sample][row]);
                    let expected = 2.0 * h * exact;
                    // Readings of order 1 leave 1e-15 of rounding; the rest is the third
                    // derivative.
                    let tolerance = 5e-15 + 1e-6 * expected.abs();
                    assert!(
                        (change - expected).abs() < tolerance,
                        "{effect} {name}: {change:e} {expected:e} run {run} sample {sample}"
                    );
                }
            }
        }
    }
    for ((_, _, name), acted) in columns.iter().zip(acted) {
        // A microsecond or half a minute of a drift by the hour do little; rounding is at 1e-9.
        assert!(acted > 1e-4, "{effect}: {name} changes readings by {acted:e} sigma");
    }
}

/// Drawn readings scatter otherwise with the effect than without it, under the same seed.
fn scatters(problem: &Problem, effect: &str) {
    let point = typical(problem);
    let drawn = |on: bool| {
        let mut changed = problem.clone();
        for part in &mut changed.parts {
            for (sigma, random) in part.random_sigma.iter_mut().zip(&part.system.randoms) {
                *sigma = if on { random.typical.unwrap_or(0.0) } else { 0.0 };
            }
        }
        let at = if on { point.clone() } else { Point::stated(&problem.layout) };
        simulate(&mut changed, &at, 7, true);
        changed.parts[0].runs[0].held().readings.clone()
    };
    let (with, without) = (drawn(true), drawn(false));
    assert!(with.iter().flatten().all(|reading| reading.is_finite()), "{effect}");
    assert_ne!(with, without, "{effect} changes no drawn reading");
}

#[test]
fn the_order_of_listing_changes_nothing() {
    let scratch = folder("order");
    let folder = scratch.join("arm");
    let effects = [
        "trunnion_tilt",
        "encoder_eccentricity",
        "rate_dependent_delay",
        "gravity_sag",
        "arm_radius",
    ];
    let forwards = problem(&folder, &effects);
    let mut reversed = effects;
    reversed.reverse();
    let backwards = problem(&folder, &reversed);
    let (a, b) = (typical(&forwards), typical(&backwards));
    for run in 0..3 {
        assert_eq!(forwards.residuals(0, run, &a), backwards.residuals(0, run, &b));
    }
    let names = |problem: &Problem| -> Vec<String> {
        problem.layout.instances.iter().map(|instance| instance.name.clone()).collect()
    };
    assert_eq!(names(&forwards), names(&backwards));
}
