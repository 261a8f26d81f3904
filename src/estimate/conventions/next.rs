//! What may be set right next: of all conventions the one that fits best, compared on few samples, then
//! the best of them on more.

use rayon::prelude::*;

use crate::engine::Problem;
use crate::estimate::autocorrelation::fewer;
use crate::estimate::minima::thinned::Thinned;

use super::looked::Looked;
use super::quick::Quick;
use super::residuals::Residuals;
use super::sequence::{Score, Sequence};
use super::streams::smooth_as_stated;
use super::suspect::Suspect;
use super::trimmed::trimmed_fit;
use super::typed::{Typed, is_far_better};
use super::{ALIKE, BETTER, GOOD, ITERATIONS, Instead, SAMPLES};

/// Conventions that are compared on more samples, and of those that fit like the best.
const FURTHER: [usize; 2] = [6, 12];
/// Number of conventions that are tried together with others where none helps by itself.
const FIRSTS: usize = 8;
/// Number of those others.
const SECONDS: usize = 30;
/// Conventions that fit so many times worse than the best are not compared.
const HOPELESS: f64 = 30.0;
/// What exceeds the least chi squared by so many times its variance factor fits worse by more than noise.
const DECISIVE: f64 = 50.0;
/// Residuals more than five times smaller than stated are no matter of a careful statement.
const TOO_GOOD: f64 = 0.04;

/// What may be set right next.
pub(super) struct Next<'s, 'c> {
    /// All that is set right with it.
    pub(super) sequence: &'s Sequence<'c>,
    /// How well that fits.
    pub(super) looked: Looked,
    /// How well it does for whoever types it.
    pub(super) typed: Typed,
    /// Others that fit about as well.
    pub(super) alike: Vec<Instead>,
}

/// One that fits far better than the numbers as they stand.
struct Compared<'s, 'c> {
    looked: Looked,
    typed: Typed,
    sequence: &'s Sequence<'c>,
}

/// What may be set right in a problem on few samples, best first, and how well these fit as they stand.
pub(super) struct Glanced<'s, 'c> {
    tried: Vec<(Quick, &'s Sequence<'c>)>,
    control: f64,
}

impl<'s, 'c> Glanced<'s, 'c> {
    /// `first` are the numbers as they were read; conventions that the residuals bear out as they stand
    /// are passed over.
    pub(super) fn at(
        first: &Problem,
        stands: &Looked,
        sequences: &'s [Sequence<'c>],
    ) -> Option<Self> {
        let few = Thinned::of(&stands.problem, SAMPLES[0]);
        let numbers = few.late_by(0.0, &[])?;
        let residuals = Residuals::of(&numbers, &stands.point);
        let control = Quick::of(&few, None)?.score.as_stated;
        // As they stand they fit from there, too.
        let there = trimmed_fit(&numbers, stands.point.clone(), ITERATIONS[1]);
        let control = there.map_or(control, |one| control.min(one.fit.variance_factor.ln()));
        let few = Thinned::of(first, SAMPLES[0]);
        let numbers = few.late_by(0.0, &[])?;
        let is_borne_out = |sequence: &Sequence<'_>| {
            let changed = sequence.applied(&numbers);
            changed.is_some_and(|one| residuals.bear_out(&Residuals::of(&one, &stands.point)))
        };
        let sequences: Vec<&Sequence<'_>> =
            sequences.par_iter().filter(|sequence| !is_borne_out(sequence)).collect();
        let mut tried: Vec<(Quick, &Sequence<'_>)> = sequences
            .into_par_iter()
            .filter_map(|sequence| Some((Quick::of(&few, Some(sequence))?, sequence)))
            .collect();
        tried.sort_by(|a, b| a.0.score.as_stated.total_cmp(&b.0.score.as_stated));
        Some(Self { tried, control })
    }

    /// The best few, each together with others: a mirrored axis of two vectors of different kinds, or
    /// angles in another unit of which one counts from another axis, help little one by one.
    pub(super) fn pairs(&self) -> Vec<Sequence<'c>> {
        let with = |(number, (_, one)): (usize, &(Quick, &'s Sequence<'c>))| {
            let others = self.tried[number + 1..].iter().take(SECONDS);
            let others = others.flat_map(|(_, other)| other.places().map(|(_, suspect)| suspect));
            // Two factors of one number are another factor.
            let is_sensible =
                |suspect: &&Suspect<'c>| !one.places().any(|(_, own)| own.scales_as(suspect));
            let others = others.filter(is_sensible);
            others.flat_map(|suspect| one.together_with(suspect)).collect::<Vec<_>>()
        };
        self.tried.iter().enumerate().take(FIRSTS).flat_map(with).collect()
    }
}

