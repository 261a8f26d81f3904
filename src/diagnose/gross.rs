//! What spoils a fit, before anything else is judged: it is left out and told.
//!
//! | file | answers |
//! |---|---|
//! | `misstated` | a stated value that is wrong altogether |
//! | `settle` | the nominal fit, without what keeps it from settling |
//! | `codes` | numbers that stand in the place of readings |
//! | `spikes`, `trimmed` | readings that bend a fit, and a fit that they do not bend |
//! | [`lost`] | stretches of readings shifted by whole samples |
//! | [`wild`] | readings and runs that are far out |
//! | `empty_runs` | runs of which nothing is left |
//! | [`left_out`] | how what is left out is told |
//! | [`mod@twice`] | what that does to the delays |

pub(super) mod codes;
pub(super) mod empty_runs;
pub mod left_out;
pub mod lost;
pub(super) mod misstated;
pub(super) mod settle;
pub(super) mod spikes;
mod trimmed;
pub mod twice;
pub mod wild;
