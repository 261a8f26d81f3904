//! What stands beside a form that the model lacks: outliers that are none of it, and rows of which it
//! leaves nothing; a small effect of one input beside a large form over another.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

const SKY: &str = r#"
name = "sky"
title = "A mount over the sky"
[inputs]
az = { unit = "rad" }
el = { unit = "rad" }
[parameters]
zero = { unit = "rad", scope = "rig" }
level = { unit = "rad", scope = "rig" }
[measurands]
d_az = { value = 'zero', unit = "rad" }
d_el = { value = 'level', unit = "rad" }
"#;

/// Two stars of 300 were mistaken for others. The error over azimuth and elevation together makes the
/// residuals of neighbours alike; those of the two are nobody's but theirs.
#[test]
fn an_outlier_without_like_neighbours_is_left_out_beside_a_form_over_several_inputs() {
    let mut random = Stream(5);
    let mut log = "az [rad],el [rad],d_az [rad],d_el [rad]\n".to_owned();
    for star in 0..300 {
        let (az, el) = (TAU * random.uniform(), 0.3 + random.uniform());
        let wrong = if [40, 200].contains(&star) { 1.0 } else { 0.0 };
        let form = 5e-5 * (2.0 * az + 4.0 * el).sin();
        let d_az = 1e-4 + form + 1e-5 * random.normal() + 7e-4 * wrong;
        let d_el = 2e-4 + 1e-5 * random.normal() - 5e-4 * wrong;
        writeln!(log, "{az:.9},{el:.9},{d_az:.9},{d_el:.9}").unwrap();
    }
    let measurands = "d_az = { sigma = \"10 urad\" }\nd_el = { sigma = \"10 urad\" }";
    let found = Campaign { model: SKY, effects: &[], measurands, log }.diagnosed();
    let mut out: Vec<(String, usize)> =
        found.left_out.readings.iter().map(|one| (one.measurand.to_string(), one.row)).collect();
    out.sort();
    let due = [("d_az", 42), ("d_az", 202), ("d_el", 42), ("d_el", 202)];
    assert_eq!(out, due.map(|(name, row)| (name.to_owned(), row)), "{}", told(&found));
    assert!(found.remainder[0].place.words.contains("az and el together"), "{}", told(&found));
}

const SNAKE: &str = r#"
name = "snake"
title = "A planar arm of four joints"
[inputs]
a = { unit = "rad" }
b = { unit = "rad" }
c = { unit = "rad" }
d = { unit = "rad" }
[parameters]
height = { unit = "m", scope = "rig" }
reach = { unit = "m", scope = "rig" }
link = { unit = "m", scope = "rig", value = "0.4 m", fixed = true }
[measurands]
h = { value = 'height + link * (sin(a) + sin(a + b) + sin(a + b + c) + sin(a + b + c + d))', unit = "m" }
x = { value = 'reach + link * (cos(a) + cos(a + b) + cos(a + b + c) + cos(a + b + c + d))', unit = "m" }
"#;
const VALUES: &str = "cosine = { unit = \"rad\", typical = \"0.2 mrad\", scope = \"rig\" }\nsine = { unit = \"rad\", typical = \"0.2 mrad\", scope = \"rig\" }";
const GEARS: &[(&str, &str, &str)] = &[
    ("gear_a", VALUES, "a = 'a + cosine * cos(a) + sine * sin(a)'"),
    ("gear_b", VALUES, "b = 'b + cosine * cos(b) + sine * sin(b)'"),
    ("gear_d", VALUES, "d = 'd + cosine * cos(d) + sine * sin(d)'"),
];

/// A gear that is eccentric in no way is like one with a wave twice a turn, over a part of a turn.
#[test]
fn a_row_whose_value_may_be_zero_beside_the_whole_remainder_is_none() {
    for seed in [11, 12] {
        let mut random = Stream(seed);
        let mut log = "a [rad],b [rad],c [rad],d [rad],h [m],x [m]\n".to_owned();
        for _ in 0..700 {
            let joints = [0; 4].map(|_| 2.4 * random.uniform() - 1.2);
            let [a, b, c, d] = joints;
            let errors = [
                2e-4 * a.cos() - 3e-4 * a.sin(),
                5e-5 * (2.0 * b).cos() + 3.7e-5 * (2.0 * b).sin(),
                0.0,
                4e-4 * d.cos() + 3e-4 * d.sin(),
            ];
            let (mut sum, mut h, mut x) = (0.0, 0.2, 0.1);
            for (joint, error) in joints.iter().zip(errors) {
                sum += joint + error;
                (h, x) = (h + 0.4 * f64::sin(sum), x + 0.4 * f64::cos(sum));
            }
            (h, x) = (h + 4e-5 * random.normal(), x + 4e-5 * random.normal());
            writeln!(log, "{a:.9},{b:.9},{c:.9},{d:.9},{h:.7},{x:.7}").unwrap();
        }
        let measurands = "h = { sigma = \"30 um\" }\nx = { sigma = \"30 um\" }";
        let found = Campaign { model: SNAKE, effects: GEARS, measurands, log }.diagnosed();
        assert_eq!(names(&found), ["gear_a", "gear_d"], "{}", told(&found));
        let words = &found.remainder[0].place.words;
        assert!(words.contains("the input `b` over b"), "{}", told(&found));
    }
}

