//! What disturbances do to readings, each by a second route: from the readings alone, without the
//! model that moved them.

use std::f64::consts::TAU;

use homepoint::campaign::run::Samples;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::trials::situation::Situation;
use homepoint::trials::situation::channel::Channel;
use homepoint::trials::situation::course::Course;
use homepoint::trials::situation::disturbance::Disturbance;
use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;

use crate::drawn::folder;

/// A rotating arm whose readings have no noise, and its point.
struct Quiet {
    opened: Opened,
    problem: Problem,
    point: Point,
}

fn quiet() -> Quiet {
    let opened = open(&Request::new([folder()])).unwrap();
    let point = calibrate(opened.problem.clone(), &Options::default()).unwrap().fit.point;
    let mut drawn = opened.problem.clone();
    drawn.parts[0].sigma.fill(0.0);
    simulate(&mut drawn, &point, 0, true);
    let mut problem = opened.problem.clone();
    for (run, drawn) in problem.parts[0].runs.iter_mut().zip(&drawn.parts[0].runs) {
        run.record.clone_from(&drawn.record);
    }
    Quiet { opened, problem, point }
}

impl Quiet {
    /// The readings with a disturbance.
    fn with(&self, disturbance: Disturbance, seed: u64) -> Problem {
        let situation = Situation { disturbances: vec![disturbance], ..Situation::default() };
        let mut problem = self.problem.clone();
        situation.disturb(&mut problem, &self.point, &mut ChaCha12Rng::seed_from_u64(seed));
        problem
    }

    fn moved(&self, channel: Channel, course: Course, size: f64, seed: u64) -> Problem {
        self.with(Disturbance::Moved { channel, course, size }, seed)
    }

    /// Changes of the readings in units of the stated noise: run, measurand, sample.
    fn changes(&self, other: &Problem) -> Vec<[Vec<f64>; 3]> {
        let sigma = &self.problem.parts[0].sigma;
        let runs = self.problem.parts[0].runs.iter().zip(&other.parts[0].runs);
        let each = runs.map(|(run, other)| {
            std::array::from_fn(|k| {
                let [a, b] = [run, other].map(|one| &one.record.whole().readings[k]);
                let turn =
                    |x: f64| if k == 0 { (x + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0 } else { x };
                a.iter().zip(b).map(|(a, b)| turn(b - a) / sigma[k]).collect()
            })
        });
        each.collect()
    }

    /// The only measurand that is moved, by run and sample.
    fn only(&self, other: &Problem) -> Vec<Vec<f64>> {
        let changes = self.changes(other);
        let moves = |k: &usize| changes.iter().any(|run| run[*k].iter().any(|one| *one != 0.0));
        let moved: Vec<usize> = (0..3).filter(moves).collect();
        assert_eq!(moved.len(), 1, "{moved:?}");
        changes.into_iter().map(|run| run[moved[0]].clone()).collect()
    }

    fn samples(&self, run: usize) -> &Samples {
        self.problem.parts[0].runs[run].record.whole()
    }

    fn setup(&self, run: usize) -> usize {
        self.problem.parts[0].runs[run].setup
    }
}

fn rms<'v>(values: impl IntoIterator<Item = &'v f64>) -> f64 {
    let moved: Vec<f64> = values.into_iter().copied().filter(|one| *one != 0.0).collect();
    (moved.iter().map(|one| one * one).sum::<f64>() / moved.len() as f64).sqrt()
}

fn rms_of_all(changes: &[[Vec<f64>; 3]]) -> f64 {
    rms(changes.iter().flatten().flatten())
}

/// Points in the station's frame from the readings of a run.
fn points(problem: &Problem, run: usize) -> Vec<[f64; 3]> {
    let readings = &problem.parts[0].runs[run].record.whole().readings;
    let point = |i: usize| {
        let [h, v, d] = [readings[0][i], readings[1][i], readings[2][i]];
        [d * v.sin() * h.cos(), d * v.sin() * h.sin(), d * v.cos()]
    };
    (0..readings[0].len()).map(point).collect()
}

fn apart(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| b[k] - a[k])
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|one| one * one).sum::<f64>().sqrt()
}

