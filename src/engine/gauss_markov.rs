//! Rows whitened along time, where a part of a reading's noise is autocorrelated.
//!
//! The noise of a row is white noise and a first-order Gauss-Markov process: a part `share` of the
//! variance whose correlation is `exp(-Δt / time)`. A Kalman filter of one state predicts each
//! reading from those before it; what it did not foresee, over its standard deviation, is white.
//! The filter is linear and its gains hang on the times alone, so the columns of a Jacobian go
//! through it like the residual, and everything that is made of rows holds for correlated noise as
//! it stands.
//!
//! Time is that of the stamps, or, where stamps say little of it (arrivals in bursts), that of
//! evenly spaced samples.
//!
//! It begins anew with every block of samples: readings on both sides of a block's edge are taken
//! for unrelated. It knows nothing of how a memory is found.

use crate::campaign::Samples;
use crate::engine::lanes::{Chunk, LANES, Lanes};

/// The autocorrelated part of the noise of a row (first-order Gauss-Markov).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussMarkov {
    /// Its part of the variance, from 0 to below 1.
    pub share: f64,
    /// The time after which correlation is down to a factor of e (s).
    pub time: f64,
    /// By which clock.
    pub clock: NoiseClock,
}

/// What says how far apart two samples are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NoiseClock {
    /// Their stamps.
    #[default]
    Stamps,
    /// Their numbers, times the mean interval of the run.
    Numbers,
}

impl NoiseClock {
    /// The times of some samples (s).
    pub fn of(self, samples: &Samples) -> &[f64] {
        match self {
            Self::Stamps => &samples.time,
            Self::Numbers => &samples.uniform_time,
        }
    }
}

impl GaussMarkov {
    /// The filter for a sequence that begins.
    pub fn filter(self) -> Filter {
        Filter { noise: self, spread: self.share, last: None, faded: (0.0, f64::INFINITY) }
    }
}

/// The gains of the filter, sample after sample.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    noise: GaussMarkov,
    /// Variance of the state before the next reading.
    spread: f64,
    last: Option<f64>,
    /// How far the state faded over the interval before, and that (s).
    faded: (f64, f64),
}

/// Relative difference of intervals over which a state fades by the same.
const SAME: f64 = 1e-9;

/// What a sample does with the state of a column: `state *= decay`, then `left = value - state`,
/// which times `weight` is white, then `state += gain * left`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// How far the state fades from the sample before.
    pub decay: f64,
    /// How far it follows the reading; 0 without one.
    pub gain: f64,
    /// One over the standard deviation of what is not foreseen; 0 without a reading.
    pub weight: f64,
}

impl Filter {
    /// Goes on to the sample at a time (s), which may have no reading.
    pub fn next(&mut self, time: f64, is_read: bool) -> Gains {
        let GaussMarkov { share, time: memory, .. } = self.noise;
        let elapsed = self.last.map_or(f64::INFINITY, |last| (time - last).max(0.0));
        let (mut decay, known) = self.faded;
        let is_same = elapsed == known || (elapsed - known).abs() <= SAME * known.min(f64::MAX);
        if !is_same {
            decay = (-elapsed / memory).exp();
            self.faded = (decay, elapsed);
        }
        self.last = Some(time);
        self.spread = decay * decay * self.spread + share * (1.0 - decay * decay);
        if !is_read {
            return Gains { decay, gain: 0.0, weight: 0.0 };
        }
        let whole = self.spread + 1.0 - share;
        let gain = self.spread / whole;
        self.spread *= 1.0 - gain;
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
    /// The state of each column.
    states: Vec<f64>,
}

impl Filtering {
    /// Begins anew for rows with such noise.
    pub(super) fn begin(&mut self, noise: &[Option<GaussMarkov>]) {
        self.rows.clear();
        let row = |one: GaussMarkov| Row { filter: one.filter(), states: Vec::new() };
        self.rows.extend(noise.iter().map(|one| one.map(row)));
    }

    /// A row's columns, whitened along time; as they are where its noise is white. Where `weights`
    /// are 0 there is no reading.
    pub(super) fn pass(
        &mut self,
        index: usize,
        lanes: &[&Lanes],
        chunk: &Chunk<'_>,
        weights: &Lanes,
        each: impl FnOnce(&[&Lanes]),
    ) {
        let Some(Some(row)) = self.rows.get_mut(index) else { return each(lanes) };
        let mut gains = [Gains { decay: 0.0, gain: 0.0, weight: 0.0 }; LANES];
        let times = row.filter.noise.clock.of(chunk.samples);
        let times = &times[chunk.start..chunk.start + chunk.len];
        for ((gain, time), weight) in gains.iter_mut().zip(times).zip(weights) {
            *gain = row.filter.next(*time, *weight != 0.0);
        }
        row.states.resize(lanes.len(), 0.0);
        self.made.resize(lanes.len().max(self.made.len()), [0.0; LANES]);
        for ((column, state), made) in lanes.iter().zip(&mut row.states).zip(&mut self.made) {
            for ((value, gain), made) in column.iter().zip(&gains).zip(made) {
                *state *= gain.decay;
                let left = value - *state;
                *made = left * gain.weight;
                *state += gain.gain * left;
            }
        }
        let made: Vec<&Lanes> = self.made[..lanes.len()].iter().collect();
        each(&made);
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
        let noise = GaussMarkov { share: 0.6, time: 0.7, clock: NoiseClock::Stamps };
        let times = [0.0, 0.1, 0.35, 0.4, 1.1, 1.15, 4.0];
        let values = [0.3, -1.2, f64::NAN, 0.8, 1.9, f64::NAN, -0.4];
        let (mut filter, mut state) = (noise.filter(), 0.0);
        let (mut length, mut log_determinant) = (0.0, 0.0);
        for (time, value) in times.iter().zip(&values) {
            let gains = filter.next(*time, !value.is_nan());
            state *= gains.decay;
            if value.is_nan() {
                assert_eq!((gains.gain, gains.weight), (0.0, 0.0));
                continue;
            }
            length += ((value - state) * gains.weight).powi(2);
            log_determinant -= 2.0 * gains.weight.ln();
            state += gains.gain * (value - state);
        }
        let read: Vec<usize> = (0..times.len()).filter(|k| !values[*k].is_nan()).collect();
        let covariance = DMatrix::from_fn(read.len(), read.len(), |i, j| {
            let apart = f64::abs(times[read[i]] - times[read[j]]);
            let white = if i == j { 1.0 - noise.share } else { 0.0 };
            white + noise.share * (-apart / noise.time).exp()
        });
        let vector = DVector::from_iterator(read.len(), read.iter().map(|k| values[*k]));
        let factor = covariance.cholesky().unwrap_or_else(|| unreachable!());
        let wanted = vector.dot(&factor.solve(&vector));
        assert!((length - wanted).abs() < 1e-12 * wanted, "{length} {wanted}");
        let wanted = factor.determinant().ln();
        assert!((log_determinant - wanted).abs() < 1e-12, "{log_determinant} {wanted}");
    }
}