/// What fits best of all that may be set right in a problem, if that is far better than how it stands.
pub(super) fn next_of<'s, 'c>(
    first: &Problem,
    stands: &Looked,
    glanced: Glanced<'s, 'c>,
) -> Option<Next<'s, 'c>> {
    let Glanced { mut tried, control } = glanced;
    tried.retain(|(quick, _)| quick.score.as_stated < control - BETTER[1].ln());
    // Inputs that are made smaller shrink residuals as they shrink all else. Where these are far
    // smaller than stated, readings that are made larger instead fit as well.
    let is_relative = is_too_good(tried.first()?.0.score.as_stated.exp());
    let score = |score: Score| score.compared(is_relative);
    tried.sort_by(|a, b| score(a.0.score).total_cmp(&score(b.0.score)));
    let best = score(tried.first()?.0.score);
    let within =
        |times: f64| tried.partition_point(|(quick, _)| score(quick.score) < best + times.ln());
    // Which of those that fit alike come first is a matter of rounding.
    let further = within(ALIKE).clamp(FURTHER[0], FURTHER[1]).min(within(HOPELESS));
    tried.truncate(further);
    let mut compared: Vec<Compared<'s, 'c>> = tried
        .into_par_iter()
        .filter_map(|(quick, sequence)| {
            let mut problem = sequence.applied(first)?;
            smooth_as_stated(&mut problem, first);
            Some((Looked::at(problem, &quick.point, Some(sequence))?, sequence))
        })
        .filter(|(looked, sequence)| {
            let scored = looked.score.as_stated.exp();
            is_far_better(stands.variance_factor, scored, sequence.doubts_a_head())
        })
        .filter(|(looked, sequence)| !looked.is_another_factor(first, sequence))
        .map(|(looked, sequence)| {
            let typed = Typed::of(first, sequence);
            Compared { looked, typed, sequence }
        })
        .collect();
    let best = compared.iter().map(|one| score(one.looked.score)).min_by(f64::total_cmp)?;
    compared.retain(|one| score(one.looked.score) < best + ALIKE.ln());
    for one in compared.iter_mut().filter(|one| !one.typed.reaches(&one.looked)) {
        one.typed = Typed::improved(first, one.sequence);
    }
    // A step on the way may still fit badly, and be within reach with the next alone.
    compared.retain(|one| one.looked.variance_factor >= GOOD || one.typed.is_better(stands));
    drop_decidedly_worse(&mut compared);
    let of_all = compared.iter().map(|one| one.typed.of_all).fold(f64::INFINITY, f64::min);
    let is_of_some = |one: &Compared<'_, '_>| one.typed.of_all >= (ALIKE * of_all).max(GOOD);
    let off = |one: &Compared<'_, '_>| one.looked.variance_factor.ln().abs();
    let nearest = compared.iter().map(off).fold(f64::INFINITY, f64::min);
    let is_farther =
        |one: &Compared<'_, '_>| is_too_good(one.looked.variance_factor) && off(one) > nearest;
    // Of those that fit alike what fits the stated uncertainties, outliers counted, then the simplest:
    // a sign before a turn, a turn before both. Residuals far smaller than stated do not fit them.
    compared.sort_by_key(|one| {
        let is_bad = one.looked.variance_factor >= GOOD || is_of_some(one);
        (is_farther(one), is_bad, !one.typed.is_settled, one.sequence.order())
    });
    let mut compared = compared.into_iter();
    let Compared { looked, typed, sequence } = compared.next()?;
    // Beside one that fits as stated, no other does about as well that does not.
    let most = (ALIKE * looked.variance_factor).max(GOOD);
    let most_of_all = (ALIKE * typed.of_all).max(GOOD);
    let own = sequence.named();
    let alike = compared
        .filter(|one| one.looked.variance_factor < most && one.typed.of_all < most_of_all)
        .filter_map(|one| {
            let mut others = one.sequence.named();
            others.retain(|one| !own.contains(one));
            Some(Instead { opposite: looked.opposite(&one.looked), ..joined(others)? })
        })
        .collect();
    Some(Next { sequence, looked: looked.improved(), typed, alike })
}

/// Drops what noise does not explain beside the fit of least chi squared, where that is as good as stated:
/// of many readings a small part of chi squared is far more than noise. Readings that are made larger
/// are not dropped for the digits that they lack.
fn drop_decidedly_worse(compared: &mut Vec<Compared<'_, '_>>) {
    let stated = |one: &Compared<'_, '_>| one.looked.score.as_stated;
    let best = compared.iter().min_by(|a, b| stated(a).total_cmp(&stated(b)));
    let Some(Looked { problem, point, variance_factor, score, .. }) = best.map(|one| &one.looked)
    else {
        return;
    };
    if *variance_factor >= GOOD || is_too_good(*variance_factor) {
        return;
    }
    // Correlated residuals are worth fewer readings.
    let readings = problem.component_count() as f64 / fewer(problem, point);
    let (most, best) = ((DECISIVE / readings).ln_1p(), *score);
    compared.retain(|one| {
        let own = one.looked.score;
        own.as_stated <= best.as_stated + most || own.relative <= best.relative + most
    });
}

/// Whether residuals are far smaller than stated.
fn is_too_good(variance_factor: f64) -> bool {
    variance_factor < TOO_GOOD
}

/// Two that help together, as one.
fn joined(all: Vec<Instead>) -> Option<Instead> {
    all.into_iter().reduce(|one, other| Instead {
        name: format!("{} and {}", one.name, other.name),
        title: format!("{}; {}", one.title, other.title),
        numbers: [one.numbers, other.numbers].concat(),
        opposite: Vec::new(),
    })
}
