//! The parts of a diagnosis, each against a second route to the same number.

use std::path::Path;

use homepoint::diagnose::budget::families::Families;
use homepoint::diagnose::budget::held_out::Folded;
use homepoint::diagnose::budget::in_fit::Row;
use homepoint::diagnose::budget::linear::Linear;
use homepoint::diagnose::budget::pieces::{FOLDS, Pieces};
use homepoint::diagnose::budget::selection::Selection;
use homepoint::diagnose::budget::selection::exchange::Exchange;
use homepoint::diagnose::evidence::Evidence;
use homepoint::diagnose::fitted::Fitted;
use homepoint::diagnose::gap::Drop;
use homepoint::diagnose::library::candidate::Candidate;
use homepoint::diagnose::library::offer::offer;
use homepoint::diagnose::library::structure::blocks;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::engine::Problem;
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::report;

use crate::drawn::{drawn, drawn_at, folder, run};
use crate::found::{names, told};

fn example() -> (Opened, Fitted) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
    let opened = open(&Request::new([folder])).unwrap();
    let nominal = calibrate(opened.problem.clone(), &Options::default()).unwrap();
    let fitted =
        Fitted { recipes: opened.recipes.clone(), problem: nominal.problem, fit: nominal.fit };
    (opened, fitted)
}

/// A fitted model and the same with an effect of the library.
fn without_and_with(opened: &Opened, fitted: &Fitted, name: &str) -> (Fitted, Fitted) {
    let offered = offer(&opened.recipes).effects;
    let candidate = offered.iter().find(|one| one.name == name).unwrap();
    let options = Options::default();
    let after = fitted.with(&candidate.selected, &[], &options).unwrap().unwrap();
    (after.without(&[&candidate.selected], &options).unwrap(), after)
}

/// What an effect in a fit takes off held-out readings, by run or stretch of a run.
fn drops(after: &Fitted, name: &str) -> Vec<Drop> {
    let row = Row { name: name.to_owned(), variant: None, members: 1, ln_prior: 0.0, change: None };
    let wanted = Wanted::default();
    let mut families = Families::default();
    let linear = Linear::new(after.clone(), &[row], &wanted, false, &mut families).unwrap();
    let selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
    let rows = linear.rows();
    let pieces = Pieces::new(&linear, &selection, &rows);
    let mut drops = Folded::new(&selection, &rows, &pieces).drops(&selection, &pieces);
    assert_eq!(drops.len(), 1);
    drops.remove(0)
}

/// A model with only some samples of each run, by run, sample and number of samples.
fn among(model: &Fitted, is_kept: &dyn Fn(usize, usize, usize) -> bool) -> Problem {
    let mut problem = model.problem.clone();
    for (run, data) in problem.parts[0].runs.iter_mut().enumerate() {
        data.record.edit(|samples| {
            for column in &mut samples.readings {
                let length = column.len();
                for (sample, reading) in column.iter_mut().enumerate() {
                    if !is_kept(run, sample, length) {
                        *reading = f64::NAN;
                    }
                }
            }
        });
    }
    Problem::new(problem.parts)
}

/// Squared residuals of some samples of a run under the model that is fitted to some others.
fn squares_of_the_rest(
    model: &Fitted,
    is_learnt: &dyn Fn(usize, usize, usize) -> bool,
    run: usize,
    is_judged: &dyn Fn(usize, usize, usize) -> bool,
) -> f64 {
    let learnt = Fitted { problem: among(model, is_learnt), ..model.clone() };
    let learnt = learnt.again(&Options::default()).unwrap();
    let gram = &among(model, is_judged).normal(&learnt.fit.point).runs[run].gram;
    gram[(gram.nrows() - 1, gram.nrows() - 1)]
}

fn evidence(fitted: &Fitted, candidates: &[&Candidate]) -> Evidence {
    Evidence::new(&fitted.problem, &fitted.fit.normal, &fitted.fit.point, candidates).unwrap()
}

#[test]
fn a_gain_is_what_the_nonlinear_fit_takes_off() {
    let (opened, fitted) = example();
    let offered = offer(&opened.recipes).effects;
    let mut compared = 0;
    for name in ["collimation", "encoder_eccentricity", "station_drift", "clock_drift"] {
        let candidate = offered.iter().find(|one| one.name == name).unwrap();
        let gain = evidence(&fitted, &[candidate]).entries[0].gain().gain;
        let with = fitted.with(&candidate.selected, &[], &Options::default()).unwrap().unwrap();
        let taken = fitted.fit.cost - with.fit.cost;
        assert!((gain - taken).abs() < 0.02 * gain.max(1.0), "{name}: {gain} {taken}");
        compared += 1;
    }
    assert_eq!(compared, 4);
}

