//! The three models of the seed in text against a hand-written model over dual numbers, in value
//! and in every derivative: at random poses, on the axes and on the cut of the horizontal angle.

use std::path::Path;

use homepoint::campaign::{Role, Run, Samples, Track};
use homepoint::engine::Part;
use homepoint::engine::part::SampleLeaves;
use homepoint::engine::point::seeded;
use homepoint::graph::Kind;
use homepoint::library::Library;
use homepoint::number::{Gradient, Number, partial, partials};
use homepoint::quaternion::Quaternion;
use homepoint::system::System;
use proptest::prelude::*;

use crate::seed;

/// Variables: radius, orientation (3), position (3), base (2), delays (4).
const N: usize = 13;
type Jet = Gradient<N>;

/// Where everything stands.
#[derive(Clone, Debug)]
struct Pose {
    arm: (f64, f64),
    platform: (f64, f64),
    radius: f64,
    /// Rotation vector.
    orientation: [f64; 3],
    position: [f64; 3],
    base: [f64; 2],
    delays: [f64; 4],
}

impl Pose {
    fn quaternion(&self) -> [f64; 4] {
        Quaternion::turn(self.orientation).components()
    }

    fn parameter(&self, name: &str, measurands: &[String]) -> [Jet; 4] {
        let fixed = N;
        let scalar =
            |value, seed| seeded(Kind::Scalar, [value, 0.0, 0.0, 0.0], [seed, fixed, fixed]);
        let [x, y, z] = self.position;
        match name {
            "radius" => scalar(self.radius, 0),
            "orientation" => seeded(Kind::Rotation, self.quaternion(), [1, 2, 3]),
            "position" => seeded(Kind::Vector, [x, y, z, 0.0], [4, 5, 6]),
            "base_distance" => scalar(self.base[0], 7),
            "base_height" => scalar(self.base[1], 8),
            "orientation_b" => seeded(Kind::Rotation, [1.0, 0.0, 0.0, 0.0], [fixed; 3]),
            delay => {
                let owner = delay.strip_suffix(".delay").unwrap();
                let m = measurands.iter().position(|name| name == owner).unwrap();
                scalar(self.delays[m], 9 + m)
            }
        }
    }

    fn delay(&self, m: usize) -> Jet {
        partial(self.delays[m], 9 + m)
    }

    /// `q (1, δ/2)` by eq. (3), what `q turn(δ)` is to first order: a route of its own.
    fn orientation_jet(&self) -> [Jet; 4] {
        let [w, x, y, z] = self.quaternion().map(Jet::constant);
        let [a, b, c] = [1, 2, 3].map(|seed| partial::<N>(0.0, seed) * 0.5);
        [
            w - x * a - y * b - z * c,
            x + w * a + y * c - z * b,
            y + w * b + z * a - x * c,
            z + w * c + x * b - y * a,
        ]
    }

    fn position_jet(&self) -> [Jet; 3] {
        [0, 1, 2].map(|i| partial(self.position[i], 4 + i))
    }
}

/// What a model in text gives for a pose.
fn in_text(model: &str, pose: &Pose) -> Vec<Jet> {
    let model = Library::builtin().unwrap().model(model, Path::new(".")).unwrap();
    let system = System::build(&model, &[], &[], &vec![None; model.inputs.len()]).unwrap();
    let names: Vec<String> =
        system.assembly.names.measurands.iter().map(|one| one.name.clone()).collect();
    let tracks = system.assembly.names.inputs.iter().map(|input| {
        let (value, rate) = if input.name == "arm_angle" { pose.arm } else { pose.platform };
        Track::Captured { value: vec![value], rate: Some(vec![rate]), acceleration: None }
    });
    let samples = Samples {
        is_untimed: false,
        time: vec![3.0],
        elapsed_time: vec![0.0],
        run_time: vec![0.0],
        setup_time: vec![0.0],
        uniform_time: vec![0.0],
        jump_time: Vec::new(),
        jump_ends: [0.0; 2],
        inputs: tracks.collect(),
        readings: vec![vec![0.0]; names.len()],
        rows: vec![2],
    };
    let run = Run { name: "one".into(), setup: 0, role: Role::Kinematic, record: samples.into() };
    let parameters: Vec<[Jet; 4]> = system
        .assembly
        .names
        .parameters
        .iter()
        .map(|parameter| pose.parameter(&parameter.name, &names))
        .collect();
    let part = Part::new(system, vec!["A".into()], vec![run], vec![1.0; names.len()]);
    let columns = part.columns().to_vec();
    let mut scratch = Samples::default();
    let leaves = SampleLeaves {
        parameters: &parameters,
        randoms: &[],
        columns: &columns,
        sample: part.runs[0].record.sample(0, &mut scratch),
    };
    let mut workspace = Vec::new();
    (0..names.len()).map(|m| part.evaluate_one(m, &leaves, &mut workspace)[0]).collect()
}

