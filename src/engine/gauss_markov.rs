//! Rows whitened along time, where a part of a reading's noise is autocorrelated.
//!
//! The noise of a row is white noise and one or two first-order Gauss-Markov processes: of each a part
//! `share` of the variance, whose correlation is `exp(-Δt / time)`. A Kalman filter with a state for
//! each process predicts each reading from those before it; what it did not foresee, over its standard
//! deviation, is white. The filter is linear and its gains hang on the times alone, so the columns of a
//! Jacobian go through it like the residual, and everything that is made of rows holds for correlated
//! noise as it stands.
//!
//! It begins anew with every block of samples: readings on both sides of a block's edge are taken
//! for unrelated. How autocorrelated noise is found is not its business.

use crate::engine::lanes::{Chunk, LANES, Lanes};

/// Processes in the noise of a row at most.
const MOST: usize = 2;

/// A first-order Gauss-Markov process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Process {
    /// Its part of the variance of the noise, from 0 to below 1.
    pub share: f64,
    /// The time after which correlation is down to a factor of e (s; a number of rows where the data
    /// have no times).
    pub time: f64,
}

/// A process that is not there.
const NONE: Process = Process { share: 0.0, time: 1.0 };

/// The autocorrelated part of the noise of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussMarkov {
    processes: [Process; MOST],
}

impl GaussMarkov {
    /// One process.
    pub const fn one(share: f64, time: f64) -> Self {
        Self { processes: [Process { share, time }, NONE] }
    }

    /// Two processes.
    pub const fn two(first: Process, second: Process) -> Self {
        Self { processes: [first, second] }
    }

    /// The processes that have a part of the variance.
    pub fn processes(&self) -> impl Iterator<Item = Process> + '_ {
        self.processes.iter().copied().filter(|one| one.share > 0.0)
    }

    /// The part of the variance that is autocorrelated.
    pub fn share(&self) -> f64 {
        self.processes.iter().map(|one| one.share).sum()
    }

    /// The filter for a sequence that begins.
    pub fn filter(self) -> Filter {
        Filter { noise: self, spread: [0.0; 3], last: None, faded: ([0.0; MOST], f64::INFINITY) }
    }
}

/// The gains of the filter, sample after sample.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    noise: GaussMarkov,
    /// Variances of the states before the next reading, and their covariance.
    spread: [f64; 3],
    last: Option<f64>,
    /// How far the states faded over the interval before, and that (s).
    faded: (States, f64),
}

/// Relative difference of intervals over which a state fades by the same.
const SAME: f64 = 1e-9;

/// A number for each process.
pub type States = [f64; MOST];

/// What a sample does with the states of a column ([`Gains::take`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// How far each state fades from the reading before; by nothing without one.
    pub decay: States,
    /// How far each follows the reading; 0 without one.
    pub gain: States,
    /// One over the standard deviation of what is not foreseen; 0 without a reading.
    pub weight: f64,
}

/// The states of a column before its first sample.
pub const BEGIN: States = [0.0; MOST];

impl Gains {
    /// Without a reading.
    pub const NOTHING: Self = Self { decay: [1.0; MOST], gain: [0.0; MOST], weight: 0.0 };

    /// What the states foresee of a reading.
    pub fn foreseen(&self, states: &States) -> f64 {
        self.decay[0] * states[0] + self.decay[1] * states[1]
    }

    /// Takes the states to a reading and returns what they did not foresee of its value, whitened.
    pub fn take(&self, states: &mut States, value: f64) -> f64 {
        let left = value - self.foreseen(states);
        self.follow(states, left);
        left * self.weight
    }

    /// Takes the states to a reading and returns its value, from what [`Gains::take`] returned.
    pub fn undo(&self, states: &mut States, whitened: f64) -> f64 {
        let left = whitened / self.weight;
        let value = left + self.foreseen(states);
        self.follow(states, left);
        value
    }

    fn follow(&self, states: &mut States, left: f64) {
        for (state, (decay, gain)) in states.iter_mut().zip(self.decay.iter().zip(&self.gain)) {
            *state = decay * *state + gain * left;
        }
    }
}

impl Filter {
    /// Goes on to the sample at a time (s), which may have no reading.
    pub fn next(&mut self, time: f64, is_read: bool) -> Gains {
        if !is_read {
            return Gains::NOTHING;
        }
        let [first, second] = self.noise.processes;
        let elapsed = self.last.map_or(f64::INFINITY, |last| (time - last).max(0.0));
        let (mut decay, known) = self.faded;
        let is_same = elapsed == known || (elapsed - known).abs() <= SAME * known.min(f64::MAX);
        if !is_same {
            decay = [first, second].map(|one| (-elapsed / one.time).exp());
            self.faded = (decay, elapsed);
        }
        self.last = Some(time);
        let [a, b] = decay;
        let [p, q, across] = self.spread;
        let p = a * a * p + first.share * (1.0 - a * a);
        let q = b * b * q + second.share * (1.0 - b * b);
        let across = a * b * across;
        let (of_first, of_second) = (p + across, q + across);
        let whole = of_first + of_second + 1.0 - first.share - second.share;
        let gain = [of_first / whole, of_second / whole];
        self.spread =
            [p - gain[0] * of_first, q - gain[1] * of_second, across - gain[0] * of_second];
        Gains { decay, gain, weight: whole.sqrt().recip() }
    }
}

