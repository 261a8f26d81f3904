//! A campaign of files that a test has written, diagnosed.

use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::{Diagnosis, diagnose};
use homepoint::engine::open::{Opened, Request, open};

use crate::folder::Folder;

/// The diagnosis of a campaign of these files (name, text).
pub(crate) fn diagnosed(files: &[(String, String)]) -> Diagnosis {
    let named: Vec<(&str, &str)> = files.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let folder = Folder::new("written", &named);
    let Opened { problem, recipes, .. } = open(&Request::new([&*folder])).unwrap();
    diagnose(problem, recipes, &Wanted::default(), &Default::default()).unwrap()
}
