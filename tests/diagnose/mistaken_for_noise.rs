//! Structure that could be mistaken for noise, and what else a fit could mistake: waves of a reading
//! over itself, a step beside slow noise, an alias that a row makes, a wrong value beside effects,
//! readings that lead a fit astray.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::found::AutocorrelatedNoise;
use homepoint::engine::open::{Request, open};
use homepoint::estimate::minima::improved;

use crate::drawn::run;
use crate::found::{names, told};
use crate::load_cell::{DELAY, LoadCell};
use crate::own_effects::Campaign;
use crate::stream::Stream;

fn is_near(found: &Diagnosis, row: &str, due: f64) {
    let row = found.rows.iter().find(|one| one.name == row).unwrap();
    let value = &row.values[0];
    let far = (value.value.unwrap() - due) / value.sigma.unwrap();
    assert!(far.abs() < 4.0, "{}: {far}, {}", row.name, told(found));
}

/// A pair of gears whose shafts are counted on over turns.
const PAIR: &str = r#"
name = "pair"
title = "Pair of gears"
[inputs]
pinion = { unit = "rad" }
[parameters]
zero = { unit = "rad", scope = "rig" }
[quantities]
turned = 'pinion * 19 / 47'
[measurands]
wheel = { value = 'turned + zero', unit = "rad" }
"#;
const RUNOUT: (&str, &str, &str) = (
    "runout",
    "c = { unit = \"rad\", typical = \"100 urad\", scope = \"rig\" }\ns = { unit = \"rad\", typical = \"100 urad\", scope = \"rig\" }",
    "turned = 'turned + c * cos(pinion * 19 / 47) + s * sin(pinion * 19 / 47)'",
);

/// A row with the first of several waves leaves the others as candidates.
#[test]
fn waves_over_a_shaft_that_is_read_have_their_place_beside_the_first_of_them() {
    let mut random = Stream(71);
    let mut log = "pinion [rad],wheel [rad]\n".to_owned();
    for row in 0..700 {
        // Six whole turns.
        let wheel = 6.0 * std::f64::consts::TAU * f64::from(row) / 700.0;
        let pinion = wheel * 47.0 / 19.0;
        let error = 1.2e-4 * wheel.cos() + 4e-5 * (2.0 * wheel + 0.4).sin();
        writeln!(log, "{pinion:.6},{:.8}", wheel + error + 0.1 + 1.5e-5 * random.normal()).unwrap();
    }
    let measurands = "wheel = { sigma = \"15 urad\" }";
    let found = Campaign { model: PAIR, effects: &[RUNOUT], measurands, log }.diagnosed();
    assert_eq!(names(&found), ["runout"], "{}", told(&found));
    is_near(&found, "runout", 1.2e-4);
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
    assert_eq!(
        found.remainder[0].place.words,
        "an error of `wheel` over wheel, 2 waves a turn",
        "{}",
        told(&found)
    );
}

/// A drive whose length follows from two others.
const DRIVE: &str = r#"
name = "drive"
title = "Drive of a parallel machine"
[inputs]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
zero = { unit = "m", scope = "rig" }
[measurands]
drive = { value = 'zero + sqrt(x^2 + y^2)', unit = "m" }
"#;

/// A wave of a length over itself is no scatter.
#[test]
fn a_wave_of_a_length_over_itself_has_its_place() {
    let mut random = Stream(73);
    let mut log = "x [m],y [m],drive [m]\n".to_owned();
    for _ in 0..220 {
        let (x, y) = (0.3 + 0.2 * random.uniform(), 0.2 + 0.4 * random.uniform());
        let drive = f64::hypot(x, y);
        let wave = 50e-6 * (std::f64::consts::TAU * 30.0 * drive + 0.7).sin();
        writeln!(log, "{x:.6},{y:.6},{:.7}", drive + wave + 0.01 + 1.2e-5 * random.normal())
            .unwrap();
    }
    let measurands = "drive = { sigma = \"12 um\" }";
    let found = Campaign { model: DRIVE, effects: &[], measurands, log }.diagnosed();
    let words = &found.remainder[0].place.words;
    assert_eq!(words, "an error of `drive` over drive, 30 waves a metre", "{}", told(&found));
}

