//! What is found beside effects, as data: in the noise, in a few runs, in readings that are left
//! out, and places.
//!
//! How it is found is for [`super::gross`], [`super::noise`] and [`super::verdict`] to say.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use crate::engine::gauss_markov::GaussMarkov;
use crate::system::Selected;
use crate::units::Unit;

use super::evidence::score::Score;
use super::library::candidate::Candidate;
use super::library::place::Place;

/// Something found in the noise.
#[derive(Clone, Debug)]
pub struct NoiseEffect {
    /// The effect of the library.
    pub name: String,
    /// Where it is part of the model: as what.
    pub selected: Option<Selected>,
    /// The name of its parameter.
    pub parameter: String,
    /// Other parameters of it that have this size, too: a walk is the same along all axes.
    pub also: Vec<String>,
    /// The campaign that it is found in, where others differ.
    pub of: Option<String>,
    /// Unit in which the parameter is declared.
    pub unit: Unit,
    /// Its size (SI).
    pub value: f64,
    /// Standard uncertainty.
    pub sigma: f64,
    /// Effects that these data cannot tell from it.
    pub aliases: Vec<String>,
    /// Of noise with a memory the time after which correlation is down to a factor of e (s).
    pub memory: Option<f64>,
    /// Logarithm of the probability of such a finding by chance.
    pub ln_p: f64,
}

/// By how much a measurand scatters otherwise than stated.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The measurand.
    pub measurand: String,
    /// Its campaign, where there are several.
    pub of: Option<String>,
    /// The factor on the standard uncertainty that is stated.
    pub factor: f64,
}

/// The noise of campaigns.
#[derive(Clone, Debug, Default)]
pub struct Noise {
    /// Effects of the library that were accepted.
    pub effects: Vec<NoiseEffect>,
    /// Effects that cannot be told from a walk.
    pub rivals: Vec<Rival>,
    /// Where the rig was displaced, if that is what a walk among them stands for.
    pub displaced: Option<Displaced>,
    /// Readings that are off in a few runs.
    pub apart: Vec<Apart>,
    /// Those among them whose size was mended once beside what else was found.
    pub grown: Vec<String>,
    /// The square of times that are off, where it counts: in the model with the effect that says
    /// so.
    pub square: Option<Selected>,
    /// Levels that are not as stated.
    pub levels: Vec<Level>,
    /// Measurand, run and factor where a run scatters otherwise than most.
    pub run_levels: Vec<(String, String, f64)>,
    /// Measurands whose noise has a memory of which the weights take account, with their campaigns
    /// where there are several.
    pub memories: Vec<(String, Option<String>, GaussMarkov)>,
    /// What is left out.
    pub left_out: LeftOut,
    /// How often levels of the campaigns' own random quantities were changed.
    pub own_levels: usize,
    /// Correlation of neighbours in time, the largest of all measurands; 0 where there is none.
    pub memory: f64,
    /// Samples in a stretch.
    pub stretch: usize,
    /// Whether runs are the stretches, for the noise has a memory: what differs from run to run is
    /// part of it then.
    pub runs_scatter: bool,
}

impl Noise {
    /// Whether one of the walks that are offered is among them.
    pub(super) fn wanders(&self, offered: &[Candidate]) -> bool {
        let is_found = |walk: &Candidate| self.effects.iter().any(|one| one.name == walk.name);
        offered.iter().any(|one| one.is_walk() && is_found(one))
    }

    /// Effects that may be there instead of an accepted walk.
    pub(super) fn instead(&self) -> impl Iterator<Item = &Rival> {
        let is_found = |walk: &str| self.effects.iter().any(|one| one.name == walk);
        self.rivals.iter().filter(move |one| is_found(&one.walk))
    }

    /// Walks that cannot be told from an effect.
    pub(super) fn walks_like<'a>(&'a self, effect: &'a str) -> impl Iterator<Item = &'a str> {
        let rivals = self.rivals.iter().filter(move |one| one.effect == effect);
        rivals.map(|one| one.walk.as_str())
    }

    /// How many single readings are left out.
    pub fn wild(&self) -> usize {
        self.left_out.readings.len()
    }

    /// Part of the readings that counts where neighbours are alike.
    pub(super) fn alike(&self) -> f64 {
        (1.0 - self.memory.powi(2)) / (1.0 + self.memory.powi(2))
    }

    /// The effects that it put into the model.
    pub fn selected(&self) -> Vec<&Selected> {
        self.effects.iter().filter_map(|one| one.selected.as_ref()).chain(&self.square).collect()
    }
}

