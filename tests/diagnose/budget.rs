//! The core of the budget, each number by a second route: sums against dense products of rows, gains
//! and held-out drops against nonlinear fits, and what must change no row.

use homepoint::diagnose::budget::families::Families;
use homepoint::diagnose::budget::held_out::Folded;
use homepoint::diagnose::budget::linear::Linear;
use homepoint::diagnose::budget::pieces::Pieces;
use homepoint::diagnose::budget::selection::Selection;
use homepoint::diagnose::budget::sums::Weighted;
use homepoint::diagnose::budget::terms::{Base, Change};
use homepoint::diagnose::fitted::Fitted;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::price::Gain;
use homepoint::diagnose::{Diagnosis, diagnose};
use homepoint::engine::Problem;
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::signatures::Signature;
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::graph::Scope;
use nalgebra::DMatrix;

use crate::drawn::{drawn, folder, run};
use crate::found::{names, told};
use crate::stated_values::{SIGMA, said, with_setup};

fn fitted(opened: &Opened, problem: Problem) -> Fitted {
    let nominal = calibrate(problem, &Options::default()).unwrap();
    Fitted { recipes: opened.recipes.clone(), problem: nominal.problem, fit: nominal.fit }
}

fn linear(fitted: &Fitted, only: &[&str], with_blocks: bool) -> Linear {
    let only: Vec<String> = only.iter().map(|name| (*name).to_owned()).collect();
    let wanted = Wanted::new(&only, &[]);
    Linear::new(fitted.clone(), &[], &wanted, with_blocks, &mut Families::default()).unwrap()
}

/// The example, with a stated place of one setup.
fn with_a_stated_place() -> Fitted {
    let free = open(&Request::new([folder()])).unwrap();
    let free = fitted(&free, free.problem.clone());
    let layout = &free.problem.layout;
    let at = layout.instances.iter().position(|one| one.name == "position").unwrap();
    let value = free.fit.point.values[at];
    let (_own, opened) = with_setup(&said([value[0] + 3e-5, value[1], value[2]], SIGMA));
    fitted(&opened, opened.problem.clone())
}

/// Whose value a signature is in a run of a campaign without names of its own.
fn of(problem: &Problem, run: usize, signature: &Signature) -> Option<String> {
    let part = &problem.parts[0];
    match signature.scope {
        Scope::Rig | Scope::Instrument => None,
        Scope::Setup => Some(part.setups[part.runs[run].setup].clone()),
        Scope::Run | Scope::Sample => Some(part.runs[run].name.clone()),
    }
}

/// Whether a sample comes no earlier than another one, by the stamps.
fn is_later(problem: &Problem, sample: (usize, usize), than: (usize, usize)) -> bool {
    let time = |(run, at): (usize, usize)| problem.parts[0].runs[run].record.whole().time[at];
    time(sample) >= time(than)
}

/// Every whitened reading as a dense row over all columns, changes among them, the residual last,
/// with its measurand.
fn dense(linear: &Linear, changes: &[(usize, Change)]) -> Vec<(usize, Vec<f64>)> {
    let (problem, sums) = (&linear.fitted.problem, &linear.sums);
    let signatures = &linear.signed[0];
    let columns: Vec<Vec<usize>> = (0..problem.parts[0].runs.len())
        .map(|run| {
            let mut columns = problem.layout.columns.touched_by(run);
            for signature in &signatures.columns {
                let whose = of(problem, run, signature);
                let is_own = |column: &&usize| {
                    let owner = &sums.owners[**column - sums.nominal];
                    (&owner.parameter, owner.component, &owner.of)
                        == (&signature.parameter, signature.component, &whose)
                };
                columns.push(*sums.of_candidate[signature.candidate].iter().find(is_own).unwrap());
            }
            columns
        })
        .collect();
    let mut rows = Vec::new();
    problem.visit_whitened(signatures, &linear.fitted.fit.point, &mut |lanes| {
        let own = &columns[lanes.run];
        let mut row = Vec::new();
        for lane in (0..lanes.stretch.len).filter(|lane| lanes.is_present(*lane)) {
            lanes.put(lane, &mut row);
            let mut whole = vec![0.0; sums.residual() + 1];
            own.iter().zip(&row).for_each(|(column, value)| whole[*column] += value);
            for (column, change) in changes {
                let base = change.base.candidate;
                let mut all = signatures.columns.iter().enumerate();
                let (at, _) = all.find(|(_, one)| one.candidate == base).unwrap();
                let sample = (lanes.run, lanes.stretch.first + lane);
                if is_later(problem, sample, change.at) {
                    whole[*column] = row[own.len() - signatures.columns.len() + at];
                }
            }
            whole[sums.residual()] = lanes.residual[lane];
            rows.push((problem.parts[0].measurand_of(lanes.row), whole));
        }
    });
    rows
}