const BAROMETER: &str = r#"
name = "barometer"
title = "Barometer of a drone"
[inputs]
throttle = { unit = "1" }
board = { unit = "K" }
height = { unit = "m" }
[parameters]
ground = { unit = "Pa", scope = "rig", start = "1010 hPa" }
density = { unit = "kg/m^3", scope = "rig", start = "1.2 kg/m^3" }
[quantities]
air = 'ground - density * 9.81 m/s^2 * height'
[measurands]
pressure = { value = 'air', unit = "Pa" }
"#;
const BOARD: &[(&str, &str, &str)] = &[(
    "board_warms",
    "part = { unit = \"Pa/K\", typical = \"1 Pa/K\", scope = \"rig\" }",
    "air = 'air + part * (board - 303.15 K)'",
)];
const DUE: f64 = -0.5;

/// What would take its place has its form.
#[test]
fn a_small_linear_effect_is_named_beside_a_large_remainder() {
    for seed in [1, 2, 3] {
        let mut random = Stream(seed);
        let mut log = String::from("time [s],throttle [1],board [K],height [m],pressure [Pa]\n");
        for row in 0..3000 {
            let t = 0.2 * f64::from(row);
            let throttle =
                0.5 + 0.2 * (t / 7.0).sin() + 0.1 * (t / 2.3).sin() + 0.02 * random.normal();
            let board = 305.0 + 5.0 * (t / 190.0).sin() + 0.5 * (t / 31.0).cos();
            let height = 30.0 + 20.0 * (t / 47.0).sin();
            let pressure = 101_000.0 - 1.2 * 9.81 * height - 60.0 * throttle * throttle
                + DUE * (board - 303.15)
                + 3.0 * random.normal();
            writeln!(log, "{t:.1},{throttle:.4},{board:.3},{height:.3},{pressure:.2}").unwrap();
        }
        let measurands = "pressure = { sigma = \"3 Pa\" }";
        let found = Campaign { model: BAROMETER, effects: BOARD, measurands, log }.diagnosed();
        assert_eq!(found.verdict, Verdict::PartlyExplained, "{seed}: {}", told(&found));
        assert_eq!(names(&found), ["board_warms"], "{seed}: {}", told(&found));
        let value = &found.rows[0].values[0];
        let far = (value.value.unwrap() - DUE) / value.sigma.unwrap();
        assert!(far.abs() < 4.0, "{seed}: {far}");
        assert!(found.remainder[0].place.words.contains("throttle"), "{seed}: {}", told(&found));
    }
}

const CELL: &str = r#"
name = "cell"
title = "A load cell in an oven"
[inputs]
mass = { unit = "kg" }
oven = { unit = "K" }
[parameters]
gain = { unit = "1", scope = "rig" }
zero = { unit = "N", scope = "rig" }
[measurands]
force = { value = '9.81 m/s^2 * mass * (1 + gain) + zero', unit = "N" }
"#;
const OVEN: &[(&str, &str, &str)] = &[
    (
        "gain_warms",
        "slope = { unit = \"1/K\", typical = \"50 ppm/K\", scope = \"rig\" }",
        "force = 'force * (1 + slope * (oven - 300 K))'",
    ),
    (
        "zero_warms",
        "slope = { unit = \"N/K\", typical = \"0.1 N/K\", scope = \"rig\" }",
        "force = 'force + slope * (oven - 300 K)'",
    ),
];
const GAIN_WARMS: f64 = 9e-5;

/// The gain and a block over the mass may exchange a large straight line, and what multiplies the reading is
/// in proportion to it: the block is no larger than what is seen of it allows. Expected is the standard
/// uncertainty of the weighted least-squares fit with a free value for each of 17 places of the mass.
#[test]
fn an_effect_that_multiplies_a_reading_is_as_uncertain_as_the_readings_make_it() {
    for seed in [1, 2, 3] {
        let mut random = Stream(seed);
        let mut log = "mass [kg],oven [K],force [N]\n".to_owned();
        // Of `T m` and `T` the squares and products, less what their means over alike masses are.
        let mut places = [[0.0; 6]; 17];
        for row in 0..500 {
            let mass = 10.0 + 990.0 * random.uniform();
            let warm = 12.0 * (0.03 * f64::from(row)).sin() + random.normal();
            let exact = 9.81 * mass * 1.004 + 2.0;
            let bump = 12.0 * (-0.5 * ((mass - 600.0) / 60.0_f64).powi(2)).exp();
            let force = exact * (1.0 + GAIN_WARMS * warm) - 0.4 * warm + bump;
            writeln!(log, "{mass:.2},{:.4},{:.3}", 300.0 + warm, force + 0.5 * random.normal())
                .unwrap();
            let [x, y] = [9.81 * mass * warm, warm];
            let sums = &mut places[(mass / 1001.0 * 17.0) as usize];
            let more = [1.0, x, y, x * x, x * y, y * y];
            sums.iter_mut().zip(more).for_each(|(sum, one)| *sum += one);
        }
        let mut left = [0.0; 3];
        for [n, x, y, xx, xy, yy] in places {
            left[0] += xx - x * x / n;
            left[1] += xy - x * y / n;
            left[2] += yy - y * y / n;
        }
        let due = 0.5 / (left[0] - left[1] * left[1] / left[2]).sqrt();
        let measurands = "force = { sigma = \"0.5 N\" }";
        let found = Campaign { model: CELL, effects: OVEN, measurands, log }.diagnosed();
        let gain = found.rows.iter().find(|row| row.name == "gain_warms");
        let gain = &gain.unwrap_or_else(|| panic!("{}", told(&found))).values[0];
        let (value, sigma) = (gain.value.unwrap(), gain.sigma.unwrap());
        assert!((sigma / due - 1.0).abs() < 0.2, "{seed}: {sigma} {due}");
        assert!((value - GAIN_WARMS).abs() < 4.0 * sigma, "{seed}: {value} {sigma}");
        assert!(found.remainder[0].place.words.contains("mass"), "{seed}: {}", told(&found));
    }
}