#[test]
fn a_drop_is_what_two_fits_without_the_fold_leave_of_a_run() {
    let set = ["encoder_eccentricity.cosine=40 urad"];
    let (opened, problem) = drawn(&["encoder_eccentricity"], &set, 4);
    let nominal = calibrate(problem, &Options::default()).unwrap();
    let fitted =
        Fitted { recipes: opened.recipes.clone(), problem: nominal.problem, fit: nominal.fit };
    let (before, after) = without_and_with(&opened, &fitted, "encoder_eccentricity");
    let drops = drops(&after, "encoder_eccentricity");
    assert_eq!(drops.len(), 12);
    for run in [0, 7] {
        let is_learnt = |other: usize, _: usize, _: usize| other % FOLDS != run % FOLDS;
        let squares = |model: &Fitted| squares_of_the_rest(model, &is_learnt, run, &|_, _, _| true);
        let due = squares(&before) - squares(&after);
        let found = drops[run].taken;
        assert!(due > 100.0, "{run}: {due}");
        assert!((found - due).abs() < 0.01 * due.abs().max(1.0), "{run}: {found} {due}");
    }
}

/// Without factoring again, what is found in the place of a term is what is found beside the rest.
#[test]
fn what_would_stand_in_the_place_of_a_term_is_the_best_beside_the_others() {
    let (_, fitted) = example();
    let wanted = Wanted::default();
    let linear = Linear::new(fitted, &[], &wanted, true, &mut Families::default()).unwrap();
    let mut selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
    let pool: Vec<usize> = (0..linear.terms.len()).collect();
    let mut model = Vec::new();
    for _ in 0..4 {
        let best = selection.ranked(&model, &pool)[0];
        model.push(best.term);
        selection.set_scale(&model);
    }
    let exchange = Exchange::new(&selection, &model, &pool);
    for out in model.iter().copied() {
        let rest: Vec<usize> = model.iter().copied().filter(|own| *own != out).collect();
        let others: Vec<usize> =
            pool.iter().copied().filter(|term| !model.contains(term)).collect();
        let due = selection.ranked(&rest, &others)[0];
        let found = exchange.best(out, |_| true).unwrap();
        assert_eq!((found.term, found.gain.degrees), (due.term, due.gain.degrees));
        assert!((found.ln_bayes - due.ln_bayes).abs() < 1e-6 * due.gain.gain.max(1.0));
    }
}

/// What belongs to a run is fitted to four fifths of it and judged on the other one.
#[test]
fn a_run_with_values_of_its_own_is_judged_between_what_it_was_fitted_to() {
    let mut request = Request::new([folder()]);
    request.with = vec!["sample_clock_rate".to_owned()];
    let (opened, problem) = drawn_at(&request, 3, &|one| {
        let of = one.of.as_deref().unwrap_or_default();
        let sense = if of.contains("ccw") { 1.0 } else { -1.0 };
        (one.name == "sample_clock_rate.rate_error").then_some(sense * 1e-6)
    });
    let nominal = calibrate(problem, &Options::default()).unwrap();
    let fitted =
        Fitted { recipes: opened.recipes.clone(), problem: nominal.problem, fit: nominal.fit };
    let (before, after) = without_and_with(&opened, &fitted, "sample_clock_rate");
    let drops = drops(&after, "sample_clock_rate");
    let mut largest = 0.0_f64;
    for (run, fold) in [(0, 4), (7, 2)] {
        let is_held_out = |_: usize, sample: usize, length: usize| sample * FOLDS / length == fold;
        let is_learnt = |run, sample, length| !is_held_out(run, sample, length);
        let squares = |model: &Fitted| squares_of_the_rest(model, &is_learnt, run, &is_held_out);
        let due = squares(&before) - squares(&after);
        let found = drops[run * FOLDS + fold].taken;
        assert!((found - due).abs() < 0.01 * due.abs().max(1.0), "{run}: {found} {due}");
        largest = largest.max(due);
    }
    assert!(largest > 10.0, "{largest}");
}

/// A clock with a rate of each run's own absorbs what a common clock and the air do, but for what
/// is left.
#[test]
fn two_effects_of_which_a_third_takes_up_both() {
    let set = ["air_drag.drag=4 um*s^2/rad^2", "clock_drift.rate_error=3 ppm"];
    let (opened, problem) = drawn(&["air_drag", "clock_drift"], &set, 1);
    let found = run(problem, &opened);
    let mut both = names(&found);
    both.sort_unstable();
    assert_eq!(both, ["air_drag", "clock_drift"], "{}", told(&found));
    assert!(found.rows.iter().all(|one| one.posterior > 0.5));
}

/// What a low-pass filter leaves beyond its delay is what servos do that run ahead in proportion to
/// acceleration, and what one that lags in proportion to its rate leaves beyond a delay is the
/// opposite.
#[test]
fn an_effect_that_another_one_is_by_its_square() {
    let (servo, filter) = ("servo_acceleration_lag", "first_order_lowpass");
    for (put_in, set) in [
        (filter, None),
        (servo, Some("servo_acceleration_lag.lag=-2e-6 s^2")),
        (servo, Some("servo_acceleration_lag.lag=2e-6 s^2")),
        (servo, Some("servo_acceleration_lag.lag=8e-6 s^2")),
    ] {
        let (opened, problem) = drawn(&[put_in], set.as_slice(), 9);
        let found = run(problem, &opened);
        assert_eq!(names(&found), [servo], "{put_in} {set:?}: {}", told(&found));
    }
}