/// What the hand-written model gives, each measurand at its own moment.
fn by_hand(model: &str, pose: &Pose) -> Vec<Jet> {
    let radius = partial(pose.radius, 0);
    let (orientation, position) = (pose.orientation_jet(), pose.position_jet());
    let arm = |m| seed::at_delay(pose.arm.0, pose.arm.1, pose.delay(m));
    match model {
        "polar_one_rotation" => (0..3)
            .map(|m| seed::polar_one_rotation(arm(m), radius, orientation, position)[m])
            .collect(),
        "polar_two_rotations" => (0..3)
            .map(|m| {
                let platform = seed::at_delay(pose.platform.0, pose.platform.1, pose.delay(m));
                seed::polar_two_rotations(arm(m), platform, radius, orientation, position)[m]
            })
            .collect(),
        _ => (0..4)
            .map(|m| {
                let (length, height) = (partial(pose.base[0], 7), partial(pose.base[1], 8));
                seed::angular_intersection(arm(m), radius, orientation, position, length, height)[m]
            })
            .collect(),
    }
}

fn agree(pose: &Pose) {
    for model in ["polar_one_rotation", "polar_two_rotations", "angular_intersection"] {
        let (text, hand) = (in_text(model, pose), by_hand(model, pose));
        assert_eq!(text.len(), hand.len());
        for (m, (a, b)) in text.iter().zip(&hand).enumerate() {
            // On the cut both ends of the half turn are the same angle.
            let turn = 2.0 * std::f64::consts::PI;
            let difference = a.value() - b.value();
            let difference = difference - turn * (difference / turn).round();
            assert!(difference.abs() < 1e-13 * a.value().abs().max(1.0), "{model} {m}: {pose:?}");
            let (da, db) = (partials(a), partials(b));
            let scale = db.iter().fold(1.0_f64, |most, value| most.max(value.abs()));
            for (variable, (x, y)) in da.iter().zip(db).enumerate() {
                assert!(
                    (x - y).abs() < 1e-12 * scale,
                    "{model} {m} variable {variable}: {x} {y} at {pose:?}"
                );
            }
        }
    }
}

