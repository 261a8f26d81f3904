//! Power: what a campaign can see, confuse or not see, from its design alone.
//!
//! For each effect of the library the size that enters a budget, and the size that is a row of it
//! and leads all other effects, with probability [`sight::CAUGHT`] at the thresholds of the
//! diagnosis ([`super::thresholds`]); the shift of each delay that an effect of the detectable size
//! causes while it is not in the model; and what would help. All of it follows from one pass over
//! the design: the noncentrality of the test that will be made is the squared length of the
//! effect's signature (Cox and Hinkley, *Theoretical Statistics*, 9.3).
//!
//! | file | answers |
//! |---|---|
//! | [`mod@design`] | predicted readings, the library before them, how well delays will be known |
//! | `detection` | how often an effect of some length enters, is named, and leads |
//! | [`mod@sight`] | sizes, from the columns of one pass |
//! | `noise` | the same for effects on the noise |
//! | `remedies` | what would be added to a campaign, tried |
//! | `words` | a sentence for each row |
//! | `alias_words` | what separates aliases, the same in both rows |
//!
//! It is linear: sizes far beyond the typical ones are extrapolated. Structure outside the library
//! has no size and is not in it.

mod alias_words;
pub mod design;
mod detection;
mod noise;
mod remedies;
pub mod sight;
mod words;

use std::collections::BTreeMap;

use design::{DelaySigma, Prospect, delay_rows, delays};
use detection::critical_gains;
use remedies::remedies;
use sight::{Way, shift, sight};

use crate::engine::open::Recipe;
use crate::engine::{Point, Problem};
use crate::estimate::batch::FitError;
use crate::estimate::calibrate::{Calibration, finish};
use crate::units::Unit;

use super::budget::absorbed::{acts_as, why_silent};
use super::evidence::scan::members;
use super::library::wanted::Wanted;

/// An effect that is seen only beyond so many times its usual size does not act.
const BEYOND: f64 = 1e4;

/// What a campaign makes of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// It is seen, and named if it is large enough.
    Visible,
    /// It is seen, but others do the same.
    Alias,
    /// Nominal parameters take it up.
    Absorbed,
    /// It changes no reading, or needs what is not there.
    NotTestable,
}

impl State {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Visible => "visible",
            Self::Alias => "alias",
            Self::Absorbed => "absorbed",
            Self::NotTestable => "not_testable",
        }
    }
}

/// One effect of the library before a campaign.
#[derive(Clone, Debug)]
pub struct Row {
    /// The effect, with its head.
    pub name: String,
    /// What the campaign makes of it.
    pub state: State,
    /// Unit in which sizes are read; that of the effect's first parameter.
    pub unit: Unit,
    /// The usual size (SI).
    pub typical: Option<f64>,
    /// The size that enters a budget (SI).
    pub detectable: Option<f64>,
    /// The size that is a row of a budget and leads other effects (SI).
    pub identifiable: Option<f64>,
    /// Effects that do the same or nearly so; of an absorbed one the parameters that take it up.
    pub with: Vec<String>,
    /// The detectable size of each member of a family.
    pub members: Vec<(BTreeMap<String, f64>, f64)>,
    /// The largest shift of each delay (s) by an effect of the detectable size outside the model.
    pub shifts: Vec<(String, f64)>,
    /// The size falls with the number of readings by a root of this order: the second for effects
    /// on the mean and for levels, the fourth for what shows in products of readings, the first for
    /// what is counted.
    pub root: f64,
    /// A sentence to act on.
    pub words: String,
}

impl Row {
    /// An effect of which nothing is known yet.
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            state: State::NotTestable,
            unit: Unit::one(),
            typical: None,
            detectable: None,
            identifiable: None,
            with: Vec::new(),
            members: Vec::new(),
            shifts: Vec::new(),
            root: 2.0,
            words: String::new(),
        }
    }
}

/// The table.
#[derive(Clone, Debug)]
pub struct Power {
    /// What a fit of the design would give.
    pub nominal: Calibration,
    /// One row for each effect: visible ones first.
    pub rows: Vec<Row>,
    /// One for each measurand.
    pub delays: Vec<DelaySigma>,
}

