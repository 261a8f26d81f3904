//! Every estimator on the named problems.

#![expect(clippy::unwrap_used, reason = "a failed test should stop")]

mod problems;

#[path = "estimate/align.rs"]
mod align;
#[path = "estimate/arrow.rs"]
mod arrow;
#[path = "estimate/batch.rs"]
mod batch;
#[path = "estimate/observability.rs"]
mod observability;