/// Columns that act in all runs, in a setup or in a run, columns of changes, and stated values of
/// either kind.
#[test]
fn sums_are_products_of_rows() {
    let fitted = with_a_stated_place();
    let mut linear =
        linear(&fitted, &["collimation", "gate_delay_per_setup", "sample_clock_rate"], true);
    let of_runs = |name: &str| {
        let is_own = |one: &homepoint::diagnose::library::candidate::Candidate| {
            let place = one.place.as_ref();
            place.is_some_and(|place| place.is_of_runs() && place.words.contains(name))
        };
        linear.candidates.iter().position(is_own).unwrap()
    };
    let change = |candidate: usize, at: (usize, usize)| Change {
        base: Base { candidate, signature: 0 },
        width: 1,
        end: None,
        at,
        gain: Gain::default(),
        members: 1,
    };
    let changes = [
        change(of_runs("all readings"), (3, 40)),
        change(of_runs("`distance`"), (3, 7)),
        change(of_runs("all readings"), (8, 0)),
    ];
    let before = linear.terms.len();
    linear.with_changes(&changes);
    let column = |term: &homepoint::diagnose::budget::terms::Term| term.columns[0][0].0;
    let placed: Vec<(usize, Change)> =
        linear.terms[before..].iter().map(column).zip(changes.clone()).collect();
    assert_eq!(placed.len(), 3);

    let rows = dense(&linear, &placed);
    let (sums, size) = (&linear.sums, linear.sums.residual() + 1);
    let weights = [0.7, 1.3, 0.2];
    let mut whole = DMatrix::<f64>::zeros(size, size);
    for (measurand, weight) in weights.iter().enumerate() {
        let own: Vec<f64> = rows
            .iter()
            .filter(|(of, _)| *of == measurand)
            .flat_map(|(_, row)| row.iter().copied())
            .collect();
        let own = DMatrix::from_row_slice(own.len() / size, size, &own);
        assert_eq!(own.nrows(), sums.readings[measurand]);
        let due = own.tr_mul(&own);
        agree(&due, &|a, b| sums.product_in(measurand, a, b));
        whole += due * *weight;
    }
    // The radius, and the three components of a place: a wide column and narrow ones.
    let problem = &fitted.problem;
    // Each has a column of its own, which acts in its equation alone: that it is wrong.
    let is_stated = |term: &&homepoint::diagnose::budget::terms::Term| {
        term.place.as_ref().is_some_and(|place| place.words.starts_with("a wrong stated value"))
    };
    let of_stated = linear.terms.iter().filter(is_stated).flat_map(|term| &term.columns);
    let of_stated: Vec<usize> = of_stated.map(|one| one[0].0).collect();
    let mut stated = 0;
    for (index, instance) in problem.layout.instances.iter().enumerate() {
        let setting = &instance.setting;
        let (Some(value), Some(sigma)) = (&setting.value, &setting.sigma) else { continue };
        for (component, (said, sigma)) in value.iter().zip(sigma).enumerate() {
            let own = problem.layout.columns_of(index, component);
            let [(column, by)] = own[..] else { unreachable!("{own:?}") };
            assert_eq!(by, 1.0);
            let left = (said - fitted.fit.point.values[index][component]) / sigma;
            whole[(column, column)] += sigma.powi(-2);
            whole[(column, size - 1)] += left / sigma;
            whole[(size - 1, column)] += left / sigma;
            whole[(size - 1, size - 1)] += left * left;
            let own = of_stated[stated];
            whole[(own, own)] += 1.0;
            for (other, product) in [(column, sigma.recip()), (size - 1, left)] {
                whole[(own, other)] += product;
                whole[(other, own)] += product;
            }
            stated += 1;
        }
    }
    assert_eq!(stated, 4);
    let weighted = Weighted::new(sums, &weights);
    agree(&whole, &|a, b| weighted.product(a, b));
}

