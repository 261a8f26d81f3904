//! Power: what a campaign is said to see, against campaigns that are simulated and fitted.
#![expect(clippy::print_stderr, reason = "what was measured is told")]

use std::collections::BTreeSet;
use std::path::Path;

use homepoint::diagnose::evidence::Evidence;
use homepoint::diagnose::library::candidate::Candidate;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::power::design::{Prospect, design, prospect};
use homepoint::diagnose::power::sight::{Way, directions};
use homepoint::diagnose::power::{Power, Row, State, power};
use homepoint::diagnose::price::ln_bayes_factor;
use homepoint::diagnose::thresholds::{ENTER, ROW, TIE};
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::{Options, fit};
use homepoint::report;
use nalgebra::DVector;

/// A campaign that ships with the project, with where it stands.
fn campaign() -> (Opened, Point) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
    let opened = open(&Request::new([folder])).unwrap();
    let nominal =
        homepoint::estimate::calibrate::calibrate(opened.problem.clone(), &Options::default());
    let point = nominal.unwrap().fit.point;
    (opened, point)
}

fn table(opened: &Opened, point: &Point) -> Power {
    let (problem, recipes) = (opened.problem.clone(), opened.recipes.clone());
    power(problem, recipes, point.clone(), &Wanted::default()).unwrap()
}

fn row<'p>(power: &'p Power, name: &str) -> &'p Row {
    power.rows.iter().find(|row| row.name == name).unwrap()
}

/// The campaign's readings with an effect of these values, noisy or not.
fn drawn(
    problem: &Problem,
    point: &Point,
    (candidate, owners): (&Candidate, &[homepoint::diagnose::evidence::Owner]),
    values: &DVector<f64>,
    seed: Option<u64>,
) -> Problem {
    let system = candidate.systems[0].as_ref().unwrap();
    let mut part = problem.parts[0].with_system((**system).clone());
    if seed.is_none() {
        part.sigma.fill(0.0);
        part.random_sigma.fill(0.0);
    }
    let mut with = Problem::new(vec![part]);
    let mut truth = point.carried(&problem.layout, &with.layout);
    for (owner, value) in owners.iter().zip(values.iter()) {
        for (index, instance) in with.layout.instances.iter().enumerate() {
            if instance.name == owner.parameter
                && (instance.of == owner.of || instance.of.is_none())
            {
                truth.values[index][owner.component] = *value;
            }
        }
    }
    simulate(&mut with, &truth, seed.unwrap_or(0), true);
    let mut parts = problem.parts.clone();
    parts[0].runs = with.parts[0].runs.clone();
    Problem::new(parts)
}

fn design_of(opened: &Opened, point: &Point) -> Prospect {
    let made = design(opened.recipes.clone(), opened.problem.clone(), point.clone());
    prospect(made, &Wanted::default()).unwrap()
}

#[test]
fn a_delay_shifts_as_far_as_a_nominal_fit_says() {
    let (opened, point) = campaign();
    let table = table(&opened, &point);
    let stage = design_of(&opened, &point);
    let mut compared = 0;
    // One value each, so that the largest shift is the shift.
    for name in ["tracking_reversal", "air_drag", "clock_drift", "trunnion_tilt", "arm_windup"] {
        let row = row(&table, name);
        let number = stage.candidates.iter().position(|one| one.name == name).unwrap();
        let (candidate, entry) = (&stage.candidates[number], &stage.evidence.entries[number]);
        let values = DVector::from_element(entry.owners.len(), row.detectable.unwrap());
        let problem = &stage.fitted.problem;
        let mut shifted = drawn(problem, &point, (candidate, &entry.owners), &values, None);
        let found = fit(&mut shifted, point.clone(), &Options::default()).unwrap();
        for (delay, due) in &row.shifts {
            let index = problem.layout.instances.iter().position(|one| one.name == *delay).unwrap();
            let moved = (found.point.values[index][0] - point.values[index][0]).abs();
            let sigma = table.delays.iter().find(|one| delay.starts_with(&one.measurand));
            let sigma = sigma.unwrap().sigma.unwrap();
            // What is small against the delay's own uncertainty may differ in the second order.
            assert!(
                (moved - due).abs() < 0.02 * due + 0.002 * sigma,
                "{name} {delay}: {moved} {due}"
            );
            compared += 1;
        }
    }
    assert_eq!(compared, 15);
}

#[test]
fn a_delay_that_measurands_share_is_listed_once() {
    let lines = |found: &Power, start: &str| {
        let text = report::power_text::text("", found);
        text.lines().filter(|line| line.starts_with(start)).count()
    };
    let (opened, point) = campaign();
    let each = table(&opened, &point);
    assert_eq!((lines(&each, "horizontal "), lines(&each, "vertical ")), (1, 1));
    // The camera has one delay for its position and its attitude.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand_eye");
    let opened = open(&Request::new([folder])).unwrap();
    let fitted =
        homepoint::estimate::calibrate::calibrate(opened.problem.clone(), &Options::default());
    let only = Wanted::new(&["clock_drift".to_owned()], &[]);
    let point = fitted.unwrap().fit.point;
    let shared = power(opened.problem, opened.recipes, point, &only).unwrap();
    assert_eq!(shared.delays.len(), 4);
    assert_eq!((lines(&shared, "x, y, z, attitude "), lines(&shared, "attitude ")), (1, 0));
}

