//! The model without the readings that are off since something changed, for delays that it does not
//! bend.
//!
//! Where something changes once, what is before it and what follows are alike each by itself: of
//! what is off and all else in its campaign the fewer readings are left out, or the others where
//! those would leave something undetermined.

use std::ops::Range;

use crate::diagnose::fitted::{Fitted, carried_onto};
use crate::diagnose::found::{LeftOut, Lost, Noise};
use crate::diagnose::gross::empty_runs::without_empty_runs;
use crate::diagnose::gross::left_out::{OfSamples, leave_samples_out, stretch};
use crate::diagnose::library::place::Place;
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::noise::given::Given;
use crate::diagnose::noise::whiten::prepare;
use crate::diagnose::sequences::{OfRun, seen_from};
use crate::diagnose::stage::Stage;
use crate::engine::Problem;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate};

use super::between::{Moment, Runs};

/// Samples of runs, by ascending number of the run over all campaigns.
type Samples = Vec<(usize, Range<usize>)>;

/// What is common to all ways of leaving readings out: the nominal model of what is given, what is
/// aside already, and what may be added.
pub(super) struct Nominal<'a> {
    pub(super) fitted: &'a Fitted,
    pub(super) aside: (&'a [Lost], &'a LeftOut),
    pub(super) wanted: &'a Wanted,
    pub(super) options: &'a Options,
}

impl Nominal<'_> {
    /// The nominal estimate, and what could be added to it once its noise is judged, without what
    /// is off at some moments of runs; `None` where that leaves something undetermined.
    pub(super) fn without(
        &self,
        runs: &Runs,
        moments: &[Moment],
        place: &Place,
    ) -> Result<Option<(Calibration, Stage)>, FitError> {
        let off = runs.off(moments);
        let mut ways = match moments {
            [one] => vec![runs.others(&off, one.run), off],
            _ => vec![off],
        };
        ways.sort_by_key(|way| way.iter().map(|(_, samples)| samples.len()).sum::<usize>());
        for way in ways {
            let off = readings(&runs.model.problem, &way, place);
            let off = in_another(&off, &runs.model.problem, &self.fitted.problem);
            if let Some(found) = self.leaving_out(&off, place)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    fn leaving_out(
        &self,
        off: &[OfSamples],
        place: &Place,
    ) -> Result<Option<(Calibration, Stage)>, FitError> {
        let Self { fitted, aside: (lost, gross), wanted, options } = self;
        let whole = &fitted.problem;
        let mut problem = whole.clone();
        leave_samples_out(&mut problem, off);
        problem = without_empty_runs(&problem).unwrap_or(problem);
        let nominal = calibrate(problem, options)?;
        if !nominal.is_sound() {
            return Ok(None);
        }
        let (problem, fit) = (nominal.problem.clone(), nominal.fit.clone());
        let seen =
            seen_from(whole, &carried_onto(&problem, &fit.point, whole, fitted.fit.point.clone()));
        let told = off.iter().filter_map(|one| stretch(whole, &seen, one, place.clone()));
        let gross = LeftOut { stretches: told.collect(), ..(*gross).clone() };
        let given = Given { lost: lost.to_vec(), gross, ..Given::of(&problem) };
        let rest = Fitted { recipes: fitted.recipes.clone(), problem, fit };
        let stage = prepare(rest, wanted, &given, &Noise::default(), options)?;
        Ok(stage.map(|stage| (nominal, stage)))
    }
}

impl Runs<'_> {
    /// Where something is off.
    fn off(&self, moments: &[Moment]) -> Samples {
        let each = moments.iter().flat_map(|moment| {
            let later = moment.goes_on.map_or(&[][..], |reach| self.later(moment.run, reach));
            let later = later.iter().map(|run| (*run, 0..self.lengths[*run]));
            later.chain([(moment.run, moment.samples.clone())])
        });
        let mut each: Samples = each.collect();
        each.sort_by_key(|(run, samples)| (*run, samples.start));
        let mut all = Samples::new();
        for (run, samples) in each {
            match all.last_mut().filter(|last| last.0 == run && samples.start <= last.1.end) {
                Some((_, last)) => last.end = last.end.max(samples.end),
                None => all.push((run, samples)),
            }
        }
        all
    }

    /// All other samples of the campaign of a run, where no run is off twice.
    fn others(&self, off: &Samples, run: usize) -> Samples {
        let problem = &self.model.problem;
        let runs = of_campaigns(problem);
        let own = (0..runs.len()).filter(|other| runs[*other].0 == runs[run].0);
        let each = own.flat_map(|run| {
            let length = self.lengths[run];
            let is_off = off.iter().find(|one| one.0 == run);
            let off = is_off.map_or(length..length, |(_, samples)| samples.clone());
            [(run, 0..off.start), (run, off.end..length)]
        });
        each.filter(|(_, samples)| !samples.is_empty()).collect()
    }
}

/// The campaign of each run and its number there.
fn of_campaigns(problem: &Problem) -> Vec<(usize, usize)> {
    let parts = problem.parts.iter().enumerate();
    parts.flat_map(|(p, part)| (0..part.runs.len()).map(move |run| (p, run))).collect()
}

/// The readings of samples that what is wrong at a place makes wrong.
fn readings(problem: &Problem, samples: &Samples, place: &Place) -> Vec<OfSamples> {
    let runs = of_campaigns(problem);
    let of_samples = |(run, samples): &(usize, Range<usize>)| {
        let (part, run) = runs[*run];
        let names = problem.parts[part].system.assembly.names.measurands.iter().enumerate();
        let own = names.filter(|(_, one)| place.measurand().is_none_or(|name| one.name == name));
        let each = own.map(|(measurand, _)| (OfRun { part, measurand, run }, samples.clone()));
        each.collect::<Vec<OfSamples>>()
    };
    samples.iter().flat_map(of_samples).collect()
}

/// The same readings in a problem of the same campaigns with other runs.
fn in_another(off: &[OfSamples], problem: &Problem, other: &Problem) -> Vec<OfSamples> {
    let same = |(one, samples): &OfSamples| {
        let name = &problem.parts[one.part].runs[one.run].name;
        let run = other.parts[one.part].runs.iter().position(|run| run.name == *name)?;
        Some((OfRun { run, ..*one }, samples.clone()))
    };
    off.iter().filter_map(same).collect()
}