/// Every product, to rounding; those of columns that never act in one run are zero.
fn agree(due: &DMatrix<f64>, product: &dyn Fn(usize, usize) -> f64) {
    let length = |column: usize| due[(column, column)].sqrt();
    let mut acting = 0;
    for a in 0..due.nrows() {
        for b in 0..due.nrows() {
            let scale = (length(a) * length(b)).max(f64::MIN_POSITIVE);
            let (found, due) = (product(a, b), due[(a, b)]);
            assert!((found - due).abs() <= 1e-9 * scale, "{a} {b}: {found} {due}");
            acting += usize::from(due != 0.0);
        }
    }
    assert!(acting > due.nrows(), "{acting}");
}

/// The nonlinear fit with an effect put in takes off what the sums say: alone, and beside another
/// one, which the fit has too.
#[test]
fn a_term_gains_what_the_fit_with_it_takes_off() {
    let (opened, problem) = drawn(&["trunnion_tilt"], &["trunnion_tilt.tilt=3 arcsec"], 61);
    let fitted = fitted(&opened, problem);
    let effects = ["collimation", "encoder_eccentricity", "station_drift", "trunnion_tilt"];
    let linear = linear(&fitted, &effects, false);
    let selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
    let options = Options::default();
    let term = |name: &str| linear.terms.iter().position(|one| one.name == name).unwrap();
    let with = |fitted: &Fitted, name: &str| {
        let selected = &linear.candidates[term(name)].selected;
        fitted.with(selected, &[], &options).unwrap().unwrap()
    };
    let tilt = term("trunnion_tilt");
    let with_tilt = with(&fitted, "trunnion_tilt");
    for name in &effects[..3] {
        let alone = selection.gain(&[], term(name)).gain;
        let taken = fitted.fit.cost - with(&fitted, name).fit.cost;
        assert!((alone - taken).abs() < 0.02 * alone.max(1.0), "{name}: {alone} {taken}");
        let beside = selection.gain(&[tilt], term(name)).gain;
        let both = with(&with_tilt, name);
        let taken = with_tilt.fit.cost - both.fit.cost;
        assert!((beside - taken).abs() < 0.02 * beside.max(1.0), "{name}: {beside} {taken}");
        let left = selection.chi_squared(&[tilt, term(name)]);
        assert!((left / both.fit.cost - 1.0).abs() < 1e-3, "{name}: {left} {}", both.fit.cost);
        let own = selection.contributions(&[term(name), tilt])[1].gain;
        let taken = with(&fitted, name).fit.cost - both.fit.cost;
        assert!((own - taken).abs() < 0.02 * own.max(1.0), "{name}: {own} {taken}");
    }
    assert!(selection.gain(&[], tilt).gain > 100.0);
}

