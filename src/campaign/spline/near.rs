//! Values of a curve at moments that follow each other: the piece of the last one is near.

use super::Spline;

impl Spline {
    /// [`Spline::at`] for a number, where `piece` (of the last call) is likely near: samples come
    /// in the order of time, so pieces are found in a few steps.
    pub fn at_near(&self, time: f64, offset: f64, order: u8, piece: &mut usize) -> f64 {
        let x = offset + (time - self.origin);
        let last = self.pieces.len();
        if last == 0 || !(self.knots[0] <= x && x < self.knots[last]) {
            return self.at(time, offset, order);
        }
        let near = (*piece).min(last - 1);
        let is_inside = self.knots[near] <= x && x < self.knots[near + 1];
        *piece = if is_inside { near } else { self.enclosing(near, x) };
        self.within(*piece, x, order)
    }

    /// The piece that encloses `x`, which lies within the knots: from a near one over distances that
    /// double until the knots enclose it, then by halves.
    fn enclosing(&self, near: usize, x: f64) -> usize {
        let last = self.pieces.len();
        let (mut low, mut high, mut reach) = (near, near + 1, 1);
        while self.knots[low] > x {
            high = low;
            low = low.saturating_sub(reach);
            reach *= 2;
        }
        while self.knots[high] <= x {
            low = high;
            high = (high + reach).min(last);
            reach *= 2;
        }
        low + self.knots[low..high].partition_point(|knot| *knot <= x) - 1
    }
}
