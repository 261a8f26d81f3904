//! How long does it take from a model's text to a campaign part that can be evaluated? Meant to
//! stay below a millisecond, so that a model is text at no price.
//!
//! The polar instrument with three effects; reading the whole effect library beside it. No data.

#[path = "by_hand/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod by_hand;
#[path = "by_hand/timing.rs"]
mod timing;

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

use by_hand::data::{EFFECTS, SIGMA};
use by_hand::process::say;
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::effect::Effect;
use homepoint::engine::Part;
use homepoint::library::{Library, embedded};
use homepoint::model::Model;
use homepoint::system::{Selected, System};
use timing::{Way, compare, criterion};

/// What it may take.
const GOAL: Duration = Duration::from_millis(1);

fn text<'t>(of: &'t [(&'t str, &'t str)], name: &str) -> &'t str {
    of.iter().find(|(stem, _)| *stem == name).map_or("", |(_, text)| *text)
}

/// Reads the model's and the effects' files and makes a part.
fn load() -> Result<Part, Diagnostics> {
    let source = |of, name| Source::new(format!("{name}.toml"), black_box(text(of, name)));
    let model = Model::parse(source(embedded::MODELS, "polar_one_rotation"))?;
    let mut selected = Vec::new();
    for name in EFFECTS {
        let effect = Effect::parse(source(embedded::EFFECTS, name))?.into();
        selected.push(Selected { effect, head: None, member: Default::default() });
    }
    let system = System::build(&model, &selected, &[], &[None])?;
    Ok(Part::new(system, Vec::new(), Vec::new(), SIGMA.to_vec()))
}

/// The same through the library, which reads every effect.
fn load_with_library() -> Result<Part, Diagnostics> {
    let library = Library::builtin()?;
    let model = library.model("polar_one_rotation", Path::new("."))?;
    let selected =
        EFFECTS.iter().map(|name| library.select(name)).collect::<Result<Vec<_>, _>>()?;
    let system = System::build(&model, &selected, &[], &[None])?;
    Ok(Part::new(system, Vec::new(), Vec::new(), SIGMA.to_vec()))
}

fn main() -> Result<(), Box<dyn Error>> {
    load()?;
    load_with_library()?;
    let mut ways = [
        Way::new("model and effects", || drop(black_box(load()))),
        Way::new("with the whole library", || drop(black_box(load_with_library()))),
    ];
    let seconds = compare(&mut criterion(), "model load", (1, "load"), &mut ways)?;
    let share = seconds[0] / GOAL.as_secs_f64();
    say(&format!("  model and effects take {share:.2} of the goal, 1 ms\n"))?;
    Ok(())
}
