//! Unknown structure: what an effect that nobody wrote down could look like, as effects made here.
//!
//! A block is a displacement of the target, an error in the time of a reading or an error of the
//! reading itself, as a free function of one covariate: an angle (waves up to an order), a rate, the
//! sense of rotation, time, setup, run. Blocks are effects like any other and go through the same
//! machine; the best of them says where the unknown sits. (A plain Fourier series in the arm angle
//! would miss clocks and platforms.)

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use crate::diagnostic::Source;
use crate::effect::Effect;
use crate::engine::open::Recipe;
use crate::graph::MeasurandKind;
use crate::model::Model;
use crate::system::Selected;
use crate::units::{Dimension, Unit};

use super::candidates::{Candidate, join};

/// Waves over a signal, where there are few signals and where there are many.
const ORDERS: (usize, usize) = (8, 3);
/// Signals that count as few.
const FEW: usize = 2;
/// Waves over the reading of a circle.
const CIRCLE_ORDERS: usize = 4;
/// The covariate of a block with a value for each run.
const RUN: &str = "run";
/// Waves of an error in time.
const TIMING_ORDERS: usize = 2;

/// Where unknown structure sits.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The measurand whose reading or time is wrong, or the channel (`target tangential`).
    pub of: Of,
    /// What it is a function of.
    pub covariate: String,
    /// A phrase.
    pub words: String,
}

impl Place {
    /// Whether each run has a value for itself.
    pub fn is_of_runs(&self) -> bool {
        self.covariate == RUN
    }
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq)]
pub enum Of {
    /// The reading of a measurand.
    Measurand(String),
    /// A part of the rig, or the time of a reading.
    Channel(String),
}

/// A covariate: terms with their dimension, one coefficient each.
#[derive(Clone)]
struct Covariate {
    name: String,
    terms: Vec<(String, Dimension)>,
    scope: &'static str,
}

impl Covariate {
    fn new(name: impl Into<String>, scope: &'static str, terms: Vec<(String, Dimension)>) -> Self {
        Self { name: name.into(), terms, scope }
    }

    fn waves(name: &str, orders: usize) -> Self {
        let pair = |order: usize| {
            ["cos", "sin"].map(|wave| (format!("{wave}({order} * {name})"), Dimension::NONE))
        };
        Self::new(name, "instrument", (1..=orders).flat_map(pair).collect())
    }
}

/// The blocks of the campaigns' models.
pub fn blocks(recipes: &[Recipe]) -> Vec<Candidate> {
    let mut found: Vec<Candidate> = Vec::new();
    for (campaign, recipe) in recipes.iter().enumerate() {
        for (effect, place) in effects(&recipe.model) {
            let selected = Selected { effect, head: None, member: BTreeMap::new() };
            if let Ok(system) = recipe.with(std::slice::from_ref(&selected)) {
                join(&mut found, (campaign, recipes.len()), selected, Some(place), system);
            }
        }
    }
    found
}

fn effects(model: &Model) -> Vec<(Arc<Effect>, Place)> {
    let mut all = Vec::new();
    channels(model, &mut all);
    timing(model, &mut all);
    readings(model, &mut all);
    all
}

/// What moves, and time, setups and runs.
fn of_the_rig(model: &Model, timing: bool) -> Vec<Covariate> {
    let signals: Vec<_> = model.inputs.iter().filter(|input| input.signal).collect();
    let orders = if signals.len() <= FEW { ORDERS.0 } else { ORDERS.1 };
    let mut all = Vec::new();
    for signal in &signals {
        let (name, own) = (&signal.name, signal.unit.dimension);
        let rate = own / Dimension::TIME;
        let angle = own == Dimension::NONE && signal.unit.symbol != "1";
        if angle {
            all.push(Covariate::waves(name, if timing { TIMING_ORDERS } else { orders }));
        }
        let turns = vec![(name.clone(), own), (format!("{name}^2"), own * own)];
        all.push(Covariate::new(
            if angle { format!("turns of {name}") } else { name.clone() },
            "instrument",
            turns,
        ));
        all.push(Covariate::new(
            format!("sense of {name}"),
            "instrument",
            vec![(format!("sign(rate({name}))"), Dimension::NONE)],
        ));
        all.push(Covariate::new(
            format!("rate of {name}"),
            "instrument",
            vec![
                (format!("rate({name})"), rate),
                (format!("abs(rate({name}))"), rate),
                (format!("rate({name})^2"), rate * rate),
            ],
        ));
        all.push(Covariate::new(
            format!("acceleration of {name}"),
            "instrument",
            vec![(format!("rate(rate({name}))"), rate / Dimension::TIME)],
        ));
    }
    let time = Dimension::TIME;
    let clock = vec![("setup_time".to_owned(), time), ("setup_time^2".to_owned(), time * time)];
    all.push(Covariate::new("time", "setup", clock));
    all.push(Covariate::new("run time", "instrument", vec![("run_time".to_owned(), time)]));
    all.push(Covariate::new("setup", "setup", vec![("1".to_owned(), Dimension::NONE)]));
    all.push(Covariate::new(RUN, "run", vec![("1".to_owned(), Dimension::NONE)]));
    all
}