const TABLE: &str = r#"
name = "table"
title = "A rotary table against a polygon"
[inputs]
table = { unit = "rad", period = "360 deg" }
[parameters]
zero = { unit = "rad", scope = "rig" }
[measurands]
error = { value = 'zero', unit = "rad" }
"#;

/// One block over the angle has both; the effect and a wave are fewer values.
#[test]
fn an_effect_once_a_turn_is_named_beside_a_wave_of_nearly_its_size() {
    for (seed, order, size) in [(1, 2.0, 0.5), (2, 3.0, 0.7), (3, 5.0, 1.2)] {
        let mut random = Stream(seed);
        let mut log = "table [rad],error [rad]\n".to_owned();
        for _ in 0..360 {
            let table = TAU * random.uniform();
            let wave = 1.6e-5 * size * (order * table + 0.4).cos();
            let error = 5e-5 + 1.5e-5 * table.cos() - 0.7e-5 * table.sin() + wave;
            writeln!(log, "{table:.6},{:.9}", error + 2e-6 * random.normal()).unwrap();
        }
        let parameters = VALUES.replace("0.2 mrad", "10 urad");
        let patch = "error = 'error + cosine * cos(table) + sine * sin(table)'";
        let effects: &[(&str, &str, &str)] = &[("disk_off_centre", &parameters, patch)];
        let measurands = "error = { sigma = \"2 urad\" }";
        let found = Campaign { model: TABLE, effects, measurands, log }.diagnosed();
        assert_eq!(found.verdict, Verdict::PartlyExplained, "{order}: {}", told(&found));
        assert_eq!(names(&found), ["disk_off_centre"], "{order}: {}", told(&found));
        let words = &found.remainder[0].place.words;
        assert!(words.contains(&format!("{order} waves a turn")), "{order}: {}", told(&found));
    }
}

const LINE: &str = r#"
name = "line"
title = "A range along a line"
[inputs]
x = { unit = "m" }
w = { unit = "1" }
s = { unit = "1" }
[parameters]
scale = { unit = "1", scope = "rig", value = "2", sigma = "0.001" }
zero = { unit = "m", scope = "rig" }
[measurands]
y = { value = 'scale * x + zero', unit = "m" }
"#;
const WALK: &[(&str, &str, &str)] = &[(
    "walk",
    "size = { unit = \"m\", typical = \"0.5 m\", scope = \"rig\" }",
    "y = 'y + size * w'",
)];

/// In the fit the scale absorbs a part of a bump over another input, by 36 standard deviations; beside the
/// bump it is as stated. A scale that is wrong is contradicted, also by four standard deviations, which are too
/// few for a part of the remainder.
#[test]
fn a_stated_value_is_not_contradicted_by_what_the_remainder_does() {
    for (scale, bump) in [(2.0, 0.5), (2.05, 0.0), (2.005, 0.0)] {
        let mut random = Stream(3);
        let mut log = "x [m],w [1],s [1],y [m]\n".to_owned();
        for _ in 0..900 {
            let [w, s] = [2.0 * random.uniform() - 1.0, 10.0 * random.uniform()];
            let x = 5.0 + 0.45 * (s - 5.0) + 4.0 * random.uniform() - 2.0;
            let form = f64::exp(-0.5 * ((s - 8.5) / 0.8_f64).powi(2));
            let y = scale * x + 1.0 + 0.8 * w + bump * form + 0.05 * random.normal();
            writeln!(log, "{x:.4},{w:.4},{s:.4},{y:.4}").unwrap();
        }
        let measurands = "y = { sigma = \"0.05 m\" }";
        let found = Campaign { model: LINE, effects: WALK, measurands, log }.diagnosed();
        assert_eq!(names(&found), ["walk"], "{}", told(&found));
        assert_eq!(found.contradicted.is_empty(), bump > 0.0, "{scale}: {}", told(&found));
        assert_eq!(found.remainder.is_empty(), scale == 2.005, "{scale}: {}", told(&found));
    }
}
