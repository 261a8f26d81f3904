//! The driver: effects enter one after the other, each with a nonlinear refit and a new
//! linearisation; then basis blocks and change points compete with them, rows are judged, and the
//! noise is looked at in what all of that leaves. What is found in the noise, and rows that did not
//! stand, lead to another round.

use std::collections::BTreeSet;

use crate::campaign::Record;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{LeftOut, NoiseEffect};
use crate::diagnose::library::variant::Variant;
use crate::diagnose::library::wanted::Wanted;
use crate::estimate::batch::{FitError, Options};

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
use crate::diagnose::thresholds::ENTER;

mod beyond_linear;
mod curved;
mod forward;
mod relax;
mod update;

/// Rounds in which change points are looked for.
const CHANGE_ROUNDS: usize = 2;
/// Change points that enter the competition in a round at most.
const MOST_CHANGES: usize = 4;
/// Rounds of structure and noise.
const ROUNDS: usize = 5;

/// What the driver found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The last linearisation.
    pub linear: Linear,
    /// The rows that are in the fit.
    pub rows: Vec<Row>,
    /// The model on it.
    pub judged: Judged,
    /// Noise scale factor of each measurand.
    pub scale: Vec<f64>,
    /// Readings that were left out.
    pub left_out: LeftOut,
    /// Effects on the noise.
    pub noise: Vec<NoiseEffect>,
    /// Effects that did not stand as rows, in all rounds, with the reason.
    pub objections: Vec<(String, Objection)>,
    /// What was done, step by step.
    pub log: Log,
}

/// A linearised fit with the model that a competition of terms left, and its noise scale factors.
struct Competed {
    linear: Linear,
    judged: Judged,
    scale: Vec<f64>,
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
    /// Sets of rows that were in the fit.
    seen: Vec<Vec<String>>,
    left_out: LeftOut,
    /// Measurands that hardly vary.
    still: BTreeSet<String>,
    /// What is left out, and the runs of each campaign with all readings.
    outliers: Vec<Outlier>,
    records: Vec<Vec<Record>>,
    noise: Vec<NoiseEffect>,
    /// Best members of families: of blocks, as they were found beside the first rows; of effects, as
    /// they were found last.
    scanned: Families,
    /// Change points of the last model with their blocks: the next one begins with them.
    changes: Vec<(String, Change)>,
    log: Log,
}

/// Searches from a fitted nominal model. `None` where its parameters are not determined.
///
/// # Errors
/// [`FitError`] where a model cannot be fitted at all.
pub fn search(
    nominal: Fitted,
    wanted: &Wanted,
    options: &Options,
) -> Result<Option<Found>, FitError> {
    let mut search = Search::new(nominal, wanted, options);
    if !search.grow()? {
        return Ok(None);
    }
    let mut round = 0;
    loop {
        round += 1;
        let Some(competed) = search.compete()? else { return Ok(None) };
        if round < ROUNDS
            && (search.take_beyond_linear(&competed)?
                || search.take_noise(&competed)?
                || search.take_rows(&competed)?
                || search.take_curved(&competed)?)
        {
            continue;
        }
        search.objections.extend(named_objections(&competed));
        let Competed { linear, judged, scale } = competed;
        let Search { rows, left_out, noise, objections, log, .. } = search;
        let found = Found { linear, rows, judged, scale, left_out, noise, objections, log };
        return Ok(Some(found));
    }
}

impl<'a> Search<'a> {
    /// One that begins with a nominal fit.
    fn new(nominal: Fitted, wanted: &Wanted, options: &'a Options) -> Self {
        let parts = nominal.problem.parts.iter();
        let records = parts.map(|part| part.runs.iter().map(|run| run.record.clone()).collect());
        Self {
            records: records.collect(),
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
            left_out: LeftOut::default(),
            outliers: Vec::new(),
            noise: Vec::new(),
            scanned: Families::default(),
            changes: Vec::new(),
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
        for (term, own) in linear.terms.iter().enumerate() {
            // Without an effect there is no relaxed form of it.
            let is_refused = |(name, form): &(String, Option<Variant>)| {
                own.name == *name && form.is_none_or(|form| own.variant == Some(form))
            };
            let is_refused = own.is_effect() && self.refused.iter().any(is_refused);
            selection.live[term] &= !is_refused && own.may_enter;
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
            if round < CHANGE_ROUNDS && selection.has_most_blocks(&model) {
                instead = instead_of_blocks(&linear, &selection, &model);
                if instead.is_some() {
                    break;
                }
            }
            let found = if round < CHANGE_ROUNDS {
                changes(&linear, &selection, &model)
            } else {
                Vec::new()
            };
            let (terms, live) = (selection.terms, selection.live);
            linear.take_terms(terms, live);
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
        let (terms, live) = (selection.terms, selection.live);
        linear.take_terms(terms, live);
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
        if has_structure { changes(linear, &selection, model) } else { Vec::new() }
    }
}

fn named_objections(competed: &Competed) -> Vec<(String, Objection)> {
    let name = |term: usize| competed.linear.terms[term].name.clone();
    competed.judged.objections.iter().map(|(term, why)| (name(*term), why.clone())).collect()
}

/// Change points beside a model, and beside the model without each of its rows, that are worth
/// their price: the best of each kind.
fn changes(linear: &Linear, selection: &Selection<'_>, model: &[usize]) -> Vec<Change> {
    let mut found = linear.changes(selection, model);
    let ln_bayes = |one: &Change| selection.ln_bayes_factor_of_change(one);
    found.retain(|one| ln_bayes(one) >= ENTER);
    found.sort_by(|a, b| ln_bayes(b).total_cmp(&ln_bayes(a)));
    Change::keep_one_of_a_kind(&mut found, MOST_CHANGES);
    found
}
