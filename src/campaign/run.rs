//! One run: its name, its setup, what it is for and what was recorded.

use crate::campaign::record::Record;

pub use crate::campaign::samples::Samples;

/// What a run is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// Slow or static: fixes the transformation.
    Reference,
    /// In motion.
    Kinematic,
}

/// One run of a campaign.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its name, unique in the campaign.
    pub name: String,
    /// Index of its setup in [`crate::campaign::load::Campaign::setups`].
    pub setup: usize,
    /// Reference or kinematic.
    pub role: Role,
    /// What was recorded.
    pub record: Record,
}

impl Run {
    /// All samples in memory, see [`Record::whole`].
    pub fn held(&self) -> &Samples {
        self.record.whole()
    }
}
