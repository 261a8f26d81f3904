//! A recorder that is started anew for each run has another delay in each: one delay for all of them comes
//! with a warning.

use std::fmt::Write as _;

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::between_runs::delays_that_differ;
use homepoint::estimate::calibrate::calibrate;

use crate::folder::Folder;
use crate::stream::Stream;

/// Delays of the runs of a pan head that sees a tag (s), and how far the tag's bearing is off in the last
/// one (rad).
fn differing(late: &[f64], knocked: f64) -> Vec<(String, usize, f64)> {
    let mut random = Stream(37);
    let pan = |t: f64| 0.9 * (0.8 * t).sin() + 0.3 * (2.1 * t + 0.4).sin();
    let mut campaign =
        "title = \"Pan\"\nmodel = \"model.toml\"\n[measurands]\nyaw = { sigma = \"2 mrad\" }\n"
            .to_owned();
    let model = "name = \"pan\"\ntitle = \"Pan head\"\n[inputs]\npan = { unit = \"rad\", signal = true }\n\
         [parameters]\nzero = { unit = \"rad\" }\n[measurands]\nyaw = { value = 'pan + zero', unit = \"rad\" }\n";
    let mut files = vec![("model.toml".to_owned(), model.to_owned())];
    for (run, late) in late.iter().enumerate() {
        let off = if run + 1 == 4 { knocked } else { 0.0 };
        let mut stream = "time [s],pan [rad]\n".to_owned();
        let mut readings = "time [s],yaw [rad]\n".to_owned();
        for step in 0..1500 {
            let t = 0.02 * f64::from(step);
            writeln!(stream, "{t:.2},{:.7}", pan(t)).unwrap();
            if step % 3 == 0 && (100..1400).contains(&step) {
                let yaw = pan(t - late) + 0.2 + off + 2e-3 * random.normal();
                writeln!(readings, "{t:.2},{yaw:.6}").unwrap();
            }
        }
        files.extend([(format!("s{run}.csv"), stream), (format!("r{run}.csv"), readings)]);
        writeln!(
            campaign,
            "[[runs]]\nname = \"{run}\"\ndata = \"r{run}.csv\"\nsignals = [\"s{run}.csv\"]"
        )
        .unwrap();
    }
    files.push(("campaign.toml".to_owned(), campaign));
    let files: Vec<(&str, &str)> = files.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let folder = Folder::new("delays_of_runs", &files);
    let opened = open(&Request::new([&*folder])).unwrap();
    let fit = calibrate(opened.problem, &Options::default()).unwrap();
    let found = delays_that_differ(&fit);
    found.into_iter().map(|one| (one.name, one.runs, one.scatter)).collect()
}

#[test]
fn a_delay_that_differs_between_runs_gives_a_warning() {
    let found = differing(&[0.03, 0.042, 0.021, 0.037], 0.0);
    assert_eq!(found.len(), 1, "{found:?}");
    let (name, runs, scatter) = &found[0];
    assert_eq!((name.as_str(), *runs), ("yaw.delay", 4));
    // The standard deviation of the four.
    assert!((scatter - 9.11e-3).abs() < 5e-4, "{scatter}");
    // One delay; a run whose bearing is off, which is no delay.
    assert!(differing(&[0.03; 4], 0.0).is_empty());
    assert!(differing(&[0.03; 4], 0.01).is_empty());
}
