//! Products of two inputs, which no library has: the causes beside them are named, and what remains is
//! over both together.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::report::diagnosis_text;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

fn is_partly(found: &Diagnosis, rows: &[(&str, f64)], place: &str) {
    let mut all = names(found);
    all.sort_unstable();
    let due: Vec<&str> = rows.iter().map(|one| one.0).collect();
    assert_eq!(all, due, "{}", told(found));
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(found));
    for (name, due) in rows {
        let value = &found.rows.iter().find(|row| row.name == *name).unwrap().values[0];
        let far = (value.value.unwrap() - due) / value.sigma.unwrap();
        assert!(far.abs() < 4.0, "{name}: {far}, {}", told(found));
    }
    assert_eq!(found.remainder[0].place.words, place, "{}", told(found));
}

/// A weighbridge whose zero and whose gain depend on the temperature; a file for the zero alone.
#[test]
fn a_gain_that_depends_on_temperature_is_over_load_and_temperature_together() {
    let model = "name = \"bridge\"\ntitle = \"Weighbridge\"\n\
        [inputs]\nload = { unit = \"kg\" }\ntemperature = { unit = \"K\" }\n\
        [parameters]\nzero = { unit = \"kg\", scope = \"rig\" }\n\
        [quantities]\nweight = 'load + zero'\n\
        [measurands]\nshown = { value = 'weight', unit = \"kg\" }\n";
    let zero = (
        "zero_of_temperature",
        "by = { unit = \"kg/K\", typical = \"0.5 kg/K\", scope = \"rig\" }",
        "weight = 'weight + by * (temperature - 293.15 K)'",
    );
    let mut random = Stream(107);
    let mut log = "load [kg],temperature [K],shown [kg]\n".to_owned();
    for row in 0..500 {
        let load = 1000.0 * (4.0 * random.uniform()).floor();
        let warm = 12.0 * (TAU * f64::from(row) / 170.0).sin() + random.normal();
        let shown = load * (1.0 + 2.4e-4 * warm) + 0.31 * warm + 40.0 + 0.8 * random.normal();
        writeln!(log, "{load},{:.3},{shown:.3}", 291.0 + warm).unwrap();
    }
    let measurands = "shown = { sigma = \"0.8 kg\" }";
    let found = Campaign { model, effects: &[zero], measurands, log }.diagnosed();
    // The value is that at the middle of the loads, 2000 kg, about which the product is taken.
    let words = "an error of `shown` over load and temperature together";
    is_partly(&found, &[("zero_of_temperature", 0.31 + 2.4e-4 * 2000.0)], words);
}

/// A compass whose deviation in the second order grows with the roll of the ship; a file for its lag.
#[test]
fn a_wave_that_grows_with_a_tilt_is_over_both_together() {
    let model = "name = \"compass\"\ntitle = \"Compass\"\n\
        [inputs]\nheading = { unit = \"rad\" }\nroll = { unit = \"rad\" }\nturn_rate = { unit = \"rad/s\" }\n\
        [parameters]\nlubber = { unit = \"rad\", scope = \"rig\" }\n\
        [quantities]\ncard = 'heading + lubber'\n\
        [measurands]\nshown = { value = 'card', kind = \"angle\", unit = \"rad\", period = \"360 deg\" }\n";
    let lag = (
        "liquid_turns",
        "lag = { unit = \"s\", typical = \"0.5 s\", scope = \"rig\" }",
        "card = 'card - lag * turn_rate'",
    );
    let mut random = Stream(109);
    let mut log = "heading [rad],roll [rad],turn_rate [rad/s],shown [rad]\n".to_owned();
    for _ in 0..600 {
        let heading = TAU * random.uniform();
        let (roll, rate) = (0.12 * random.normal(), 0.03 * random.normal());
        let wave = 0.4 * roll * (2.0 * heading + 0.5).sin();
        let shown = heading + 0.02 - 0.6 * rate + wave + 3e-3 * random.normal();
        let shown = shown.rem_euclid(TAU);
        writeln!(log, "{heading:.5},{roll:.5},{rate:.6},{shown:.6}").unwrap();
    }
    let measurands = "shown = { sigma = \"3 mrad\" }";
    let found = Campaign { model, effects: &[lag], measurands, log }.diagnosed();
    let words = "an error of `shown` over heading and roll together";
    is_partly(&found, &[("liquid_turns", 0.6)], words);
}

/// A rotary table, what is commanded and what its encoder reads: the two go together, so that an error of
/// one angle is over that, with its order.
#[test]
fn a_wave_over_what_is_commanded_and_read_is_over_one_of_them() {
    let model = "name = \"table\"\ntitle = \"Rotary table\"\n\
        [inputs]\nnominal = { unit = \"rad\" }\nencoder = { unit = \"rad\" }\n\
        [parameters]\nzero = { unit = \"rad\", scope = \"rig\" }\n\
        [measurands]\nshown = { value = 'encoder - nominal + zero', kind = \"angle\", unit = \"rad\" }\n";
    let mut random = Stream(173);
    let mut log = "nominal [rad],encoder [rad],shown [rad]\n".to_owned();
    for row in 0..144 {
        let nominal = TAU * f64::from(row % 72) / 72.0;
        let error = 8e-5 * (3.0 * nominal + 0.7).cos() + 1e-5 * random.normal() - 5e-5;
        let encoder = (nominal + error).rem_euclid(TAU);
        let shown = error + 3e-5 + 16e-6 * (nominal + 1.1).cos() + 1e-6 * random.normal();
        writeln!(log, "{nominal:.9},{encoder:.9},{shown:e}").unwrap();
    }
    let measurands = "shown = { sigma = \"1 urad\" }";
    let found = Campaign { model, effects: &[], measurands, log }.diagnosed();
    let words: Vec<&str> = found.remainder.iter().map(|one| one.place.words.as_str()).collect();
    let [words] = words.as_slice() else { panic!("{}", told(&found)) };
    assert!(words.ends_with(", 1 wave a turn"), "{words}");
}

