//! Which effects a model absorbs by itself, and which effects are one: what their files say of it.

use std::path::Path;

use homepoint::engine::gram::LeastSquares;
use homepoint::engine::{Point, Problem};
use homepoint::library::Library;
use nalgebra::{DMatrix, DVector};

use crate::planned::{effect_columns, fitting, folder, jacobians, problem, typical};

/// Share of the norm of column `column` that all other columns cannot follow.
fn left_over(rows: &DMatrix<f64>, column: usize) -> f64 {
    let mut base = rows.clone().remove_column(column);
    for mut one in base.column_iter_mut() {
        let norm = one.norm();
        one /= norm;
    }
    let target: DVector<f64> = rows.column(column) / rows.column(column).norm();
    let q = base.qr().q();
    // Twice is enough for a projection to be orthogonal to rounding.
    let once = &target - &q * q.tr_mul(&target);
    (&once - &q * q.tr_mul(&once)).norm()
}

/// Whitened Jacobian of all readings, over all columns.
fn whitened(problem: &Problem, point: &Point) -> DMatrix<f64> {
    let n = problem.columns().len();
    let mut rows: Vec<DVector<f64>> = Vec::new();
    for run in 0..problem.parts[0].runs.len() {
        let touched = problem.columns().touched_by(run);
        for jacobian in jacobians(problem, run, point) {
            for (slot, sigma) in problem.parts[0].slots().iter().zip(&problem.parts[0].sigma) {
                let mut row = DVector::zeros(n);
                for (local, column) in touched.iter().enumerate() {
                    row[*column] = jacobian[(slot.residual, local)] / sigma;
                }
                rows.push(row);
            }
        }
    }
    DMatrix::from_fn(rows.len(), n, |i, j| rows[i][j])
}

/// Smallest and largest share that the model, and the rest of the effect, leave of an effect's
/// columns.
fn shares(problem: &Problem, point: &Point) -> (f64, f64) {
    let rows = whitened(problem, point);
    let own: Vec<usize> = effect_columns(problem).iter().map(|one| one.0).collect();
    own.iter()
        .map(|column| left_over(&rows, *column))
        .fold((f64::INFINITY, 0.0), |(least, most), share| {
            (f64::min(least, share), f64::max(most, share))
        })
}

/// The problem with the radius held: a length from outside.
fn with_radius_held(problem: &Problem) -> Problem {
    let mut parts = problem.parts.clone();
    let system = &mut parts[0].system;
    let radius = system.assembly.names.parameters.iter().position(|one| one.name == "radius");
    system.settings[radius.unwrap()].fixed = true;
    Problem::new(parts)
}

#[test]
fn effects_are_absorbed_where_they_say_so_and_nowhere_else() {
    let folder = folder("absorbed");
    let path = folder.join("arm");
    let library = Library::builtin().unwrap();
    // Lengths that the statement of the radius alone separates, as their files say.
    let lengths = ["arm_radius", "distance_scale", "kinematic_scale", "target_radial_offset"];
    let mut absorbed = Vec::new();
    for name in fitting(&path) {
        let problem = problem(&path, &[&name]);
        if effect_columns(&problem).is_empty() {
            continue;
        }
        let about = &library.effect(&name).unwrap().about;
        let (zero, point) = (Point::stated(&problem.layout), typical(&problem));
        let (_, at_zero) = shares(&problem, &zero);
        if about.starts_with("Absorbed:") {
            assert!(at_zero < 1e-13, "{name} leaves {at_zero:e}");
            absorbed.push(name);
        } else if lengths.contains(&name.as_str()) {
            assert!(at_zero < 1e-13, "{name} leaves {at_zero:e}");
            let (held, _) = shares(&with_radius_held(&problem), &zero);
            assert!(held > 1e-2, "{name} leaves {held:e} of a stated radius");
        } else {
            let (_, beyond) = shares(&problem, &point);
            assert!(beyond > 1e-3, "{name} leaves {beyond:e}");
        }
    }
    assert!(absorbed.len() >= 7, "{absorbed:?}");
}

/// Share that the model and all effects but the last leave of each of the last one's columns.
fn share_of_last(campaign: &Path, effects: &[&str]) -> Vec<(String, f64)> {
    let problem = problem(campaign, effects);
    let rows = whitened(&problem, &Point::stated(&problem.layout));
    let own = effect_columns(&problem);
    let last = effects.last().unwrap();
    let prefix = format!("{last}.");
    let mut others = rows.clone();
    // The last effect's columns one at a time: alone beside the rest.
    for (column, _, name) in &own {
        if name.starts_with(&prefix) {
            others.column_mut(*column).fill(0.0);
        }
    }
    let kept: Vec<usize> =
        (0..rows.ncols()).filter(|column| others.column(*column).norm() > 0.0).collect();
    let mut shares = Vec::new();
    for (column, _, name) in own.into_iter().filter(|one| one.2.starts_with(&prefix)) {
        let mut columns = kept.clone();
        columns.push(column);
        shares.push((name, left_over(&rows.select_columns(&columns), columns.len() - 1)));
    }
    shares
}

#[test]
fn effects_that_are_one_with_others_are() {
    let folder = folder("alike");
    let arm = folder.join("arm");
    for effects in [
        &["axial_runout_second", "bearing_wobble"][..],
        &["bearing_wobble", "axial_runout_second"],
        &["centrifugal_stretch", "support_sway"],
        &["support_sway", "centrifugal_stretch"],
        // r'' is across the arm by the acceleration and along it by the square of the rate.
        &["arm_acceleration_bending", "centrifugal_stretch", "acceleration_lag"],
    ] {
        let shares = share_of_last(&arm, effects);
        assert!(!shares.is_empty());
        for (name, share) in shares {
            assert!(share < 1e-12, "{name} leaves {share:e} beside {effects:?}");
        }
    }
}

#[test]
fn a_robots_first_and_last_joint_are_absorbed_and_the_others_are_not() {
    let folder = folder("joints");
    for (name, share) in share_of_last(&folder.join("robot"), &["joint_offset"]) {
        if name.ends_with("joint_1") || name.ends_with("joint_6") {
            assert!(share < 1e-12, "{name} leaves {share:e}");
        } else {
            assert!(share > 1e-3, "{name} leaves {share:e}");
        }
    }
}
