//! Which of two rows has the wrong time where time runs backwards: the one before, if two rows go
//! on from where those before it left off, else the later one.
//!
//! A stamp that is far ahead would else make all rows after it bad. A row is taken once the one
//! after it is known.

/// A row of which nothing is wrong but, perhaps, its time.
#[derive(Debug)]
pub(crate) struct Row {
    /// Its line.
    pub(crate) number: usize,
    pub(crate) time: f64,
    pub(crate) cells: Vec<f64>,
}

/// What is known of some rows once another one is read.
#[derive(Debug, Default)]
pub(crate) struct Decided {
    /// One to be taken.
    pub(crate) taken: Option<Row>,
    /// Bad ones, with why.
    pub(crate) bad: Vec<(usize, String)>,
    /// The time after which the others are to come, if not that of the row that was read.
    pub(crate) goes_on_after: Option<f64>,
}

/// Rows of which it is not known yet whether they are bad.
#[derive(Debug, Default)]
pub(crate) struct Undecided {
    /// Time of the last row that was taken.
    taken: Option<f64>,
    /// The last row in the order of time.
    last: Option<Row>,
    /// One that came after it with a time before it, but not before those that were taken, and what
    /// is said of it.
    late: Option<(Row, String)>,
}

impl Undecided {
    /// A row in the order of time.
    pub(crate) fn next(&mut self, row: Row) -> Decided {
        let bad = self.late.take().map(|(late, why)| (late.number, why)).into_iter().collect();
        let taken = self.last.replace(row);
        self.taken = taken.as_ref().map_or(self.taken, |row| Some(row.time));
        Decided { taken, bad, goes_on_after: None }
    }

    /// A row whose time comes before that of the last one, and what is to be said of it.
    pub(crate) fn late(&mut self, row: Row, why: String) -> Decided {
        if self.taken.is_some_and(|taken| row.time < taken) {
            return Decided { bad: vec![(row.number, why)], ..Decided::default() };
        }
        match self.late.take() {
            None => {
                self.late = Some((row, why));
                Decided::default()
            }
            Some((late, _)) if late.time <= row.time => {
                let ahead = self.last.take().map(|last| {
                    let Row { number, time, .. } = last;
                    let go_on = late.time;
                    (
                        number,
                        format!(
                            "{time} s is ahead of the rows that follow, which go on at {go_on} s"
                        ),
                    )
                });
                let goes_on_after = Some(row.time);
                self.taken = Some(late.time);
                self.last = Some(row);
                Decided { taken: Some(late), bad: ahead.into_iter().collect(), goes_on_after }
            }
            Some((late, said)) => {
                let bad = vec![(late.number, said)];
                self.late = Some((row, why));
                Decided { bad, ..Decided::default() }
            }
        }
    }

    /// No row follows.
    pub(crate) fn end(&mut self) -> Decided {
        let bad = self.late.take().map(|(late, why)| (late.number, why)).into_iter().collect();
        Decided { taken: self.last.take(), bad, goes_on_after: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows that are taken and those that are bad, by their times.
    fn judged(times: &[f64]) -> (Vec<f64>, Vec<usize>) {
        let mut undecided = Undecided::default();
        let (mut taken, mut bad) = (Vec::new(), Vec::new());
        let mut last = f64::NEG_INFINITY;
        let mut note = |decided: Decided| {
            taken.extend(decided.taken.map(|row| row.time));
            bad.extend(decided.bad.into_iter().map(|one| one.0));
            decided.goes_on_after
        };
        for (number, time) in times.iter().copied().enumerate() {
            let row = Row { number, time, cells: vec![time] };
            if time >= last {
                note(undecided.next(row));
                last = time;
            } else if let Some(after) = note(undecided.late(row, String::new())) {
                last = after;
            }
        }
        note(undecided.end());
        (taken, bad)
    }

    #[test]
    fn the_row_is_bad_that_does_not_go_with_the_others() {
        assert_eq!(judged(&[0.0, 1.0, 1.0, 2.0]), (vec![0.0, 1.0, 1.0, 2.0], vec![]));
        // Ahead: within a run, at its beginning and, where one row alone follows, not.
        assert_eq!(
            judged(&[0.0, 1.0, 1e9, 3.0, 4.0, 5.0]),
            (vec![0.0, 1.0, 3.0, 4.0, 5.0], vec![2])
        );
        assert_eq!(judged(&[1e9, 1.0, 2.0]), (vec![1.0, 2.0], vec![0]));
        assert_eq!(judged(&[0.0, 1e9, 2.0]), (vec![0.0, 1e9], vec![2]));
        // Behind: by little, by much, twice, and where a clock starts anew.
        assert_eq!(judged(&[0.0, 1.0, 2.0, 1.5, 3.0]), (vec![0.0, 1.0, 2.0, 3.0], vec![3]));
        assert_eq!(judged(&[0.0, 1.0, 2.0, -5.0, 3.0]), (vec![0.0, 1.0, 2.0, 3.0], vec![3]));
        assert_eq!(judged(&[0.0, 1.0, 3.0, 2.5, 2.0, 4.0]), (vec![0.0, 1.0, 3.0, 4.0], vec![3, 4]));
        assert_eq!(judged(&[5.0, 6.0, 0.0, 1.0, 2.0]), (vec![5.0, 6.0], vec![2, 3, 4]));
        // Two that are ahead, one after the other.
        assert_eq!(judged(&[0.0, 1e9, 1.0, 2.0, 1e9, 3.0, 4.0]).0, [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(judged(&[]), (vec![], vec![]));
    }
}
