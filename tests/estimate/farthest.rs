//! Where the largest residuals of a bad fit are: in the rows that are wrong; nowhere where the model is.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::farthest::{Farthest, farthest};

use crate::folder::Folder;
use crate::problems::Stream;

/// A line through readings, with an error by row.
fn of(error: impl Fn(usize) -> f64) -> Option<Farthest> {
    let mut random = Stream(41);
    let mut log = "x [m],y [m]\n".to_owned();
    for row in 0..500 {
        let x = random.uniform();
        log.push_str(&format!(
            "{x:.6},{:.6}\n",
            2.0 * x + 0.3 + error(row) + 1e-3 * random.normal()
        ));
    }
    let model = "name = \"line\"\ntitle = \"Line\"\n[inputs]\nx = { unit = \"m\" }\n\
         [parameters]\nslope = { unit = \"1\" }\nzero = { unit = \"m\" }\n\
         [measurands]\ny = { value = 'slope * x + zero', unit = \"m\" }\n";
    let campaign = "title = \"Line\"\nmodel = \"model.toml\"\n[measurands]\ny = { sigma = \"1 mm\" }\n\
         [[runs]]\nname = \"one\"\ndata = \"log.csv\"\n";
    let files = [("model.toml", model), ("campaign.toml", campaign), ("log.csv", log.as_str())];
    let folder = Folder::new("farthest", &files);
    let opened = open(&Request::new([&*folder])).unwrap();
    farthest(&calibrate(opened.problem, &Options::default()).unwrap())
}

#[test]
fn the_largest_residuals_are_in_the_rows_that_are_wrong() {
    let wrong = |row: usize| if (100..110).contains(&row) || row == 300 { 0.5 } else { 0.0 };
    let found = of(wrong).unwrap();
    assert_eq!((found.run.as_str(), found.measurand.as_str()), ("one", "y"));
    assert_eq!(found.rows, [(102, 111), (302, 302)]);
}

#[test]
fn a_model_that_is_wrong_has_none() {
    assert_eq!(of(|row| 0.4 * (0.05 * row as f64).sin()), None);
}