/// What campaigns can see, with their parameters at a point.
///
/// # Errors
/// [`FitError`] if sums do not fit their blocks.
pub fn power(
    problem: Problem,
    recipes: Vec<Recipe>,
    point: Point,
    wanted: &Wanted,
) -> Result<Power, FitError> {
    let fitted = design::design(recipes, problem, point);
    let nominal = finish(fitted.problem.clone(), fitted.fit.clone(), Vec::new(), Vec::new())?;
    let delays = delays(&nominal);
    let mut power = Power { nominal, rows: Vec::new(), delays };
    if !power.nominal.is_sound() {
        return Ok(power);
    }
    let Some(stage) = design::prospect(fitted, wanted) else { return Ok(power) };
    let mut rows = rows(&stage, wanted);
    let is_open = rows.iter().any(|row| row.state != State::Visible);
    let tried = if is_open { remedies(&stage.fitted) } else { Vec::new() };
    let tried = tried.into_iter().filter_map(|(remedy, fitted)| {
        Some((remedy, self::rows(&design::prospect(fitted, wanted)?, wanted)))
    });
    let tried: Vec<(String, Vec<Row>)> = tried.collect();
    for row in &mut rows {
        row.words = words::words(row, &stage, &tried);
    }
    power.rows = rows;
    Ok(power)
}

/// The library's rows before a design, without words.
fn rows(stage: &Prospect, wanted: &Wanted) -> Vec<Row> {
    let ways = stage.candidates.iter().zip(&stage.evidence.entries);
    let ways: Vec<Way<'_>> = ways.map(|(candidate, entry)| Way { candidate, entry }).collect();
    let is_same = |a: &Way<'_>, b: &Way<'_>| a.candidate.name == b.candidate.name;
    let families: Vec<&[Way<'_>]> = ways.chunk_by(is_same).collect();
    let of_family = |own: &&[Way<'_>]| {
        let others = ways.iter().filter(|way| !is_same(way, &own[0]));
        let others: Vec<Way<'_>> = others.filter(|way| way.entry.degrees() > 0).copied().collect();
        let scanned = if own.len() > 1 { members(&stage.fitted, own[0].candidate) } else { None };
        let members = scanned.unwrap_or(own.len());
        let critical_gains = |degrees| critical_gains(degrees, members, families.len());
        row(stage, own, sight(&stage.evidence, own, &others, critical_gains))
    };
    let mut rows: Vec<Row> = families.iter().map(of_family).collect();
    rows.extend(noise::rows(stage, wanted));
    rows.extend(stage.not_testable.iter().map(|one| not_testable(&one.name, one.why.clone())));
    rows.sort_by(|a, b| (a.state as u8, &a.name).cmp(&(b.state as u8, &b.name)));
    rows
}

fn not_testable(name: &str, why: String) -> Row {
    Row { words: why, ..Row::new(name) }
}

/// The row of an effect with its ways, of which there is one at least.
fn row(stage: &Prospect, ways: &[Way<'_>], seen: Row) -> Row {
    let way = ways[0];
    let name = &way.candidate.name;
    let Some(owner) = way.entry.owners.first().filter(|_| ways.iter().any(|w| w.entry.acts()))
    else {
        return not_testable(name, why_silent(&stage.fitted, &way.candidate.selected));
    };
    if ways.iter().any(|way| !way.entry.finite) {
        let why = "the recordings do not hold an input that it acts on, or its slope where its parameters are zero is no number".to_owned();
        return not_testable(name, why);
    }
    let absorbed = ways.iter().all(|way| way.entry.degrees() == 0);
    let typical = way.candidate.typical(&owner.parameter);
    if let Some((size, typical)) =
        seen.detectable.zip(typical).filter(|(size, typical)| *size > BEYOND * typical)
    {
        let times = (size / typical).log10().floor();
        let why = format!(
            "these runs hardly make it act: it would have to be 1e{times} times its usual size"
        );
        return not_testable(name, why);
    }
    let state = match (absorbed, seen.detectable, seen.identifiable) {
        (true, ..) | (_, None, _) => State::Absorbed,
        (_, _, None) => State::Alias,
        _ => State::Visible,
    };
    let with = if absorbed {
        let nominal = acts_as(&stage.fitted, &stage.evidence.takers(way.entry));
        nominal.split(", ").map(str::to_owned).collect()
    } else {
        seen.with
    };
    let shifts = |size: f64| {
        let largest = |row: &[(usize, f64)]| {
            ways.iter().map(|way| size * shift(*way, row)).fold(0.0, f64::max)
        };
        delay_rows(stage).into_iter().map(|(delay, row)| (delay, largest(&row))).collect()
    };
    let declared = way.candidate.unit(&owner.parameter).unwrap_or_else(Unit::one);
    let unit = stage.fitted.unit_of_parameter(&owner.parameter, declared);
    let shifts = seen.detectable.map(shifts).unwrap_or_default();
    Row { state, unit, typical, with, shifts, ..seen }
}
