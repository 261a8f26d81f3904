//! What changes at a moment in the course of a run: a clock that is set, an instrument that is
//! knocked, a beam that was lost and taken up again.
//!
//! Effects with a value for each run, a memory or a noisier run say something like it. So runs are
//! cut into pieces, and each reading, its time, the target and the rig are looked at for one value
//! between two cuts, from a cut to the end of its run, or from a cut on in all later runs
//! (`between`, `finer`). It is what happened where a few moments leave nothing beyond white noise
//! (`white`) in any piece, nor to anything that could be added to the model, and are far likelier
//! than any of that (`beside`). Where noise has a memory, or wanders, nothing is said. It is told
//! with its rows (`told`), and the readings that are off are left out (`without`).

use std::collections::HashSet;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{LeftOut, Location, Lost, Reading};
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::search::Search;
use crate::diagnose::stage::Stage;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::Calibration;

use beside::Alone;
use between::Runs;
use white::{lasting, levelled, levels, white};
use without::Nominal;

mod beside;
mod between;
mod finer;
mod told;
mod white;
mod without;

/// What changed at a moment.
pub(in crate::diagnose) struct Changed {
    /// What it may be, the likeliest first: each does for all that is there.
    pub(in crate::diagnose) places: Vec<Location>,
    /// The effects beside which it shows.
    pub(in crate::diagnose) effects: Vec<String>,
    /// The model and its noise beside which it shows, without the readings that are off where that
    /// is no effect.
    pub(in crate::diagnose) stage: Stage,
    /// The nominal estimate without them, where anything is left out.
    pub(in crate::diagnose) nominal: Option<Calibration>,
}

/// What changed in the course of a run, if that is all that is there: beside the nominal model, or
/// beside the effects that a search adopted. `fitted` is the nominal model of every reading that is
/// not lost or gross.
///
/// # Errors
/// [`FitError`] where a model cannot be fitted at all.
pub(in crate::diagnose) fn changed(
    search: &Search,
    fitted: &Fitted,
    aside: (&[Lost], &LeftOut),
    wanted: &Wanted,
    options: &Options,
) -> Result<Option<Changed>, FitError> {
    let Some(first) = search.stages.first() else { return Ok(None) };
    let common = Common { fitted, aside, wanted, options };
    if let Some((alone, _)) = common.alone(first)? {
        let stage = alone.stage.clone();
        return common.beside_nothing(alone, stage).map(Some);
    }
    let Some(last) = search.stages.last().filter(|_| !search.adopted.is_empty()) else {
        return Ok(None);
    };
    let Some((alone, back)) = common.alone(last)? else { return Ok(None) };
    // Where a change does for all without the effects, they are not there; where for nearly all,
    // they follow what a linear model leaves of it.
    let adopted: Vec<&Candidate> = search.adopted.iter().map(|one| &one.candidate).collect();
    let nominal = white(first, &fitted.problem, &back, options)?;
    let nominal =
        nominal.filter(|model| Runs::of(model, wanted).does_for(&alone, &adopted).unwrap_or(false));
    let beside_nothing = nominal.and_then(|model| {
        let noise_found = alone.stage.noise_found.clone();
        Some(Stage { noise_found, ..Stage::new(model, wanted)? })
    });
    if let Some(stage) = beside_nothing {
        return common.beside_nothing(alone, stage).map(Some);
    }
    let Alone { places, stage, .. } = alone;
    Ok(Some(Changed { places, effects: search.names(), stage, nominal: None }))
}

/// What all models have in common.
struct Common<'a> {
    fitted: &'a Fitted,
    aside: (&'a [Lost], &'a LeftOut),
    wanted: &'a Wanted,
    options: &'a Options,
}

impl Common<'_> {
    /// What changed beside the model of a stage, and the runs that are looked at as they are given.
    fn alone(&self, stage: &Stage) -> Result<Option<(Alone, Vec<String>)>, FitError> {
        let Self { fitted: Fitted { problem: given, .. }, aside, wanted, options } = self;
        let key = |one: &Reading| (one.run.clone(), one.row, one.measurand.clone());
        let gross: HashSet<_> = aside.1.readings.iter().map(key).collect();
        let out = &stage.noise_found.left_out;
        let mut back: Vec<String> = out.runs.iter().map(|one| one.run.clone()).collect();
        back.extend(lasting(out.readings.iter().filter(|one| !gross.contains(&key(one)))));
        // What is wild in a run in which something changes may be what is off there.
        while let Some(model) = white(stage, given, &back, options)? {
            let Some(first) = Runs::of(&model, wanted).changed(stage) else { break };
            let names = model.problem.run_names();
            let is_in = |run: &str| first.found.moments.iter().any(|one| names[one.run] == run);
            let is_back = |one: &Reading| back.iter().any(|run| **run == *one.run);
            let readings =
                out.readings.iter().filter(|one| !is_back(one) || gross.contains(&key(one)));
            let (own, others): (Vec<_>, Vec<_>) =
                readings.cloned().partition(|one| is_in(&one.run) && !gross.contains(&key(one)));
            if !own.is_empty() {
                back.extend(own.into_iter().map(|one| one.run.to_string()));
                continue;
            }
            // What is off adds to the scatter where samples are far from each other.
            let Some(model) = levelled(model, &first.left, options)? else { break };
            let Some(mut alone) = Runs::of(&model, wanted).changed(stage) else { break };
            let left_out = &mut alone.stage.noise_found.left_out;
            (left_out.readings, left_out.runs) = (others, aside.1.runs.clone());
            alone.stage.noise_found.levels = levels(&model.problem, given);
            return Ok(Some((alone, back)));
        }
        Ok(None)
    }

    /// What changed beside no effect, without the readings that are off; where they cannot be left
    /// out, beside a stage with all of them.
    fn beside_nothing(&self, alone: Alone, with: Stage) -> Result<Changed, FitError> {
        let Self { fitted, aside, wanted, options } = *self;
        let Alone { found, places, stage, .. } = alone;
        let runs = Runs::of(&stage.fitted, wanted);
        let nominal = Nominal { fitted, aside, wanted, options };
        let without = match places.first() {
            Some(best) => nominal.without(&runs, &found.moments, &best.place)?,
            None => None,
        };
        let (nominal, stage) = match without {
            Some((nominal, stage)) => (Some(nominal), stage),
            None => (None, with),
        };
        Ok(Changed { places, effects: Vec::new(), stage, nominal })
    }
}