/// Share of simulated campaigns in which an effect of a size enters a budget, and in which it is a
/// row that leads all others by more than a tie.
fn shares(opened: &Opened, point: &Point, name: &str, size: f64, trials: usize) -> (f64, f64) {
    let stage = design_of(opened, point);
    let names: BTreeSet<&str> = stage.candidates.iter().map(|one| one.name.as_str()).collect();
    let ways: Vec<usize> =
        (0..stage.candidates.len()).filter(|n| stage.candidates[*n].name == name).collect();
    let (mut entered, mut named) = (0, 0);
    for trial in 0..trials {
        let number = ways[trial % ways.len()];
        let (candidate, entry) = (&stage.candidates[number], &stage.evidence.entries[number]);
        let all = directions(Way { candidate, entry });
        let values = &all[(7 * trial) % all.len()] * size;
        let seed = 1000 + trial as u64;
        let readings =
            drawn(&opened.problem, point, (candidate, &entry.owners), &values, Some(seed));
        let mut problem = readings;
        let fit = fit(&mut problem, point.clone(), &Options::default()).unwrap();
        let all: Vec<&Candidate> = stage.candidates.iter().collect();
        let evidence = Evidence::new(&problem, &fit.normal, &fit.point, &all).unwrap();
        let ln_bayes: Vec<f64> = (0..all.len())
            .map(|n| {
                let entry = &evidence.entries[n];
                let gain = entry.gain();
                let members = all.iter().filter(|one| one.name == all[n].name).count();
                ln_bayes_factor(gain, members, names.len())
            })
            .collect();
        let best = |own: bool| {
            let numbers = (0..all.len()).filter(|n| (all[*n].name == name) == own);
            numbers.max_by(|a, b| ln_bayes[*a].total_cmp(&ln_bayes[*b]))
        };
        let (own, other) = (best(true).unwrap(), best(false).unwrap());
        entered += usize::from(ln_bayes[own] >= ENTER);
        let leads = ln_bayes[own] > ln_bayes[other] + TIE;
        named += usize::from(leads && evidence.entries[own].gain().gain >= ROW);
    }
    (entered as f64 / trials as f64, named as f64 / trials as f64)
}

#[test]
#[ignore = "long"]
fn effects_of_the_detectable_size_enter() {
    let (opened, point) = campaign();
    let table = table(&opened, &point);
    let name = "encoder_eccentricity";
    let size = row(&table, name).detectable.unwrap();
    let (found, _) = shares(&opened, &point, name, size, 20);
    // 20 trials at 0.9: fewer than 14 happen once in 400 times.
    assert!(found >= 14.0 / 20.0, "{found}");
    let (found, _) = shares(&opened, &point, name, 0.6 * size, 10);
    assert!(found <= 0.5, "{found}");
}

#[test]
#[ignore = "long"]
fn sizes_of_many_effects_against_simulated_campaigns() {
    let trials = std::env::var("TRIALS").ok().and_then(|text| text.parse().ok()).unwrap_or(60);
    let (opened, point) = campaign();
    let table = table(&opened, &point);
    let signed = design_of(&opened, &point);
    let (mut sum, mut count, mut named) = (0.0, 0.0, (0.0, 0.0));
    for row in &table.rows {
        let has_form = signed.candidates.iter().any(|one| one.name == row.name);
        let Some(size) = row.detectable.filter(|_| has_form) else { continue };
        let (found, _) = shares(&opened, &point, &row.name, size, trials);
        sum += found;
        count += 1.0;
        let told = row.identifiable.map(|size| shares(&opened, &point, &row.name, size, trials));
        if let Some((_, first)) = told {
            named.0 += first;
            named.1 += 1.0;
        }
        eprintln!("{}: enters {found:.2}, is named {:?}", row.name, told.map(|told| told.1));
    }
    eprintln!(
        "{count} effects, {trials} trials each: enter at the detectable size {:.3}; named at the identifiable size {:.3} of {}",
        sum / count,
        named.0 / named.1,
        named.1
    );
    assert!((0.8..0.98).contains(&(sum / count)), "{}", sum / count);
}