/// An effect and a walk that do as much: one of them is taken, the other one is its alias.
#[derive(Clone, Debug)]
pub struct Rival {
    /// The walk.
    pub walk: String,
    /// The effect.
    pub effect: String,
    /// The effect's test without the walk in the model.
    pub score: Score,
    /// Logarithm of the effect's likelihood over that of the walk.
    pub likelier: f64,
}

impl Rival {
    /// The probability that it is the effect, if it is one of the two.
    pub(super) fn part(&self) -> f64 {
        1.0 / (1.0 + (-self.likelier).exp())
    }
}

/// What is off in a few runs.
#[derive(Clone, Debug)]
pub struct Apart {
    /// The block of unknown structure that says so for all runs.
    pub block: String,
    /// For each change the runs that have its value.
    pub runs: Vec<Vec<usize>>,
    /// Where it sits.
    pub place: Place,
}

/// Displacements that do for a walk.
#[derive(Clone, Debug)]
pub struct Displaced {
    /// Where each sits, the largest first.
    pub places: Vec<Location>,
    /// The effect that the walk is.
    pub walk: String,
    /// Logarithm of their likelihood ratio, against nothing, the choice of their kind paid for.
    pub(super) likelihood: f64,
    /// How much of them the walk explains: the logarithm of its likelihood ratio, against nothing,
    /// by theirs.
    pub share: f64,
}

impl Displaced {
    /// The effect nearest to them: the walk for which they do.
    pub fn nearest(&self) -> Ranked {
        let (name, share) = (self.walk.clone(), self.share);
        Ranked { name, member: BTreeMap::new(), score: Score::NONE, share, probability: 0.0 }
    }
}

/// A reading that is left out because it is wild or a code.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Name of the run.
    pub run: Arc<str>,
    /// Row of its data file.
    pub row: usize,
    /// The measurand.
    pub measurand: Arc<str>,
    /// How far out it was, in robust standard deviations of its measurand.
    pub deviations: f64,
    /// The code that stands in its place, if it is one (SI).
    pub code: Option<f64>,
}

/// A run, or a stretch of it, of which all readings of a measurand are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Name of the run.
    pub run: String,
    /// The measurand.
    pub measurand: String,
    /// How many readings that are.
    pub readings: usize,
    /// Rows of the data file: first and last.
    pub rows: (usize, usize),
    /// How far out half of them were at least, in robust standard deviations of the measurand.
    pub deviations: f64,
    /// What is wrong.
    pub place: Place,
}

/// What is left out.
#[derive(Clone, Debug, Default)]
pub struct LeftOut {
    /// Single readings.
    pub readings: Vec<Reading>,
    /// Runs that are wrong as wholes.
    pub runs: Vec<Stretch>,
    /// What is on one side of a moment at which something changed.
    pub stretches: Vec<Stretch>,
}

impl LeftOut {
    /// Whether it is nothing.
    pub fn is_empty(&self) -> bool {
        self.readings.is_empty() && self.runs.is_empty() && self.stretches.is_empty()
    }

    /// Adds what is left out later.
    pub fn extend(&mut self, later: Self) {
        self.readings.extend(later.readings);
        self.runs.extend(later.runs);
        self.stretches.extend(later.stretches);
    }
}

/// A stretch of readings that belong to other moments.
#[derive(Clone, Debug, PartialEq)]
pub struct Lost {
    /// Index of the campaign.
    pub part: usize,
    /// Index of the run.
    pub run: usize,
    /// Name of the run.
    pub name: String,
    /// Its samples.
    pub samples: Range<usize>,
    /// Rows of the data file: first and last.
    pub rows: (usize, usize),
    /// The readings of sample `i` belong to sample `i + periods`.
    pub periods: isize,
    /// Logarithm of the probability of such a finding by chance.
    pub ln_p: f64,
}

/// A testable effect.
#[derive(Clone, Debug)]
pub struct Ranked {
    /// The effect.
    pub name: String,
    /// Of a family the member that explains most.
    pub member: BTreeMap<String, f64>,
    /// Its test against the nominal model.
    pub score: Score,
    /// Share of what is there that it explains, between 0 and 1.
    pub share: f64,
    /// Probability that it, or an effect like it, is the cause.
    pub probability: f64,
}

/// Where the gap lies.
#[derive(Clone, Debug)]
pub struct Location {
    /// The block.
    pub place: Place,
    /// Share of the best block's gain.
    pub share: f64,
}
