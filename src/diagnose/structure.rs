//! Unknown structure: what an effect that nobody wrote down could look like, as effects made here.
//!
//! A block is a displacement of the target, its pedestal or the rig, an error in the time of a reading or an error
//! of the reading itself, as a free function of one covariate: an angle (waves up to an order), a rate, the
//! sense of rotation, time, setup, run. Blocks are effects like any other and go through the same
//! machine; the best of them says where the unknown sits. (A plain Fourier series in the arm angle
//! would miss clocks and platforms.) Those whose scale nobody knows are families: `waves`.

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
use super::waves;

/// Waves over a signal, where there are few signals and where there are many.
pub(super) const ORDERS: (usize, usize) = (8, 3);
/// Signals that count as few.
pub(super) const FEW: usize = 2;
/// Waves over the reading of a circle.
const CIRCLE_ORDERS: usize = 4;
/// The covariate of a block with a value for each run.
const RUN: &str = "run";
/// The covariate of what a setup does in its course.
const TIME: &str = "time";
/// The covariate of a wave in time with phases of each run's own.
pub(super) const OSCILLATION: &str = "oscillation";
/// Where the instrument and the rig stand to each other, in models that know it.
const POSITION: &str = "position";
/// Waves of an error in time.
const TIMING_ORDERS: usize = 2;

/// Where unknown structure sits.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The measurand whose reading or time is wrong, or the channel (`target tangential`).
    pub of: Of,
    /// What it is a function of.
    pub covariate: String,
    /// A phrase; `{member}` stands for the member of a family.
    pub words: String,
}

impl Place {
    /// Whether it is a value for each run.
    pub fn is_of_runs(&self) -> bool {
        self.covariate == RUN
    }

    /// Whether it is a wave in time.
    pub fn is_oscillation(&self) -> bool {
        self.covariate == OSCILLATION
    }

    /// A displacement of the instrument, or of all that it looks at.
    fn of_the_rig(covariate: &str, when: &str) -> Self {
        Self {
            of: Of::Channel("rig".to_owned()),
            covariate: covariate.to_owned(),
            words: format!("a displacement of the instrument or the rig {when}"),
        }
    }

    /// Where the rig was displaced between a run and the one before it.
    pub(super) fn before_run(name: &str) -> Self {
        Self::of_the_rig(RUN, &format!("before run `{name}`"))
    }

