//! A moving input: its value and its derivatives at any offset from a sample's reference time.

use std::sync::Arc;

use crate::campaign::spline::Spline;
use crate::graph::Input;
use crate::number::Number;

/// Where an input's values come from.
#[derive(Clone, Debug)]
pub enum Track {
    /// The data do not hold it.
    Absent,
    /// The same all through the run.
    Constant(f64),
    /// Recorded with each sample; local Taylor series about the reference time.
    Captured {
        /// Value at the reference time.
        value: Vec<f64>,
        /// Rate, if recorded.
        rate: Option<Vec<f64>>,
        /// Acceleration, if recorded.
        acceleration: Option<Vec<f64>>,
    },
    /// Logged as a stream of its own; a smoothing spline.
    Logged(Arc<Spline>),
}

impl Track {
    /// The `order`-th time derivative at `time + offset` for sample `index`.
    ///
    /// Captured: `a + r o + ½ c o²` and its derivatives, a missing rate or acceleration being zero.
    /// Logged: the spline at `time + offset`. NaN where the data do not hold the input.
    pub fn at<N: Number>(&self, index: usize, time: f64, offset: N, order: u8) -> N {
        let of = |column: &Option<Vec<f64>>| match column {
            Some(column) => column.get(index).copied().unwrap_or(f64::NAN),
            None => 0.0,
        };
        match self {
            Self::Absent => N::constant(f64::NAN),
            Self::Constant(value) => N::constant(if order == 0 { *value } else { 0.0 }),
            Self::Captured { value, rate, acceleration } => match order {
                0 => {
                    let at = value.get(index).copied().unwrap_or(f64::NAN);
                    if rate.is_none() && acceleration.is_none() {
                        return N::constant(at);
                    }
                    (offset * (0.5 * of(acceleration)) + of(rate)) * offset + at
                }
                1 => offset * of(acceleration) + of(rate),
                2 => N::constant(of(acceleration)),
                _ => N::constant(0.0),
            },
            Self::Logged(spline) => spline.at(time, offset, order),
        }
    }

    /// Shares the knots of another track, where both are curves over the same.
    pub(crate) fn share_knots(&mut self, other: Option<&Self>) {
        if let (Self::Logged(own), Some(Self::Logged(other))) = (self, other)
            && let Some(own) = Arc::get_mut(own)
        {
            own.share_knots(other);
        }
    }

    /// Whether it moves: it has a rate, or is a stream. Delays act only where something moves.
    pub fn moves(&self) -> bool {
        matches!(self, Self::Captured { rate: Some(_), .. } | Self::Logged(_))
    }

    /// Whether it was captured with its rate, but not with the rate of that.
    pub fn has_rate_alone(&self) -> bool {
        matches!(self, Self::Captured { rate: Some(_), acceleration: None, .. })
    }

    /// The same source, its columns empty.
    pub fn without_values(&self) -> Self {
        match self {
            Self::Captured { rate, acceleration, .. } => {
                let empty = |column: &Option<Vec<f64>>| column.as_ref().map(|_| Vec::new());
                let (rate, acceleration) = (empty(rate), empty(acceleration));
                Self::Captured { value: Vec::new(), rate, acceleration }
            }
            other => other.clone(),
        }
    }

    /// Whether both are captured, with the same columns.
    pub(crate) fn has_columns_of(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::Captured { rate, acceleration, .. },
                Self::Captured { rate: other_rate, acceleration: other_acceleration, .. },
            ) => {
                rate.is_some() == other_rate.is_some()
                    && acceleration.is_some() == other_acceleration.is_some()
            }
            _ => false,
        }
    }

    /// The columns of a captured input: value, rate, acceleration, as far as there are any.
    pub(crate) fn columns(&self) -> impl Iterator<Item = &Vec<f64>> {
        let [value, rate, acceleration] = match self {
            Self::Captured { value, rate, acceleration } => {
                [Some(value), rate.as_ref(), acceleration.as_ref()]
            }
            _ => [None; 3],
        };
        value.into_iter().chain(rate).chain(acceleration)
    }

    /// The same, to be changed.
    pub(crate) fn columns_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let (value, rate, acceleration) = match self {
            Self::Captured { value, rate, acceleration } => {
                (Some(value), rate.as_mut(), acceleration.as_mut())
            }
            _ => (None, None, None),
        };
        value.into_iter().chain(rate).chain(acceleration)
    }
}

/// For each input of a run, by where it comes from, whether it is a signal that moves. One that is no
/// signal may have a column of its rate beside it: no delay acts on it.
pub fn moving_signals<'a>(
    inputs: &'a [Input],
    tracks: &'a [Track],
) -> impl Iterator<Item = bool> + 'a {
    inputs.iter().zip(tracks).map(|(input, track)| input.signal && track.moves())
}

/// Takes jumps by whole periods out of recorded values.
///
/// `expected` is the change of the value that is expected from one value to the next (from its
/// rate), zero if nothing is known. The first value stays; a value that is not finite is passed
/// over.
pub fn unwrap(values: &mut [f64], period: f64, expected: impl Fn(usize, usize) -> f64) {
    let mut unwrapper = Unwrapper::new(period);
    let mut last = 0;
    for (index, value) in values.iter_mut().enumerate().filter(|(_, value)| value.is_finite()) {
        *value = unwrapper.next(*value, expected(last, index));
        last = index;
    }
}

/// The same for values that come one by one.
#[derive(Clone, Copy, Debug)]
pub struct Unwrapper {
    period: f64,
    last: Option<f64>,
}

impl Unwrapper {
    /// Nothing has come yet.
    pub fn new(period: f64) -> Self {
        Self { period, last: None }
    }

    /// A finite value without its jumps, `expected` being its change since the last one.
    pub fn next(&mut self, value: f64, expected: f64) -> f64 {
        let turns = match self.last {
            Some(last) if self.period > 0.0 => ((value - (last + expected)) / self.period).round(),
            _ => 0.0,
        };
        let moved = turns.is_finite() && turns != 0.0;
        let value = if moved { value - turns * self.period } else { value };
        self.last = Some(value);
        value
    }
}
