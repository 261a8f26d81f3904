//! The one stream of pseudo-random numbers of tests and unit tests.

/// A reproducible stream of numbers (Knuth's MMIX generator), from its seed.
pub(crate) struct Stream(pub(crate) u64);

impl Stream {
    /// A number in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number of mean 0 and variance 1: the sum of twelve uniform ones is normal enough.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}
