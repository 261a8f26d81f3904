//! Bursts and spikes once more, beside the effects that are in the fit: effects may have hidden them,
//! or made them up.

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::noise::leave_out;
use crate::diagnose::outliers::records::Records;
use crate::estimate::batch::FitError;

use super::Search;

impl Search<'_> {
    /// Judges bursts and spikes beside the rows, once; whether others than before are left out.
    pub(super) fn take_spikes(&mut self, linear: &Linear) -> Result<bool, FitError> {
        let has_none_to_judge = self.rows.is_empty() || !self.transients.is_empty();
        if has_none_to_judge || std::mem::replace(&mut self.has_judged_spikes, true) {
            return Ok(false);
        }
        let mut fitted = linear.fitted.clone();
        if !self.spikes.judge(&mut fitted.problem, &fitted.fit.point) {
            return Ok(false);
        }
        self.log.push("bursts and spikes are judged again".to_owned());
        self.records = Records::of(&fitted.problem);
        leave_out(&mut fitted.problem, linear, &self.outliers);
        self.fitted = fitted.again(self.options)?;
        Ok(true)
    }
}
