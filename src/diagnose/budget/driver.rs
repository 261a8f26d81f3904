//! The driver: effects enter one after the other, each with a nonlinear refit and a new
//! linearisation; then basis blocks and change points compete with them, rows are judged, and the
//! noise is looked at in what all of that leaves. What is found in the noise, and rows that did not
//! stand, lead to another round.

use std::collections::BTreeSet;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{LeftOut, NoiseEffect};
use crate::diagnose::library::variant::Variant;
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::outliers::lost::Jump;
use crate::diagnose::outliers::records::Records;
use crate::diagnose::outliers::spikes::Spikes;
use crate::estimate::batch::{FitError, Options};

use super::absorbed::Unseen;
use super::families::Families;
use super::in_fit::Row;
use super::judge::{Judged, Objection};
use super::linear::Linear;
use super::noise::Outlier;
use super::noise_or_blocks::{Instead, instead_of_blocks};
use super::search::{Log, Pools};
use super::selection::Selection;
use super::still::still_readings;
use super::terms::Change;

mod curved_rows;
mod fitted_changes;
mod forward;
mod jitter;
mod jumps;
mod members;
mod relax;
mod spikes;
mod update;
mod usual_values;

/// Rounds in which change points are looked for.
const CHANGE_ROUNDS: usize = 2;
/// Rounds of structure and noise.
const ROUNDS: usize = 5;

/// What the driver found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The last linearisation, with the rows that are in the fit.
    pub competed: Competed,
    /// Readings that were left out.
    pub left_out: LeftOut,
    /// Effects on the noise.
    pub noise: Vec<NoiseEffect>,
    /// Effects that show in no reading beside the nominal model.
    pub unseen: Unseen,
    /// Effects that did not stand as rows, in all rounds, with the reason.
    pub objections: Vec<(String, Objection)>,
    /// What was done, step by step.
    pub log: Log,
}

/// A linearised fit with the model that a competition of terms left, and its noise scale factors.
#[derive(Clone, Debug)]
pub struct Competed {
    /// The fit.
    pub linear: Linear,
    /// The model on it.
    pub judged: Judged,
    /// Noise scale factor of each measurand.
    pub scale: Vec<f64>,
}

/// A search that goes on.
struct Search<'a> {
    /// Of the library, with the relaxed forms that were found necessary.
    wanted: Wanted,
    options: &'a Options,
    nominal: Fitted,
    fitted: Fitted,
    rows: Vec<Row>,
    /// Effects that did not stand: they do not come back.
    refused: Vec<(String, Option<Variant>)>,
    /// Why, where that was judged.
    objections: Vec<(String, Objection)>,
    /// Effects that nominal parameters absorb, of which a refit found nothing beyond that; whether
    /// relaxed forms were tried, too.
    absorbed: Vec<(String, bool)>,
    /// Sets of rows that were in the fit, and those beside which members were looked for.
    seen: Vec<Vec<String>>,
    with_members: Vec<Vec<String>>,
    left_out: LeftOut,
    /// Bursts and spikes seen from the nominal fit, seen last; whether they were judged beside rows.
    first_spikes: Spikes,
    spikes: Spikes,
    has_judged_spikes: bool,
    /// Measurands that hardly vary.
    still: BTreeSet<String>,
    /// What is left out, and the runs of each campaign with all readings.
    outliers: Vec<Outlier>,
    records: Records,
    noise: Vec<NoiseEffect>,
    /// Effects that show in no reading beside the nominal model; `None` before it is linearised.
    unseen: Option<Unseen>,
    /// Best members of families: of blocks beside the first rows, of effects as they were found last.
    scanned: Families,
    /// Change points of the last model with their blocks: the next one begins with them.
    changes: Vec<(String, Change)>,
    /// Large ones that were fitted, by the name of their block.
    tried_changes: Vec<(String, (usize, usize), Option<usize>)>,
    log: Log,
}

/// Searches from a fitted nominal model, without bursts and spikes that are seen from it. `None` where
/// its parameters are not determined.
pub fn search(
    nominal: Fitted,
    spikes: Spikes,
    wanted: &Wanted,
    options: &Options,
) -> Result<Option<Found>, FitError> {
    Search::new(nominal, spikes, wanted, options).found()
}

/// Searches with jumps of clocks in the fit from the start; `None` where they do not explain far more.
pub fn search_with_jumps(
    nominal: Fitted,
    jumps: &[Jump],
    wanted: &Wanted,
    options: &Options,
) -> Result<Option<Found>, FitError> {
    let spikes = Spikes::none(&nominal.problem);
    let mut search = Search::new(nominal, spikes, wanted, options);
    if search.take_jumps(jumps)? { search.found() } else { Ok(None) }
}

impl Search<'_> {
    /// Searches to the end. `None` where nominal parameters are not determined.
    fn found(self) -> Result<Option<Found>, FitError> {
        let mut search = self;
        if !search.grow()? {
            return Ok(None);
        }
        let mut round = 0;
        loop {
            round += 1;
            search.take_members()?;
            let Some(competed) = search.compete()? else { return Ok(None) };
            if round < ROUNDS
                && (search.take_implausible(&competed)?
                    || search.take_out_curved(&competed)?
                    || search.take_beyond_linear(&competed)?
                    || search.take_noise(&competed)?
                    || search.take_rows(&competed)?
                    || search.take_curved(&competed)?
                    || search.take_spikes(&competed)?)
            {
                continue;
            }
            let Competed { linear, judged, .. } = &competed;
            let name = |term: usize| linear.terms[term].name.clone();
            let named = judged.objections.iter().map(|(term, why)| (name(*term), why.clone()));
            search.objections.extend(named);
            let Search { left_out: outliers, spikes, noise, objections, log, unseen, .. } = search;
            let unseen = unseen.unwrap_or_default();
            let mut left_out = spikes.left_out;
            left_out.extend(outliers);
            return Ok(Some(Found { competed, left_out, noise, unseen, objections, log }));
        }
    }
}

