//! What users see: the program in a terminal, the shipped examples, the keys of JSON, whole
//! answers.
#![expect(clippy::unwrap_used, reason = "a failed test should stop")]

#[path = "../problems/drawn.rs"]
mod drawn;
#[path = "../common/folder.rs"]
mod folder;
#[path = "../problems/scale.rs"]
mod scale;
#[path = "../problems/stream.rs"]
mod stream;

mod begun_beside;
mod delays_of_runs;
mod effects_elsewhere;
mod examples;
mod examples_again;
mod held_delays;
mod joint_fit;
mod json_keys;
mod left_out;
mod misread;
mod sessions;
mod spilled_campaigns;
mod terminal;
mod time_zones;
mod units_of_results;
mod written_over;
