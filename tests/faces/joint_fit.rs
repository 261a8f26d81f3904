//! What stands behind delays is said beside them: other solutions, members that were held or chosen.

use std::process::Command;

use serde_json::Value;

use crate::folder::Folder;

/// A mirror that turns with one period: solutions a period apart fit alike.
fn mirror() -> Folder {
    let angle = |t: f64| 0.5 * (std::f64::consts::TAU * t / 2.0).sin();
    let log: String = (0..1600)
        .map(|n| 0.025 * f64::from(n))
        .map(|t| format!("{t:.3},{:.8}\n", angle(t)))
        .collect();
    let data: String = (0..250)
        .map(|n| (5.0 + 0.1 * f64::from(n), 1e-4 * f64::from((n * 37) % 11 - 5) / 3.0))
        .map(|(t, noise)| format!("{t:.3},{:.8}\n", 1.1 * angle(t + 0.013) + noise))
        .collect();
    let files = [
        (
            "model.toml",
            "name = \"mirror\"\ntitle = \"Mirror\"\n[inputs]\nangle = { unit = \"rad\", signal = true }\n\
             [parameters]\nscale = { unit = \"1\", start = \"1\" }\n[measurands]\n\
             y = { value = 'scale * angle', unit = \"rad\", sigma = \"100 urad\" }\n"
                .to_owned(),
        ),
        (
            "campaign.toml",
            "title = \"Mirror\"\nmodel = \"model.toml\"\ndelay_range = \"5 s\"\n[[runs]]\nname = \"run\"\n\
             data = \"data.csv\"\nsignals = [\"log.csv\"]\n"
                .to_owned(),
        ),
        (
            "effects/uneven.toml",
            "name = \"uneven\"\ntitle = \"Uneven\"\nacts = \"instrument\"\n[shape]\nperiod = { unit = \"rad\", from = \"0.2 rad\", to = \"0.7 rad\" }\n\
             [parameters]\nextra = { unit = \"1\", typical = \"1e-3\", scope = \"instrument\" }\n\
             wave = { unit = \"rad\", typical = \"1 mrad\", scope = \"instrument\" }\n\
             [patch]\ny = 'y + extra * angle + wave * cos(angle * (1 turn) / period)'\n"
                .to_owned(),
        ),
        ("log.csv", format!("time [s],angle [rad]\n{log}")),
        ("data.csv", format!("time [s],y [rad]\n{data}")),
    ];
    let files = files.each_ref().map(|(name, text)| (*name, text.as_str()));
    Folder::new("mirror", &files)
}

fn said(folder: &Folder, arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    let output = command.arg(arguments[0]).arg(&**folder).args(&arguments[1..]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn solutions_that_fit_alike_are_reported_beside_delays_and_the_comparison() {
    let folder = mirror();
    for command in ["calibrate", "delays", "compare"] {
        let text = said(&folder, &[command]);
        assert!(text.contains("The solution is ambiguous: beside `y.delay`"), "{command}: {text}");
        let value: Value =
            serde_json::from_str(&said(&folder, &[command, "--format", "json"])).unwrap();
        let others = value["other_minima"].as_array().unwrap();
        // Half a period later with a scale of the other sign.
        let halves = |one: &Value| one["value"].as_f64().unwrap() - 0.013;
        assert!(!others.is_empty(), "{command}");
        assert!(others.iter().all(|one| (halves(one) - halves(one).round()).abs() < 1e-2));
    }
}

#[test]
fn members_that_are_held_or_chosen_are_reported_beside_delays_and_the_comparison() {
    let folder = mirror();
    for command in ["calibrate", "delays", "compare"] {
        let text = said(&folder, &[command, "--with", "uneven"]);
        assert!(text.contains("`uneven.extra` is held at zero"), "{command}: {text}");
        assert!(text.contains("`uneven.period` = "), "{command}: {text}");
    }
}
