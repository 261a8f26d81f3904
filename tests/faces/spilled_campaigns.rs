//! Whole answers from campaigns larger than the memory for them: every number of a fit and of every
//! reading's delay is the one that memory for all would give, bit by bit.

use std::convert::Infallible;
use std::path::Path;

use homepoint::campaign::load::MEMORY;
use homepoint::campaign::write::write_campaign_with;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::{Diagnosis, diagnose};
use homepoint::engine::Point;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::simulate::{draw_run, simulate};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::conditions::self_calibration;
use homepoint::estimate::transformation::{Choice, each_delay_of, transformation};

use crate::folder::Folder;

fn opened(folder: &Path, with: &[&str], memory: u64) -> Opened {
    let mut request = Request::new([folder]);
    request.with = with.iter().map(|name| (*name).to_owned()).collect();
    request.memory = Some(memory);
    open(&request).unwrap()
}

/// Every number of a joint estimate, with its name.
fn numbers(result: &Calibration) -> Vec<(String, u64)> {
    let mut all = Vec::new();
    for one in result.estimates() {
        let name = format!("{} {:?}", one.name, one.of);
        all.push((name.clone(), one.value.unwrap_or(f64::NAN).to_bits()));
        all.push((name, one.sigma.unwrap_or(f64::NAN).to_bits()));
    }
    all.extend(result.covariance.iter().map(|value| ("covariance".to_owned(), value.to_bits())));
    all.extend(result.rms.iter().map(|(name, value)| (name.clone(), value.to_bits())));
    all.push(("cost".to_owned(), result.fit.cost.to_bits()));
    all.push(("iterations".to_owned(), result.fit.iterations as u64));
    all.push(("readings".to_owned(), result.readings as u64));
    all
}

/// Every number of the delays: of each reading, then the summaries.
fn delays(opened: &Opened, result: &Calibration) -> Vec<(String, u64)> {
    let mut all = Vec::new();
    let visit = &mut |one: &homepoint::estimate::newton::ReadingDelay| {
        let name = format!("{} {} {} {:?}", one.run, one.row, one.measurand, one.state);
        let numbers = [one.time, one.delay, one.slope, one.random, one.common];
        all.extend(numbers.map(|value| (name.clone(), value.to_bits())));
        Ok::<_, Infallible>(())
    };
    let Ok((from, found)) = each_delay_of(&opened.problem, result, 0, visit);
    for one in &found.measurands {
        let name = format!("{} {from:?} {} {}", one.measurand, one.solved, one.blind);
        let numbers = [one.mean, one.sigma_of_mean, one.median_expanded_uncertainty];
        all.extend(numbers.map(|value| (name.clone(), value.unwrap_or(f64::NAN).to_bits())));
    }
    all
}

/// Every number of the delays under changed conditions; none of it reads a run back whole.
fn conditions(opened: &Opened, result: &Calibration) -> Vec<u64> {
    let given = transformation(&opened.problem, Some(result), 0, Choice::Best).unwrap();
    let found = self_calibration(&given, 0);
    let runs = given.problem.parts[0].runs.iter();
    assert!(runs.map(|run| &run.record).all(|one| one.is_in_memory() != one.is_spilled()));
    let numbers =
        found.conditions.iter().flat_map(|one| [one.rate, one.mean, one.random, one.sigma]);
    numbers.map(f64::to_bits).collect()
}

fn assert_same(folder: &Path, with: &[&str]) {
    let held = opened(folder, with, MEMORY);
    let spilled = opened(folder, with, 0);
    let told =
        |opened: &Opened| opened.warnings.iter().map(ToString::to_string).collect::<Vec<_>>();
    assert_eq!(told(&held), told(&spilled));
    let records = |opened: &Opened| {
        opened.problem.parts[0].runs.iter().map(|run| run.record.clone()).collect::<Vec<_>>()
    };
    assert!(records(&held).iter().all(|record| !record.is_spilled()));
    assert!(records(&spilled).iter().all(|record| record.is_spilled()));
    let fit = |opened: &Opened| calibrate(opened.problem.clone(), &Options::default()).unwrap();
    let (one, other) = (fit(&held), fit(&spilled));
    assert!(one.is_sound(), "{folder:?}");
    assert_eq!(numbers(&one), numbers(&other), "{folder:?} {with:?}");
    assert_eq!(conditions(&held, &one), conditions(&spilled, &other), "{folder:?} {with:?}");
    let (one, other) = (delays(&held, &one), delays(&spilled, &other));
    assert!(one.len() > 100);
    assert!(one == other, "delays of {folder:?} {with:?}");
    assert!(records(&spilled).iter().all(|record| record.fault().is_none()));
}

