//! A simulated run as it would have been captured: the inverse of what reading does, and replies.
//!
//! Replies come `after` their requests, start bit to start bit, with some scatter: as `[timing]`
//! says in `reply`, else as they did in the recorded run. None comes before its request is complete
//! or after the next one begins, and each is captured on the grid of the stated resolution.

use std::ops::Range;

use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::campaign::captured::moved;
use crate::campaign::record::Stretch;
use crate::campaign::samples::Samples;
use crate::campaign::signal::Track;
use crate::campaign::timing::replies::RequestToReply;
use crate::campaign::timing::{Method, REPLY, Reply, RunTiming, Timing};

/// How a run's samples are written as captures.
#[derive(Clone, Debug)]
pub(crate) struct Capturing {
    /// The columns of edges: of the request, and of the reply if there is one.
    pub(crate) columns: Vec<&'static str>,
    /// From the reference time back to the edge (s).
    shift: f64,
    reply: Option<Reply>,
    /// How long a request is (s).
    length: f64,
    /// Grid of captured times (s).
    resolution: Option<f64>,
    /// Where the replies' scatter is from.
    generator: ChaCha12Rng,
}

impl Timing {
    /// How a run's samples are written as captures, with replies as in the recorded run, if it was.
    pub(crate) fn capturing(
        &self,
        run: &RunTiming,
        recorded: Option<&RequestToReply>,
    ) -> Capturing {
        let recorded = recorded.map(|recorded| Reply {
            after: recorded.time.mean,
            scatter: recorded.time.standard_deviation,
        });
        let reply = self.reply.or(recorded).filter(|_| self.method != Method::Trigger);
        let mut columns = vec![self.method.column()];
        columns.extend(reply.map(|_| REPLY));
        Capturing {
            columns,
            shift: -self.shift(run),
            reply,
            length: self.length(run),
            resolution: self.resolution,
            generator: ChaCha12Rng::seed_from_u64(0),
        }
    }
}

impl Capturing {
    /// Draws the replies from a seed, of the run with this number.
    pub(crate) fn seed(&mut self, seed: u64, run: usize) {
        self.generator = ChaCha12Rng::seed_from_u64(seed);
        // Readings are drawn from the first streams.
        self.generator.set_stream(u64::MAX - run as u64);
    }

    /// The replies (s) to requests; none where none are captured.
    pub(crate) fn replies(&mut self, requests: &[f64]) -> Vec<f64> {
        let Some(Reply { after, scatter }) = self.reply else { return Vec::new() };
        let step = self.resolution.unwrap_or(0.0);
        let mut interval = f64::INFINITY;
        (0..requests.len())
            .map(|row| {
                if let Some(next) = requests.get(row + 1) {
                    interval = next - requests[row];
                }
                let normal: f64 = StandardNormal.sample(&mut self.generator);
                let latest = (interval - step).max(self.length);
                let time = (after + scatter * normal).min(latest).max(self.length + step);
                let reply = requests[row] + time;
                if step > 0.0 { (reply / step).round() * step } else { reply }
            })
            .collect()
    }

    /// Times and inputs of a stretch as they would have been captured: the inverse of what reading
    /// does.
    pub(crate) fn captured(&self, stretch: Stretch<'_>) -> Samples {
        let range: Range<usize> = stretch.range();
        let time = stretch.samples.time[range.clone()].iter().map(|time| time + self.shift);
        let cut = |column: &[f64]| column[range.clone()].to_vec();
        let inputs = stretch.samples.inputs.iter().map(|track| match track {
            Track::Captured { value, rate, acceleration } => {
                let (mut value, mut rate) = (cut(value), rate.as_deref().map(cut));
                let acceleration = acceleration.as_deref().map(cut);
                for row in 0..value.len() {
                    if let Some(rate) = &mut rate {
                        let bend = acceleration.as_ref().map_or(0.0, |column| column[row]);
                        (value[row], rate[row]) = moved(value[row], rate[row], bend, self.shift);
                    }
                }
                Track::Captured { value, rate, acceleration }
            }
            other => other.clone(),
        });
        let readings = stretch.samples.readings.iter().map(|column| cut(column)).collect();
        Samples { time: time.collect(), inputs: inputs.collect(), readings, ..Samples::default() }
    }
}
