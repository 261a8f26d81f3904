//! A straight line read at given places, once each: the closed forms are in every book.

use std::fmt::Write;

use homepoint::engine::Problem;
use homepoint::engine::open::{Request, open};

use crate::folder::Folder;

/// Its model.
const MODEL: &str = "name = \"line\"\n[inputs]\nx = { unit = \"m\" }\n\
    [parameters]\nslope = { unit = \"1\", scope = \"rig\" }\nheight = { unit = \"m\", scope = \"rig\" }\n\
    [measurands]\ny = { value = 'slope * x + height', unit = \"m\" }\n";

/// Readings at times (s) and places (m), with a standard uncertainty of 1 m each.
pub(crate) fn line(samples: impl Iterator<Item = (f64, f64, f64)>) -> (Folder, Problem) {
    let mut text = String::from("time [s],x [m],y [m]\n");
    for (time, x, y) in samples {
        writeln!(text, "{time},{x},{y}").unwrap();
    }
    let campaign = "title = \"Line\"\nmodel = \"line.toml\"\n[measurands]\ny = { sigma = \"1 m\" }\n\
        [[runs]]\nname = \"run\"\ndata = \"run.csv\"\n";
    let files = [("campaign.toml", campaign), ("line.toml", MODEL), ("run.csv", &text)];
    let folder = Folder::new("line", &files);
    let problem = open(&Request::new([&*folder])).unwrap().problem;
    (folder, problem)
}
