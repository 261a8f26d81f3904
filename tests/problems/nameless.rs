//! Readings drawn with an effect that no library holds, and their diagnosis.

use std::path::PathBuf;

use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::library::place::Place;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::{Diagnosis, diagnose};
use homepoint::engine::layout::Instance;
use homepoint::engine::open::Request;
use homepoint::estimate::batch::Options;

use crate::drawn::{drawn_at, folder};
use crate::found::told;

/// The diagnosis of readings drawn with an effect that nobody knows there, with values as said.
pub(crate) fn with_a_nameless(
    text: &str,
    seed: u64,
    value: &dyn Fn(&Instance) -> f64,
) -> Diagnosis {
    with_a_nameless_and_without(&[], text, seed, value)
}

/// The same without some effects of the library.
pub(crate) fn with_a_nameless_and_without(
    without: &[&str],
    text: &str,
    seed: u64,
    value: &dyn Fn(&Instance) -> f64,
) -> Diagnosis {
    with_a_nameless_in(folder(), without, text, seed, value)
}

/// The same of an example.
pub(crate) fn with_a_nameless_in(
    campaign: PathBuf,
    without: &[&str],
    text: &str,
    seed: u64,
    value: &dyn Fn(&Instance) -> f64,
) -> Diagnosis {
    let own = tempfile::tempdir().unwrap();
    let whole = format!("name = \"nameless\"\ntitle = \"Nameless\"\nacts = \"arm\"\n{text}");
    std::fs::write(own.path().join("nameless.toml"), whole).unwrap();
    let mut request = Request::new([campaign]);
    request.effects = vec![own.path().to_owned()];
    request.with = vec!["nameless".to_owned()];
    let (opened, problem) =
        drawn_at(&request, seed, &|one| (!one.setting.fixed).then(|| value(one)));
    let without: Vec<String> = without.iter().map(|name| (*name).to_owned()).collect();
    let wanted = Wanted::new(&[], &without);
    diagnose(problem, opened.recipes, &wanted, &Options::default()).unwrap()
}

pub(crate) fn best_place(found: &Diagnosis) -> &Place {
    assert_eq!(found.verdict, Verdict::Unknown, "{}", told(found));
    &found.remainder[0].place
}
