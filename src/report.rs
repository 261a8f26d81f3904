//! Results for people and programs.
//!
//! | file | answers |
//! |---|---|
//! | [`conditions`] | transformations, their bias, self-calibration, agreement of campaigns |
//! | [`conventions`], `typed_columns` | conventions that were mistaken; what to type instead |
//! | [`deviations`] | deviations of runs, and what the head must follow |
//! | [`budget`] | uncertainty budgets of delays |
//! | [`figure`] | a value with its standard uncertainty as people write it |
//! | [`global`] | whether chi squared agrees with what is stated |
//! | [`json`] | the keys that programs rely on, `docs/formats.md` section 6 |
//! | `layout` | tables as the terminal shows them |
//! | [`text`] | tables and sentences for the terminal |
//! | [`diagnosis`], `gap`, `diagnosis_text`, `verdict_text`, `noise_text`, `next` | why simulation and reality differ, for programs and for people |
//! | [`trials`], `trials_text` | how well a diagnosis does on campaigns whose truth is known |
//! | [`trials_replay`], `trials_replay_text` | recorded trials made again, and what differs |
//! | [`power`], `power_text` | what a campaign can see |
//! | [`timing`] | how reference times came about |
//! | [`correlations`] | estimates that are correlated, and the covariance of all |
//! | [`members`] | members of families that were chosen |
//! | [`noise`] | for which noise uncertainties hold |
//! | [`smoothing`] | what errors of smoothed streams add to readings |
//! | `sentences` | sums of parameters, and why a fit is no result |
//! | [`table`] | results reading by reading, as CSV |

pub mod autocorrelation;
pub mod budget;
pub mod conditions;
pub mod conventions;
pub mod correlations;
pub mod deviations;
pub mod diagnosis;
#[cfg(feature = "cli")]
pub mod diagnosis_text;
pub mod figure;
mod gap;
pub mod global;
pub mod json;
#[cfg(feature = "cli")]
pub(crate) mod layout;
pub mod left_out;
#[cfg(feature = "cli")]
mod linear_range;
pub mod members;
pub mod minima;
#[cfg(feature = "cli")]
mod next;
pub mod noise;
#[cfg(feature = "cli")]
mod noise_text;
pub mod power;
#[cfg(feature = "cli")]
pub mod power_text;
#[cfg(feature = "cli")]
mod rows_text;
mod sentences;
pub mod smoothing;
pub mod table;
#[cfg(feature = "cli")]
pub mod text;
pub mod timing;
pub mod trials;
pub mod trials_replay;
#[cfg(feature = "cli")]
pub mod trials_replay_text;
#[cfg(feature = "cli")]
pub mod trials_text;
mod typed_columns;
#[cfg(feature = "cli")]
mod verdict_text;
