//! The engine: graphs over readings, in lanes and by definition; effects in them; noise;
//! simulation.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a failed test should stop")]

#[path = "../common/folder.rs"]
mod folder;
#[path = "../problems/planned.rs"]
mod planned;
#[path = "../problems/seed.rs"]
mod seed;

mod by_hand;
mod correlated;
mod effects;
mod effects_absorbed;
mod effects_in_readings;
mod functions;
mod lane_math;
mod lanes;
mod order_of_runs;
mod seed_models;
mod signatures;
mod simulated_effects;
