//! Named problems with known solutions, for every estimator.

pub(crate) mod camera;
pub(crate) mod line;
pub(crate) mod linear;
pub(crate) mod load_cell;
mod stream;
pub(crate) mod wahba;

pub(crate) use stream::Stream;

impl Stream {
    /// A number in [-1, 1).
    pub(crate) fn next(&mut self) -> f64 {
        2.0 * self.uniform() - 1.0
    }
}
