//! Stamps of a counter that begins anew, made to go on.

/// How much of the counter's size a row may come late by.
const LATE: f64 = 0.05;

/// A counter of stamps, by its size (s).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wraps {
    size: f64,
    /// How often it began anew.
    count: f64,
    last: f64,
}

impl Wraps {
    /// A counter of a size, at its beginning.
    pub(crate) fn new(size: f64) -> Self {
        Self { size, count: 0.0, last: f64::NAN }
    }

    /// The next stamp as if the counter had no end.
    ///
    /// Where a stamp lies before the last one by more than half the size the counter began anew. A
    /// row that comes late, from before that, keeps its place.
    pub(crate) fn next(&mut self, stamp: f64) -> f64 {
        if stamp.is_nan() {
            return stamp;
        }
        let mut value = stamp + self.count * self.size;
        if self.last - value > 0.5 * self.size {
            self.count += 1.0;
            value += self.size;
        } else if value - self.last > (1.0 - LATE) * self.size {
            return value - self.size;
        }
        self.last = value;
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_goes_on_where_it_begins_anew_and_late_rows_keep_their_place() {
        let mut wraps = Wraps::new(100.0);
        let stamps = [10.0, 70.0, 99.0, 1.0, 98.5, 2.0, 60.0, 95.0, 4.0];
        let found = stamps.map(|stamp| wraps.next(stamp));
        assert_eq!(found, [10.0, 70.0, 99.0, 101.0, 98.5, 102.0, 160.0, 195.0, 204.0]);
    }
}