/// The filters of a block's rows, as they go from chunk to chunk.
#[derive(Debug, Default)]
pub(super) struct Filtering {
    rows: Vec<Option<Row>>,
    made: Vec<Lanes>,
}

#[derive(Debug)]
struct Row {
    filter: Filter,
    /// The states of each column.
    states: Vec<States>,
}

impl Filtering {
    /// Begins anew for rows with such noise.
    pub(super) fn begin(&mut self, noise: &[Option<GaussMarkov>]) {
        self.rows.clear();
        let row = |one: GaussMarkov| Row { filter: one.filter(), states: Vec::new() };
        self.rows.extend(noise.iter().map(|one| one.map(row)));
    }

    /// A row's columns, whitened along time, with the gains of the samples; as they are where its noise
    /// is white. Where `weights` are 0 there is no reading.
    pub(super) fn pass(
        &mut self,
        index: usize,
        lanes: &[&Lanes],
        chunk: &Chunk<'_>,
        weights: &Lanes,
        each: impl FnOnce(&[&Lanes], Option<&[Gains; LANES]>),
    ) {
        let Some(Some(row)) = self.rows.get_mut(index) else { return each(lanes, None) };
        let mut gains = [Gains::NOTHING; LANES];
        let order = (chunk.start..chunk.start + chunk.len).map(|at| chunk.samples.order_of(at));
        for ((gain, time), weight) in gains.iter_mut().zip(order).zip(weights) {
            *gain = row.filter.next(time, *weight != 0.0);
        }
        row.states.resize(lanes.len(), BEGIN);
        self.made.resize(lanes.len().max(self.made.len()), [0.0; LANES]);
        for ((column, state), made) in lanes.iter().zip(&mut row.states).zip(&mut self.made) {
            for ((value, gain), made) in column.iter().zip(&gains).zip(made) {
                *made = gain.take(state, *value);
            }
        }
        let made: Vec<&Lanes> = self.made[..lanes.len()].iter().collect();
        each(&made, Some(&gains));
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// The squared length of a whitened sequence and the determinant of its covariance are those of
    /// the covariance matrix written out, missing readings left out.
    #[test]
    fn what_is_whitened_has_the_length_that_the_covariance_says() {
        let slow = Process { share: 0.35, time: 2.9 };
        let fast = Process { share: 0.45, time: 0.2 };
        for noise in [GaussMarkov::one(0.6, 0.7), GaussMarkov::two(slow, fast)] {
            let times = [0.0, 0.1, 0.35, 0.4, 1.1, 1.15, 4.0];
            let values = [0.3, -1.2, f64::NAN, 0.8, 1.9, f64::NAN, -0.4];
            let (mut filter, mut states, mut raw) = (noise.filter(), BEGIN, BEGIN);
            let (mut length, mut log_determinant) = (0.0, 0.0);
            for (time, value) in times.iter().zip(&values) {
                let gains = filter.next(*time, !value.is_nan());
                if value.is_nan() {
                    assert_eq!(gains, Gains::NOTHING);
                    continue;
                }
                log_determinant -= 2.0 * gains.weight.ln();
                let whitened = gains.take(&mut states, *value);
                length += whitened.powi(2);
                let back = gains.undo(&mut raw, whitened);
                assert!((back - value).abs() < 1e-14, "{back} {value}");
            }
            let read: Vec<usize> = (0..times.len()).filter(|k| !values[*k].is_nan()).collect();
            let covariance = DMatrix::from_fn(read.len(), read.len(), |i, j| {
                let apart = f64::abs(times[read[i]] - times[read[j]]);
                let white = if i == j { 1.0 - noise.share() } else { 0.0 };
                let of = |one: Process| one.share * (-apart / one.time).exp();
                white + noise.processes().map(of).sum::<f64>()
            });
            let vector = DVector::from_iterator(read.len(), read.iter().map(|k| values[*k]));
            let factor = covariance.cholesky().unwrap_or_else(|| unreachable!());
            let wanted = vector.dot(&factor.solve(&vector));
            assert!((length - wanted).abs() < 1e-12 * wanted, "{length} {wanted}");
            let wanted = factor.determinant().ln();
            assert!((log_determinant - wanted).abs() < 1e-12, "{log_determinant} {wanted}");
        }
    }
}
