//! homepoint calibrates instruments in motion and finds out why simulation and reality differ.
//!
//! The layers, top to bottom; each imports only from the ones above it:
//!
//! | layer | rooms |
//! |---|---|
//! | number | [`number`], [`units`], [`quaternion`] |
//! | language | [`diagnostic`], [`formula`], [`graph`], [`document`] |

pub mod number;
pub mod quaternion;
pub mod units;

pub mod diagnostic;
pub mod document;
pub mod formula;
pub mod graph;