/// The station is displaced by the same vector from one run on, in one setup.
#[test]
fn a_knocked_station_is_displaced_to_the_end_of_its_setup() {
    let quiet = quiet();
    let position = Channel::Parameter("position".to_owned());
    for (course, seed) in [(Course::FromRun, 1), (Course::WithinRun { lasting: true }, 2)] {
        let is_within = course != Course::FromRun;
        let knocked = quiet.moved(position.clone(), course, 2.0, seed);
        assert!((rms_of_all(&quiet.changes(&knocked)) - 2.0).abs() < 1e-6);
        let mut vector = None;
        let mut parts = 0;
        for run in 0..quiet.problem.parts[0].runs.len() {
            let all = points(&quiet.problem, run).into_iter().zip(points(&knocked, run));
            let shifts: Vec<[f64; 3]> = all.map(|(a, b)| apart(a, b)).collect();
            let first = shifts.iter().position(|one| norm(*one) > 1e-9);
            let Some(first) = first else {
                // Nothing comes back within the setup.
                assert!(vector.is_none_or(|(_, setup)| setup != quiet.setup(run)), "run {run}");
                continue;
            };
            parts += usize::from(first > 0);
            let (own, setup) = *vector.get_or_insert((shifts[first], quiet.setup(run)));
            assert_eq!(setup, quiet.setup(run));
            // The three readings of a sample have delays of their own, so that their point is not
            // that of one moment.
            let most = 3e-3 * norm(own);
            assert!(shifts[first..].iter().all(|one| norm(apart(own, *one)) < most));
        }
        assert!(vector.is_some());
        assert_eq!(parts, usize::from(is_within));
    }
}

/// After a jump of the clock the target is where it is a certain time later.
#[test]
fn a_clock_jump_moves_the_target_along_its_path() {
    let quiet = quiet();
    let jumped = quiet.moved(Channel::Time, Course::WithinRun { lasting: false }, 3.0, 4);
    assert!((rms_of_all(&quiet.changes(&jumped)) - 3.0).abs() < 1e-6);
    let mut runs = 0;
    for run in 0..quiet.problem.parts[0].runs.len() {
        let samples = quiet.samples(run);
        let all = points(&quiet.problem, run).into_iter().zip(points(&jumped, run));
        let late = all.enumerate().map(|(i, (a, b))| {
            let rate: f64 = samples.inputs[0].at(i, samples.time[i], 0.0, 1);
            norm(apart(a, b)) / (1.15 * rate.abs())
        });
        let late: Vec<f64> = late.collect();
        let Some(first) = late.iter().position(|one| *one > 1e-9) else { continue };
        runs += 1;
        assert!(first >= late.len() / 4 && first < 3 * late.len() / 4, "{first}");
        let by = late[first];
        let most =
            late[first..].iter().fold(0.0, |most, one| f64::max(most, (one / by - 1.0).abs()));
        assert!(most < 1e-3, "{by}: {most}");
    }
    assert_eq!(runs, 1);
}

/// Courses of one reading: what they give a run, a setup or a sample.
#[test]
fn courses_have_their_forms() {
    let quiet = quiet();
    let course = |course: Course| {
        let moved = quiet.only(&quiet.moved(Channel::Reading, course.clone(), 1.5, 7));
        assert!((rms(moved.iter().flatten()) - 1.5).abs() < 1e-5, "{course:?}");
        moved
    };
    let is_near = |a: f64, b: f64| (a - b).abs() < 1e-4;

    let offsets = course(Course::EachRun);
    let firsts: Vec<f64> = offsets.iter().map(|run| run[0]).collect();
    assert!(
        offsets.iter().zip(&firsts).all(|(run, own)| run.iter().all(|one| is_near(*one, *own)))
    );
    assert!(firsts.windows(2).all(|pair| (pair[0] - pair[1]).abs() > 1e-6));

    let settling = course(Course::Settling { time: 8.0 });
    for (number, run) in settling.iter().enumerate() {
        let t = &quiet.samples(number).run_time;
        let last = run.len().min(20) - 1;
        let due = run[0] * (-(t[last] - t[0]) / 8.0).exp();
        assert!(is_near(run[last], due), "{} {due}", run[last]);
    }

    let sense = course(Course::Direction);
    for (number, run) in sense.iter().enumerate() {
        let is_back = quiet.problem.parts[0].runs[number].name.contains("_cw");
        let sign = if is_back { -1.0 } else { 1.0 };
        assert!(run.iter().all(|one| is_near(*one, 1.5 * sign * sense[0][0].signum())), "{number}");
    }

    let drift = course(Course::Drift);
    let (early, late) = (quiet.samples(0), quiet.samples(1));
    let slope = (drift[0][9] - drift[0][0]) / (early.time[9] - early.time[0]);
    let due = drift[0][0] + slope * (late.time[5] - early.time[0]);
    assert!(is_near(drift[1][5], due), "{} {due}", drift[1][5]);
}

