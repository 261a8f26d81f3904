//! A file with what its columns seem to be.

use crate::campaign::begin::guess::Guess;
use crate::campaign::begin::survey::Survey;

/// A log.
#[derive(Clone, Debug)]
pub(super) struct Log {
    pub(super) survey: Survey,
    pub(super) guess: Guess,
}

impl Log {
    /// The mean time between its rows (s).
    pub(super) fn spacing(&self) -> Option<f64> {
        let time = self.guess.time.as_ref()?;
        let values = &self.survey.columns[time.column].values;
        let span = values.last()? - values.first()?;
        Some(span * time.unit.factor / self.survey.rows().max(1) as f64)
    }
}