/// Without its only run a setup is not determined: what belongs to it is fitted there.
#[test]
fn the_only_run_of_a_setup_is_held_out_but_for_what_belongs_to_it() {
    let (opened, fitted) = example();
    let mut parts = fitted.problem.parts.clone();
    let fast = |run: &homepoint::campaign::Run| run.name.ends_with("50");
    parts[0].runs.retain(fast);
    parts[0].setups = parts[0].runs.iter().map(|run| run.name.clone()).collect();
    parts[0].runs.iter_mut().enumerate().for_each(|(number, run)| run.setup = number);
    let runs = parts[0].runs.len();
    assert!(runs >= 4);
    let nominal = calibrate(Problem::new(parts), &Options::default()).unwrap();
    let fitted =
        Fitted { recipes: opened.recipes.clone(), problem: nominal.problem, fit: nominal.fit };
    let (_, after) = without_and_with(&opened, &fitted, "encoder_second_harmonic");
    let drops = drops(&after, "encoder_second_harmonic");
    assert_eq!(drops.len(), runs);
    // The effect is not there: what it takes off is of the size of noise.
    assert!(drops.iter().all(|one| one.taken.abs() < 30.0), "{drops:?}");
}

#[test]
fn every_shipped_model_has_blocks_of_unknown_structure() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    for (name, least) in [("rotating_arm", 90), ("rail_car", 20), ("hand_eye", 60)] {
        let opened = open(&Request::new([folder.join(name)])).unwrap();
        let found = blocks(&opened.recipes);
        assert!(found.len() >= least, "{name}: {}", found.len());
        assert!(found.iter().all(|one| one.place.is_some()));
    }
}

#[test]
fn probabilities_of_causes_leave_something_for_none() {
    let (opened, _) = example();
    let options = Options::default();
    let found =
        homepoint::diagnose::diagnose(opened.problem, opened.recipes, &Wanted::default(), &options);
    let json = report::diagnosis::json(&found.unwrap(), None);
    assert_eq!(json["verdict"], "adequate");
    let whole: f64 = json["candidates"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["probability"].as_f64().unwrap())
        .sum();
    assert!(whole > 0.0 && whole < 1.0, "{whole}");
}

/// A member's uncertainty is where the sum of squares of a joint fit is larger by one, and the
/// effect's values share in it.
#[test]
fn a_member_is_as_certain_as_the_sum_of_squares_says() {
    let cyclic = "distance_cyclic";
    let truth = [("unit_length", 0.5), ("cosine", 5e-6), ("sine", -3e-6)];
    let set = truth.map(|(name, value)| format!("{cyclic}.{name}={value} m"));
    let (opened, problem) = drawn(&[cyclic], &set.each_ref().map(String::as_str), 32);
    let found = run(problem.clone(), &opened);
    let [one] = &found.rows[..] else { unreachable!("{}", told(&found)) };
    let known = one.member_sigma["unit_length"];
    let best = one.member["unit_length"];
    assert!((best - 0.5).abs() < 4.0 * known, "{best} {known}");

    let fitted_at = |member: f64| {
        let mut request = Request::new([folder()]);
        request.with = vec![cyclic.to_owned()];
        request.set = vec![format!("{cyclic}.unit_length={member} m")];
        let mut parts = open(&request).unwrap().problem.parts;
        for (part, drawn) in parts.iter_mut().zip(&problem.parts) {
            part.runs.clone_from(&drawn.runs);
        }
        calibrate(Problem::new(parts), &Options::default()).unwrap()
    };
    let [at_best, below, above] = [best, best - known, best + known].map(fitted_at);
    let rise = 0.5 * (below.fit.cost + above.fit.cost) - at_best.fit.cost;
    assert!((0.9..1.5).contains(&rise), "{rise}");

    let json = report::diagnosis::json(&found, None);
    let told = &json["effects"][0];
    assert_eq!(told["member_sigma"]["unit_length"].as_f64(), Some(known));
    for (name, truth) in &truth[1..] {
        let name = format!("{cyclic}.{name}");
        let of = |fit: &Calibration| {
            let all = fit.estimates();
            let own = all.into_iter().find(|one| one.name == name).unwrap();
            (own.value.unwrap(), own.sigma.unwrap())
        };
        let (value, sigma) = of(&at_best);
        let share = (of(&above).0 - value).hypot(of(&below).0 - value) / 2_f64.sqrt();
        let parameters = told["parameters"].as_array().unwrap();
        let own = parameters.iter().find(|own| own["name"] == name.as_str()).unwrap();
        let own_sigma = own["sigma"].as_f64().unwrap();
        assert!((own_sigma / sigma.hypot(share) - 1.0).abs() < 0.1, "{name}: {own_sigma}");
        assert!(own_sigma > 1.2 * sigma, "{name}: {own_sigma} {sigma}");
        let value = own["value"].as_f64().unwrap();
        assert!((value - truth).abs() < 4.0 * own_sigma, "{name}: {value} {own_sigma}");
    }
}
