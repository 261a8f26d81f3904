//! What users write: models, effects, the library, campaigns and their recordings.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a failed test should stop")]

#[path = "../common/folder.rs"]
mod folder;
#[path = "../problems/stream.rs"]
mod stream;

mod begin;
mod begin_alike;
mod begin_planar;
mod begin_stops;
mod campaign;
mod dates;
mod every_effect;
mod exports;
mod faults;
mod files;
mod formats;
mod forms;
mod guides;
mod larger_than_memory;
mod limits;
mod models;
mod order;
mod outside_streams;
mod parquet;
mod preambles;
mod recorded;
mod sexagesimal;
mod spline;
mod stamps_and_formulas;
mod stamps_in_columns;
mod timing_faults;