/// Waves of the first and the second order over one input: both have their amplitudes.
#[test]
fn waves_of_two_orders_have_two_amplitudes() {
    let model = "name = \"table\"\ntitle = \"Rotary table\"\n[inputs]\nangle = { unit = \"rad\" }\n\
        [parameters]\nzero = { unit = \"rad\", scope = \"rig\" }\n\
        [measurands]\nshown = { value = 'zero', unit = \"rad\" }\n";
    let mut random = Stream(29);
    let mut log = "angle [rad],shown [rad]\n".to_owned();
    for row in 0..144 {
        let angle = TAU * f64::from(row % 72) / 72.0;
        let error = 16e-6 * (angle + 1.1).cos() + 9e-6 * (2.0 * angle - 0.4).sin();
        writeln!(log, "{angle:.9},{:e}", 3e-5 + error + 1e-6 * random.normal()).unwrap();
    }
    let measurands = "shown = { sigma = \"1 urad\" }";
    let found = Campaign { model, effects: &[], measurands, log }.diagnosed();
    let [remainder] = found.remainder.as_slice() else { panic!("{}", told(&found)) };
    let [(1, first), (2, second)] = remainder.orders[..] else { panic!("{remainder:?}") };
    assert!((first - 16e-6).abs() < 5e-7 && (second - 9e-6).abs() < 5e-7, "{remainder:?}");
    let text = diagnosis_text::text("", &found, &diagnosis_text::Asked::default());
    assert!(text.contains("amplitude 16 µrad (1 a turn), 9.0 µrad (2 a turn), rms"), "{text}");
}

/// A rotary table that tilts, with an error of its places that grows with the tilt; without it where the
/// error is zero. Both turn: the tilt goes through 150 degrees.
fn tilting_table(error: f64, seed: u64) -> Diagnosis {
    let model = "name = \"table\"\ntitle = \"Tilting table\"\n\
        [inputs]\na = { unit = \"rad\" }\nc = { unit = \"rad\", period = \"360 deg\" }\n\
        [parameters]\nzero = { unit = \"m\", scope = \"rig\" }\n\
        [measurands]\ndy = { value = 'zero', unit = \"m\" }\n";
    let mut random = Stream(seed);
    let mut log = "a [rad],c [rad],dy [m]\n".to_owned();
    for row in 0..7 * 24 {
        let a = (25.0 * f64::from(row % 7) - 75.0).to_radians();
        let c = (15.0 * f64::from(row / 7)).to_radians();
        let dy = 5e-6 + error * a.sin() * (2.0 * c + 0.4).cos() + 1e-6 * random.normal();
        writeln!(log, "{a:.6},{c:.6},{dy:e}").unwrap();
    }
    let measurands = "dy = { sigma = \"1 um\" }";
    Campaign { model, effects: &[], measurands, log }.diagnosed()
}

#[test]
fn a_wave_that_grows_with_a_wide_tilt_is_over_both_together() {
    for (error, seed) in [(3e-6, 111), (1.5e-6, 112)] {
        let found = tilting_table(error, seed);
        let words: Vec<&str> = found.remainder.iter().map(|one| one.place.words.as_str()).collect();
        assert_eq!(words, ["an error of `dy` over a and c together"], "{}", told(&found));
    }
}

#[test]
fn two_angles_without_an_error_are_adequate() {
    for seed in 121..131 {
        let found = tilting_table(0.0, seed);
        assert_eq!(found.verdict, Verdict::Adequate, "{}", told(&found));
    }
}

/// A pan-tilt head that moves: its error is no noise that remembers.
#[test]
fn an_error_over_pan_and_tilt_is_no_autocorrelated_noise() {
    let model = "name = \"head\"\ntitle = \"Pan-tilt head\"\n\
        [inputs]\npan = { unit = \"rad\", signal = true }\ntilt = { unit = \"rad\", signal = true }\n\
        [parameters]\nzero = { unit = \"rad\", scope = \"rig\" }\n\
        [measurands]\nseen = { value = 'pan + zero', unit = \"rad\" }\n";
    let mut random = Stream(113);
    let mut log = "time [s],pan [rad],tilt [rad],seen [rad]\n".to_owned();
    for row in 0..1200 {
        let time = 0.1 * f64::from(row);
        let pan = 2.2 * (TAU * time / 23.0).sin() + 0.7 * (TAU * time / 9.3 + 1.0).sin();
        let tilt = 0.8 * (TAU * time / 31.0).sin() + 0.3 * (TAU * time / 12.0 + 2.0).sin();
        let error = 2e-4 * tilt.sin() * (2.0 * pan + 0.4).cos();
        let seen = pan + 0.01 + error + 1e-4 * random.normal();
        writeln!(log, "{time:.1},{pan:.7},{tilt:.7},{seen:.8}").unwrap();
    }
    let measurands = "seen = { sigma = \"100 urad\" }";
    let found = Campaign { model, effects: &[], measurands, log }.diagnosed();
    let words = "an error of `seen` over pan and tilt together";
    assert_eq!(found.remainder[0].place.words, words, "{}", told(&found));
    assert!(found.autocorrelation.is_empty(), "{}", told(&found));
}
