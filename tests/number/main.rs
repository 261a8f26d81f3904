//! Numbers: units, derivatives of elementary functions, quaternions, Stumpff functions.
#![expect(clippy::unwrap_used, reason = "a failed test should stop")]

mod elementary;
mod quaternion;
mod stumpff;
mod units;
