//! Unobservable directions.

use homepoint::engine::gram::{Columns, LeastSquares, Normal};
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::{Options, Outcome};
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::observability::{Direction, Kind, Limit, examine};
use nalgebra::{DMatrix, DVector};

use crate::folder::Folder;
use crate::problems::Stream;
use crate::problems::linear::{Linear, constant_rate, random_arrow};

fn at_zero(problem: &Linear) -> Normal {
    problem.normal(&vec![0.0; problem.columns.len()])
}

fn single(rows: DMatrix<f64>) -> Linear {
    let n = rows.ncols();
    Linear {
        columns: Columns { global: n, setups: vec![0], runs: vec![(0, 0)] },
        runs: vec![(rows.clone(), DVector::zeros(rows.nrows()))],
        priors: vec![],
        bounds: vec![],
    }
}

#[test]
fn a_delay_that_acts_as_a_turn_is_named_with_its_rate() {
    let found = examine(&at_zero(&constant_rate(3.0)), &[]).unwrap().directions;
    let [idle, turn] = &found[..] else { unreachable!("{found:?}") };
    assert_eq!((idle.weights.clone(), idle.kind), (vec![(3, 1.0)], Kind::Exact));
    assert_eq!((turn.kind, turn.standard_uncertainty), (Kind::Exact, None));
    let weight = |c| turn.weights.iter().find(|w| w.0 == c).unwrap().1;
    assert!((weight(1) / weight(0) + 3.0).abs() < 1e-7, "a delay of 1 s is a turn of -3 rad");
    assert_eq!(turn.weights.len(), 2);
    assert!(turn.singular_value < 1e-7 && (turn.shares[0].abs() - 1.0).abs() < 1e-15);
}

#[test]
fn a_determined_problem_has_no_such_direction() {
    let columns = Columns { global: 3, setups: vec![2], runs: vec![(0, 1), (0, 2)] };
    assert_eq!(examine(&at_zero(&random_arrow(2, columns)), &[]).unwrap().directions, vec![]);
    let empty = random_arrow(2, Columns { global: 0, setups: vec![0], runs: vec![(0, 0)] });
    assert_eq!(examine(&at_zero(&empty), &[]).unwrap().directions, vec![]);
}

#[test]
fn noise_can_hide_a_direction() {
    // The second column is the first plus 1e-5 of an independent one.
    let rows = DMatrix::from_fn(100, 2, |i, k| {
        let x = i as f64;
        10.0 * (x * 0.3).sin() + if k == 1 { 1e-4 * (x * 0.7).cos() } else { 0.0 }
    });
    let found = examine(&at_zero(&single(rows)), &[]).unwrap().directions;
    let [one] = &found[..] else { unreachable!("{found:?}") };
    assert_eq!(one.kind, Kind::UpToNoise);
    assert!((1e-6..1e-5).contains(&one.singular_value), "{one:?}");
    let sigma = one.standard_uncertainty.unwrap();
    // 1 / (1e-4 √50): what the independent part alone tells.
    assert!((sigma / 1414.0 - 1.0).abs() < 0.02, "{sigma}");
}

#[test]
fn an_implausible_uncertainty_counts_and_leads() {
    let rows = DMatrix::from_fn(100, 3, |i, k| {
        let x = i as f64;
        [(x * 0.3).sin(), (x * 0.3).sin() + 0.01 * (x * 0.7).cos(), (x * 0.11).sin()][k]
    });
    let normal = at_zero(&single(rows));
    assert_eq!(
        examine(&normal, &[Limit::Unlimited, Limit::Size(20.0), Limit::Size(1.0)])
            .unwrap()
            .directions,
        vec![]
    );
    let found = examine(&normal, &[Limit::Unlimited, Limit::Size(10.0), Limit::Size(1.0)])
        .unwrap()
        .directions;
    let [one] = &found[..] else { unreachable!("{found:?}") };
    assert_eq!((one.kind, one.weights[0].0, one.weights[1].0), (Kind::UpToNoise, 1, 0));
    assert!((one.weights[0].1 / one.weights[1].1 + 1.0).abs() < 0.02);
    assert!((one.standard_uncertainty.unwrap() - 14.14).abs() < 0.3);
    // Both plausible sizes exceeded: still one direction, they move together.
    assert_eq!(
        examine(&normal, &[Limit::Size(1.0), Limit::Size(1.0), Limit::Unlimited])
            .unwrap()
            .directions
            .len(),
        1
    );
}

