//! Competition: rows, blocks and change points on one linearised fit, and the judgement of the rows.

use crate::diagnose::budget::judge::Judged;
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::noise::{components, isolated_outliers};
use crate::diagnose::budget::noise_or_blocks::{Instead, instead_of_blocks};
use crate::diagnose::budget::search::Pools;
use crate::diagnose::budget::terms::Change;
use crate::estimate::batch::FitError;

use super::Search;

/// Rounds in which change points are looked for.
const CHANGE_ROUNDS: usize = 2;

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

/// A model, and the noise scale factors under which it was found.
type Scaled = (Vec<usize>, Vec<f64>);

impl Search<'_> {
    /// Rows, blocks and change points compete, and rows are judged. `None` where nominal parameters
    /// are not determined.
    pub(super) fn compete(&mut self) -> Result<Option<Competed>, FitError> {
        let linear =
            Linear::new(self.fitted.clone(), &self.rows, &self.wanted, true, &mut self.scanned);
        // The fit may be another one when this is called again.
        self.scanned.effects.clear();
        let Some(mut linear) = linear else { return Ok(None) };
        linear.without_own_covariates(&self.no_covariates);
        let Some((model, scale)) = self.searched(&mut linear)? else { return self.compete() };
        let mut selection = self.selection(&linear);
        selection.adopt_scale(&scale);
        let pools = Pools::of(&selection);
        let judged = selection.judge(model, pools, &linear, &mut self.log);
        selection.set_scale(&judged.model);
        let scale = selection.scale.clone();
        linear.terms = selection.terms;
        self.changes = linear.changes_in(&judged.model);
        Ok(Some(Competed { linear, judged, scale }))
    }

    /// The model of rows, blocks and change points that explains most, with its noise scale factors.
    /// `None` where something goes into the fit first: changes that are large, or noise that explains
    /// more than blocks.
    fn searched(&mut self, linear: &mut Linear) -> Result<Option<Scaled>, FitError> {
        let mut model = linear.rows();
        let first = self.first_changes(linear, &model);
        linear.with_changes(&first);
        if self.take_transients(linear)? {
            return Ok(None);
        }
        let mut scale: Vec<f64> = Vec::new();
        let mut instead = None;
        let may_change = self.may_change_noise();
        for round in 0..=CHANGE_ROUNDS {
            let mut selection = self.selection(linear);
            let pools = Pools::of(&selection);
            model = selection.search(&model, &pools, &mut self.log);
            scale.clone_from(&selection.scale);
            if self.take_changes(linear, &selection, &model)? {
                self.changes.clear();
                return Ok(None);
            }
            if round < CHANGE_ROUNDS && selection.has_most_blocks(&model) {
                instead = instead_of_blocks(linear, &selection, &model, may_change);
                if instead.is_some() {
                    // The model may have blocks that were reduced beside rows.
                    linear.terms = selection.terms;
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
        let mut selection = self.selection(linear);
        selection.adopt_scale(&scale);
        let instead = instead.or_else(|| instead_of_blocks(linear, &selection, &model, may_change));
        let Some(noise) = instead else { return Ok(Some((model, scale))) };
        if matches!(noise, Instead::Autocorrelated(_)) {
            // What is wrong in one reading would be in the predictions of those behind it.
            model.retain(|term| linear.terms[*term].is_effect());
            let mut found =
                isolated_outliers(&components(linear, &selection, &model, &mut |_, _| {}));
            found.extend(self.outliers.iter().copied());
            if self.take_outliers(linear, found)? {
                return Ok(None);
            }
        }
        drop(selection);
        self.log.push("noise explains more than blocks".to_owned());
        let fitted = linear.fitted.clone();
        match noise {
            Instead::Autocorrelated(noise) => self.take_autocorrelation(fitted, &noise)?,
            Instead::OfRuns(noise) => self.take_noise_of_runs(fitted, &noise)?,
        }
        Ok(None)
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
