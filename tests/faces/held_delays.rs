//! A delay that no reading of the nominal model depends on is held at zero by a diagnosis; where an effect
//! that it finds is the first that depends on a signal, the command that goes on states it.

use std::fmt::Write as _;
use std::process::Command;

use crate::folder::Folder;

const MODEL: &str = "name = \"axis\"\ntitle = \"Axis\"\n[inputs]\nnominal = { unit = \"m\" }\nspindle = { unit = \"K\", signal = true }\n\
     [parameters]\nzero = { unit = \"m\" }\n[measurands]\nposition = { value = 'nominal + zero', unit = \"m\" }\n";
const EFFECT: &str = "name = \"expansion\"\ntitle = \"Thermal growth\"\nacts = \"instrument\"\n[parameters]\n\
     alpha = { unit = \"ppm/K\", typical = \"10 ppm/K\", scope = \"rig\" }\n\
     [patch]\nposition = 'position + alpha * nominal * (spindle - 293.15 K)'\n";
const CAMPAIGN: &str = "title = \"Axis\"\nmodel = \"model.toml\"\n[measurands]\nposition = { sigma = \"1 um\" }\n\
     [[runs]]\nname = \"all\"\ndata = \"all.csv\"\nsignals = [\"spindle.csv\"]\n";

#[test]
fn the_next_command_states_a_delay_that_was_held() {
    let warm = |t: f64| 20.0 + 6.0 * (1.0 - (-t / 900.0).exp());
    let mut stream = "time [s],spindle [degC]\n".to_owned();
    for i in 0..260 {
        let t = 10.0 * f64::from(i) - 100.0;
        writeln!(stream, "{t:.1},{:.5}", warm(t.max(0.0))).unwrap();
    }
    let mut table = "time [s],nominal [mm],position [mm]\n".to_owned();
    for i in 0..400 {
        let (t, x) = (6.0 * f64::from(i), 12.5 * f64::from(i * 17 % 41));
        let noise = 0.001 * (f64::from(i * 29 % 60) / 17.0 - 1.76);
        let x_read = x * (1.0 + 12e-6 * (warm(t) - 20.0)) + noise;
        writeln!(table, "{t:.1},{x:.1},{x_read:.5}").unwrap();
    }
    let files = [
        ("model.toml", MODEL),
        ("campaign.toml", CAMPAIGN),
        ("effects/expansion.toml", EFFECT),
        ("all.csv", &*table),
        ("spindle.csv", &*stream),
    ];
    let folder = Folder::new("axis", &files);
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
        let output = command.args(arguments).arg(".").current_dir(&*folder).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (_, text) = run(&["diagnose"]);
    let due = "`homepoint calibrate . --set position.delay=\"0 s\" --with expansion`";
    assert!(text.contains(due), "{text}");
    let (code, text) = run(&["calibrate", "--set", "position.delay=0 s", "--with", "expansion"]);
    assert_eq!(code, Some(0), "{text}");
}
