//! A measurement campaign: runs of an instrument on a rig, with units settled and signals ready.
//!
//! | file | answers |
//! |---|---|
//! | [`mod@file`] | what campaign.toml says, with the place of everything |
//! | [`load`] | a campaign file read against its model |
//! | [`table`] | a CSV file (plain or .gz) as columns in SI, with the place of every cell |
//! | [`signal`] | a moving input: local Taylor series or smoothing spline |
//! | [`run`] | one run; the samples of a stretch of it: times, inputs, readings |
//! | [`record`] | all samples of a run, however long: held in memory or spilled to a temporary file |
//! | [`recorder`] | samples taken in their order and kept as a record, within a budget of memory |
//! | [`plan`] | a run that is not measured yet |
//! | [`specification`] | what the maker of the instrument promises to follow |
//! | [`mod@write`] | a campaign of the same form, files whole or not at all |

pub mod entries;
pub mod file;
pub mod header;
mod lines;
pub mod load;
pub mod overrides;
pub mod plan;
mod readings;
pub mod record;
pub mod recorder;
pub mod run;
mod samples;
pub mod signal;
mod smoothing;
pub mod specification;
mod spill;
pub mod spline;
pub mod table;
pub mod write;

pub use record::{Record, Stretch};
pub use run::{Role, Run, Samples};
pub use signal::Track;
