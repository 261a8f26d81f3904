//! From where on something counts in `power`, and where it is lost among the readings.

/// Probability of any false declaration, split evenly over effects, blocks and noise.
pub const FALSE_ALARMS: f64 = 0.01;
/// Effects are not adopted below this length of their signature: their shrinkage is noise.
pub const LEAST_LAMBDA: f64 = 5.0;
/// Effects whose gains differ less cannot be told apart: the 1 % point of chi squared of two
/// degrees.
pub const ALIKE: f64 = 9.2;
/// Of fewer runs none is judged beside the others.
pub const LEAST_RUNS: usize = 4;

/// The level of a test among so many, for a third of the false alarms.
pub fn level(tests: usize) -> f64 {
    (FALSE_ALARMS / 3.0 / tests.max(1) as f64).ln()
}