/// Each fifth of the runs, judged under fits of both models to the others, stated values with a
/// fifth of their weight.
#[test]
fn held_out_evidence_is_what_fits_to_the_other_folds_leave() {
    let (opened, problem) = drawn(&["collimation"], &["collimation.offset=4 arcsec"], 62);
    let fitted = fitted(&opened, problem);
    let linear = linear(&fitted, &["collimation", "encoder_eccentricity"], false);
    let selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
    let options = Options::default();
    let model: Vec<usize> = ["encoder_eccentricity", "collimation"]
        .iter()
        .map(|name| linear.terms.iter().position(|one| one.name == *name).unwrap())
        .collect();
    let folded = Folded::new(&selection, &model, &Pieces::new(&linear, &selection, &model));
    let with = |model: &[usize]| {
        model.iter().fold(fitted.clone(), |fitted, term| {
            let selected = &linear.candidates[*term].selected;
            fitted.with(selected, &[], &options).unwrap().unwrap()
        })
    };
    // Of the fits with some runs left out: their readings, their normal equations, stated values.
    let without = |whole: &Fitted, fold: Option<usize>| {
        let mut rest = whole.clone();
        for (number, run) in rest.problem.parts[0].runs.iter_mut().enumerate() {
            if Some(number % 5) == fold {
                run.record.edit(|samples| {
                    samples.readings.iter_mut().for_each(|column| column.fill(f64::NAN));
                });
            }
        }
        let rest = Fitted { problem: Problem::new(rest.problem.parts), ..rest };
        rest.again(&options).unwrap()
    };
    let squares = |whole: &Fitted| -> f64 {
        (0..5)
            .map(|fold| {
                let rest = without(whole, Some(fold));
                let normal = whole.problem.normal(&rest.fit.point);
                let runs = normal.runs.iter().enumerate();
                let own = runs.filter(|(number, _)| number % 5 == fold).map(|(_, run)| {
                    let last = run.gram.nrows() - 1;
                    run.gram[(last, last)]
                });
                let stated: f64 = normal.priors.iter().map(|one| one.residual.powi(2)).sum();
                own.sum::<f64>() + stated / 5.0
            })
            .sum()
    };
    // Minus two times the log predictive density of each fold: what its readings add to chi squared, and
    // by how much they make the covariance of all values smaller.
    let predictive = |whole: &Fitted| -> f64 {
        let evidence = |fit: &Fitted| {
            let made = calibrate(fit.problem.clone(), &options).unwrap();
            let scaled = made.covariance.map_with_location(|i, j, value| {
                value / (made.covariance[(i, i)] * made.covariance[(j, j)]).sqrt()
            });
            let lengths: f64 = made.covariance.diagonal().iter().map(|one| one.ln()).sum();
            fit.fit.cost - lengths - scaled.determinant().ln()
        };
        let all = evidence(&without(whole, None));
        (0..5).map(|fold| all - evidence(&without(whole, Some(fold)))).sum()
    };
    let models: Vec<Fitted> = [vec![model[0], model[1]], vec![model[1]], vec![model[0]]]
        .iter()
        .map(|one| with(one))
        .collect();
    let both = [squares(&models[0]), predictive(&models[0])];
    for at in 0..2 {
        let due = [squares(&models[at + 1]) - both[0], predictive(&models[at + 1]) - both[1]];
        for (found, due) in
            [folded.squares_drop(at), folded.predictive_gains(&[at])[0]].iter().zip(due)
        {
            assert!((found - due).abs() < 0.02 * due.abs().max(5.0), "{at}: {found} {due}");
        }
    }
}

/// Readings with two effects.
fn two_effects(seed: u64) -> (Opened, Problem) {
    let set = ["trunnion_tilt.tilt=6 arcsec", "tracking_reversal.step=30 urad"];
    drawn(&["trunnion_tilt", "tracking_reversal"], &set, seed)
}

