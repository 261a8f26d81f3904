//! Values of rows by groups of readings (runs, senses, rates): among many comparisons some differ by
//! chance, and the rows stand all the same.

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::stream::Stream;
use crate::written::diagnosed;

const SAMPLES: usize = 400;
const DRAWS: u64 = 40;

/// Speed and yaw rate of a robot beside the speeds of its wheels, in four runs; both wheels are larger
/// than stated, not by the same, and stand farther apart.
fn robot(seed: u64) -> Diagnosis {
    let model = "name = \"robot\"\ntitle = \"Robot\"\n[inputs]\nleft_wheel = { unit = \"rad/s\", signal = true }\nright_wheel = { unit = \"rad/s\", signal = true }\n\
         [parameters]\ntrack = { unit = \"m\", scope = \"rig\", value = \"0.5 m\", fixed = true }\n\
         [quantities]\nleft = '0.1 m * left_wheel'\nright = '0.1 m * right_wheel'\n\
         [measurands]\nspeed = { value = '(left + right) / 2', unit = \"m/s\" }\nyaw_rate = { value = '(right - left) / track', unit = \"rad/s\" }\n\
         [delays]\ncamera = { of = [\"speed\", \"yaw_rate\"] }\n";
    let effect = |name: &str, unit: &str, patch: &str| {
        format!(
            "name = \"{name}\"\ntitle = \"{name}\"\nacts = \"arm\"\n[parameters]\nchange = {{ unit = \"{unit}\", typical = \"0.01 {unit}\", scope = \"rig\" }}\n[patch]\n{patch}\n"
        )
    };
    let both = "left = 'left * (1 + change)'\nright = 'right * (1 + change)'";
    let unequal = "left = 'left * (1 - change)'\nright = 'right * (1 + change)'";
    let mut files = vec![
        ("model.toml".to_owned(), model.to_owned()),
        ("effects/larger.toml".to_owned(), effect("larger", "1", both)),
        ("effects/unequal.toml".to_owned(), effect("unequal", "1", unequal)),
        ("effects/wider.toml".to_owned(), effect("wider", "m", "track = 'track + change'")),
    ];
    let mut campaign = "title = \"Robot\"\nmodel = \"model.toml\"\n[measurands]\nspeed = { sigma = \"5 mm/s\" }\nyaw_rate = { sigma = \"13 mrad/s\" }\n[parameters]\n\"camera.delay\" = { value = \"-20 ms\", fixed = true }\n".to_owned();
    let mut random = Stream(seed);
    for (name, slope) in [("up", 0.05), ("fast", 0.09), ("down", -0.04), ("slow", 0.02)] {
        campaign += &format!(
            "[[runs]]\nname = \"{name}\"\ndata = \"{name}.csv\"\nsignals = [\"{name}_wheels.csv\"]\n"
        );
        let wheels = |t: f64| {
            let ahead = 4.0 + slope * t + 0.6 * (0.05 * t).sin();
            let turn = 1.5 * (0.3 * t + 1.0).sin() + 0.3 * slope * t;
            [ahead - turn, ahead + turn]
        };
        let mut stream = "time [s],left_wheel [rad/s],right_wheel [rad/s]\n".to_owned();
        let mut log = "time [s],speed [m/s],yaw_rate [rad/s]\n".to_owned();
        for sample in 0..SAMPLES * 2 {
            let t = 0.05 * sample as f64;
            let [left, right] = wheels(t);
            stream += &format!("{t:.3},{left:.6},{right:.6}\n");
            if sample > 4 && sample % 2 == 0 && sample < 2 * SAMPLES - 4 {
                let [left, right] = wheels(t - 0.02);
                let [left, right] = [0.1 * 1.002 * left, 0.1 * 1.009 * right];
                let speed = 0.5 * (left + right) + 5e-3 * random.normal();
                let yaw = (right - left) / 0.506 + 13e-3 * random.normal();
                log += &format!("{t:.3},{speed:.6},{yaw:.6}\n");
            }
        }
        files.push((format!("{name}.csv"), log));
        files.push((format!("{name}_wheels.csv"), stream));
    }
    files.push(("campaign.toml".to_owned(), campaign));
    diagnosed(&files)
}

#[test]
fn three_causes_stand_in_every_draw() {
    let mut wrong = Vec::new();
    for seed in 0..DRAWS {
        let found = robot(500 + seed);
        let mut names: Vec<&str> = found.rows.iter().map(|row| row.name.as_str()).collect();
        names.sort_unstable();
        if found.verdict != Verdict::Explained || names != ["larger", "unequal", "wider"] {
            wrong.push(format!("{seed}: {}", told(&found)));
        }
    }
    assert!(wrong.is_empty(), "{} of {DRAWS}\n{}", wrong.len(), wrong.join("\n"));
}

/// Six runs of a shaker that swings to and fro, of which the gain differs by a thousandth: no run has a
/// rate by which values could differ, and what the user suspects is named.
#[test]
fn runs_that_swing_have_no_rates_to_differ_by() {
    let model = "name = \"shaker\"\ntitle = \"Shaker\"\n[inputs]\ntable = { unit = \"m\", signal = true }\n\
         [parameters]\nzero = { unit = \"m\", scope = \"rig\" }\n[quantities]\nmoved = 'table'\n\
         [measurands]\npot = { value = 'zero + moved', unit = \"m\", sigma = \"0.3 mm\" }\n";
    let effect = "name = \"larger\"\ntitle = \"larger\"\nacts = \"arm\"\n[parameters]\nchange = { unit = \"1\", typical = \"0.01\", scope = \"rig\" }\n[patch]\nmoved = 'moved * (1 + change)'\n";
    let mut files = vec![
        ("model.toml".to_owned(), model.to_owned()),
        ("effects/larger.toml".to_owned(), effect.to_owned()),
    ];
    let mut campaign = "title = \"Shaker\"\nmodel = \"model.toml\"\n".to_owned();
    let mut random = Stream(77);
    for run in 0..6 {
        campaign += &format!(
            "[[runs]]\nname = \"r{run}\"\ndata = \"r{run}.csv\"\nsignals = [\"r{run}_table.csv\"]\n"
        );
        let swing = |t: f64| 0.06 * (5.65 * t + f64::from(run)).sin();
        let gain = 1.01 + 0.001 * random.normal();
        let mut log = "time [s],pot [mm]\n".to_owned();
        let mut stream = "time [s],table [mm]\n".to_owned();
        let start = 30.0 * f64::from(run);
        for sample in -60..460 {
            let t = start + 0.02 * f64::from(sample);
            stream += &format!("{t:.3},{:.6}\n", 1e3 * swing(t));
            if (0..400).contains(&sample) {
                log += &format!(
                    "{t:.3},{:.4}\n",
                    1e3 * gain * swing(t - 0.004) + 0.3 * random.normal()
                );
            }
        }
        files.push((format!("r{run}.csv"), log));
        files.push((format!("r{run}_table.csv"), stream));
    }
    files.push(("campaign.toml".to_owned(), campaign));
    let found = diagnosed(&files);
    assert!(found.rows.iter().any(|row| row.name == "larger"), "{}", told(&found));
}
