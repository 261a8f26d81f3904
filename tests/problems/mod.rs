//! Named problems with known solutions, for every estimator.

pub(crate) mod linear;
pub(crate) mod wahba;

/// A reproducible stream of numbers in [-1, 1) (Knuth's MMIX generator).
pub(crate) struct Stream(pub(crate) u64);

impl Stream {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
