//! Transients are left out of the fit: no term has their form, and other structure would imitate it.

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::noise::leave_out;
use crate::diagnose::budget::transients::MOST;
use crate::diagnose::outliers::records::Records;
use crate::estimate::batch::FitError;

use super::Search;

impl Search<'_> {
    /// Leaves transients out that explain more than any term beside the rows; whether there are such.
    pub(super) fn take_transients(&mut self, linear: &Linear) -> Result<bool, FitError> {
        let model = linear.rows();
        if linear.fitted.problem.has_autocorrelated_noise() {
            return Ok(false);
        }
        let mut selection = self.selection(linear);
        selection.set_scale(&model);
        let found = linear.transients(&selection, &model);
        drop(selection);
        let Some(first) = found.first() else { return Ok(false) };
        let known = self.transients.iter().filter(|one| one.is_like(first)).count();
        if known + found.len() > MOST {
            return Ok(false);
        }
        // What has sharp ends is a burst.
        if self.take_spikes(linear)? {
            return Ok(true);
        }
        let mut fitted = linear.fitted.clone();
        self.records.put_into(&mut fitted.problem);
        for one in &found {
            let (part, run, measurand) = one.at;
            let data = &mut fitted.problem.parts[part];
            let columns = data.slots()[measurand].columns();
            data.runs[run].record.leave_out([(one.samples.clone(), columns)]);
            self.log.push(format!("{} is left out", one.place.words));
        }
        self.records = Records::of(&fitted.problem);
        self.outliers.retain(|one| !found.iter().any(|own| own.has(linear, one.at)));
        self.left_out = leave_out(&mut fitted.problem, linear, &self.outliers);
        self.transients.extend(found);
        self.changes.clear();
        self.seen_outliers.clear();
        self.fitted = fitted.again(self.options)?;
        Ok(true)
    }
}