/// What the head does.
fn of_the_head(model: &Model) -> Vec<Covariate> {
    let mut all = Vec::new();
    for measurand in &model.measurands {
        let (name, own) = (&measurand.name, measurand.unit.dimension);
        let rate = own / Dimension::TIME;
        match measurand.kind {
            MeasurandKind::Rotation => continue,
            MeasurandKind::Angle { .. } => all.push(Covariate::waves(name, CIRCLE_ORDERS)),
            MeasurandKind::Plain => all.push(Covariate::new(
                name,
                "instrument",
                vec![(name.clone(), own), (format!("{name}^2"), own * own)],
            )),
        }
        all.push(Covariate::new(
            format!("rate of {name}"),
            "instrument",
            vec![
                (format!("rate({name})"), rate),
                (format!("abs(rate({name}))"), rate),
                (format!("sign(rate({name}))"), Dimension::NONE),
            ],
        ));
        all.push(Covariate::new(
            format!("acceleration of {name}"),
            "instrument",
            vec![(format!("rate(rate({name}))"), rate / Dimension::TIME)],
        ));
    }
    all
}

/// Displacements of the target.
fn channels(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    let has = |name: &str| model.quantities.contains_key(name);
    if !has("target") {
        return;
    }
    let directions = if has("arm_turn") {
        [
            ("target tangential", "rotate(arm_turn, [0, 1, 0])"),
            ("target radial", "rotate(arm_turn, [1, 0, 0])"),
            ("target axial", "[0, 0, 1]"),
        ]
    } else {
        [("target x", "[1, 0, 0]"), ("target y", "[0, 1, 0]"), ("target z", "[0, 0, 1]")]
    };
    for (channel, direction) in directions {
        for covariate in of_the_rig(model, false) {
            let place = Place {
                of: Of::Channel(channel.to_owned()),
                words: displacement(channel.trim_start_matches("target "), &covariate.name),
                covariate: covariate.name.clone(),
            };
            let patch = |sum: &str| format!("target = 'target + ({sum}) * {direction}'");
            all.extend(effect(&place, &covariate, Dimension::LENGTH, patch));
        }
    }
}

fn displacement(direction: &str, covariate: &str) -> String {
    let article = if matches!(direction, "axial" | "x") { "an" } else { "a" };
    format!("{article} {direction} displacement of the target over {covariate}")
}

/// Errors in the time of readings: of each measurand, and of all alike, as a clock makes them.
fn timing(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    let names: Vec<&str> = model.measurands.iter().map(|one| one.name.as_str()).collect();
    let mut groups: Vec<(&str, &[&str])> = Vec::new();
    for (number, name) in names.iter().enumerate() {
        groups.push((name, &names[number..=number]));
    }
    if names.len() > 1 {
        groups.push(("all readings", &names));
    }
    for (of, names) in groups {
        let called = if names.len() > 1 { of.to_owned() } else { format!("`{of}`") };
        for covariate in of_the_rig(model, true) {
            let place = Place {
                of: Of::Channel(format!("time of {of}")),
                words: format!("a timing error of {called} over {}", covariate.name),
                covariate: covariate.name.clone(),
            };
            let patch = |sum: &str| {
                let line = |name: &&str| format!("\"{name}.t\" = 't + {sum}'\n");
                names.iter().map(line).collect()
            };
            all.extend(effect(&place, &covariate, Dimension::TIME, patch));
        }
    }
}

/// Errors of readings.
fn readings(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    for measurand in &model.measurands {
        let name = &measurand.name;
        if measurand.kind == MeasurandKind::Rotation {
            continue;
        }
        let mut covariates = of_the_rig(model, false);
        covariates.extend(of_the_head(model));
        for covariate in covariates {
            let place = Place {
                of: Of::Measurand(name.clone()),
                words: format!("an error of `{name}` over {}", covariate.name),
                covariate: covariate.name.clone(),
            };
            let patch = |sum: &str| format!("{name} = '{name} + {sum}'");
            all.extend(effect(&place, &covariate, measurand.unit.dimension, patch));
        }
    }
}

/// A block as an effect: the sum of coefficients times terms, put into a patch.
fn effect(
    place: &Place,
    covariate: &Covariate,
    dimension: Dimension,
    patch: impl Fn(&str) -> String,
) -> Option<(Arc<Effect>, Place)> {
    let (Of::Measurand(of) | Of::Channel(of)) = &place.of;
    let kind = if matches!(place.of, Of::Measurand(_)) { "reading" } else { "channel" };
    let name: String = format!("unknown_{kind}_{of}_{}", covariate.name)
        .chars()
        .map(|c| if c.is_alphanumeric() { c } else { '_' })
        .collect();
    let mut text =
        format!("name = \"{name}\"\ntitle = \"{}\"\nacts = \"noise\"\n[parameters]\n", place.words);
    let mut sum = Vec::new();
    for (number, (term, of)) in covariate.terms.iter().enumerate() {
        let unit = Unit::coherent(dimension / *of).si_symbol();
        let scope = covariate.scope;
        let written = writeln!(
            text,
            "part_{number} = {{ unit = \"{unit}\", typical = \"1 {unit}\", scope = \"{scope}\" }}"
        );
        written.ok()?;
        sum.push(format!("part_{number} * {term}"));
    }
    text.push_str("[patch]\n");
    text.push_str(&patch(&sum.join(" + ")));
    text.push('\n');
    let effect = Effect::parse(Source::new(name, text)).ok()?;
    Some((Arc::new(effect), place.clone()))
}