/// A height with yearly waves.
const SITE: &str = r#"
name = "site"
title = "Site"
[inputs]
season = { unit = "rad" }
[parameters]
level = { unit = "m", scope = "rig" }
[quantities]
height = 'level'
[measurands]
up = { value = 'height', unit = "m" }
"#;
const YEARLY: (&str, &str, &str) = (
    "yearly",
    "c = { unit = \"m\", typical = \"5 mm\", scope = \"rig\" }\ns = { unit = \"m\", typical = \"5 mm\", scope = \"rig\" }",
    "height = 'height + c * cos(season) + s * sin(season)'",
);

/// Without the step the noise would be half as large again, and remember four times as long.
#[test]
fn a_step_beside_noise_that_remembers_is_found() {
    let mut random = Stream(79);
    let mut log = "time [s],season [rad],up [m]\n".to_owned();
    let mut slow = 0.0;
    for row in 0..1200 {
        slow = 0.9 * slow + (1.0_f64 - 0.81).sqrt() * 4e-3 * random.normal();
        let season = 0.0172 * f64::from(row);
        let step = if row >= 700 { 0.015 } else { 0.0 };
        let up = 0.2 + 4e-3 * season.cos() + step + slow + 4e-3 * random.normal();
        writeln!(log, "{row},{season:.5},{up:.6}").unwrap();
    }
    let measurands = "up = { sigma = \"4 mm\" }";
    let found = Campaign { model: SITE, effects: &[YEARLY], measurands, log }.diagnosed();
    let change = found.remainder.iter().find(|one| one.change.is_some());
    let change = change.unwrap_or_else(|| panic!("{}", told(&found)));
    let (row, _) = change.place.rows.unwrap();
    assert!((690..712).contains(&row), "{row}");
    assert!(!found.autocorrelation.is_empty(), "{}", told(&found));
}

/// A beam that is loaded: its zero and its stiffness are open.
const BEAM: &str = r#"
name = "beam"
title = "Beam"
[inputs]
load = { unit = "N" }
[parameters]
zero = { unit = "m", scope = "rig" }
compliance = { unit = "m/N", scope = "rig" }
[quantities]
force = 'load'
droop = 'compliance * force'
[measurands]
read = { value = 'droop + zero', unit = "m" }
"#;
const BEND: (&str, &str, &str) = (
    "bend",
    "k = { unit = \"m/N^2\", typical = \"1e-8 m/N^2\", scope = \"rig\" }",
    "droop = 'droop + k * force^2'",
);
/// What the compliance absorbs; with the bend in the fit its slope has the form of that.
const CELL: (&str, &str, &str) = (
    "cell",
    "error = { unit = \"1\", typical = \"1 %\", scope = \"rig\" }",
    "force = 'force * (1 + error)'",
);

#[test]
fn what_a_row_brings_into_the_slope_of_another_effect_is_no_alias() {
    let mut random = Stream(83);
    let mut log = "load [N],read [m]\n".to_owned();
    for _ in 0..150 {
        let load = 100.0 * random.uniform();
        let read = 0.02 + 1e-5 * load + 3e-8 * load * load + 5e-6 * random.normal();
        writeln!(log, "{load:.4},{read:.8}").unwrap();
    }
    let measurands = "read = { sigma = \"5 um\" }";
    let found = Campaign { model: BEAM, effects: &[BEND, CELL], measurands, log }.diagnosed();
    assert_eq!(
        (found.verdict, names(&found)),
        (Verdict::Explained, vec!["bend"]),
        "{}",
        told(&found)
    );
    is_near(&found, "bend", 3e-8);
    let row = &found.rows[0];
    assert!(row.aliases.is_empty() && row.confounded.is_empty() && row.posterior > 0.99, "{row:?}");
    assert!(found.candidates.iter().all(|one| one.name != "cell"), "{:?}", found.candidates);
    let absorbed = found.absorbed.iter().find(|one| one.name == "cell");
    let absorbed = absorbed.unwrap_or_else(|| {
        panic!("{:?}", found.not_testable.iter().find(|one| one.name == "cell"))
    });
    assert_eq!(absorbed.acts_as, "compliance");
}