/// Random courses: variance, memory and frequency.
#[test]
fn random_courses_have_their_spectra() {
    let quiet = quiet();
    let course = |course: Course| quiet.only(&quiet.moved(Channel::Reading, course, 1.0, 9));
    // Correlation of neighbours over all runs.
    let neighbours = |all: &[Vec<f64>]| {
        let pairs = || all.iter().flat_map(|run| run.windows(2));
        let products: f64 = pairs().map(|pair| pair[0] * pair[1]).sum();
        products / pairs().map(|pair| pair[0] * pair[0]).sum::<f64>()
    };
    let white = neighbours(&course(Course::White));
    assert!(white.abs() < 0.1, "{white}");
    let memory = neighbours(&course(Course::Memory { time: 2.0 }));
    // Samples are some 0.4 to 0.6 s apart.
    assert!((0.68..0.86).contains(&memory), "{memory}");

    let levels = course(Course::Levels);
    let each: Vec<f64> = levels.iter().map(rms).collect();
    let most = each.iter().fold(0.0, |most, one| f64::max(most, *one));
    let least = each.iter().fold(f64::INFINITY, |least, one| f64::min(least, *one));
    assert!(most > 2.0 * least, "{each:?}");

    // Steps of a walk are independent, and their variance goes with time.
    let walk = course(Course::Walk);
    let (mut steps, mut pauses) = (Vec::new(), Vec::new());
    for (number, run) in walk.iter().enumerate() {
        let time = &quiet.samples(number).time;
        let rooted = |i: usize| (run[i] - run[i - 1]) / (time[i] - time[i - 1]).sqrt();
        steps.extend((1..run.len()).map(rooted));
        if number > 0 && quiet.setup(number) == quiet.setup(number - 1) {
            let before = quiet.samples(number - 1).time.last().unwrap();
            let jump = run[0] - walk[number - 1].last().unwrap();
            pauses.push(jump / (time[0] - before).sqrt());
        }
    }
    assert!(neighbours(&[steps.clone()]).abs() < 0.1);
    let ratio = rms(&pauses) / rms(&steps);
    assert!((0.5..1.7).contains(&ratio), "{ratio}");

    // A ringing has its power at its frequency, not away from it.
    let ringing = course(Course::Ringing { frequency: 0.37, coherence: 5.0 });
    let power = |frequency: f64| {
        let runs = ringing.iter().enumerate().map(|(number, run)| {
            let time = &quiet.samples(number).run_time;
            let of = |wave: fn(f64) -> f64| {
                let each = run.iter().zip(time).map(|(one, t)| one * wave(TAU * frequency * t));
                each.sum::<f64>()
            };
            of(f64::cos).powi(2) + of(f64::sin).powi(2)
        });
        runs.sum::<f64>()
    };
    assert!(power(0.37) > 5.0 * power(0.15).max(power(0.6)));
}

/// Every measurand has noise of its own, of the size that is asked for.
#[test]
fn every_reading_scatters_by_itself() {
    let quiet = quiet();
    let noisy = quiet.moved(Channel::EveryReading, Course::White, 3.0_f64.sqrt(), 3);
    let changes = quiet.changes(&noisy);
    for k in 0..3 {
        let own = rms(changes.iter().flat_map(|run| &run[k]));
        assert!((own - 3.0_f64.sqrt()).abs() < 1e-5, "{k}: {own}");
    }
    let products: f64 =
        changes.iter().flat_map(|run| run[0].iter().zip(&run[1])).map(|(a, b)| a * b).sum();
    let count: usize = changes.iter().map(|run| run[0].len()).sum();
    assert!((products / 3.0 / count as f64).abs() < 0.1);
}

#[test]
fn codes_replace_their_share_of_one_measurand() {
    let quiet = quiet();
    let coded = quiet.with(Disturbance::ErrorCodes { code: 0.0, share: 0.2 }, 5);
    let changed = quiet.only(&coded);
    let all: usize = changed.iter().map(Vec::len).sum();
    let codes = changed.iter().flatten().filter(|one| **one != 0.0).count();
    let share = codes as f64 / all as f64;
    assert!((share - 0.2).abs() < 0.04, "{share}");
    let runs = &coded.parts[0].runs;
    let zeros = runs.iter().flat_map(|run| run.record.whole().readings.iter().flatten());
    assert_eq!(zeros.filter(|one| **one == 0.0).count(), codes);
}

