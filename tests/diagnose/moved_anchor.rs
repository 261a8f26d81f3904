//! What was mounted anew before one run stands elsewhere in all of its coordinates.

use std::fmt::Write as _;

use homepoint::engine::open::{Request, open};

use crate::drawn::run;
use crate::found::told;
use crate::stream::Stream;

const ROBOT: &str = r#"
name = "cables"
title = "Two cables of a robot, length by drum encoders"
[inputs]
px = { unit = "m" }
py = { unit = "m" }
pz = { unit = "m" }
[parameters]
zero_1 = { unit = "m" }
zero_2 = { unit = "m" }
anchor = { kind = "vector", unit = "m", start = ["5 m", "4 m", "2.9 m"] }
[measurands]
first = { value = 'norm([px, py, pz] - [0 m, 0 m, 3 m]) + zero_1', unit = "m" }
second = { value = 'norm([px, py, pz] - anchor) + zero_2', unit = "m" }
"#;

#[test]
fn a_vector_that_changed_in_one_run_has_all_its_components() {
    for seed in [5, 6, 7] {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        let mut stream = Stream(seed);
        let mut campaign = "title = \"Cables\"\nmodel = \"model.toml\"\n[measurands]\n\
             first = { sigma = \"0.6 mm\" }\nsecond = { sigma = \"0.6 mm\" }\n"
            .to_owned();
        for day in 0..4 {
            let mut log = "px [m],py [m],pz [m],first [m],second [m]\n".to_owned();
            let moved = if day == 2 { [4e-3, -6e-3, 0.0] } else { [0.0; 3] };
            for _ in 0..150 {
                let p = [4.0, 3.0, 1.8].map(|to: f64| 0.5 + to * stream.uniform());
                let to = |anchor: [f64; 3]| -> f64 {
                    (0..3).map(|k| (p[k] - anchor[k]).powi(2)).sum::<f64>().sqrt()
                };
                let first = to([0.0, 0.0, 3.0]) + 0.02 + 6e-4 * stream.normal();
                let at = [0, 1, 2].map(|k| [5.01, 3.99, 2.905][k] + moved[k]);
                let second = to(at) - 0.01 + 6e-4 * stream.normal();
                writeln!(log, "{},{},{},{first:.6},{second:.6}", p[0], p[1], p[2]).unwrap();
            }
            write(&format!("day_{day}.csv"), &log);
            writeln!(campaign, "[[runs]]\nname = \"day_{day}\"\ndata = \"day_{day}.csv\"").unwrap();
        }
        write("model.toml", ROBOT);
        write("campaign.toml", &campaign);
        let opened = open(&Request::new([folder.path().to_owned()])).unwrap();
        let found = run(opened.problem.clone(), &opened);
        assert!(found.remainder.len() >= 2, "{}", told(&found));
        for part in &found.remainder {
            let (words, change) = (&part.place.words, part.change.as_ref().unwrap());
            assert!(words.contains("`anchor.") && words.ends_with("in run `day_2`"), "{words}");
            let axis = ["x", "y", "z"].iter().position(|k| words.contains(&format!("anchor.{k}")));
            let far = change.value - [4e-3, -6e-3, 0.0][axis.unwrap()];
            assert!(far.abs() < 4.0 * change.sigma, "{words}: {change:?}, {}", told(&found));
        }
    }
}
