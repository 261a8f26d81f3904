//! A measurement campaign: runs of an instrument on a rig, with units settled and signals ready.
//!
//! | file | answers |
//! |---|---|
//! | [`mod@file`] | what campaign.toml says, with the place of everything |
//! | [`load`] | a campaign file read against its model |
//! | `logged` | a logged stream made into a signal: turns taken out, glitches told |
//! | `overlap` | runs of one setup that seem to be recorded at the same time |
//! | [`table`] | a CSV file (plain or .gz) or a Parquet file as columns in SI, with the place of every cell |
//! | `row`, `lines` | a line of it as numbers; its lines, one after the other |
//! | `undecided` | which of two rows is bad where time runs backwards |
//! | [`signal`] | a moving input: local Taylor series or smoothing spline |
//! | `points`, `smoothing`, [`spline`] | a stream gathered into knots; how much to smooth it; the curve |
//! | [`run`] | one run |
//! | [`samples`] | the samples of a run or a stretch of it: times, inputs, readings |
//! | [`record`] | all samples of a run, however long: held in memory or spilled to a temporary file |
//! | `spill`, `spilled` | numbers in a temporary file; them as samples |
//! | [`recorder`] | samples taken in their order and kept as a record, within a budget of memory |
//! | [`timing`] | when a reading was asked for: captures made into reference times |
//! | [`calibration`] | an input's certificate: corrections, and what they leave open |
//! | [`statement`] | how well a value is known, as a certificate states it |
//! | [`plan`] | a run that is not measured yet |
//! | [`specification`] | what the maker of the instrument promises to follow |
//! | [`whole`] | a file that is whole or not there |
//! | [`mod@write`], [`write_run`] | a campaign of the same form |

pub mod calibration;
mod captured;
pub mod entries;
pub mod file;
pub mod header;
mod lines;
pub mod load;
mod loader;
mod logged;
mod overlap;
pub mod overrides;
#[cfg(feature = "parquet")]
mod parquet;
pub mod plan;
mod points;
mod readings;
pub mod record;
pub mod recorder;
mod row;
pub mod run;
pub mod samples;
pub mod signal;
mod smoothing;
pub mod specification;
mod spill;
mod spilled;
pub mod spline;
pub mod statement;
pub mod table;
pub mod timing;
mod undecided;
pub mod whole;
pub mod write;
pub mod write_run;

pub use record::{Record, Sample, Stretch};
pub use run::{Role, Run};
pub use samples::Samples;
pub use signal::Track;
