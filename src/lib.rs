//! homepoint calibrates instruments in motion and finds out why simulation and reality differ.
//!
//! The layers, top to bottom; each imports only from the ones above it:
//!
//! | layer | rooms |
//! |---|---|
//! | number | [`number`], [`units`], [`quaternion`] |

pub mod number;
pub mod quaternion;
pub mod units;