fn pose() -> Pose {
    Pose {
        arm: (0.7, 1.3),
        platform: (0.4, -0.2),
        radius: 1.15,
        orientation: [0.4, 1.1, -0.3],
        position: [0.4, 1.7, 0.3],
        base: [3.1, 0.2],
        delays: [1e-4, -2e-4, 3e-4, 5e-5],
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn text_and_hand_agree_at_random_poses(
        arm in (-7.0..7.0_f64, -3.5..3.5_f64),
        platform in (-4.0..4.0_f64, -0.6..0.6_f64),
        radius in 0.1..2.0_f64,
        orientation in prop::array::uniform3(-2.0..2.0_f64),
        position in prop::array::uniform3(2.5..6.0_f64),
        base in prop::array::uniform2(-1.0..1.0_f64),
        delays in prop::array::uniform4(-1e-2..1e-2_f64),
    ) {
        agree(&Pose { arm, platform, radius, orientation, position, base, delays });
    }

    /// All around the instrument: in every octant, before and behind the cut, under and over it.
    #[test]
    fn text_and_hand_agree_all_around(
        arm in (-7.0..7.0_f64, -3.5..3.5_f64),
        platform in (-4.0..4.0_f64, -0.6..0.6_f64),
        orientation in prop::array::uniform3(-2.0..2.0_f64),
        position in prop::array::uniform3(-4.0..4.0_f64),
        delays in prop::array::uniform4(-1e-2..1e-2_f64),
    ) {
        let base = [9.0, -0.3];
        let pose = Pose { arm, platform, radius: 1.15, orientation, position, base, delays };
        // Straight overhead the horizontal angle is singular.
        let [x, y, _] = seed::point_one_rotation(arm.0, 1.15, pose.quaternion(), position);
        prop_assume!(x.hypot(y) > 0.2);
        agree(&pose);
    }
}

/// On the negative x-axis, a hair to either side of it and with either zero: the value may be
/// either end of the half turn, the derivatives are those of every other place.
#[test]
fn text_and_hand_agree_on_the_cut_and_beside_it() {
    for aside in [-1e-9, -1e-16, -0.0, 0.0, 1e-16, 1e-9] {
        for (delay, rate) in [(0.0, 2.0), (1e-3, -2.0)] {
            let (arm, platform) = ((0.0, rate), (0.0, 0.5));
            let position = [-3.0, aside, 0.25];
            let pose = Pose { arm, platform, position, delays: [delay; 4], ..pose() };
            agree(&Pose { orientation: [0.0; 3], ..pose.clone() });
            // The arm's axis along the instrument's own axes, either way.
            for orientation in
                [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]
            {
                let quarter = orientation.map(|a| a * std::f64::consts::FRAC_PI_2);
                agree(&Pose { orientation: quarter, ..pose.clone() });
            }
        }
    }
}

/// The delay's derivative is the reading's rate: against readings a little earlier and later.
#[test]
fn the_derivative_with_respect_to_the_delay_is_the_rate_of_the_reading() {
    let h = 1e-4;
    for model in ["polar_one_rotation", "polar_two_rotations", "angular_intersection"] {
        for turn in 0..12 {
            let mut pose = pose();
            pose.arm.0 = 0.5 * f64::from(turn);
            let now = in_text(model, &pose);
            let moved = |sign: f64| {
                let mut moved = pose.clone();
                moved.delays = moved.delays.map(|delay| delay + sign * h);
                in_text(model, &moved)
            };
            let at = [1.0, -1.0, 2.0, -2.0].map(moved);
            for m in 0..now.len() {
                // Five points: what is left is of order h⁴.
                let [one, minus_one, two, minus_two] =
                    [0, 1, 2, 3].map(|k: usize| at[k][m].value());
                let rate = (8.0 * (one - minus_one) - (two - minus_two)) / (12.0 * h);
                let exact = partials(&now[m])[9 + m];
                assert!((rate - exact).abs() < 2e-8, "{model} {m}: {rate} {exact}");
                // A measurand's delay moves that measurand alone.
                for other in (0..4).filter(|other| *other != m) {
                    assert_eq!(partials(&now[m])[9 + other], 0.0, "{model} {m}");
                }
            }
        }
    }
}

#[test]
fn text_and_hand_agree_on_the_axes() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let turns = [
        [0.0; 3],
        [quarter, 0.0, 0.0],
        [0.0, quarter, 0.0],
        [0.0, 0.0, quarter],
        [2.0 * quarter, 0.0, 0.0],
        [0.0, 0.0, -2.0 * quarter],
    ];
    for orientation in turns {
        for position in
            [[3.0, 0.0, 0.0], [-3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, -3.0, 0.0], [2.0, 0.0, 2.0]]
        {
            for quarters in 0..4 {
                let arm = (f64::from(quarters) * quarter, 2.0);
                let platform = (f64::from(quarters) * quarter, 0.5);
                let delays = [0.0; 4];
                agree(&Pose { arm, platform, orientation, position, delays, ..pose() });
                agree(&Pose { arm, platform: (0.0, 0.0), orientation, position, ..pose() });
            }
        }
    }
}
