//! The noise for which an estimate's uncertainties hold, as data.

use crate::engine::gauss_markov::GaussMarkov;

/// The noise of which an estimate takes account.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Noise {
    /// As stated.
    #[default]
    Stated,
    /// As estimated, for each measurand.
    Autocorrelated(Vec<Estimated>),
    /// As the scores of clusters scatter.
    Sandwich(Clusters),
}

/// The noise of a measurand, estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimated {
    /// Name.
    pub measurand: String,
    /// The campaign, where there are several.
    pub of: Option<String>,
    /// Standard deviation over what is stated.
    pub level: f64,
    /// For each component the part of it that is autocorrelated; `None` where it is white.
    pub components: Vec<Option<GaussMarkov>>,
    /// Whether it is correlated over rows, for the data have no times.
    pub is_over_rows: bool,
}

/// Over what scores are summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clusters {
    /// How many clusters.
    pub count: usize,
    /// Samples of each; `None`: each is a run.
    pub samples: Option<usize>,
}
