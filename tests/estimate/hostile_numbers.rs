//! Finite numbers of any size in readings, uncertainties and stated values: estimates end with an
//! answer of their own type, never with a panic, and in bounded time.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::{Options, Outcome};
use homepoint::estimate::calibrate::{Calibration, calibrate};

use crate::scale::{SCALE, Scales};

const SIZES: [f64; 9] = [1e-300, 1e-160, 1e-30, 1.0, 1e30, 1e100, 1e150, 1e200, 1e308];

fn fitted(folder: &std::path::Path) -> Option<Calibration> {
    let problem = open(&Request::new([folder])).ok()?.problem;
    calibrate(problem, &Options::default()).ok()
}

/// A scale with a level of its noise to be estimated.
const NOISY: &str = r#"name  = "scale"
title = "A scale on a lift"

[inputs]
lift = { unit = "m", signal = true }

[parameters]
a = { unit = "m", scope = "instrument" }

[measurands]
x = { value = 'a + lift', unit = "m" }
"#;

fn noisy(scales: &Scales, name: &str, reading: f64) -> std::path::PathBuf {
    let (head, sigma) = ("effects = [\"timestamp_jitter\"]\n", "x = { sigma = \"1 mm\" }");
    let folder = scales.written(name, NOISY, head, "", sigma, "m", &[]);
    let rows = (0..12).map(|row| {
        let x = if row == 7 { reading } else { 5.0 + f64::from(row) };
        format!("{row},{row},1,{x:e}\n")
    });
    let text = format!("time [s],lift [m],lift_rate [m/s],x [m]\n{}", rows.collect::<String>());
    std::fs::write(folder.join("one.csv"), text).unwrap();
    folder
}

#[test]
fn levels_of_noise_are_estimated_or_the_fit_says_that_numbers_are_too_large() {
    let scales = Scales::new();
    let mut too_large = 0;
    for (number, size) in SIZES.into_iter().enumerate() {
        for sign in [1.0, -1.0] {
            let name = format!("c{number}{sign}");
            let Some(fit) = fitted(&noisy(&scales, &name, sign * size)) else { continue };
            if fit.fit.outcome == Outcome::NotFinite {
                too_large += 1;
                let farthest = fit.problem.farthest(&fit.fit.point);
                assert_eq!(farthest.map(|one| one.place.2), Some(7), "{size}");
            } else {
                assert!(fit.levels.iter().all(|one| one.value.is_finite()), "{size}");
            }
        }
    }
    assert!(too_large > 0);
}

#[test]
fn readings_uncertainties_and_stated_values_of_any_size_end_in_an_answer() {
    let scales = Scales::new();
    let few = || [1e-300, 1e-160, 1.0, 1e150, 1e308].into_iter().enumerate();
    for (i, reading) in few() {
        for (j, sigma) in few() {
            for (k, stated) in few() {
                let said = format!("a = {{ value = \"{stated:e} m\", sigma = \"{sigma:e} m\" }}");
                let of_x = format!("x = {{ sigma = \"{sigma:e} m\" }}");
                let name = format!("c{i}_{j}_{k}");
                let readings = [1.0, reading, -reading];
                let folder = scales.written(&name, SCALE, "", &said, &of_x, "m", &readings);
                if let Some(fit) = fitted(&folder) {
                    // Whatever it says, it says it without a panic.
                    drop((fit.is_sound(), fit.estimates(), fit.variance_factor()));
                }
            }
        }
    }
}

/// What a run that is not measured yet would tell is computed from sums of squares over its own
/// values.
#[test]
fn remedies_are_looked_for_with_uncertainties_of_any_size() {
    let scales = Scales::new();
    for (number, sigma) in SIZES.into_iter().enumerate() {
        let head = "";
        let said = "a = { scope = \"run\" }";
        let of_x = format!("x = {{ sigma = \"{sigma:e} m\" }}");
        let folder = scales.written(&format!("c{number}"), NOISY, head, said, &of_x, "m", &[]);
        let text = "time [s],lift [m],lift_rate [m/s],x [m]\n0,0,1,1\n1,1,1,2\n2,2,1,3\n";
        std::fs::write(folder.join("one.csv"), text).unwrap();
        let campaign = folder.join("campaign.toml");
        let free = std::fs::read_to_string(&campaign).unwrap().replace("\"x.delay\" =", "#");
        std::fs::write(&campaign, free).unwrap();
        if let Some(fit) = fitted(&folder) {
            assert!(fit.fit.outcome == Outcome::NotFinite || !fit.is_sound(), "{sigma}");
        }
    }
}
