//! Whether a way left that still shrinks is worth another step. What a step is, is not its business.

/// Steps without a comparison of costs that may fail to halve the remaining way.
const BLIND_STEPS: usize = 8;
/// Iterations in a row in which the way left shrinks, after which a fit may go on beyond its limit, up
/// to so many times as many.
const STEADY: usize = 10;
const LONGER: usize = 3;

/// A way left that shrinks slowly, but each time: where the noise of signals is in the derivatives,
/// all steps are too short by one factor.
#[derive(Default)]
pub(super) struct Shrinking {
    last: f64,
    times: usize,
}

impl Shrinking {
    /// Notes the way left; whether so many iterations are enough.
    pub(super) fn may_end(&mut self, way: f64, iterations: usize, limit: usize) -> bool {
        self.times = if way < self.last { self.times + 1 } else { 0 };
        self.last = way;
        iterations > limit && (self.times < STEADY || iterations > limit.saturating_mul(LONGER))
    }
}

/// Steps so near to the end that costs cannot be compared: the way left must keep shrinking.
#[derive(Default)]
pub(super) struct Blind {
    best: Option<f64>,
    failures: usize,
}

impl Blind {
    /// Notes the way left; whether it has long stopped shrinking.
    pub(super) fn is_lost(&mut self, way: f64) -> bool {
        match self.best {
            Some(best) if way > 0.5 * best => self.failures += 1,
            _ => {
                self.best = Some(way);
                self.failures = 0;
            }
        }
        self.failures > BLIND_STEPS
    }
}