/// A flow meter of which the factor is stated.
const METER: &str = r#"
name = "meter"
title = "Meter"
[inputs]
flow = { unit = "1" }
warmth = { unit = "1" }
[parameters]
factor = { unit = "1", scope = "rig", value = "300", sigma = "1" }
[quantities]
through = 'flow'
gain = 'factor'
[measurands]
pulses = { value = 'gain * through', unit = "1" }
"#;
const SLIP: (&str, &str, &str) = (
    "slip",
    "lost = { unit = \"1\", typical = \"1e-2\", scope = \"rig\" }",
    "through = 'through - lost'",
);
const WARMING: (&str, &str, &str) = (
    "warming",
    "slope = { unit = \"1\", typical = \"1e-3\", scope = \"rig\" }",
    "gain = 'gain * (1 + slope * warmth)'",
);

/// Two effects keep the fit from being sound with the value free, and with it both are right.
#[test]
fn a_wrong_stated_value_is_set_free_beside_effects_that_are_as_large() {
    let mut random = Stream(89);
    let mut log = "flow [1],warmth [1],pulses [1]\n".to_owned();
    for row in 0..160 {
        let flow = 0.5 + 3.0 * random.uniform();
        let warmth = if row < 80 { 0.0 } else { 25.0 * random.uniform() };
        let pulses = 380.0 * (1.0 + 4e-3 * warmth) * (flow - 0.08) + 0.4 * random.normal();
        writeln!(log, "{flow:.5},{warmth:.3},{pulses:.4}").unwrap();
    }
    let measurands = "pulses = { sigma = \"0.4\" }";
    let effects = &[SLIP, WARMING];
    let found = Campaign { model: METER, effects, measurands, log }.diagnosed();
    assert_eq!(found.set_free.as_deref(), Some("factor"), "{}", told(&found));
    let mut all = names(&found);
    all.sort_unstable();
    assert_eq!(all, ["slip", "warming"], "{}", told(&found));
    is_near(&found, "slip", 0.08);
    is_near(&found, "warming", 4e-3);
    assert!((found.contradicted[0].alone - 380.0).abs() < 0.5, "{:?}", found.contradicted);
}

/// A pressure transducer beside a reference.
const GAUGE: &str = r#"
name = "gauge"
title = "Pressure transducer"
[inputs]
reference = { unit = "bar" }
temperature = { unit = "K" }
[parameters]
gain = { unit = "1", scope = "instrument", start = "1" }
zero = { unit = "bar", scope = "instrument" }
[measurands]
reading = { value = 'gain * reference + zero', unit = "bar" }
"#;

/// Noise alone would explain it, too, were it five times as large and remembered for minutes.
#[test]
fn an_unknown_cause_beside_noise_that_remembers_is_no_noise() {
    let mut random = Stream(83);
    let mut log = "time [s],reference [bar],temperature [K],reading [mbar]\n".to_owned();
    let (mut slow, memory) = (0.0, (-0.5_f64 / 3.0).exp());
    let mut temperatures = Vec::new();
    for row in 0..2400 {
        let t = 0.5 * f64::from(row);
        let reference = 5.0 - 4.6 * (t * 0.084).cos() + 0.15 * (t * 0.37).sin();
        let temperature = 295.0 + 3.0 * (1.0 - (-t / 500.0).exp()) + (t * 0.0203).sin();
        temperatures.push(temperature);
        slow = memory * slow + (1.0 - memory.powi(2)).sqrt() * random.normal();
        let noise = 0.5 * (0.4_f64.sqrt() * slow + 0.6_f64.sqrt() * random.normal());
        let reading = 1004.0 * reference + 12.0 + 1.2 * (temperature - 296.0) + noise;
        writeln!(log, "{t},{reference:.6},{temperature:.4},{reading:.4}").unwrap();
    }
    let measurands = "reading = { sigma = \"0.5 mbar\" }";
    let found = Campaign { model: GAUGE, effects: &[], measurands, log }.diagnosed();
    assert_eq!(found.verdict, Verdict::Unknown, "{}", told(&found));
    let [part] = &found.remainder[..] else { panic!("{}", told(&found)) };
    assert_eq!(part.place.words, "an error of `reading` over temperature", "{}", told(&found));
    // What the temperature does in readings (Pa), not in their differences.
    let count = temperatures.len() as f64;
    let mean = temperatures.iter().sum::<f64>() / count;
    let variance = temperatures.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / count;
    let (rms, _) = part.rms.as_ref().unwrap();
    let ratio = rms / (120.0 * variance.sqrt());
    assert!((0.95..1.05).contains(&ratio), "{ratio}");
    let [AutocorrelatedNoise { noise, .. }] = &found.autocorrelation[..] else {
        panic!("{}", told(&found))
    };
    let one = noise.processes().next().unwrap();
    assert!((0.3..0.5).contains(&one.share), "{noise:?}");
    assert!((2.0..4.5).contains(&one.time), "{noise:?}");
}

