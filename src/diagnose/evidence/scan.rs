//! Families over a range (a frequency, a period, a width): which member explains most.
//!
//! A line is as narrow as the recordings are long: a fixed grid of members would miss it. So the
//! grid is made from the signatures themselves (`grid`). The constant is left open in one compiled
//! program, `TOGETHER` members at once: one pass over the readings serves them all. What nominal
//! parameters absorb is taken off each of few members; of more, off the best by the plain gain. The
//! best is polished between its neighbours (`best`); of fast oscillations the spectrum of the residuals
//! has the members to try (`spectrum`); coupling between values of different runs is left
//! aside. The best is then tested like any other candidate; every member of the grid is paid for,
//! twice for the polishing. A list of members is looked through in the same way, as it stands.

mod best;
mod grid;
mod group;
mod opened;
mod spectrum;

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::DVector;
use rayon::prelude::*;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::{Candidate, fitting};
use crate::diagnose::library::place::Place;
use crate::diagnose::library::structure::FAST;
use crate::effect::Members;
use crate::engine::passes::Passes;
use crate::engine::signatures::{Candidate as Signed, Signatures};
use crate::engine::{Part, Problem};
use crate::system::{Selected, System};
use crate::units::Dimension;

use self::best::best_member;
use self::opened::opened;
use super::Nominal;
use super::sampling::{HALF_PERIOD, Sampling, is_frequency};

/// Members in one pass over the readings: they share everything but their own columns.
const TOGETHER: usize = 8;

/// What was found before: the best member of each family, and the number of members.
pub type Scanned = HashMap<String, (f64, usize)>;

/// The best member of a family, as `known` or looked for, and the number of members that it was
/// chosen among. `None` where the effect has not just one family, or its member cannot be left
/// open.
pub fn scan(
    fitted: &Fitted,
    family: &Candidate,
    known: &mut Scanned,
) -> Option<(Candidate, usize)> {
    let (value, members) = match known.get(&family.name) {
        Some(known) => *known,
        None => best_member(fitted, family)?,
    };
    let candidate = with_member(fitted, family, value)?;
    known.insert(family.name.clone(), (value, members));
    Some((candidate, members))
}

/// Looks for the members of several families at once: one by itself leaves threads without work where
/// runs are short.
pub fn scan_all<'f>(
    fitted: &Fitted,
    families: impl Iterator<Item = &'f Candidate>,
    known: &mut Scanned,
) {
    let new: Vec<&Candidate> = families.filter(|one| !known.contains_key(&one.name)).collect();
    let found: Vec<_> = new.par_iter().map(|family| best_member(fitted, family)).collect();
    for (family, found) in new.iter().zip(found) {
        known.extend(found.map(|found| (family.name.clone(), found)));
    }
}

/// A family's candidate with this member.
pub(in crate::diagnose) fn with_member(
    fitted: &Fitted,
    family: &Candidate,
    value: f64,
) -> Option<Candidate> {
    let (name, _) = family.selected.effect.shape.first()?;
    let mut selected = family.selected.clone();
    selected.member = [(name.clone(), value)].into();
    let place = family.place.as_ref().map(|place| place.at(value));
    fitting(&fitted.recipes, &selected, place.as_ref())
}

/// The number of members that a family is scanned over, as it is paid for; `None` where it is not.
pub fn members(fitted: &Fitted, family: &Candidate) -> Option<usize> {
    let mut families = family.selected.effect.shape.values();
    let is_scanned = families.all(|one| matches!(one.members, Members::Range { .. }));
    Some(is_scanned.then(|| Scan::new(fitted, family))??.tried()?.paid)
}

/// A family whose constant is left open.
struct Scan<'a> {
    fitted: &'a Fitted,
    members: &'a Members,
    /// For each campaign that it fits the columns of `TOGETHER` members: alone, with those of each
    /// other, and with the nominal ones.
    alone: Vec<Passes<'a>>,
    across: Vec<Passes<'a>>,
    beside: Vec<Passes<'a>>,
    nominal: Nominal,
    samples: usize,
    /// Whether each run has values of its own, whatever the family's.
    is_by_runs: bool,
    /// Of a family of frequencies, and the lowest of them.
    sampling: Option<(Sampling, f64)>,
    /// The longest period (s) of a family of waves over time that a setup shows.
    longest: f64,
    /// Whether its members are no frequencies, periods or time constants.
    is_over_motion: bool,
    /// Whether they are frequencies of a fast oscillation that no effect describes.
    is_fast: bool,
}

/// The first part of the key of what holds together over a run.
const OF_RUN: usize = 2;

