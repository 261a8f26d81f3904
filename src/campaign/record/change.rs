//! How a run is looked at otherwise than it was recorded: without readings, or at another rate.

use crate::campaign::samples::Samples;
use crate::campaign::signal::Track;

/// A run looked at otherwise than it was recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// No reading is there.
    WithoutReadings,
    /// The same positions passed at this many times the rate; negative is the other way round.
    Retimed(f64),
}

impl Change {
    pub(super) fn apply(self, samples: &mut Samples) {
        match self {
            Self::WithoutReadings => {
                samples.readings.iter_mut().for_each(|column| column.fill(f64::NAN));
            }
            Self::Retimed(factor) => {
                let Samples { time, inputs, .. } = samples;
                for track in inputs.iter_mut().filter(|track| track.moves()) {
                    let at = |order: u8, scale: f64| {
                        let samples = time.iter().enumerate();
                        samples.map(|(i, t)| scale * track.at::<f64>(i, *t, 0.0, order)).collect()
                    };
                    *track = Track::Captured {
                        value: at(0, 1.0),
                        rate: Some(at(1, factor)),
                        acceleration: Some(at(2, factor * factor)),
                    };
                }
            }
        }
    }
}

/// An input recorded with its rate and acceleration; columns are empty.
pub(in crate::campaign) fn captured_with_rates() -> Track {
    Track::Captured { value: Vec::new(), rate: Some(Vec::new()), acceleration: Some(Vec::new()) }
}
