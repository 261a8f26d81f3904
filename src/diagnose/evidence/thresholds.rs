//! From where on something counts: what search, noise and verdict have in common.

/// Probability of any false declaration, split evenly over effects, blocks and noise. What is
/// looked for once these are settled comes on top of it: ringing has a tenth of that, and levels
/// and wild readings are named by the level of the noise again.
pub const FALSE_ALARMS: f64 = 0.01;
/// Effects are not adopted below this length of their signature: their shrinkage is noise.
pub const LEAST_LAMBDA: f64 = 5.0;
/// Logarithms of probabilities that differ less do not tell effects apart: half of [`ALIKE`].
pub const TIE: f64 = 4.6;
/// Effects whose gains differ less cannot be told apart: the 1 % point of chi squared of two
/// degrees.
pub const ALIKE: f64 = 9.2;
/// Share that an effect must explain to be named although its form does not fit: the one from which
/// on two effects count as one name. Neighbours in a library explain up to .976 of each other.
pub const NAMED: f64 = 0.98;
/// An effect that is less probable than this is no name for what is there: its size is far from
/// what is usual, or something that nobody wrote down does as much with less.
pub const LEAST_PROBABLE: f64 = 0.001;
/// Odds against two effects of the library in a place that one unknown cause would do for, and
/// against displacements that nobody wrote down where a walk would do.
pub const FURTHER: f64 = 1000.0;
/// Of fewer runs none is judged beside the others.
pub const LEAST_RUNS: usize = 4;

/// The level of a test among so many, for a third of the false alarms.
pub fn level(tests: usize) -> f64 {
    (FALSE_ALARMS / 3.0 / tests.max(1) as f64).ln()
}
