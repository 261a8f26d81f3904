//! Estimates: Newton and batch, their uncertainties and budgets, on named problems, simulations and
//! recordings.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a failed test should stop")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/folder.rs"]
mod folder;
#[path = "../problems/mod.rs"]
mod problems;
#[path = "../problems/scale.rs"]
mod scale;
#[path = "../problems/seed.rs"]
mod seed;

mod absorbed;
mod align;
mod answers;
mod arrow;
mod attitude_streams;
mod autocorrelation;
mod batch;
mod bounds_and_priors;
mod certificates;
mod components;
mod conventions;
mod coordinates_mistaken;
mod correlations;
mod coverage;
mod delay_budget;
mod deviations;
mod far_clocks;
mod farthest;
mod hostile_numbers;
mod nested;
mod nist;
mod no_slope;
mod noise_model;
mod nothing_moves;
mod observability;
mod other_angles;
mod other_turns;
mod other_values;
mod overstated;
mod practice;
mod real_recordings;
mod remedies;
mod roles;
mod seed_uncertainty;
mod setups;
mod shared_statements;
mod signs;
mod small_readings;
mod smoothed_streams;
mod stated_sigmas;
mod stationary;
mod time_referencing;
mod traceability;
mod turns;
mod two_routes;
mod units_mistaken;
mod units_of_heads;
mod units_of_logs;
mod units_of_one_run;
