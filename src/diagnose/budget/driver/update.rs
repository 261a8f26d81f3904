//! What a round found goes into the fit: effects on the noise, rows that stand; and rows that do not
//! stand leave it.

use crate::diagnose::budget::in_fit::effect_of;
use crate::diagnose::budget::judge::Objection;
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::neighbours::without_shared;
use crate::diagnose::budget::noise::{Outlier, few_are_far, leave_out, noise};
use crate::diagnose::budget::noise_of_runs::OfRun;
use crate::diagnose::budget::noise_or_blocks::OfComponent;
use crate::diagnose::budget::terms::{Term, without};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::variant::Variant;
use crate::engine::gram::LeastSquares;
use crate::estimate::batch::FitError;

use super::{Competed, Search};

/// How often autocorrelated noise is estimated anew.
const NOISE_CHANGES: usize = 2;

impl Search<'_> {
    /// Takes what is found in the noise into the problem; whether there was something.
    pub(super) fn take_noise(&mut self, competed: &Competed) -> Result<bool, FitError> {
        let Competed { linear, judged, .. } = competed;
        let selection = self.selection_of(competed);
        let whole = self.with_all_readings(linear);
        let all = whole.as_ref().unwrap_or(linear);
        let may_change = self.may_change_noise();
        let mut found = noise(all, &selection, &judged.model, &self.outliers, may_change);
        without_shared(&mut found.outliers, all, &selection, &judged.model);
        few_are_far(&mut found.outliers);
        drop(selection);
        if self.take_jitter(competed, found.jitter)? {
            return Ok(true);
        }
        let mut outliers = found.outliers;
        if whole.is_none() {
            outliers.extend(self.outliers.iter().copied());
        }
        if self.take_outliers(linear, outliers)? {
            return Ok(true);
        }
        if found.autocorrelation.is_empty() {
            return Ok(false);
        }
        // What a linear step to rows that are not yet in the fit leaves is no noise.
        let is_new =
            |term: &usize| linear.terms[*term].is_effect() && !linear.rows().contains(term);
        if judged.model.iter().any(is_new) && self.take_rows(competed)? {
            return Ok(true);
        }
        let fitted = self.without_rows(&failed(competed), linear, linear.fitted.clone())?;
        self.take_autocorrelation(fitted, &found.autocorrelation)?;
        Ok(true)
    }

    /// Leaves exactly these readings out, where that is another set than before, and one that was not tried
    /// beside the same rows and noise; whether it is.
    pub(super) fn take_outliers(
        &mut self,
        linear: &Linear,
        mut outliers: Vec<Outlier>,
    ) -> Result<bool, FitError> {
        outliers.sort_by_key(|one| one.at);
        let places = |all: &[Outlier]| all.iter().map(|one| one.at).collect::<Vec<_>>();
        let mut rows: Vec<_> =
            self.rows.iter().map(|row| (row.name.clone(), row.variant)).collect();
        rows.sort_by(|a, b| a.0.cmp(&b.0));
        // Models beside the same rows may take each other's outliers back without end.
        let before = (rows.clone(), places(&self.outliers));
        let new = (rows, places(&outliers));
        if !self.seen_outliers.contains(&before) {
            self.seen_outliers.push(before);
        }
        if self.seen_outliers.contains(&new) {
            return Ok(false);
        }
        self.log.push(format!("{} outliers are left out", outliers.len()));
        let mut fitted = linear.fitted.clone();
        self.records.put_into(&mut fitted.problem);
        self.left_out = leave_out(&mut fitted.problem, linear, &outliers);
        self.outliers = outliers;
        self.fitted = fitted.again(self.options)?;
        Ok(true)
    }

    /// The linearised fit over all readings, with those that earlier rounds left out: whether they
    /// are outliers is judged again by each model. `None` where nothing is left out, or where the
    /// noise of a reading is that of its neighbour, too.
    fn with_all_readings(&self, linear: &Linear) -> Option<Linear> {
        if self.outliers.is_empty() || linear.fitted.problem.has_autocorrelated_noise() {
            return None;
        }
        let mut whole = linear.clone();
        self.records.put_into(&mut whole.fitted.problem);
        whole.fitted.problem.reweight(&linear.fitted.fit.point);
        Some(whole)
    }

    /// Whether autocorrelated noise may be estimated anew.
    pub(super) fn may_change_noise(&self) -> bool {
        self.noise_changes < NOISE_CHANGES
    }

    /// Goes on with autocorrelated noise.
    pub(super) fn take_autocorrelation(
        &mut self,
        mut fitted: Fitted,
        found: &[OfComponent],
    ) -> Result<(), FitError> {
        let parts = &fitted.problem.parts;
        let is_known = |one: &OfComponent| parts[one.0].gauss_markov[one.1].is_some();
        self.noise_changes += usize::from(found.iter().any(is_known));
        for (part, row, noise) in found {
            for one in noise.processes() {
                self.log.push(format!(
                    "autocorrelated noise in component {row}: share {:.2}, {:.3e} s",
                    one.share, one.time
                ));
            }
            fitted.problem.parts[*part].gauss_markov[*row] = Some(*noise);
        }
        self.seen_outliers.clear();
        self.fitted = fitted.again(self.options)?;
        Ok(())
    }

    /// Goes on with noise that differs from run to run.
    pub(super) fn take_noise_of_runs(
        &mut self,
        mut fitted: Fitted,
        found: &[OfRun],
    ) -> Result<(), FitError> {
        let names = fitted.problem.run_names();
        for (number, run, measurand, factor) in found {
            let name = &names[fitted.problem.run_index(*number, *run)];
            let part = &mut fitted.problem.parts[*number];
            let known = &part.system.assembly.names.measurands[*measurand].name;
            self.log.push(format!("{factor:.2} times the noise of `{known}` in run `{name}`"));
            if part.run_levels.is_empty() {
                part.run_levels = vec![vec![1.0; part.sigma.len()]; part.runs.len()];
            }
            part.run_levels[*run][*measurand] = *factor;
        }
        self.seen_outliers.clear();
        self.fitted = fitted.again(self.options)?;
        Ok(())
    }

    /// Takes effects that did not stand out of the competition, or lets those in again whose values
    /// differ between groups of readings, with values of their own, and those that had such values
    /// in the library's form; whether there are such.
    fn refuse(&mut self, competed: &Competed) -> bool {
        let (mut relaxed, mut narrowed) = (false, false);
        // What leaves the fit, but stays in the model without a name, competes again.
        let stays = |term: &usize| {
            competed.judged.nameless.contains(term) && competed.linear.rows().contains(term)
        };
        let is_out = |(term, _): &&(usize, Objection)| !stays(term);
        for (term, objection) in competed.judged.objections.iter().filter(is_out) {
            let own = &competed.linear.terms[*term];
            let form = match objection {
                Objection::Apart(label, _) => label.variant(),
                _ => None,
            };
            let is_open = |form: &Variant| {
                own.variants.contains(form)
                    && !self.wanted.variants.contains_key(&own.name)
                    && !self.is_refused(&own.name, *form)
            };
            if let Some(form) = form.filter(is_open) {
                self.log.push(format!("{} with {}", own.name, form.words()));
                self.wanted.variants.insert(own.name.clone(), form);
                relaxed = true;
            } else {
                self.refused.push((own.name.clone(), own.variant));
                self.objections.push((own.name.clone(), objection.clone()));
                // The library's form may stand where that with more values does not.
                narrowed |= self.wanted.variants.remove(&own.name).is_some();
            }
        }
        if narrowed {
            // What was judged beside the wrong form is judged again.
            self.refused.retain(|(_, form)| form.is_some());
            self.objections.clear();
        }
        relaxed || narrowed
    }

    /// Takes rows out of the fit whose values, beside all that entered after them, cannot be; whether there
    /// are such.
    pub(super) fn take_implausible(
        &mut self,
        Competed { linear, .. }: &Competed,
    ) -> Result<bool, FitError> {
        let can_be = |row: &usize| {
            !linear.terms[*row].is_effect() || linear.is_plausible(&linear.fitted, *row)
        };
        let leave: Vec<usize> = linear.rows().into_iter().filter(|row| !can_be(row)).collect();
        if leave.is_empty() {
            return Ok(false);
        }
        for row in &leave {
            self.refuse_size(&linear.terms[*row]);
        }
        self.fitted = self.without_rows(&leave, linear, linear.fitted.clone())?;
        Ok(true)
    }

    /// The fit without some of the rows that are in it. The library's form of each may come back.
    pub(super) fn without_rows(
        &mut self,
        leave: &[usize],
        linear: &Linear,
        mut fitted: Fitted,
    ) -> Result<Fitted, FitError> {
        for row in leave {
            let name = &linear.terms[*row].name;
            if let Some(selected) = effect_of(&fitted, name).cloned() {
                fitted = fitted.without(&[&selected], self.options)?;
            }
            self.rows.retain(|own| own.name != *name);
            self.wanted.variants.remove(name);
            self.log.push(format!("{name} leaves the fit"));
        }
        Ok(fitted)
    }

    /// Puts the rows that stand into the fit, and no others; whether the fit changed.
    pub(super) fn take_rows(&mut self, competed: &Competed) -> Result<bool, FitError> {
        let Competed { linear, judged, .. } = competed;
        let relaxed = self.refuse(competed);
        let stands =
            |term: &&usize| linear.terms[**term].is_effect() && !judged.nameless.contains(*term);
        let wanted: Vec<usize> = judged.model.iter().filter(stands).copied().collect();
        let in_fit = linear.rows();
        let stays = |row: &usize| {
            let is_change = !linear.terms[*row].is_effect() && judged.model.contains(row);
            is_change || wanted.contains(row)
        };
        let leave: Vec<usize> = in_fit.iter().copied().filter(|row| !stays(row)).collect();
        let enter: Vec<usize> =
            wanted.iter().copied().filter(|row| !in_fit.contains(row)).collect();
        let mut names: Vec<String> =
            wanted.iter().map(|term| linear.terms[*term].name.clone()).collect();
        names.sort_unstable();
        if !relaxed && ((leave.is_empty() && enter.is_empty()) || self.seen.contains(&names)) {
            return Ok(false);
        }
        self.seen.push(names);
        let selection = self.selection_of(competed);
        let mut fitted = linear.fitted.clone();
        fitted = self.without_rows(&leave, linear, fitted)?;
        for term in &enter {
            let rest = without(&judged.model, *term);
            let start = linear.start(&selection, &rest, *term);
            let selected = &linear.candidates[linear.terms[*term].candidate].selected;
            let with = fitted.with(selected, &start, self.options)?;
            let is_fitted = with.is_some();
            if let Some(with) = with.filter(Fitted::is_sound) {
                if !linear.is_plausible(&with, *term) {
                    self.refuse_size(&linear.terms[*term]);
                    continue;
                }
                self.rows.push(linear.row(*term));
                self.log.push(format!("{} enters the fit", linear.terms[*term].name));
                fitted = with;
            } else {
                let Term { name, variant, .. } = &linear.terms[*term];
                self.refused.push((name.clone(), *variant));
                let objection = (name.clone(), Objection::NotConverged);
                self.objections.extend(is_fitted.then_some(objection));
            }
        }
        self.fitted = fitted;
        Ok(true)
    }
}

/// Rows in the fit that did not stand: other noise than that under which they were judged is no reason to
/// keep them, and beside it they may be named again.
fn failed(Competed { linear, judged, .. }: &Competed) -> Vec<usize> {
    let mut failed = linear.rows();
    failed.retain(|row| judged.objections.iter().any(|(term, _)| term == row));
    failed
}
