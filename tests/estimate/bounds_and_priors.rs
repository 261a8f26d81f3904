//! Estimates at their bounds, starts beyond them, and stated values that readings contradict, on a
//! scale whose answers are known.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Bound, Calibration, Estimate, calibrate};
use homepoint::estimate::contradicted::contradicted;
use homepoint::report;

use crate::scale::{SCALE, Scales};

fn fitted(parameters: &str, sigma: &str, readings: &[f64]) -> Calibration {
    let scales = Scales::new();
    let of_x = format!("x = {{ sigma = \"{sigma}\" }}");
    let folder = scales.written("c", SCALE, "", parameters, &of_x, "m", readings);
    let problem = open(&Request::new([folder])).unwrap().problem;
    calibrate(problem, &Options::default()).unwrap()
}

fn of_a(fit: &Calibration) -> Estimate {
    fit.estimates().into_iter().find(|one| one.name == "a").unwrap()
}

#[test]
fn an_estimate_that_a_bound_holds_says_so_and_has_no_uncertainty() {
    for (said, value, bound) in [
        (r#"a = { upper = "1 m" }"#, 1.0, Bound::Upper),
        (r#"a = { lower = "2 m" }"#, 2.0, Bound::Lower),
        (r#"a = { lower = "0 m", upper = "1 m", start = "0.5 m" }"#, 1.0, Bound::Upper),
        (r#"a = { upper = "0 m" }"#, 0.0, Bound::Upper),
    ] {
        let fit = fitted(said, "1 mm", &[1.0005, 1.0005]);
        assert!(fit.is_sound(), "{said}: {}", fit.fit.outcome);
        let one = of_a(&fit);
        assert_eq!((one.value, one.sigma, one.bound), (Some(value), None, Some(bound)), "{said}");
        let text = report::text::calibration("t", &fit);
        assert!(text.contains(&format!("at its {} bound", bound.word())), "{text}");
        let json = report::json::calibration(&fit);
        let own = json["parameters"].as_array().unwrap();
        let own = own.iter().find(|one| one["name"] == "a").unwrap();
        assert_eq!((&own["bound"], own["sigma"].is_null()), (&bound.word().into(), true));
    }
}

#[test]
fn a_bound_that_does_not_hold_the_estimate_leaves_it_alone() {
    for said in ["", r#"a = { lower = "0 m" }"#, r#"a = { lower = "0 m", upper = "2 m" }"#] {
        let fit = fitted(said, "1 mm", &[1.0, 1.001]);
        let one = of_a(&fit);
        assert_eq!(one.bound, None, "{said}");
        assert!((one.sigma.unwrap() - 1e-3 / 2_f64.sqrt()).abs() < 1e-12);
        assert!(report::json::calibration(&fit)["parameters"][0].get("bound").is_none());
    }
}

#[test]
fn a_start_beyond_a_bound_is_moved_into_it() {
    // The readings pull away from the bound, and a fit from beyond it would not get anywhere.
    for (said, read, value) in [
        (r#"a = { lower = "3 m" }"#, 5.0, 5.0),
        (r#"a = { lower = "3 m" }"#, -5.0, 3.0),
        (r#"a = { upper = "-3 m" }"#, -5.0, -5.0),
        (r#"a = { upper = "-3 m" }"#, 5.0, -3.0),
        (r#"a = { lower = "3 m", upper = "4 m", start = "9 m" }"#, 3.5, 3.5),
    ] {
        let fit = fitted(said, "1 mm", &[read, read]);
        assert!(fit.is_sound(), "{said} {read}: {}", fit.fit.outcome);
        let found = of_a(&fit).value.unwrap();
        assert!((found - value).abs() < 1e-9, "{said} {read}: {found}");
    }
}

#[test]
fn a_value_that_is_far_off_is_contradicted_by_however_few_readings() {
    for count in [1, 2, 20, 100] {
        let readings: Vec<f64> = (0..count).map(|k| 2.0 + 1e-7 * f64::from(k % 3)).collect();
        for (off, is_contradicted) in [(1e6, true), (100.0, true), (8.0, true), (2.0, false)] {
            let value = 2.0 - 1e-6 * off;
            let said = format!("a = {{ value = \"{value:?} m\", sigma = \"1 um\" }}");
            let fit = fitted(&said, "1 um", &readings);
            let found = contradicted(&fit);
            assert_eq!(!found.is_empty(), is_contradicted, "{count} {off}");
            if let Some(one) = found.first() {
                assert_eq!(one.parameter, "a");
                let expected = off / (1.0 + 1.0 / f64::from(count)).sqrt();
                assert!((one.deviations / expected - 1.0).abs() < 0.05, "{}", one.deviations);
            }
        }
    }
}

/// Readings that scatter more than stated raise the bar by as much.
#[test]
fn residuals_larger_than_stated_raise_the_bar() {
    let readings: Vec<f64> = (0..40).map(|k| 2.0 + if k % 2 == 0 { 1e-3 } else { -1e-3 }).collect();
    let said = "a = { value = \"2.0001 m\", sigma = \"1 um\" }";
    assert!(contradicted(&fitted(said, "10 um", &readings)).is_empty());
    assert!(!contradicted(&fitted(said, "10 um", &vec![2.0; 40])).is_empty());
}

/// Two of a kind, both far off: neither hides the other.
#[test]
fn several_contradicted_values_do_not_hide_each_other() {
    let model = SCALE.replace(
        "[measurands]\n",
        "b = { unit = \"m\", scope = \"instrument\" }\n\n[measurands]\ny = { value = 'b', unit = \"m\" }\n",
    );
    let said = "\"y.delay\" = { value = \"0 s\", fixed = true }\na = { value = \"1 m\", sigma = \"1 um\" }\nb = { value = \"1 m\", sigma = \"1 um\" }\n";
    let scales = Scales::new();
    let sigmas = "x = { sigma = \"1 um\" }\ny = { sigma = \"1 um\" }";
    let folder = scales.written("c", &model, "", said, sigmas, "m", &[]);
    std::fs::write(folder.join("one.csv"), "time [s],x [m],y [m]\n0,2,3\n1,2,3\n").unwrap();
    let problem = open(&Request::new([folder])).unwrap().problem;
    let fit = calibrate(problem, &Options::default()).unwrap();
    let names: Vec<String> = contradicted(&fit).into_iter().map(|one| one.parameter).collect();
    assert_eq!(names, ["b", "a"]);
}

/// A stop that is measured in residuals of a million times the stated noise would be far from the
/// minimum.
#[test]
fn contradictory_values_end_at_their_minimum() {
    let fit = fitted(r#"a = { value = "1 m", sigma = "1 um" }"#, "1 um", &[2.0]);
    let found = of_a(&fit).value.unwrap();
    assert!(fit.is_sound());
    assert!((found - 1.5).abs() < 1e-9, "{found}");
}

#[test]
fn temperatures_are_printed_as_values_and_their_uncertainties_as_differences() {
    let model = SCALE.replace("\"m\"", "\"degC\"");
    let scales = Scales::new();
    let (head, sigma) = ("", "x = { sigma = \"0.5 K\" }");
    let folder = scales.written("c", &model, head, "", sigma, "degC", &[20.0, 20.0]);
    let problem = open(&Request::new([folder])).unwrap().problem;
    let fit = calibrate(problem, &Options::default()).unwrap();
    let text = report::text::calibration("t", &fit);
    assert!(text.contains("20.00 degC"), "{text}");
    assert!(text.contains("0.35 K"), "{text}");
    assert!(!text.contains("fixed"), "{text}");
    let table = report::table::parameters(&fit);
    let row = table.lines().find(|line| line.starts_with("a,")).unwrap();
    let fields: Vec<&str> = row.split(',').collect();
    let number = |index: usize| fields[index].parse::<f64>().unwrap();
    assert!((number(3) - 293.15).abs() < 1e-6, "{row}");
    assert!((number(4) - 0.5_f64.sqrt() * 0.5).abs() < 1e-9, "{row}");
    assert_eq!(fields[5], "K");
}
