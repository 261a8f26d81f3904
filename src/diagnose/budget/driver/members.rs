//! Members of families once more: a period that was found beside the first rows is off where other rows
//! hid in what it explained. Beside all of them each is looked for again.

use crate::diagnose::evidence::members::with_best_member;
use crate::estimate::batch::FitError;

use super::Search;

impl Search<'_> {
    /// Looks for the members of rows again, once for each set of rows; whether one is another.
    pub(super) fn take_members(&mut self) -> Result<bool, FitError> {
        let mut names: Vec<String> = self.rows.iter().map(|row| row.name.clone()).collect();
        names.sort_unstable();
        // What entered alone was looked for beside nothing else.
        if names.len() < 2 || self.with_members.contains(&names) {
            return Ok(false);
        }
        let mut is_other = false;
        for row in 0..self.rows.len() {
            let name = self.rows[row].name.clone();
            if let Some((with, members)) = with_best_member(&self.fitted, &name, self.options)? {
                self.log.push(format!("another member of {name}"));
                self.rows[row].members = members;
                self.fitted = with;
                is_other = true;
            }
        }
        self.with_members.push(names);
        Ok(is_other)
    }
}
