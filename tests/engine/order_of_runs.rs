//! The order of runs in time, where times go on and where clocks begin anew.

use std::fmt::Write as _;

use homepoint::engine::open::{Request, open};

use crate::folder::Folder;

/// The order of runs of 10 s, each in a setup from a time (s) on.
fn order(runs: &[(&str, f64)]) -> Vec<usize> {
    let model = "name = \"scale\"\ntitle = \"Scale\"\n[parameters]\nzero = { unit = \"m\" }\n\
                 [measurands]\nread = { value = 'zero', unit = \"m\" }\n";
    let mut campaign =
        "title = \"Scale\"\nmodel = \"scale.toml\"\n[measurands]\nread = { sigma = \"1 um\" }\n"
            .to_owned();
    let mut files = vec![("scale.toml".to_owned(), model.to_owned())];
    for (number, (setup, begin)) in runs.iter().enumerate() {
        let mut log = "time [s],read [um]\n".to_owned();
        for at in 0..=10 {
            writeln!(log, "{},{at}", begin + f64::from(at)).unwrap();
        }
        files.push((format!("run_{number}.csv"), log));
        let run = format!("name = \"run_{number}\"\ndata = \"run_{number}.csv\"");
        writeln!(campaign, "[[runs]]\n{run}\nsetup = \"{setup}\"").unwrap();
    }
    files.push(("campaign.toml".to_owned(), campaign));
    let files: Vec<(&str, &str)> = files.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let folder = Folder::new("order", &files);
    open(&Request::new([&*folder])).unwrap().problem.order_in_time()
}

#[test]
fn runs_of_one_clock_are_in_its_order() {
    assert_eq!(order(&[("A", 40.0), ("B", 0.0), ("A", 20.0)]), [2, 0, 1]);
}

/// The instrument stands in one setup at a time.
#[test]
fn setups_whose_clocks_begin_anew_follow_each_other() {
    let runs = [("A", 0.0), ("A", 20.0), ("B", 0.0), ("B", 20.0)];
    assert_eq!(order(&runs), [0, 1, 2, 3]);
    let runs = [("A", 20.0), ("A", 0.0), ("B", 0.0), ("B", 20.0)];
    assert_eq!(order(&runs), [1, 0, 2, 3]);
}

#[test]
fn runs_whose_clocks_begin_anew_are_in_the_order_in_which_they_are_stated() {
    assert_eq!(order(&[("A", 0.3), ("A", 0.0), ("A", 0.1)]), [0, 1, 2]);
}