#[test]
fn the_examples_give_the_same_bits() {
    for name in ["rotating_arm", "rail_car", "hand_eye"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name);
        assert_same(&folder, &[]);
    }
}

const HEAD: &str = r#"
model = "polar_one_rotation"
[parameters]
radius      = { value = "1.15 m", sigma = "10 um" }
orientation = { start = ["0.3 rad", "1.2 rad", "-0.4 rad"] }
position    = { start = ["0.3 m", "1.6 m", "0.2 m"] }
"horizontal.delay" = { start = "0.2 ms" }
[inputs]
arm_angle = { sigma = "0.2 arcsec" }
[measurands]
horizontal = { sigma = "6 urad" }
vertical   = { sigma = "6 urad" }
distance   = { sigma = "8 um" }
"#;

/// Runs of two setups, both ways, each of so many samples.
fn planned(folder: &Path, samples: usize) {
    let rates = [("a", "A", 190), ("b", "A", -190), ("c", "B", 60), ("d", "B", -170)];
    let runs = rates.map(|(name, setup, rate)| {
        let seconds = 30;
        let trigger = samples as f64 / f64::from(seconds);
        format!(
            "[[runs]]\nname = \"{name}\"\nsetup = \"{setup}\"\nplan = {{ trigger = \"{trigger} Hz\", duration = \"{seconds} s\", arm_angle = {{ start = \"10 deg\", rate = \"{rate} deg/s\" }} }}\n"
        )
    });
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join("campaign.toml"), HEAD.to_owned() + &runs.concat()).unwrap();
}

/// Draws a planned campaign into a folder, some readings missing.
fn drawn(plan: &Path, to: &Path, memory: u64) {
    let opened = opened(plan, &["timestamp_jitter"], memory);
    let mut problem = opened.problem;
    problem.parts[0].random_sigma.iter_mut().for_each(|sigma| *sigma = sigma.max(2e-7));
    let point = Point::start(&problem.layout);
    let runs = &problem.parts[0].runs;
    write_campaign_with(to, &opened.campaigns[0], &opened.models[0], runs, &mut |run, table| {
        draw_run(&problem, (0, run), &point, 3, true, &mut |stretch, drawn| {
            let mut drawn = drawn.to_vec();
            for (column, values) in drawn.iter_mut().enumerate() {
                let missing = |i: &usize| (stretch.first + i) % (11 + column) == 5;
                (0..stretch.len).filter(missing).for_each(|i| values[i] = f64::NAN);
            }
            table.write(stretch, Some(&drawn))
        })
    })
    .unwrap();
}

#[test]
fn long_runs_with_gaps_and_random_quantities_give_the_same_bits() {
    let scratch = Folder::new("spilled", &[]);
    let (plan, folder) = (scratch.join("plan"), scratch.join("drawn"));
    planned(&plan, 9000);
    drawn(&plan, &folder, MEMORY);
    assert_same(&folder, &[]);
    assert_same(&folder, &["timestamp_jitter", "collimation", "angle_noise_level"]);
}

/// Puts outliers into a drawn run.
fn spoil(file: &Path) {
    let text = std::fs::read_to_string(file).unwrap();
    let spoiled = text.lines().enumerate().map(|(row, line)| match line.rsplit_once(',') {
        Some((before, distance)) if row % 397 == 11 && !distance.is_empty() => {
            format!("{before},{}\n", distance.parse::<f64>().unwrap() + 0.001)
        }
        _ => line.to_owned() + "\n",
    });
    std::fs::write(file, spoiled.collect::<String>()).unwrap();
}

