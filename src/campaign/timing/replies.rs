//! When replies came on a serial line, and where the arm was then.
//!
//! The time from request to reply (start bit to start bit) is not a delay: a reading can be true of
//! a moment long before it is sent. Like the request each reply has its place on the arm (Depenthal
//! 2009, section 2.3): the inputs captured with the request, moved along their rates. All replies
//! count in the summary; the first [`KEPT`] of a run are kept one by one.

use crate::campaign::captured::{columns_of, moved};
use crate::campaign::table::Table;

/// Replies of a run that are kept one by one.
pub const KEPT: usize = 1 << 17;

/// What a number does over a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Over {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub standard_deviation: f64,
    /// Smallest.
    pub smallest: f64,
    /// Largest.
    pub largest: f64,
}

/// The replies of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RequestToReply {
    /// The run.
    pub run: String,
    /// Replies captured.
    pub count: usize,
    /// The time from request to reply (s).
    pub time: Over,
    /// By how much each captured input moved meanwhile (SI).
    pub moved: Vec<(String, Over)>,
    /// The first replies, one by one.
    pub replies: Vec<Captured>,
}

/// A request and its reply.
#[derive(Clone, Debug, PartialEq)]
pub struct Captured {
    /// Row of the data file (line number, from 1).
    pub row: usize,
    /// Start bit of the request (s).
    pub request: f64,
    /// Start bit of the reply (s).
    pub reply: f64,
    /// Value of each captured input at both (SI), in the order of [`RequestToReply::moved`].
    pub inputs: Vec<[f64; 2]>,
}

/// A captured input with its rate, at the edges of the rows at hand.
pub(super) struct Moved {
    name: String,
    value: Vec<f64>,
    rate: Vec<f64>,
    acceleration: Option<Vec<f64>>,
}

impl Moved {
    /// An input of a table; `None` without values or rates.
    pub(super) fn of(table: &Table, input: &str) -> Option<Self> {
        let [value, rate, acceleration] = columns_of(input).map(|name| table.values(&name));
        Some(Self {
            name: input.to_owned(),
            value: value?.to_vec(),
            rate: rate?.to_vec(),
            acceleration: acceleration.map(<[f64]>::to_vec),
        })
    }

    /// Its value in a row, then and some time later.
    fn at(&self, row: usize, later: f64) -> [f64; 2] {
        let bend = self.acceleration.as_ref().map_or(0.0, |column| column[row]);
        [self.value[row], moved(self.value[row], self.rate[row], bend, later).0]
    }
}

impl Over {
    /// Nothing yet. Until the end `standard_deviation` is the sum of squares about the mean.
    const NOTHING: Self = Self {
        mean: 0.0,
        standard_deviation: 0.0,
        smallest: f64::INFINITY,
        largest: f64::NEG_INFINITY,
    };

    /// Takes the value that makes `count` of them.
    fn see(&mut self, value: f64, count: usize) {
        let before = value - self.mean;
        self.mean += before / count as f64;
        self.standard_deviation += before * (value - self.mean);
        self.smallest = self.smallest.min(value);
        self.largest = self.largest.max(value);
    }

    fn end(&mut self, count: usize) {
        let freedom = count.saturating_sub(1).max(1) as f64;
        self.standard_deviation = (self.standard_deviation / freedom).sqrt();
    }
}

impl RequestToReply {
    pub(super) fn new(run: &str) -> Self {
        let (time, moved, replies) = (Over::NOTHING, Vec::new(), Vec::new());
        Self { run: run.to_owned(), count: 0, time, moved, replies }
    }

    /// Takes further rows: their edges, replies (NaN where there is none), and inputs at the edges.
    pub(super) fn see(
        &mut self,
        rows: &[usize],
        requests: &[f64],
        replies: &[f64],
        inputs: &[Moved],
    ) {
        if self.moved.is_empty() {
            self.moved = inputs.iter().map(|one| (one.name.clone(), Over::NOTHING)).collect();
        }
        for (row, (request, reply)) in requests.iter().zip(replies).enumerate() {
            let time = reply - request;
            if time.is_nan() {
                continue;
            }
            self.count += 1;
            self.time.see(time, self.count);
            let places: Vec<[f64; 2]> = inputs.iter().map(|one| one.at(row, time)).collect();
            for ((_, moved), [from, to]) in self.moved.iter_mut().zip(&places) {
                moved.see(to - from, self.count);
            }
            if self.replies.len() < KEPT {
                let (request, reply) = (*request, *reply);
                let row = rows.get(row).copied().unwrap_or(0);
                self.replies.push(Captured { row, request, reply, inputs: places });
            }
        }
    }

    /// After the last row.
    pub(super) fn end(&mut self) {
        self.time.end(self.count);
        self.moved.iter_mut().for_each(|(_, moved)| moved.end(self.count));
    }
}
