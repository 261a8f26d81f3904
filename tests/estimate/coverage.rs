//! Does U (k = 2) of a single delay hold the truth as often as it says?
//! (Depenthal 2009, section 3.4)
//!
//! For each model 500 campaigns are drawn: two slow reference runs and 20 triggers of a fast one.
//! What certificates state (radius, reference time) is drawn anew for each campaign, within the
//! stated uncertainty, and so is what is random in each sample. The system is compiled once; a
//! campaign is its readings alone. Outside the blind ranges 95 ± 1 % of the delays lie within U of
//! the truth: k = 2 stands for 95.45 %, and 500 campaigns whose delays have some error in common (a
//! sixth of the variance at most) tell that to about 0.3 %.

use std::convert::Infallible;

use homepoint::engine::open::{Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::newton::{ReadingDelay, State};
use homepoint::estimate::transformation::{Choice, transformation};
use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::folder::Folder;

const CAMPAIGNS: u64 = 500;

/// A campaign of 20 triggers, and where its delays and its certificates stand.
struct Trial {
    problem: Problem,
    truth: Point,
    /// For each measurand, the instance that is its delay.
    delays: Vec<usize>,
}

impl Trial {
    fn new(name: &str, text: &str) -> Self {
        let folder = Folder::new(name, &[("campaign.toml", text)]);
        let opened = open(&Request::new([&folder])).unwrap();
        let mut problem = opened.problem;
        let mut truth = Point::stated(&problem.layout);
        let names = &problem.parts[0].system.assembly.names.measurands;
        let place =
            |name: &str| problem.layout.instances.iter().position(|one| one.name == name).unwrap();
        let delays: Vec<usize> =
            names.iter().map(|one| place(&format!("{}.delay", one.name))).collect();
        // Unlike delays of a size that such instruments have.
        for (count, instance) in delays.iter().enumerate() {
            truth.values[*instance][0] = [148e-6, 116e-6, 235e-6, 90e-6][count];
        }
        simulate(&mut problem, &truth, 0, true);
        Self { problem, truth, delays }
    }

    /// The campaign drawn anew, with the truth that belongs to it.
    fn draw(&self, seed: u64) -> (Problem, Point) {
        let mut truth = self.truth.clone();
        let mut generator = ChaCha12Rng::seed_from_u64(!seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
        for (instance, value) in self.problem.layout.instances.iter().zip(&mut truth.values) {
            if let (Some(sigma), false) = (&instance.setting.sigma, instance.setting.fixed) {
                value[0] += sigma[0] * normal();
            }
        }
        let mut problem = self.problem.clone();
        simulate(&mut problem, &truth, seed, false);
        (problem, truth)
    }

    /// How many delays lie within U of the truth, and how many there are, by measurand; the same of
    /// the mean delays of all measurands together.
    fn covered(&self, choice: Choice) -> (Vec<(usize, usize)>, (usize, usize)) {
        let mut counts = vec![(0, 0); self.delays.len()];
        let mut means = (0, 0);
        for seed in 1..=CAMPAIGNS {
            let (problem, truth) = self.draw(seed);
            let needs_joint = choice != Choice::Iterated;
            let joint =
                needs_joint.then(|| calibrate(problem.clone(), &Options::default()).unwrap());
            let given = transformation(&problem, joint.as_ref(), 0, choice).unwrap();
            let mut see = |one: &ReadingDelay| {
                if one.state == State::Solved {
                    let truth = truth.values[self.delays[one.measurand]][0];
                    let count = &mut counts[one.measurand];
                    count.0 += usize::from((one.delay - truth).abs() <= one.expanded_uncertainty());
                    count.1 += 1;
                }
                Ok::<_, Infallible>(())
            };
            let Ok(found) = given.each_delay(0, &given.wanted(0), &mut see);
            for (one, instance) in found.measurands.iter().zip(&self.delays) {
                let off = one.mean.unwrap() - truth.values[*instance][0];
                means.0 += usize::from(off.abs() <= 2.0 * one.sigma_of_mean.unwrap());
                means.1 += 1;
            }
        }
        (counts, means)
    }
}

#[track_caller]
fn is_95_percent(trial: &Trial, choice: Choice) {
    let (counts, means) = trial.covered(choice);
    let percent = |(within, all): (usize, usize)| 100.0 * within as f64 / all as f64;
    let all = counts.iter().fold((0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
    assert!(all.1 > 15 * CAMPAIGNS as usize, "{all:?}");
    assert!((percent(all) - 95.0).abs() < 1.0, "{}", percent(all));
    for count in counts {
        assert!((percent(count) - 95.0).abs() < 1.5, "{}", percent(count));
    }
    // 500 means a measurand, which share much of their error, tell it to 1 %.
    assert!((percent(means) - 95.0).abs() < 2.5, "{}", percent(means));
}

const POLAR: &str = r#"
[measurands]
horizontal = { sigma = "6 urad" }
vertical   = { sigma = "6 urad" }
distance   = { sigma = "8 um" }
[timing]
method          = "trigger"
edge            = "1 us"
controller_gate = { at_most = "100 ns" }
jitter          = "0.5 us"
"#;

fn one_rotation() -> Trial {
    Trial::new("one", &polar_one_rotation(&runs([""; 3], "5 deg/s", "190 deg/s")))
}

fn polar_one_rotation(runs: &str) -> String {
    format!(
        r#"model = "polar_one_rotation"
[parameters]
radius      = {{ value = "1.146 m", sigma = "2 um" }}
orientation = {{ start = ["-0.368181 rad", "-1.2 rad", "0.370859 rad"] }}
position    = {{ start = ["1.9 m", "0.4 m", "0.3 m"] }}
[inputs]
arm_angle = {{ sigma = "0.4 arcsec" }}
{POLAR}
{runs}"#
    )
}

/// Three runs of an arm; `more` says what else moves in each.
fn runs(more: [&str; 3], slow: &str, fast: &str) -> String {
    let run = |name: &str, role: &str, plan: &str, more: &str| {
        format!("[[runs]]\nname = \"{name}\"\n{role}plan = {{ {plan}{more} }}\n")
    };
    let slow = |sign: &str| {
        format!(
            "trigger = \"1 Hz\", duration = \"72 s\", arm_angle = {{ start = \"1 deg\", rate = \"{sign}{slow}\" }}"
        )
    };
    let fast = format!(
        "trigger = \"2.3 Hz\", duration = \"8.69 s\", arm_angle = {{ start = \"10 deg\", rate = \"{fast}\" }}"
    );
    let reference = "role = \"reference\"\n";
    run("slow_ccw", reference, &slow(""), more[0])
        + &run("slow_cw", reference, &slow("-"), more[1])
        + &run("fast", "", &fast, more[2])
}

fn two_rotations() -> Trial {
    let platform =
        |rate: &str| format!(", platform_angle = {{ start = \"0 deg\", rate = \"{rate} deg/s\" }}");
    let [still, turning] = ["0", "-40"].map(platform);
    let text = format!(
        r#"model = "polar_two_rotations"
[parameters]
radius      = {{ value = "1.146 m", sigma = "2 um" }}
orientation = {{ start = ["-0.368181 rad", "-1.2 rad", "0.370859 rad"] }}
position    = {{ start = ["2.6 m", "0.3 m", "0.2 m"] }}
[inputs]
arm_angle      = {{ sigma = "0.4 arcsec" }}
platform_angle = {{ sigma = "0.4 arcsec" }}
{POLAR}
{}"#,
        runs([&still, &still, &turning], "5 deg/s", "100 deg/s")
    );
    Trial::new("two", &text)
}

fn angular_intersection() -> Trial {
    let text = format!(
        r#"model = "angular_intersection"
[parameters]
radius        = {{ value = "1.146 m", sigma = "20 um" }}
orientation   = {{ start = ["1.509094 rad", "-0.716344 rad", "1.031937 rad"] }}
position      = {{ start = ["2.2 m", "4.5 m", "0.3 m"] }}
base_distance = {{ start = "4.2 m" }}
base_height   = {{ start = "0.15 m" }}
[inputs]
arm_angle = {{ sigma = "0.4 arcsec" }}
[measurands]
horizontal_a = {{ sigma = "40 urad" }}
vertical_a   = {{ sigma = "40 urad" }}
horizontal_b = {{ sigma = "40 urad" }}
vertical_b   = {{ sigma = "40 urad" }}
[timing]
method = "trigger"
edge   = "10 us"
jitter = "5 us"
{}"#,
        runs([""; 3], "5 deg/s", "50 deg/s")
    );
    Trial::new("intersection", &text)
}

#[test]
fn two_rotations_from_reference_runs() {
    is_95_percent(&two_rotations(), Choice::Best);
}

#[test]
fn angular_intersection_from_reference_runs() {
    is_95_percent(&angular_intersection(), Choice::Best);
}

/// One slow direction, hardly slower than the other run: errors grow by 1 / (1 - 30 / 50). With the
/// covariance that the transformation has at held delays 91 % of the delays and 80 % of the means
/// would be within U.
#[test]
fn one_rotation_iterated_from_one_slow_direction() {
    let slow = r#"trigger = "1 Hz", duration = "12 s", arm_angle = { start = "1 deg", rate = "30 deg/s" }"#;
    let fast = r#"trigger = "1.1 Hz", duration = "18.18 s", arm_angle = { start = "10 deg", rate = "50 deg/s" }"#;
    let runs = format!(
        "[[runs]]\nname = \"slow\"\nrole = \"reference\"\nplan = {{ {slow} }}\n\
         [[runs]]\nname = \"fast\"\nplan = {{ {fast} }}\n"
    );
    is_95_percent(&Trial::new("one_way", &polar_one_rotation(&runs)), Choice::Iterated);
}

/// The transformation and the delays in turn: what the delays found bring into the transformation
/// counts.
#[test]
fn one_rotation_iterated() {
    is_95_percent(&one_rotation(), Choice::Iterated);
}

#[test]
fn one_rotation_from_reference_runs() {
    is_95_percent(&one_rotation(), Choice::Best);
}

#[test]
fn one_rotation_from_the_joint_fit() {
    is_95_percent(&one_rotation(), Choice::Joint);
}
