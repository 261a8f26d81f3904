//! homepoint calibrates instruments in motion and finds out why simulation and reality differ.
//!
//! The layers, top to bottom; each imports only from the ones above it:
//!
//! | layer | rooms |
//! |---|---|
//! | number | [`number`], [`units`], [`quaternion`], [`statistics`] |
//! | language | [`diagnostic`], [`formula`], [`graph`], [`document`], [`progress`] |
//! | nouns | [`model`], [`effect`], [`convention`], [`library`], [`campaign`], [`system`] |
//! | engine | [`engine`] |
//! | estimate | [`estimate`] |
//! | diagnose | [`diagnose`] |
//! | trials | [`trials`] |
//! | faces | [`report`], `cli` |

pub mod number;
pub mod quaternion;
pub mod statistics;
pub mod units;

pub mod diagnostic;
pub mod document;
pub mod formula;
pub mod graph;
pub mod progress;

pub mod campaign;
pub mod convention;
pub mod effect;
pub mod library;
pub mod model;
pub mod system;

pub mod engine;

pub mod estimate;

pub mod diagnose;

pub mod trials;

pub mod report;

#[cfg(feature = "cli")]
pub mod cli;

#[cfg(test)]
#[path = "../tests/problems/stream.rs"]
mod stream;