#[test]
fn lost_samples_bring_later_readings_forward() {
    let quiet = quiet();
    let lost = quiet.with(Disturbance::LostSamples { periods: 2, length: 15 }, 6);
    let changes = quiet.changes(&lost);
    let touched: Vec<usize> =
        (0..changes.len()).filter(|run| rms(&changes[*run][2]) > 0.0).collect();
    let [run] = touched.as_slice() else { unreachable!("{touched:?}") };
    let [before, after] = [&quiet.problem, &lost].map(|one| one.parts[0].runs[*run].record.whole());
    let first = changes[*run][2].iter().position(|one| *one != 0.0).unwrap();
    for column in 0..3 {
        for sample in first..(first + 15).min(before.len()) {
            let due = before.readings[column].get(sample + 2);
            let found = after.readings[column][sample];
            assert!(due.map_or(found.is_nan(), |due| found == *due), "{column} {sample}");
        }
    }
}

#[test]
fn bursts_are_consecutive_and_far_out_on_one_side() {
    let quiet = quiet();
    let burst = Disturbance::OutlierBursts { bursts: 1, length: 6, size: 40.0 };
    let changed = quiet.only(&quiet.with(burst, 8));
    let hit = |run: &&Vec<f64>| run.iter().any(|one| *one != 0.0);
    let runs: Vec<&Vec<f64>> = changed.iter().filter(hit).collect();
    let [run] = runs.as_slice() else { unreachable!("{}", runs.len()) };
    let first = run.iter().position(|one| *one != 0.0).unwrap();
    let own = &run[first..first + 6];
    assert!(own.iter().all(|one| one.abs() >= 39.99 && one.signum() == own[0].signum()), "{own:?}");
    assert!(run[first + 6..].iter().all(|one| *one == 0.0));
}

#[test]
fn a_wrong_unit_multiplies_one_measurand_of_one_run() {
    let quiet = quiet();
    let wrong = quiet.with(Disturbance::WrongUnit { factor: 0.9 }, 11);
    let mut found = Vec::new();
    for (run, other) in quiet.problem.parts[0].runs.iter().zip(&wrong.parts[0].runs) {
        for column in 0..3 {
            let [a, b] = [run, other].map(|one| &one.record.whole().readings[column]);
            if a != b {
                found.push(run.name.clone());
                assert!(a.iter().zip(b).all(|(a, b)| (b / a - 0.9).abs() < 1e-12));
            }
        }
    }
    assert_eq!(found.len(), 1, "{found:?}");
}

#[test]
fn rounded_readings_are_multiples_of_their_step() {
    let quiet = quiet();
    let rounded = quiet.with(Disturbance::Quantised { step: 4.0 }, 12);
    let changed = quiet.only(&rounded);
    assert!(changed.iter().flatten().all(|one| one.abs() <= 2.0 + 1e-6));
    // Rounding scatters as a uniform distribution of that width.
    let own = rms(changed.iter().flatten());
    assert!((own - 4.0 / 12.0_f64.sqrt()).abs() < 0.1, "{own}");
}

#[test]
fn a_misstated_value_is_off_in_the_statement_and_not_in_the_readings() {
    let quiet = quiet();
    for fixed in [false, true] {
        let misstated = Disturbance::Misstated { by: 12.0, fixed };
        let situation = Situation { disturbances: vec![misstated], ..Situation::default() };
        let (mut problem, mut recipes) = (quiet.problem.clone(), quiet.opened.recipes.clone());
        let mut chance = ChaCha12Rng::seed_from_u64(1);
        situation.misstate(&mut problem, &mut recipes, &mut chance);
        let radius = problem.layout.instances.iter().find(|one| one.name == "radius").unwrap();
        let value = radius.setting.value.as_ref().unwrap()[0];
        assert!(((value - 1.15).abs() - 12e-6).abs() < 1e-12, "{value}");
        assert_eq!(radius.setting.fixed, fixed);
        let system = recipes[0].with(&[]).unwrap();
        let known = system.settings.iter().any(|one| one.value == Some(vec![value]));
        assert!(known, "recipes state it, too");
        assert!(rms_of_all(&quiet.changes(&problem)).is_nan(), "no reading moves");
    }
}