    /// Of a family, with the member that was found.
    pub fn at(&self, member: f64) -> Self {
        let digits = (2.0 - member.abs().log10().floor()).clamp(0.0, 6.0) as usize;
        let mut text = format!("{member:.digits$}");
        if digits > 0 {
            text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
        }
        Self { words: self.words.replace("{member}", &text), ..self.clone() }
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
pub(super) struct Covariate {
    name: String,
    /// What it is over, and the same in a phrase.
    over: String,
    words: String,
    terms: Vec<(String, Dimension)>,
    scope: &'static str,
    /// The line of the family that the terms name; empty without.
    family: String,
}

impl Covariate {
    fn new(name: impl Into<String>, scope: &'static str, terms: Vec<(String, Dimension)>) -> Self {
        let name = name.into();
        let (over, words, family) = (name.clone(), name.clone(), String::new());
        Self { name, over, words, terms, scope, family }
    }

    /// Waves of one of the orders that a line says, by its name.
    pub(super) fn family(angle: &str, order: &str, family: String) -> Self {
        Self {
            over: angle.to_owned(),
            words: format!("{angle}, {{member}} waves a turn"),
            family,
            ..Self::new(format!("fine {angle}"), "instrument", wave(&format!("{order} * {angle}")))
        }
    }

    /// Waves over a setup of one of the periods that a line says, by its name.
    pub(super) fn swing(period: &str, family: String) -> Self {
        let phase = format!("2 * pi * setup_time / {period}");
        Self {
            over: TIME.to_owned(),
            words: format!("{TIME}, a wave every {{member}} s"),
            family,
            ..Self::new("slow time", "setup", wave(&phase))
        }
    }

    /// Each of its terms along each axis.
    fn along_axes(self) -> Self {
        let axes = ["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"];
        let along =
            |axis| self.terms.iter().map(move |(term, of)| (format!("{term} * {axis}"), *of));
        let terms = axes.into_iter().flat_map(along).collect();
        Self { terms, ..self }
    }

    fn waves(name: &str, orders: usize) -> Self {
        let pair = |order: usize| wave(&format!("{order} * {name}"));
        Self::new(name, "instrument", (1..=orders).flat_map(pair).collect())
    }
}

/// A wave as a cosine and a sine.
fn wave(phase: &str) -> Vec<(String, Dimension)> {
    ["cos", "sin"].map(|wave| (format!("{wave}({phase})"), Dimension::NONE)).to_vec()
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
    rig(model, &mut all);
    pedestal(model, &mut all);
    timing(model, &mut all);
    readings(model, &mut all);
    all.extend(waves::in_time(model));
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
        let angle = turns(&signal.unit);
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
    all.push(over_time());
    let run_time = vec![("run_time".to_owned(), Dimension::TIME)];
    all.push(Covariate::new("run time", "instrument", run_time));
    all.push(Covariate::new("setup", "setup", vec![("1".to_owned(), Dimension::NONE)]));
    all.push(Covariate::new(RUN, "run", vec![("1".to_owned(), Dimension::NONE)]));
    all
}

/// The course of a setup.
fn over_time() -> Covariate {
    let powers =
        [("setup_time", Dimension::TIME), ("setup_time^2", Dimension::TIME * Dimension::TIME)];
    let powers = powers.map(|(power, dimension)| (power.to_owned(), dimension));
    Covariate::new(TIME, "setup", powers.to_vec())
}

/// Whether a signal of this unit is an angle.
pub(super) fn turns(unit: &Unit) -> bool {
    unit.dimension == Dimension::NONE && unit.symbol != "1"
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

/// The directions in which a target may be displaced, by channel; none where a model has no target.
fn directions(model: &Model) -> &'static [(&'static str, &'static str)] {
    let has = |name: &str| model.quantities.contains_key(name);
    match (has("target"), has("arm_turn")) {
        (false, _) => &[],
        (true, true) => &[
            ("target tangential", "rotate(arm_turn, [0, 1, 0])"),
            ("target radial", "rotate(arm_turn, [1, 0, 0])"),
            ("target axial", "[0, 0, 1]"),
        ],
        (true, false) => {
            &[("target x", "[1, 0, 0]"), ("target y", "[0, 1, 0]"), ("target z", "[0, 0, 1]")]
        }
    }
}

/// Displacements of the target.
fn channels(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    for (channel, direction) in directions(model) {
        let mut covariates = of_the_rig(model, false);
        covariates.extend(waves::over_signals(model));
        covariates.push(waves::slow());
        for covariate in covariates {
            let place = Place {
                of: Of::Channel((*channel).to_owned()),
                words: displacement(channel, &covariate.words),
                covariate: covariate.over.clone(),
            };
            let patch = |sum: &str| format!("target = 'target + ({sum}) * {direction}'");
            all.extend(effect(&place, &covariate, Dimension::LENGTH, patch));
        }
    }
}

/// Displacements of the instrument, or of all that it looks at, in the course of a setup.
fn rig(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    if !model.parameters.iter().any(|one| one.name == POSITION) {
        return;
    }
    for covariate in [over_time(), waves::slow()].map(Covariate::along_axes) {
        let place = Place::of_the_rig(&covariate.over, &format!("over {}", covariate.words));
        let patch = |sum: &str| format!("{POSITION} = '{POSITION} + {sum}'");
        all.extend(effect(&place, &covariate, Dimension::LENGTH, patch));
    }
}

/// Displacements of the rig by what moves: its pedestal gives way to imbalance and torque, in directions of its
/// own, which are others in each setup for the instrument.
fn pedestal(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    let signals: Vec<_> = model.inputs.iter().filter(|input| input.signal).collect();
    if directions(model).is_empty() || signals.len() > FEW {
        return;
    }
    let names: Vec<&str> = signals.iter().map(|signal| signal.name.as_str()).collect();
    let moves = |one: &Covariate| names.iter().any(|name| one.name.ends_with(name));
    for covariate in of_the_rig(model, true).into_iter().filter(moves).map(Covariate::along_axes) {
        let place = Place {
            of: Of::Channel("pedestal".to_owned()),
            covariate: covariate.over.clone(),
            words: format!("a displacement of the rig's pedestal over {}", covariate.words),
        };
        let patch = |sum: &str| format!("target = 'target + {sum}'");
        all.extend(effect(&place, &covariate, Dimension::LENGTH, patch));
    }
}

fn displacement(channel: &str, covariate: &str) -> String {
    let direction = channel.trim_start_matches("target ");
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
        covariates.push(waves::slow());
        if matches!(measurand.kind, MeasurandKind::Angle { .. }) {
            covariates.push(waves::over_circle(name, CIRCLE_ORDERS));
        }
        for covariate in covariates {
            let place = Place {
                of: Of::Measurand(name.clone()),
                words: format!("an error of `{name}` over {}", covariate.words),
                covariate: covariate.over.clone(),
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
    let part = |number: usize| format!("part_{number}");
    let coefficients: Vec<(String, Dimension)> = (0..)
        .zip(&covariate.terms)
        .map(|(number, (_, of))| (part(number), dimension / *of))
        .collect();
    let terms = (0..).zip(&covariate.terms);
    let sum: Vec<String> = terms.map(|(n, (term, _))| format!("{} * {term}", part(n))).collect();
    made(
        &format!("unknown_{kind}_{of}_{}", covariate.name),
        place,
        (&coefficients, covariate.scope),
        &covariate.family,
        &patch(&sum.join(" + ")),
    )
}

/// An effect that nobody wrote down: coefficients with their dimensions and scope, the line of its
/// family, if it has one, and its patches.
pub(super) fn made(
    name: &str,
    place: &Place,
    (coefficients, scope): (&[(String, Dimension)], &str),
    family: &str,
    patches: &str,
) -> Option<(Arc<Effect>, Place)> {
    let name: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    let mut text =
        format!("name = \"{name}\"\ntitle = \"{}\"\nacts = \"noise\"\n[parameters]\n", place.words);
    for (coefficient, dimension) in coefficients {
        let unit = Unit::coherent(*dimension).si_symbol();
        let written = writeln!(
            text,
            "{coefficient} = {{ unit = \"{unit}\", typical = \"1 {unit}\", scope = \"{scope}\" }}"
        );
        written.ok()?;
    }
    let shape = if family.is_empty() { "" } else { "[shape]\n" };
    text.push_str(&format!("[patch]\n{patches}\n{shape}{family}\n"));
    let effect = Effect::parse(Source::new(name, text)).ok()?;
    Some((Arc::new(effect), place.clone()))
}