/// A column that is too short for its plausible size whatever the others are, and that these hardly
/// follow, is a direction by itself; where these follow it they are named with it.
#[test]
fn what_others_hardly_follow_is_unseen_by_itself() {
    let of = |part: f64| {
        let rows = DMatrix::from_fn(100, 2, |i, k| {
            let x = i as f64;
            [0.01 * (part * (x * 0.3).sin() + (x * 0.7).cos()), (x * 0.3).sin()][k]
        });
        let limits = [Limit::Size(1.0), Limit::Unlimited];
        examine(&at_zero(&single(rows)), &limits).unwrap().directions
    };
    let columns = |found: &[Direction]| -> Vec<usize> {
        let [one] = found else { unreachable!("{found:?}") };
        assert!(one.is_implausible && one.kind == Kind::UpToNoise, "{one:?}");
        one.weights.iter().map(|weight| weight.0).collect()
    };
    let alone = of(0.1);
    assert_eq!(columns(&alone), [0]);
    // 1 / (0.01 √50)
    let sigma = alone[0].standard_uncertainty.unwrap();
    assert!((sigma / 14.14 - 1.0).abs() < 0.02, "{sigma}");
    assert_eq!(columns(&of(10.0)), [0, 1]);
}

/// Two delays of two setups, each against its own orientation: two directions, not mixed.
#[test]
fn parallel_null_spaces_are_told_apart() {
    let rates = [3.0, 0.7];
    let rows = DMatrix::from_fn(60, 5, |i, k| match (i % 3, k) {
        (s, d) if s < 2 && d == s => rates[s],
        (s, o) if s < 2 && o == s + 2 => 1.0,
        (2, 4) => 1.0,
        _ => 0.0,
    });
    let found = examine(&at_zero(&single(rows)), &[]).unwrap().directions;
    let mut columns: Vec<Vec<usize>> = found
        .iter()
        .map(|d: &Direction| {
            let mut columns: Vec<usize> = d.weights.iter().map(|w| w.0).collect();
            columns.sort_unstable();
            columns
        })
        .collect();
    columns.sort();
    assert_eq!(columns, [[0, 2], [1, 3]]);
}

/// One height read a hundred times, the sum of two; the second taped to 20.
fn taped_height() -> Normal {
    let mut problem = single(DMatrix::from_element(100, 2, 1.0));
    problem.priors = vec![(vec![(1, 1.0 / 20.0)], 0.0)];
    at_zero(&problem)
}

#[test]
fn a_stated_parameter_is_known_to_what_is_stated() {
    let normal = taped_height();
    let found = examine(&normal, &[Limit::Size(0.5), Limit::Stated]).unwrap();
    assert_eq!(found.directions, vec![]);
    // With the second held, the mean of a hundred readings of 1 remains.
    assert!((found.judged[(0, 0)].sqrt() - 0.1).abs() < 1e-12, "{}", found.judged);
    let found = examine(&normal, &[Limit::Size(0.5), Limit::Size(0.5)]).unwrap();
    let [one] = &found.directions[..] else { unreachable!("{found:?}") };
    assert!(one.is_implausible);
    // Neither is known better than the tape: 20, and the readings' 0.1.
    let expected = 20.0_f64.hypot(0.1);
    assert!((found.judged[(0, 0)].sqrt() - expected).abs() < 1e-6 * expected);
}

#[test]
fn a_weak_direction_within_plausible_sizes_is_determined() {
    let rows = DMatrix::from_fn(100, 2, |i, k| {
        let x = i as f64;
        10.0 * (x * 0.3).sin() + if k == 1 { 1e-4 * (x * 0.7).cos() } else { 0.0 }
    });
    let normal = at_zero(&single(rows));
    // Its standard uncertainty is 1 / (1e-4 √50) = 1414.
    let count =
        |size| examine(&normal, &[Limit::Size(size), Limit::Size(size)]).unwrap().directions.len();
    assert_eq!((count(2000.0), count(1000.0)), (0, 1));
}

