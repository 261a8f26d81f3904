//! What spoils a fit, before anything else is judged: it is left out and reported.
//!
//! | file | answers |
//! |---|---|
//! | `misstated` | a stated value that is wrong altogether |
//! | `settle` | the nominal fit, without what keeps it from settling |
//! | `codes` | numbers that stand in the place of readings |
//! | `frozen` | readings that repeat the last one while the instrument moves on |
//! | `bursts`, `places` | stretches of wrong readings, and whether they come back at a place |
//! | `spikes`, `trimmed` | readings that bend a fit, and a fit that they do not bend |
//! | [`lost`], `shifted` | stretches of readings shifted by whole samples, and by other times |
//! | [`wild`] | readings and runs that are far out |
//! | `empty_runs` | runs of which nothing is left |
//! | [`left_out`] | how what is left out is told |
//! | [`mod@twice`] | what that does to the delays |

mod bursts;
pub(super) mod codes;
pub(super) mod empty_runs;
pub(super) mod frozen;
pub mod left_out;
pub mod lost;
pub(super) mod misstated;
mod places;
pub(super) mod settle;
mod shifted;
pub(super) mod spikes;
mod trimmed;
pub mod twice;
pub mod wild;
