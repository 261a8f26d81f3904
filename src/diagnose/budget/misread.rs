//! The answer where a convention was mistaken.

use crate::estimate::conventions::Mistaken;

use super::answer::{Diagnosis, Verdict};

impl Diagnosis {
    /// The answer with the convention that was mistaken. What was found in numbers that were misread is
    /// worth nothing: it is no part of the answer, unless the convention is doubtful, or the numbers fit
    /// about as well as they stand once a stated value is free.
    #[must_use]
    pub fn with_mistaken(mut self, mistaken: Option<Mistaken>) -> Self {
        self.mistaken = mistaken;
        let factor = self.nominal.variance_factor().unwrap_or(f64::INFINITY);
        if let Some(mistaken) = &mut self.mistaken {
            let free = self.set_free.clone();
            mistaken.stated = free.filter(|_| mistaken.is_as_good_as(factor));
        }
        if !self.is_misread() {
            return self;
        }
        Self {
            mistaken: self.mistaken,
            not_testable: self.not_testable,
            ..Self::without_search(self.nominal, Verdict::Unknown)
        }
    }

    /// Whether numbers were misread, and nothing else explains as much.
    pub fn is_misread(&self) -> bool {
        self.mistaken.as_ref().is_some_and(|one| !one.is_doubtful() && one.stated.is_none())
    }
}