/// A lever arm and a shift on a road that hardly turns: four values, of which two sums are known. What is
/// known once the shift is counts as no direction of its own.
#[test]
fn open_directions_are_counted_once() {
    let model = "name = \"antenna\"\ntitle = \"Antenna on a car\"\n[inputs]\nheading = { unit = \"rad\" }\n\
        [parameters]\n\
        shift_e = { unit = \"m\", plausible = \"100 mm\" }\nshift_n = { unit = \"m\", plausible = \"100 mm\" }\n\
        ahead = { unit = \"m\", plausible = \"100 mm\" }\nleft = { unit = \"m\", plausible = \"100 mm\" }\n\
        [measurands]\n\
        e = { value = 'shift_e + ahead * cos(heading) - left * sin(heading)', unit = \"m\", sigma = \"20 mm\" }\n\
        n = { value = 'shift_n + ahead * sin(heading) + left * cos(heading)', unit = \"m\", sigma = \"20 mm\" }\n";
    let campaign = "title = \"Road\"\nmodel = \"model.toml\"\n[[runs]]\nname = \"road\"\ndata = \"data.csv\"\n";
    let mut noise = Stream(11);
    let mut data = "heading [rad],e [m],n [m]\n".to_owned();
    for _ in 0..400 {
        let heading: f64 = 0.6435 + 2e-3 * noise.normal();
        let e = 0.4 - 1.2 * heading.cos() - 0.35 * heading.sin() + 0.02 * noise.normal();
        let n = -0.2 - 1.2 * heading.sin() + 0.35 * heading.cos() + 0.02 * noise.normal();
        data += &format!("{heading:.6},{e:.5},{n:.5}\n");
    }
    let files = [("model.toml", model), ("campaign.toml", campaign), ("data.csv", &*data)];
    let folder = Folder::new("road", &files);
    let fit =
        calibrate(open(&Request::new([&*folder])).unwrap().problem, &Default::default()).unwrap();
    assert_eq!(fit.unobservable.len(), 2, "{:?}", fit.unobservable);
    // What is given is known to its plausible size, and what is not is not.
    let (given, open): (Vec<_>, Vec<_>) =
        fit.estimates().into_iter().partition(|one| one.value.is_some());
    assert!(given.iter().all(|one| one.sigma.unwrap() < 0.1), "{given:?}");
    assert!(open.len() >= 2, "{given:?}");
}

/// A lidar that sees nothing but level ground: its yaw has no effect, and what is left of its derivative is
/// rounding. The fit converges, and the yaw is not determined.
#[test]
fn a_turn_without_effect_is_not_determined_though_its_derivative_is_rounding() {
    let model = "name = \"roof\"\ntitle = \"Lidar on a roof\"\n\
        [inputs]\naz = { unit = \"rad\" }\nel = { unit = \"rad\" }\n\
        [parameters]\nheight = { unit = \"m\", start = \"2 m\" }\nyaw = { unit = \"rad\" }\npitch = { unit = \"rad\" }\nroll = { unit = \"rad\" }\n\
        [quantities]\nbeam = '[cos(el) * cos(az), cos(el) * sin(az), sin(el)]'\n\
        turned = 'rotate(rotation_z(yaw) * rotation_y(pitch) * rotation_x(roll), beam)'\n\
        [measurands]\nrange = { value = 'norm(turned * (-height / turned.z))', unit = \"m\" }\n";
    let mut random = Stream(31);
    let mut log = "az [rad],el [rad],range [m]\n".to_owned();
    for _ in 0..400 {
        let (az, el) = (std::f64::consts::TAU * random.uniform(), -0.1 - 0.5 * random.uniform());
        // To first order in pitch and roll.
        let down = -el.sin() + 0.03 * el.cos() * az.cos() - 0.02 * el.cos() * az.sin();
        log.push_str(&format!("{az:.6},{el:.6},{:.4}\n", 1.8 / down + 0.02 * random.normal()));
    }
    let campaign = "title = \"Roof\"\nmodel = \"model.toml\"\n[measurands]\nrange = { sigma = \"20 mm\" }\n\
        [[runs]]\nname = \"one\"\ndata = \"log.csv\"\n";
    let files = [("model.toml", model), ("campaign.toml", campaign), ("log.csv", log.as_str())];
    let folder = Folder::new("roof", &files);
    let opened = open(&Request::new([&*folder])).unwrap();
    let found = calibrate(opened.problem, &Options::default()).unwrap();
    assert_eq!(found.fit.outcome, Outcome::Converged);
    let estimates = found.estimates();
    let value = |name: &str| estimates.iter().find(|one| one.name == name).unwrap().value;
    assert_eq!(value("yaw"), None);
    assert!((value("height").unwrap() - 1.8).abs() < 0.02, "{:?}", value("height"));
    assert!((value("pitch").unwrap() - 0.03).abs() < 0.002, "{:?}", value("pitch"));
}
