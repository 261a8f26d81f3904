//! The answer, put together from what the driver found. It looks for nothing.

use std::collections::HashSet;

use crate::diagnose::library::prior::Prior;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::Estimate;
use crate::estimate::contradicted::contradicted;
use crate::estimate::linear_range::{BeyondRange, beyond_range};

use super::answer::{Diagnosis, Doubtful, FAR_BEYOND_STATED, Findings, decide};
use super::driver::{Competed, Found};
use super::judge::{Judged, Objection};
use super::linear::Linear;
use super::noise_scale::{autocorrelation, levels, scatter, white_scale};
use super::search::Pools;
use super::selection::Selection;
use super::solved::Solved;
use super::terms::without;

mod candidates;
mod remainder;
mod rows;
mod size;

impl Diagnosis {
    /// Puts the answer together beside the nominal calibration.
    pub fn of(mut self, found: Found, prior: &Prior, options: &Options) -> Result<Self, FitError> {
        let Found { competed, left_out, transients, noise, unseen, objections, log } = found;
        let Competed { linear, judged, scale } = competed;
        let mut selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
        selection.adopt_scale(&scale);
        // What did not stand is a rival of a row still, and whole blocks that were reduced beside it.
        let reduced: Vec<_> = linear.terms.iter().filter_map(|term| term.reduced_from).collect();
        for (number, term) in selection.terms.iter_mut().enumerate() {
            if term.is_effect()
                && term.variant.is_none()
                && !judged.model.contains(&number)
                && unseen.has(&term.name)
            {
                term.columns.clear();
            }
            let is_rival = term.is_effect() || term.may_enter || reduced.contains(&number);
            term.may_enter = is_rival && !term.columns.is_empty();
        }
        let of_transients: f64 = transients.iter().map(|one| one.gain.excess()).sum();
        let budget = Budget::new(&linear, &selection, &judged, of_transients);
        self.left_out.extend(left_out);
        self.noise = noise;
        self.levels = levels(&linear, &scale);
        self.autocorrelation = autocorrelation(&linear.fitted.problem);
        self.log = log;
        let in_fit = selection.rows_of(&linear.rows());
        let stands: Vec<usize> = (0..judged.model.len())
            .filter(|at| {
                in_fit.contains(&judged.model[*at]) && !judged.nameless.contains(&judged.model[*at])
            })
            .collect();
        let rest: Vec<usize> = (0..judged.model.len()).filter(|at| !stands.contains(at)).collect();
        let gains = selection.contributions(&judged.model);
        let parts = budget.parts(&rest);
        let solved = Solved::of(&selection, &judged.model, &rest, &gains);
        if !stands.is_empty() {
            let found = budget.rows(&stands, (&rest, &parts), &gains, options)?;
            self.rows = found.rows;
            self.gap = Some(found.gap);
            self.contradicted = contradicted(&found.explained);
            self.steps = Some(found.steps);
            self.explained = Some(found.explained);
        }
        let last = self.explained.as_ref().unwrap_or(&self.nominal);
        // Of a row the value that is reported: beside the remainder, which the fit does not have.
        let mut estimates = last.estimates();
        let of_rows: Vec<&Estimate> = self.rows.iter().flat_map(|row| &row.values).collect();
        for one in &mut estimates {
            let same = |own: &&&Estimate| own.name == one.name && own.of == one.of;
            one.value = of_rows.iter().find(same).map_or(one.value, |own| own.value);
        }
        self.beyond_range = beyond_range(&last.problem, &estimates);
        self.remainder = budget.remainder((&rest, &parts), &gains, &solved);
        self.remainder.extend(budget.of_inputs());
        if !transients.is_empty() {
            self.remainder.extend(transients.iter().map(|one| budget.transient(one)));
            self.remainder.sort_by(|a, b| b.share.total_cmp(&a.share));
        }
        let (has_rows, has_remainder) = (!self.rows.is_empty(), !self.remainder.is_empty());
        let is_part =
            |parameter: &str| self.remainder.iter().any(|one| one.place.is_of_stated(parameter));
        // In the fit with rows a stated value may be contradicted by what the remainder does.
        self.contradicted.retain(|one| !has_remainder || is_part(&one.parameter));
        // Beside rows, a row may absorb in the fit what a stated value in the remainder does.
        if self.contradicted.is_empty() {
            self.contradicted = contradicted(&self.nominal);
            self.contradicted.retain(|one| !has_rows || is_part(&one.parameter));
        }
        self.doubtful = budget.doubtful(&objections);
        // Another form of it may stand.
        self.doubtful.retain(|one| !self.rows.iter().any(|row| row.name == one.name));
        let doubtful = self.doubtful.iter().flat_map(|one| &one.values);
        self.beyond_range.extend(doubtful.filter_map(|one| {
            let setting = linear.candidates.iter().find_map(|own| own.setting(&one.parameter))?;
            let whose = (one.parameter.as_str(), one.of.as_deref());
            BeyondRange::of(setting, whose, one.value, &one.unit)
        }));
        (self.candidates, self.causes) = budget.candidates(prior);
        self.absorbed = unseen.absorbed;
        self.absorbed.retain(|one| !self.rows.iter().any(|row| row.name == one.name));
        self.not_testable = unseen.not_testable;
        let white = white_scale(&linear, &scale);
        let largest_scale = white.iter().copied().fold(0.0, f64::max);
        if largest_scale > FAR_BEYOND_STATED {
            self.remainder.extend(scatter(&linear, &white));
        }
        self.verdict = decide(Findings {
            rows: self.rows.len(),
            remainder: self.remainder.len(),
            noise: self.noise.len()
                + self.autocorrelation.len()
                + self.levels.iter().filter(|one| one.run.is_some()).count()
                + usize::from(!self.left_out.is_empty()),
            largest_scale,
        });
        Ok(self)
    }
}

/// A model on its sums.
struct Budget<'a> {
    linear: &'a Linear,
    selection: &'a Selection<'a>,
    model: &'a [usize],
    /// Terms of it that are too small for a name.
    nameless: &'a [usize],
    pools: Pools,
    /// What transients would add to chi squared.
    of_transients: f64,
    /// What the model takes off chi squared, with that.
    total: f64,
}

impl<'a> Budget<'a> {
    fn new(
        linear: &'a Linear,
        selection: &'a Selection<'a>,
        judged: &'a Judged,
        of_transients: f64,
    ) -> Self {
        let Judged { model, nameless, .. } = judged;
        let explained = selection.chi_squared(&[]) - selection.chi_squared(model);
        let (pools, total) = (Pools::of(selection), explained + of_transients);
        Self { linear, selection, model, nameless, pools, of_transients, total }
    }

    /// Effects that did not stand as rows, the last reason of each.
    fn doubtful(&self, objections: &[(String, Objection)]) -> Vec<Doubtful> {
        let Self { linear, selection, .. } = self;
        let mut found = Vec::new();
        let mut seen = HashSet::new();
        for (name, objection) in objections.iter().rev() {
            let term = (0..linear.terms.len()).find(|n| linear.terms[*n].name == *name);
            let Some(term) = term.filter(|_| seen.insert(name)) else { continue };
            let rows = without(&selection.rows_of(self.model), term);
            let gain = selection.gain(&rows, term);
            if objection.leaves_candidate(gain) {
                found.push(Doubtful {
                    name: name.clone(),
                    gain,
                    objection: objection.clone(),
                    values: linear.sizes(selection, &rows, term),
                });
            }
        }
        found
    }
}
