//! The diagnosis: what was put into readings comes out, with its place; power before any reading;
//! trials.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a failed test should stop")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../problems/drawn.rs"]
mod drawn;
#[path = "../common/folder.rs"]
mod folder;
#[path = "../problems/load_cell.rs"]
mod load_cell;
#[path = "../problems/nameless.rs"]
mod nameless;
#[path = "../problems/stream.rs"]
mod stream;

mod apart_by_chance;
mod backlash;
mod beside_remainder;
mod between_runs;
mod budget;
mod bursts;
mod changed_runs;
mod clock_steps;
mod codes;
mod confounded;
mod contrast_of_runs;
mod copied_inputs;
mod correlation_times;
mod curved;
mod designs;
mod each_effect;
mod errors_of_inputs;
mod fast_oscillations;
mod finer_than_bends;
mod forms_in_one_run;
mod found;
mod jumps_of_clocks;
mod levels;
mod lone_outliers;
mod losses_under_load;
mod members;
mod mistaken_for_noise;
mod moments;
mod moved_anchor;
mod no_readings;
mod noise;
mod noise_far_beyond;
mod noise_of_runs;
mod other_measurands;
mod over_angles;
mod own_effects;
mod parts;
mod places;
mod power;
mod practice;
mod prior;
mod products;
mod repeating_motion;
mod replay;
mod runs;
mod runs_in_sequence;
mod sensitivities;
mod several_causes;
mod situations;
mod sizes;
mod stated_values;
mod streams;
mod suspected;
mod table_of_stops;
mod too_small;
mod transients;
mod trials;
mod unknown;
mod values_of_runs;
mod variants;
mod waves_over_lengths;
mod waves_over_runs;
mod waves_over_time;
mod weak_noise;
mod written;
mod wrong_setups;
