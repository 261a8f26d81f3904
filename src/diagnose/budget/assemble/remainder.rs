//! The parts of the remainder with their places and sizes.

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::DVector;

use crate::diagnose::budget::answer::{NEAREST, Remainder, StepChange};
use crate::diagnose::budget::neighbours::{OfInputs, of_inputs};
use crate::diagnose::budget::solved::Solved;
use crate::diagnose::budget::terms::{Term, without};
use crate::diagnose::budget::transients::Transient;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::place::{Of, Place};
use crate::diagnose::price::Gain;
use crate::units::Unit;

use super::Budget;

/// Ratio of a wave to what is seen of it from which its amplitude is no size of it.
const ABSORBED: f64 = 2.0;
/// Part of the amplitude of all waves over a turn from which one of them is named.
const PART_OF_WAVES: f64 = 0.2;
const MOST_WAVES: usize = 4;

/// Of an error of a reading that is waves over a turn the few orders that are most of it, with the
/// amplitude of each; none of a form that many orders make together.
fn waves(term: &Term, place: &Place, values: &[f64]) -> Vec<(usize, f64)> {
    let is_whole = term.change.is_none() && term.reduced_from.is_none();
    let is_of_reading = matches!(place.of, Of::Measurand(_)) && place.orders > 0;
    if !is_whole || !is_of_reading || values.len() != 2 * place.orders {
        return Vec::new();
    }
    let amplitudes = values.chunks(2).map(|pair| pair[0].hypot(pair[1]));
    let whole = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    let mut all: Vec<(usize, f64)> = (1..).zip(amplitudes).collect();
    all.retain(|(_, amplitude)| *amplitude >= PART_OF_WAVES * whole);
    if all.len() > MOST_WAVES { Vec::new() } else { all }
}