/// A first fit of all readings ends seconds away; from where readings are left out the fit begins anew.
#[test]
fn readings_that_lead_a_fit_astray_are_left_out_from_the_beginning() {
    for seed in [8, 23, 27] {
        let own = tempfile::tempdir().unwrap();
        let cell = LoadCell { seed, wrong: 0.022, ..LoadCell::default() };
        let wrong = cell.written(own.path());
        let opened = open(&Request::new([own.path()])).unwrap();
        let found = run(improved(opened.problem.clone()).0, &opened);
        assert_eq!(found.left_out.readings.len(), wrong, "{seed}: {}", told(&found));
        let answer = (found.verdict, names(&found));
        assert_eq!(answer, (Verdict::Explained, vec![]), "{seed}: {}", told(&found));
        let estimates = found.nominal.estimates();
        let delay = estimates.iter().find(|one| one.name == "raw.delay").unwrap();
        let far = (delay.value.unwrap() - DELAY) / delay.sigma.unwrap();
        assert!(far.abs() < 4.0, "{seed}: {delay:?}");
    }
}

/// Readings of which the second half of a campaign, a run of its own, is three times noisier.
#[test]
fn of_two_runs_the_noisier_one_has_noise_of_its_own() {
    let own = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(own.path().join(name), text).unwrap();
    let mut random = Stream(101);
    for (run, size) in [("calm", 2e-3), ("storm", 6e-3)] {
        let mut log = "season [rad],up [m]\n".to_owned();
        for row in 0..400 {
            let season = 0.02 * f64::from(row);
            let up = 0.2 + 4e-3 * season.cos() + size * random.normal();
            writeln!(log, "{season:.5},{up:.6}").unwrap();
        }
        write(&format!("{run}.csv"), &log);
    }
    write("model.toml", SITE);
    std::fs::create_dir(own.path().join("effects")).unwrap();
    let (name, parameters, patch) = YEARLY;
    let effect = format!(
        "name = \"{name}\"\ntitle = \"{name}\"\nacts = \"arm\"\n[parameters]\n{parameters}\n[patch]\n{patch}\n"
    );
    write("effects/yearly.toml", &effect);
    write(
        "campaign.toml",
        "title = \"Site\"\nmodel = \"model.toml\"\n[measurands]\nup = { sigma = \"2 mm\" }\n\
         [[runs]]\nname = \"calm\"\ndata = \"calm.csv\"\n[[runs]]\nname = \"storm\"\ndata = \"storm.csv\"\n",
    );
    let opened = open(&Request::new([own.path()])).unwrap();
    let found = run(opened.problem.clone(), &opened);
    assert_eq!(names(&found), ["yearly"], "{}", told(&found));
    let [level] = &found.levels[..] else { panic!("{:?}", found.levels) };
    assert_eq!(level.run.as_deref(), Some("storm"));
    assert!((level.factor / 3.0 - 1.0).abs() < 0.15, "{level:?}");
    assert!(found.left_out.is_empty(), "{:?}", found.left_out);
}