#[test]
fn states_are_those_that_are_known() {
    let (opened, point) = campaign();
    let table = table(&opened, &point);
    for (name, state) in [
        ("homepoint_offset", State::Absorbed),
        ("gate_delay", State::Absorbed),
        ("range_rate_error", State::Absorbed),
        ("clock_drift", State::Alias),
        // A rate for each run is more than one clock can do.
        ("sample_clock_rate", State::Visible),
        ("trunnion_tilt", State::Visible),
        ("platform_axis_tilt", State::NotTestable),
        // Built-in detectors have a row, too.
        ("outliers", State::Visible),
        ("lost_samples", State::NotTestable),
    ] {
        let row = row(&table, name);
        assert_eq!(row.state, state, "{name}: {row:?}");
        assert!(!row.words.is_empty(), "{name}");
    }
    for row in &table.rows {
        if let (Some(seen), Some(told)) = (row.detectable, row.identifiable) {
            assert!(told >= seen * (1.0 - 1e-9), "{}", row.name);
        }
    }
}

#[test]
fn more_readings_show_smaller_effects() {
    let (opened, point) = campaign();
    let once = table(&opened, &point);
    // All runs once more: half the variance of everything.
    let mut twice = opened.problem.clone();
    for part in &mut twice.parts {
        let mut again = part.runs.clone();
        again.iter_mut().for_each(|run| run.name = format!("{}_again", run.name));
        part.runs.append(&mut again);
    }
    let twice = Problem::new(twice.parts);
    let twice = power(twice, opened.recipes.clone(), point, &Wanted::default()).unwrap();
    for name in ["trunnion_tilt", "tracking_reversal", "collimation"] {
        let ratio = row(&once, name).detectable.unwrap() / row(&twice, name).detectable.unwrap();
        assert!((ratio - 2.0_f64.sqrt()).abs() < 0.02, "{name}: {ratio}");
    }
    for (one, other) in once.delays.iter().zip(&twice.delays) {
        let ratio = one.sigma.unwrap() / other.sigma.unwrap();
        assert!((ratio - 2.0_f64.sqrt()).abs() < 0.02, "{}: {ratio}", one.measurand);
    }
}

/// An effect without anything to find has no size: its parameters are constants or do nothing.
#[test]
fn an_effect_with_nothing_to_find_has_no_size() {
    let own = tempfile::tempdir().unwrap();
    let text = "name = \"stated\"\ntitle = \"Stated\"\nacts = \"arm\"\n\
                [parameters]\nknown = { unit = \"m\", typical = \"1 um\", scope = \"rig\", value = \"2 um\", fixed = true }\n\
                [patch]\ntarget = 'target + known * rotate(arm_turn, [1, 0, 0])'\n";
    std::fs::write(own.path().join("stated.toml"), text).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
    let mut request = Request::new([folder]);
    request.effects = vec![own.path().to_owned()];
    let opened = open(&request).unwrap();
    let power = table(&opened, &campaign().1);
    assert_eq!(row(&power, "stated").detectable, None);
}

#[test]
fn a_plan_says_what_it_can_see_and_what_would_help() {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/01_at901_without_t_cam/plan.toml");
    let opened = open(&Request::new([folder])).unwrap();
    let point = Point::stated(&opened.problem.layout);
    let table = table(&opened, &point);
    let json = report::power::json(&table);
    for key in ["name", "detectable", "identifiable", "unit", "state", "with", "words"] {
        assert!(json["effects"][0].get(key).is_some(), "{key}");
    }
    for measurand in ["horizontal", "vertical", "distance"] {
        assert!(json["delays"][measurand].as_f64().unwrap() > 0.0, "{measurand}");
    }
    let bending = row(&table, "arm_acceleration_bending");
    assert_eq!(bending.state, State::NotTestable);
    // The plan's fastest run.
    let words = "a run whose rate swings by 190 deg/s both ways would detect it";
    assert!(bending.words.contains(words), "{}", bending.words);
}

/// What one row of two aliases says of the other, the other does not deny.
#[test]
fn rows_of_aliases_agree_on_what_separates_them() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/03_ltd500");
    let opened = open(&Request::new([folder])).unwrap();
    let fit = homepoint::estimate::calibrate::calibrate;
    let point = fit(opened.problem.clone(), &Options::default()).unwrap().fit.point;
    let table = table(&opened, &point);
    let words = |name: &str| row(&table, name).words.as_str();
    // A rate for each run can do all that one rate for all of them does.
    let (each, common) = (words("sample_clock_rate"), words("clock_drift"));
    assert!(each.contains("separates them where it is the cause"), "{each}");
    assert!(each.ends_with("nothing tried here where `clock_drift` is"), "{each}");
    assert!(
        common.contains("nothing tried here separates them, where it is the cause"),
        "{common}"
    );
    let aliases = table.rows.iter().filter(|row| row.state == State::Alias);
    for one in aliases.filter(|row| row.words.ends_with(" separates them")) {
        let others = one.with.iter().map(|name| row(&table, name));
        for other in others.filter(|other| other.with == [one.name.clone()]) {
            assert!(!other.words.contains("nothing tried here"), "{} {}", one.words, other.words);
        }
    }
}