impl Budget<'_> {
    /// What each term of the remainder takes off chi squared beyond chance, one after the other beside the
    /// rest of the model, the one that does most first: what two of them have in common is of the first.
    pub(super) fn parts(&self, rest: &[usize]) -> Vec<f64> {
        let Self { selection, model, .. } = self;
        let of_rest = |at: &usize| rest.contains(at);
        let others = (0..model.len()).filter(|at| !of_rest(at)).map(|at| model[at]);
        let mut beside: Vec<usize> = others.collect();
        let alone = rest.iter().map(|at| selection.gain(&beside, model[*at]).excess());
        let mut order: Vec<(usize, f64)> = alone.enumerate().collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut parts = vec![0.0; rest.len()];
        for (number, _) in order {
            let term = model[rest[number]];
            parts[number] = selection.gain(&beside, term).excess();
            beside.push(term);
        }
        parts
    }

    /// A transient, which the fit does not have, with its rms in its own readings.
    pub(super) fn transient(&self, one: &Transient) -> Remainder {
        let share = (one.gain.excess() / self.total.max(f64::MIN_POSITIVE)).min(1.0);
        let (part, _, measurand) = one.at;
        let Fitted { problem, fit, .. } = &self.linear.fitted;
        let name = &problem.parts[part].system.assembly.names.measurands[measurand].name;
        let rms = Some((one.rms * problem.rms_sigma(&fit.point, part, measurand), name.clone()));
        Remainder { gain: one.gain, share, rms, ..Remainder::at(one.place.clone()) }
    }

    /// The parts of the remainder, terms and what each of them takes off.
    pub(super) fn remainder(
        &self,
        (rest, parts): (&[usize], &[f64]),
        gains: &[Gain],
        solved: &Solved,
    ) -> Vec<Remainder> {
        let Self { linear, selection, .. } = self;
        let total = self.total.max(f64::MIN_POSITIVE);
        let mut found: Vec<Remainder> = rest
            .iter()
            .zip(parts)
            .map(|(at, part)| {
                let term = &linear.terms[self.model[*at]];
                let own: Vec<f64> = solved.of_term(*at).to_vec();
                let is_small = self.nameless.contains(&self.model[*at]);
                let like = || Place::like(&term.name, is_small);
                let place = term.place.clone().unwrap_or_else(like);
                let rest = without(self.model, self.model[*at]);
                let ranked = selection.ranked(&rest, &self.pools.effects);
                let nearest = ranked.first().filter(|one| one.ln_bayes > 0.0).map(|one| {
                    let share = one.gain.gain / gains[*at].gain.max(f64::MIN_POSITIVE);
                    (linear.terms[one.term].name.clone(), share.min(1.0))
                });
                let is_wave = own.len() == 2 && term.members > 1;
                let waves = waves(term, &place, &own);
                let block = linear.candidates.get(term.candidate);
                let of_wave = block.filter(|_| is_wave || !waves.is_empty());
                let amplitude = of_wave.and_then(|block| {
                    let unit = block.selected.effect.parameters.first()?.unit.clone();
                    let largest = waves.iter().map(|one| one.1).reduce(f64::max);
                    Some((largest.unwrap_or_else(|| own[0].hypot(own[1])), unit))
                });
                // An equation of what is stated is no reading.
                let is_of_prior = term.candidate == usize::MAX && place.stated().is_some();
                let rms = self.rms(self.model[*at], &own).filter(|_| !is_of_prior);
                // Over a part of a turn nominal parameters may absorb most of a wave.
                let is_seen = |(size, _): &(f64, Unit)| {
                    let rms = rms.as_ref().map_or(0.0, |(rms, _)| *rms);
                    !matches!(place.of, Of::Measurand(_)) || size * FRAC_1_SQRT_2 < ABSORBED * rms
                };
                let amplitude = amplitude.filter(is_seen);
                let mut changes = self.changes(term, solved, *at).into_iter();
                let (change, turn) = (changes.next(), changes.next());
                Remainder {
                    gain: gains[*at],
                    share: (part / total).min(1.0),
                    rms,
                    orders: if amplitude.is_some() { waves } else { Vec::new() },
                    amplitude,
                    change,
                    turn,
                    nearest: nearest.filter(|(_, share)| *share >= NEAREST),
                    place,
                }
            })
            .collect();
        found.sort_by(|a, b| b.share.total_cmp(&a.share));
        found
    }

    /// By how much a term changes something, at a moment or from the beginning: values of one unit together,
    /// as how far along all axes.
    fn changes(&self, term: &Term, solved: &Solved, at: usize) -> Vec<StepChange> {
        let linear = self.linear;
        let of_block = |candidate: usize, signature: usize| {
            let block = linear.candidates.get(candidate)?;
            Some(block.selected.effect.parameters.get(signature)?.unit.clone())
        };
        let is_of_stated = || term.place.as_ref().is_some_and(|place| place.stated().is_some());
        let unit = |column: usize| match &term.change {
            Some(_) if term.in_fit => {
                Some(linear.size(term.columns.get(column)?.first()?.0, 0.0)?.unit)
            }
            Some(_) if term.is_form_in_run() => None,
            Some(change) => of_block(change.base.candidate, change.base.signature + column),
            // Of a fixed value that is wrong.
            None if column == 0 && is_of_stated() => of_block(term.candidate, 0),
            None => None,
        };
        let columns = solved.terms[at].clone();
        let units: Vec<(usize, Unit)> =
            (0..columns.len()).map_while(|own| Some((columns.start + own, unit(own)?))).collect();
        let together = units.chunk_by(|a, b| a.1.dimension == b.1.dimension).map(|own| {
            let columns = own[0].0..own[0].0 + own.len();
            let values = solved.values.rows_range(columns.clone());
            let (value, along) = match values.len() {
                1 => (values[0], DVector::repeat(1, 1.0)),
                _ => (values.norm(), values.normalize()),
            };
            let covariance = solved.covariance.view_range(columns.clone(), columns) * &along;
            let sigma = along.dot(&covariance).max(0.0).sqrt();
            StepChange { value, sigma, unit: own[0].1.clone() }
        });
        together.collect()
    }

    /// Errors that several inputs decide together, which no term has the form of: what is left beside
    /// the other parts.
    pub(super) fn of_inputs(&self) -> Vec<Remainder> {
        let Self { linear, selection, model, .. } = self;
        let Fitted { problem, fit, .. } = &linear.fitted;
        let remainder = |one: OfInputs| {
            let of = linear.measurands().find(|own| own.number == one.measurand)?;
            let rms = one.rms * problem.rms_sigma(&fit.point, of.part, of.measurand);
            let only = match &*problem.parts[of.part].system.assembly.names.inputs {
                [only] => Some(only.name.as_str()),
                _ => None,
            };
            let place = Place::of_inputs(of.name, only);
            let rms_in_noise = one.rms / selection.scale[one.measurand];
            let squares = rms_in_noise.powi(2) * linear.sums.readings[one.measurand] as f64;
            // Of what the terms explain and this; alone it has no share.
            let share = if model.is_empty() { 0.0 } else { squares / (self.total + squares) };
            Some(Remainder { rms: Some((rms, of.name.to_owned())), share, ..Remainder::at(place) })
        };
        of_inputs(linear, selection, model).into_iter().filter_map(remainder).collect()
    }
}