#[test]
fn a_diagnosis_is_the_same_and_takes_no_memory_for_what_it_leaves_out() {
    let scratch = Folder::new("spilled_diagnosis", &[]);
    let (plan, folder) = (scratch.join("plan"), scratch.join("drawn"));
    planned(&plan, 2000);
    drawn(&plan, &folder, MEMORY);
    spoil(&folder.join("b.csv"));
    spoil(&folder.join("c.csv"));
    let found = [MEMORY, 0].map(|memory| {
        let Opened { problem, recipes, .. } = opened(&folder, &[], memory);
        diagnose(problem, recipes, &Wanted::default(), &Options::default()).unwrap()
    });
    assert!(found[0].left_out.readings.len() >= 6, "{:?}", found[0].left_out);
    let noise = |one: &Diagnosis| {
        format!("{:?} {:?} {:?} {:?}", one.left_out, one.noise, one.levels, one.autocorrelation)
    };
    assert_eq!(noise(&found[0]), noise(&found[1]));
    let told = |one: &Diagnosis| {
        format!("{:?} {:?} {:?} {:?}", one.verdict, one.rows, one.candidates, one.gap)
    };
    assert_eq!(told(&found[0]), told(&found[1]));
    let last = &found[1].nominal.problem;
    assert!(last.parts[0].runs.iter().all(|run| run.record.is_spilled()));
}

#[test]
fn what_is_drawn_from_a_spilled_plan_is_what_memory_gives() {
    let scratch = Folder::new("spilled_plan", &[]);
    let plan = scratch.join("plan");
    planned(&plan, 9000);
    drawn(&plan, &scratch.join("held"), MEMORY);
    drawn(&plan, &scratch.join("spilled"), 0);
    for file in ["a.csv", "b.csv", "c.csv", "d.csv", "campaign.toml"] {
        let read = |folder: &str| std::fs::read(scratch.join(folder).join(file)).unwrap();
        assert!(read("held") == read("spilled"), "{file}");
    }
    // Drawn in memory, too.
    let mut problem = opened(&plan, &["timestamp_jitter"], MEMORY).problem;
    problem.parts[0].random_sigma.iter_mut().for_each(|sigma| *sigma = sigma.max(2e-7));
    let point = Point::start(&problem.layout);
    let mut read = Vec::new();
    let keep = &mut |_: homepoint::campaign::Stretch<'_>, drawn: &[Vec<f64>]| {
        read.extend_from_slice(&drawn[2]);
        Ok::<_, Infallible>(())
    };
    let Ok(()) = draw_run(&problem, (0, 1), &point, 3, true, keep);
    simulate(&mut problem, &point, 3, true);
    assert_eq!(problem.parts[0].runs[1].held().readings[2], read);
}

#[test]
fn a_start_from_a_part_of_a_long_run_is_the_same_wherever_it_is_kept() {
    let scratch = Folder::new("spilled_start", &[]);
    let (plan, folder) = (scratch.join("plan"), scratch.join("drawn"));
    planned(&plan, 80_000);
    let text = std::fs::read_to_string(plan.join("campaign.toml")).unwrap();
    drawn(&plan, &folder, MEMORY);
    // Nothing stated of the transformation: Horn's closed form has to find it.
    let without = |text: &str| {
        let lines = text.lines().filter(|l| !l.contains("orientation") && !l.contains("position"));
        lines.map(|line| line.to_owned() + "\n").collect::<String>()
    };
    assert_ne!(without(&text), text);
    let toml = folder.join("campaign.toml");
    std::fs::write(&toml, without(&std::fs::read_to_string(&toml).unwrap())).unwrap();
    let starts = [MEMORY, 0].map(|memory| {
        let problem = opened(&folder, &[], memory).problem;
        assert!(problem.parts[0].runs.iter().map(|run| run.record.len()).sum::<usize>() > 1 << 18);
        let (point, aligned) = homepoint::estimate::start::start(&problem);
        assert!(aligned.len() == 2 && aligned.iter().all(|one| one.result.is_ok()), "{aligned:?}");
        point.values.iter().flatten().map(|value| value.to_bits()).collect::<Vec<_>>()
    });
    assert_eq!(starts[0], starts[1]);
}