/// Values of all rows with their uncertainties.
fn values(found: &Diagnosis) -> Vec<(String, f64, f64)> {
    let mut all: Vec<(String, f64, f64)> = found
        .rows
        .iter()
        .flat_map(|row| &row.values)
        .map(|one| {
            let name = format!("{} {:?}", one.name, one.of);
            (name, one.value.unwrap(), one.sigma.unwrap())
        })
        .collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

#[test]
fn the_order_of_runs_changes_no_row() {
    let (opened, problem) = two_effects(63);
    let as_is = run(problem.clone(), &opened);
    let mut expected = names(&as_is);
    expected.sort_unstable();
    assert_eq!(expected, ["tracking_reversal", "trunnion_tilt"], "{}", told(&as_is));
    let mut parts = problem.parts.clone();
    parts[0].runs.rotate_left(5);
    parts[0].runs.swap(0, 3);
    let other = run(Problem::new(parts), &opened);
    assert_eq!(other.verdict, as_is.verdict, "{}", told(&other));
    let (own, others) = (values(&as_is), values(&other));
    assert_eq!(own.len(), others.len(), "{}", told(&other));
    for ((name, value, sigma), (other, again, _)) in own.iter().zip(&others) {
        assert_eq!(name, other);
        assert!((value - again).abs() < 0.05 * sigma, "{name}: {value} {again} ± {sigma}");
    }
}

/// An effect of the user's own that does what a right one does, under another name, is named in its
/// place, for it is suspected, with that as alias; neither the gain nor the other row changes.
#[test]
fn a_twin_of_a_right_effect_changes_no_other_row() {
    let own = tempfile::tempdir().unwrap();
    let shipped = std::fs::read_to_string(
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models/effects/trunnion_tilt.toml"),
    )
    .unwrap();
    let twin = shipped.replacen("trunnion_tilt", "twin_tilt", 1);
    std::fs::write(own.path().join("twin_tilt.toml"), twin).unwrap();
    let (opened, problem) = two_effects(64);
    let as_is = run(problem.clone(), &opened);
    let request = Request { effects: vec![own.path().to_owned()], ..Request::new([folder()]) };
    let more = open(&request).unwrap();
    let found = run(problem, &more);
    assert_eq!(found.verdict, as_is.verdict, "{}", told(&found));
    let of = |found: &Diagnosis, is_tilt: bool| {
        let mut all = found.rows.iter().filter(|one| one.name.ends_with("_tilt") == is_tilt);
        let one = all.next().unwrap_or_else(|| unreachable!("{}", told(found))).clone();
        assert!(all.next().is_none(), "{}", told(found));
        one
    };
    for is_tilt in [true, false] {
        let (before, after) = (of(&as_is, is_tilt), of(&found, is_tilt));
        assert!((after.gain.gain / before.gain.gain - 1.0).abs() < 1e-3, "{}", told(&found));
        for (a, b) in before.values.iter().zip(&after.values) {
            let (value, again) = (a.value.unwrap(), b.value.unwrap());
            assert!((value - again).abs() < 0.05 * a.sigma.unwrap(), "{value} {again}");
        }
    }
    let tilt = of(&found, true);
    assert_eq!(
        (tilt.name.as_str(), &tilt.aliases[..]),
        ("twin_tilt", &["trunnion_tilt".to_owned()][..])
    );
    // Twenty to one.
    assert!((tilt.posterior - 20.0 / 21.0).abs() < 0.03, "{}", tilt.posterior);
}

/// A right row that is put into the model leaves the other rows to be named, with the values that
/// they have beside it.
#[test]
fn with_a_right_row_in_the_model_the_rest_is_named() {
    let (opened, problem) = two_effects(65);
    let as_is = run(problem.clone(), &opened);
    let set = ["trunnion_tilt", "tracking_reversal"];
    for (at, name) in set.iter().enumerate() {
        let rest = set[1 - at];
        let mut with = Request::new([folder()]);
        with.with = vec![(*name).to_owned()];
        let mut with = open(&with).unwrap();
        with.problem.parts[0].runs.clone_from(&problem.parts[0].runs);
        let found = run(Problem::new(with.problem.parts.clone()), &with);
        assert_eq!(names(&found), [rest], "{name}: {}", told(&found));
        let own: Vec<_> =
            values(&as_is).into_iter().filter(|one| one.0.starts_with(rest)).collect();
        for ((_, value, sigma), (_, again, _)) in own.iter().zip(values(&found)) {
            assert!((value - again).abs() < 0.2 * sigma, "{rest}: {value} {again} ± {sigma}");
        }
        assert!(!own.is_empty());
    }
}

/// An effect that nominal parameters absorb changes no row.
#[test]
fn an_effect_that_does_nothing_here_changes_no_row() {
    let own = tempfile::tempdir().unwrap();
    let text = "name = \"idle\"\ntitle = \"Idle\"\nacts = \"arm\"\n\
                [parameters]\nsize = { unit = \"m\", typical = \"1 um\", scope = \"rig\" }\n\
                [patch]\ntarget = 'target + size * [0, 0, 1]'\n";
    std::fs::write(own.path().join("idle.toml"), text).unwrap();
    let (opened, problem) = two_effects(66);
    let as_is = run(problem.clone(), &opened);
    let request = Request { effects: vec![own.path().to_owned()], ..Request::new([folder()]) };
    let more = open(&request).unwrap();
    let wanted = Wanted::default();
    let found = diagnose(problem, more.recipes, &wanted, &Options::default()).unwrap();
    assert_eq!((found.verdict, names(&found)), (as_is.verdict, names(&as_is)), "{}", told(&found));
    for ((name, value, sigma), (_, again, _)) in values(&as_is).iter().zip(values(&found)) {
        assert!((value - again).abs() < 0.05 * sigma, "{name}: {value} {again} ± {sigma}");
    }
}
