//! An effect of the user's own with a value for each run, which sum to zero, beside another one: all
//! that held-out runs could say of it is in the runs themselves.

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::stream::Stream;
use crate::written::diagnosed;

/// Runs, readings of each, and their standard deviation (N).
const RUNS: usize = 24;
const READINGS: usize = 20;
const SIGMA: f64 = 0.4;

#[test]
fn zero_shifts_of_runs_are_named_beside_a_gain_over_temperature() {
    let model = "name = \"cell\"\ntitle = \"Load cell\"\n[inputs]\nload = { unit = \"N\" }\nwarmth = { unit = \"K\" }\n\
         [parameters]\nzero = { unit = \"N\", scope = \"rig\" }\ngain = { unit = \"1\", scope = \"rig\", start = \"1\" }\n\
         [quantities]\nshown = 'gain * load'\n\
         [measurands]\nforce = { value = 'shown + zero', unit = \"N\" }\n";
    let effect = |name: &str, parameter: &str, patch: &str| {
        format!(
            "name = \"{name}\"\ntitle = \"{name}\"\nacts = \"instrument\"\n[parameters]\n{parameter}\n[patch]\nshown = '{patch}'\n"
        )
    };
    let shift = "shift = { unit = \"N\", typical = \"0.2 N\", scope = \"run\", sum = \"zero\" }";
    let slope = "slope = { unit = \"1/K\", typical = \"1e-4 1/K\", scope = \"rig\" }";
    let mut files = vec![
        ("model.toml".to_owned(), model.to_owned()),
        ("effects/switched.toml".to_owned(), effect("switched", shift, "shown + shift")),
        ("effects/warm.toml".to_owned(), effect("warm", slope, "shown + slope * warmth * load")),
    ];
    let mut campaign = format!(
        "title = \"Load cell\"\nmodel = \"model.toml\"\n[measurands]\nforce = {{ sigma = \"{SIGMA} N\" }}\n"
    );
    let mut random = Stream(31);
    let draws: Vec<f64> = (0..RUNS).map(|_| 0.45 * random.normal()).collect();
    let mean = draws.iter().sum::<f64>() / RUNS as f64;
    let shifts: Vec<f64> = draws.iter().map(|one| one - mean).collect();
    for (run, shift) in shifts.iter().enumerate() {
        let warmth = 12.0 * random.normal();
        campaign += &format!(
            "[[runs]]\nname = \"r{run}\"\ndata = \"r{run}.csv\"\ninputs = {{ warmth = \"{warmth} K\" }}\n"
        );
        let mut log = "load [N],force [N]\n".to_owned();
        for reading in 0..READINGS {
            let load = 250.0 * (reading % 10) as f64 / 10.0 + 3.0 * random.normal();
            let force = 1.0007 * load + 2.1 + shift + 3.1e-4 * warmth * load;
            log += &format!("{load:.5},{:.5}\n", force + SIGMA * random.normal());
        }
        files.push((format!("r{run}.csv"), log));
    }
    files.push(("campaign.toml".to_owned(), campaign));
    let found = diagnosed(&files);
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
    let mut names: Vec<&str> = found.rows.iter().map(|row| row.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["switched", "warm"], "{}", told(&found));
    let fit = found.explained.as_ref().unwrap();
    for one in fit.estimates().iter().filter(|one| one.name == "switched.shift") {
        let run: usize = one.of.as_ref().unwrap()[1..].parse().unwrap();
        let off = (one.value.unwrap() - shifts[run]) / one.sigma.unwrap();
        assert!(off.abs() < 4.0, "run {run}: {off}");
    }
}
