//! The driver: effects enter one after the other, each with a nonlinear refit and a new
//! linearisation; then basis blocks and change points compete with them, rows are judged, and the
//! noise is looked at in what all of that leaves. What is found in the noise, and rows that did not
//! stand, lead to another round.

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
use super::judge::Objection;
use super::linear::Linear;
use super::no_covariates::NoCovariates;
use super::noise::{Outlier, ReadingAt};
use super::search::Log;
use super::selection::Selection;
use super::terms::Change;
use super::transients::Transient;

mod compete;
mod curved_rows;
mod fitted_changes;
mod forward;
mod jitter;
mod jumps;
mod levels;
mod members;
mod relax;
mod spikes;
mod suspected;
mod transients;
mod update;
mod usual_values;

pub use self::compete::Competed;
use self::suspected::Displaced;

/// Rounds of structure and noise, and those until rows of the last model are in the fit.
const ROUNDS: usize = 5;
const LAST_ROUND: usize = ROUNDS + 3;

/// Rows, by name and form, and the places of readings.
type Tried = (Vec<(String, Option<Variant>)>, Vec<ReadingAt>);

/// What the driver found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The last linearisation, with the rows that are in the fit.
    pub competed: Competed,
    /// Readings that were left out.
    pub left_out: LeftOut,
    /// Transients among them.
    pub transients: Vec<Transient>,
    /// Effects on the noise.
    pub noise: Vec<NoiseEffect>,
    /// Effects that show in no reading beside the nominal model.
    pub unseen: Unseen,
    /// Effects that did not stand as rows, in all rounds, with the reason.
    pub objections: Vec<(String, Objection)>,
    /// What was done, step by step.
    pub log: Log,
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
    /// Effects of the library that do not enter beside one of the user's own.
    displaced: Vec<Displaced>,
    /// Transients, which are left out, too.
    transients: Vec<Transient>,
    /// What a block may not be over.
    no_covariates: NoCovariates,
    /// What is left out, and the runs of each campaign with all readings.
    outliers: Vec<Outlier>,
    records: Records,
    /// Rows in the fit with the places of what was left out beside them, under the same noise.
    seen_outliers: Vec<Tried>,
    noise: Vec<NoiseEffect>,
    /// How often autocorrelated noise was estimated anew.
    noise_changes: usize,
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
            let is_changed = if round < ROUNDS {
                search.take(&competed)?
            } else {
                round < LAST_ROUND && search.take_rows(&competed)?
            };
            if is_changed {
                continue;
            }
            let Competed { linear, judged, .. } = &competed;
            let name = |term: usize| linear.terms[term].name.clone();
            let named = judged.objections.iter().map(|(term, why)| (name(*term), why.clone()));
            search.objections.extend(named);
            let Search { left_out: outliers, spikes, transients, noise, .. } = search;
            let Search { objections, log, unseen, .. } = search;
            let unseen = unseen.unwrap_or_default();
            let mut left_out = spikes.left_out;
            left_out.extend(outliers);
            let problem = &competed.linear.fitted.problem;
            left_out.stretches.extend(transients.iter().map(|one| one.stretch(problem)));
            return Ok(Some(Found {
                competed,
                left_out,
                transients,
                noise,
                unseen,
                objections,
                log,
            }));
        }
    }

    /// Takes the first of what a round found into the fit, or out of it; whether there was something.
    fn take(&mut self, competed: &Competed) -> Result<bool, FitError> {
        Ok(self.take_implausible(competed)?
            || self.take_out_curved(competed)?
            || self.take_beyond_linear(competed)?
            || self.take_levels(competed)?
            || self.take_noise(competed)?
            || self.take_rows(competed)?
            || self.take_curved(competed)?
            || self.take_copy(competed)?
            || self.take_spikes(&competed.linear)?)
    }
}

impl<'a> Search<'a> {
    /// One that begins with a nominal fit.
    fn new(nominal: Fitted, spikes: Spikes, wanted: &Wanted, options: &'a Options) -> Self {
        Self {
            records: Records::of(&nominal.problem),
            no_covariates: NoCovariates::of(&nominal),
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
            displaced: Vec::new(),
            transients: Vec::new(),
            outliers: Vec::new(),
            seen_outliers: Vec::new(),
            noise: Vec::new(),
            noise_changes: 0,
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
        let rows = linear.rows();
        let is_in_fit = |name: &str| rows.iter().any(|row| linear.terms[*row].name == name);
        for one in self.displaced.iter().filter(|one| is_in_fit(&one.own) && !is_in_fit(&one.copy))
        {
            let copies = selection.terms.iter_mut().filter(|own| own.name == one.copy);
            copies.for_each(|own| own.may_enter = false);
        }
        selection
    }

    /// The same under the noise scale factors of a competition.
    fn selection_of<'l>(&self, competed: &'l Competed) -> Selection<'l> {
        let mut selection = self.selection(&competed.linear);
        selection.adopt_scale(&competed.scale);
        selection
    }
}
