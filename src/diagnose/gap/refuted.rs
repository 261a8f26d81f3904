//! Whether effects are borne out by readings that they were not fitted to.

use crate::diagnose::search::Adopted;

use super::Gap;

/// Whether named effects fail on the readings that they were not fitted to: what they take off
/// there is below a quarter of what they take off where they were fitted, by more than chance does.
/// A value that is learnt from half of a run costs twice there what it costs with all readings.
pub(in crate::diagnose) fn is_refuted(gap: &Gap, effects: &[Adopted]) -> bool {
    gap.closed.is_some() && gap.held_out_drop < least_drop(gap.lambda.powi(2), degrees(effects))
}

/// The degrees of freedom of some effects together.
pub(in crate::diagnose) fn degrees(effects: &[Adopted]) -> usize {
    effects.iter().map(|one| one.score.degrees).sum()
}

/// The least drop on held-out readings of effects with so many values that take so much off where
/// they were fitted.
fn least_drop(learnt: f64, degrees: usize) -> f64 {
    0.25 * learnt - 2.0 * degrees as f64 - REFUTED * 2.0 * learnt.sqrt()
}

/// Standard deviations by which a held-out drop must be too small.
const REFUTED: f64 = 3.0;

#[cfg(test)]
mod tests {
    use super::least_drop;

    #[test]
    fn only_a_clear_failure_on_held_out_readings_refutes() {
        // Large effects of one value must show there; small ones, and those with a value for each
        // of forty runs, may even do harm.
        assert!(least_drop(2500.0, 1) > 300.0);
        assert!(least_drop(64.0, 1) < 0.0 && least_drop(144.0, 40) < -100.0);
        assert!(least_drop(144.0, 12) > -172.0, "a slip that a clock's rate does not explain");
    }
}