impl<'a> Scan<'a> {
    /// `None` where the effect has not just one family, or its member cannot be left open.
    fn new(fitted: &'a Fitted, family: &'a Candidate) -> Option<Self> {
        let problem = &fitted.problem;
        let effect = &family.selected.effect;
        let (name, declared) = effect.shape.first().filter(|_| effect.shape.len() == 1)?;
        let lowest = declared.members.series(2).into_iter().fold(f64::INFINITY, f64::min);
        let is_in_time = is_frequency(&declared.unit);
        let is_over_motion = !is_in_time && declared.unit.dimension != Dimension::TIME;
        let sampling = is_in_time.then(|| {
            let all = Sampling::of(problem, family.is_of_runs());
            (if family.place.is_some() { all.of_unknown() } else { all }, lowest)
        });
        let is_fast = lowest >= FAST && family.place.as_ref().is_some_and(Place::is_oscillation);
        let is_of_time = family.place.as_ref().is_some_and(Place::is_over_time);
        let longest = if is_of_time { longest_period(problem) } else { f64::INFINITY };
        if lowest > longest {
            return None;
        }
        let selected = Selected {
            effect: opened(effect, name)?.into(),
            member: Default::default(),
            head: family.selected.head.clone(),
        };
        let (mut alone, mut across, mut beside) = (Vec::new(), Vec::new(), Vec::new());
        let point = &fitted.fit.point;
        for (part, recipe) in fitted.recipes.iter().enumerate() {
            let Ok(system) = recipe.with(std::slice::from_ref(&selected)) else { continue };
            let system: &System = &system;
            let all = std::array::from_fn::<_, TOGETHER, _>(|number| Signed { number, system });
            let opened = |among| Arc::new(Signatures::open(problem, part, &all, name, among));
            let signatures = opened(false);
            alone.push(Passes::new(problem, Arc::clone(&signatures), point, false));
            across.push(Passes::new(problem, signatures, point, true));
            beside.push(Passes::new(problem, opened(true), point, false));
        }
        let nominal = Nominal::of(&fitted.fit.normal)?;
        let runs = problem.parts.iter().flat_map(|part| &part.runs);
        let samples = runs.map(|run| run.record.len()).sum();
        let members = &declared.members;
        let is_by_runs = false;
        Some(Self {
            fitted,
            members,
            alone,
            across,
            beside,
            nominal,
            samples,
            is_by_runs,
            sampling,
            longest,
            is_over_motion,
            is_fast,
        })
    }

    /// Whether a member is a frequency that the runs cannot tell from nothing, or too long a period.
    fn is_blind(&self, member: f64) -> bool {
        member > self.longest
            || self.sampling.as_ref().is_some_and(|(sampling, _)| sampling.is_blind(member))
    }

    /// Whether what values of a run's own say for a member says as much for a wave slower than all
    /// of the family.
    fn is_slow_in(&self, key: (usize, usize), member: f64) -> bool {
        let of_run = |(sampling, lowest): &(Sampling, f64)| {
            key.0 == OF_RUN && sampling.is_slow_in(key.1, member, *lowest)
        };
        self.sampling.as_ref().is_some_and(of_run)
    }

    /// What each of at most `TOGETHER` members takes off the sum of squares; blind ones nothing.
    fn gains(&self, members: &[f64]) -> Vec<f64> {
        let known = self.nominal.factor.half(&self.nominal.score);
        let mut gains = self.added(&self.beside, members, Some(&known));
        for (gain, member) in gains.iter_mut().zip(members) {
            if self.is_blind(*member) {
                *gain = 0.0;
            }
        }
        gains
    }

    /// What each of at most `TOGETHER` members gains, added up over everything that holds together;
    /// without the runs in which its wave is as much one slower than all of the family, where these
    /// say most of it. Nominal parameters stand still or, with their score halfway to its product,
    /// what they absorb is taken off.
    fn added(
        &self,
        programs: &[Passes<'_>],
        members: &[f64],
        known: Option<&DVector<f64>>,
    ) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); members.len()];
        for (key, group) in programs.iter().flat_map(|one| self.groups(one, &filled(members))) {
            let taken = known.map(|known| (self.nominal.factor.across(&group.across), known));
            for (member, (fast, slow)) in sums.iter_mut().enumerate() {
                let is_slow = self.is_slow_in(key, members[member]);
                *(if is_slow { slow } else { fast }) += group.gain(member, taken.as_ref());
            }
        }
        // What does most where it is slow is something slow.
        sums.into_iter().map(|(fast, slow)| if fast < slow { fast } else { fast + slow }).collect()
    }

    /// Mean squared cosines between a member and others, fewer than `TOGETHER`.
    fn alike(&self, member: f64, others: &[f64]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); others.len()];
        let all: Vec<f64> = std::iter::once(member).chain(others.iter().copied()).collect();
        for (_, group) in self.across.iter().flat_map(|one| self.groups(one, &filled(&all))) {
            for (number, (between, directions)) in (1..).zip(&mut sums) {
                if let Some((cosines, own)) = group.cosines(number) {
                    *between += cosines;
                    *directions += own;
                }
            }
        }
        sums.into_iter().map(|(sum, all)| if all > 0.0 { sum / all } else { 1.0 }).collect()
    }
}

/// The longest period (s) of which some setup lasts a half.
fn longest_period(problem: &Problem) -> f64 {
    let of_part = |part: &Part| {
        let mut setups = vec![[f64::INFINITY, f64::NEG_INFINITY]; part.setups.len()];
        for run in &part.runs {
            if let Some([first, last]) = run.record.ends(|samples| &samples.setup_time) {
                let [low, high] = &mut setups[run.setup];
                (*low, *high) = (low.min(first), high.max(last));
            }
        }
        setups.into_iter().map(|[low, high]| high - low).fold(0.0, f64::max)
    };
    problem.parts.iter().map(of_part).fold(0.0, f64::max) / HALF_PERIOD
}

/// As many members as one pass takes, the last repeated.
fn filled(members: &[f64]) -> Vec<f64> {
    let last = members.last().copied().unwrap_or(1.0);
    (0..TOGETHER).map(|number| members.get(number).copied().unwrap_or(last)).collect()
}
