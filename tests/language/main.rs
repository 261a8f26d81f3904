//! The language: formulas to trees, trees to graphs, effects as patches, rates.
#![expect(clippy::unwrap_used, reason = "a failed test should stop")]

mod bench;
mod delayed;
mod faults;
mod functions;
mod meanings;
mod parsing;
mod patches;
mod rates;