impl<'a> Search<'a> {
    /// One that begins with a nominal fit.
    fn new(nominal: Fitted, spikes: Spikes, wanted: &Wanted, options: &'a Options) -> Self {
        Self {
            records: Records::of(&nominal.problem),
            still: still_readings(&nominal),
            wanted: wanted.clone(),
            options,
            fitted: nominal.clone(),
            nominal,
            rows: Vec::new(),
            refused: Vec::new(),
            objections: Vec::new(),
            absorbed: Vec::new(),
            seen: Vec::new(),
            with_members: Vec::new(),
            left_out: LeftOut::default(),
            first_spikes: spikes.clone(),
            spikes,
            has_judged_spikes: false,
            outliers: Vec::new(),
            noise: Vec::new(),
            unseen: None,
            scanned: Families::default(),
            changes: Vec::new(),
            tried_changes: Vec::new(),
            log: Log::new(),
        }
    }

    /// Whether a relaxed form of an effect did not stand.
    fn is_refused(&self, name: &str, form: Variant) -> bool {
        self.refused.iter().any(|(own, other)| own == name && *other == Some(form))
    }

    /// A selection in which what did not stand has no part.
    fn selection<'l>(&self, linear: &'l Linear) -> Selection<'l> {
        let mut selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
        for own in selection.terms.iter_mut().filter(|own| own.is_effect()) {
            // Without an effect there is no relaxed form of it.
            let is_refused = |(name, form): &(String, Option<Variant>)| {
                own.name == *name && form.is_none_or(|form| own.variant == Some(form))
            };
            own.may_enter &= !self.refused.iter().any(is_refused);
        }
        selection
    }

    /// The same under the noise scale factors of a competition.
    fn selection_of<'l>(&self, competed: &'l Competed) -> Selection<'l> {
        let mut selection = self.selection(&competed.linear);
        selection.adopt_scale(&competed.scale);
        selection
    }

    /// Rows, blocks and change points compete, and rows are judged. `None` where nominal parameters
    /// are not determined.
    fn compete(&mut self) -> Result<Option<Competed>, FitError> {
        let linear =
            Linear::new(self.fitted.clone(), &self.rows, &self.wanted, true, &mut self.scanned);
        // The fit may be another one when this is called again.
        self.scanned.effects.clear();
        let Some(mut linear) = linear else { return Ok(None) };
        linear.without_own_covariates(&self.still);
        let mut model = linear.rows();
        let first = self.first_changes(&linear, &model);
        linear.with_changes(&first);
        let mut scale: Vec<f64> = Vec::new();
        let mut instead = None;
        for round in 0..=CHANGE_ROUNDS {
            let mut selection = self.selection(&linear);
            let pools = Pools::of(&selection);
            model = selection.search(&model, &pools, &mut self.log);
            scale.clone_from(&selection.scale);
            if self.take_changes(&linear, &selection, &model)? {
                self.changes.clear();
                return self.compete();
            }
            if round < CHANGE_ROUNDS && selection.has_most_blocks(&model) {
                instead = instead_of_blocks(&linear, &selection, &model);
                if instead.is_some() {
                    break;
                }
            }
            let found =
                if round < CHANGE_ROUNDS { linear.changes(&selection, &model) } else { Vec::new() };
            linear.terms = selection.terms;
            let before = linear.terms.len();
            linear.with_changes(&found);
            if linear.terms.len() == before {
                break;
            }
        }
        self.changes = linear.changes_in(&model);
        let mut selection = self.selection(&linear);
        selection.adopt_scale(&scale);
        let instead = instead.or_else(|| instead_of_blocks(&linear, &selection, &model));
        if let Some(noise) = instead {
            drop(selection);
            self.log.push("noise explains more than blocks".to_owned());
            let fitted = linear.fitted.clone();
            match noise {
                Instead::Autocorrelated(noise) => self.take_autocorrelation(fitted, &noise)?,
                Instead::OfRuns(noise) => self.take_noise_of_runs(fitted, &noise)?,
            }
            return self.compete();
        }
        let pools = Pools::of(&selection);
        let judged = selection.judge(model, pools, &linear, &mut self.log);
        selection.set_scale(&judged.model);
        let scale = selection.scale.clone();
        linear.terms = selection.terms;
        self.changes = linear.changes_in(&judged.model);
        Ok(Some(Competed { linear, judged, scale }))
    }

    /// The change points with which a competition begins: those of the last model, or, where blocks
    /// would enter beside the rows, those that are found beside these. A block that imitates a change
    /// would enter first otherwise, and others to mend it.
    fn first_changes(&self, linear: &Linear, model: &[usize]) -> Vec<Change> {
        if !self.changes.is_empty() {
            return linear.known_changes(&self.changes);
        }
        let mut selection = self.selection(linear);
        selection.set_scale(model);
        let has_structure = selection.best_block(model, &Pools::of(&selection)).is_some();
        if has_structure { linear.changes(&selection, model) } else { Vec::new() }
    }
}
