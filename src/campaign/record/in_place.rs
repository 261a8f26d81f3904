//! Changes of a record that leave its samples where they are kept: readings left out, another rate,
//! other streams, other starts of clocks.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use super::change::{Change, captured_with_rates};
use super::{Kept, Record};
use crate::campaign::signal::Track;
use crate::campaign::spill::BLOCK;

impl Record {
    /// Leaves readings out: those of such samples in such reading columns are missing from then on.
    /// What is kept stays where it is.
    pub fn leave_out(&mut self, readings: impl IntoIterator<Item = (Range<usize>, Range<usize>)>) {
        for (samples, columns) in readings.into_iter().filter(|(samples, _)| !samples.is_empty()) {
            let all = Arc::make_mut(&mut self.left_out);
            for block in samples.start / BLOCK..samples.end.div_ceil(BLOCK) {
                let of = samples.start.max(block * BLOCK)..samples.end.min((block + 1) * BLOCK);
                all.entry(block).or_default().push((of, columns.clone()));
            }
            self.whole = OnceLock::new();
        }
    }

    /// The same run, looked at otherwise. Only the last change counts.
    pub fn changed(&self, change: Change) -> Self {
        let inputs = match (change, &self.kept) {
            (Change::WithoutReadings, _) => self.inputs.clone(),
            (Change::Retimed(_), _) => {
                let moving = |track: &Track| match track.moves() {
                    true => captured_with_rates(),
                    false => track.clone(),
                };
                self.inputs.iter().map(moving).collect()
            }
        };
        Self { inputs, change: Some(change), whole: OnceLock::new(), ..self.clone() }
    }

    /// Puts other streams in the place of those of some inputs. What is kept stays where it is.
    pub(crate) fn replace_streams(&mut self, streams: Vec<(usize, Track)>) {
        let put = |inputs: &mut [Track]| {
            streams.iter().for_each(|(input, track)| inputs[*input] = track.clone());
        };
        put(&mut self.inputs);
        match &mut self.kept {
            Kept::Held(samples) => put(&mut Arc::make_mut(samples).inputs),
            Kept::Spilled { inputs, .. } => put(inputs),
        }
        self.whole = OnceLock::new();
    }

    /// Lets the time since the start of the setup count from `start` (s).
    pub(crate) fn set_setup_start(&mut self, start: f64) {
        match &mut self.kept {
            Kept::Held(samples) => {
                let samples = Arc::make_mut(samples);
                samples.setup_time = samples.time.iter().map(|time| time - start).collect();
            }
            Kept::Spilled { starts, .. } => starts.setup = start,
        }
    }

    /// Lets elapsed time count from `start` (s).
    pub(crate) fn set_start(&mut self, start: f64) {
        match &mut self.kept {
            Kept::Held(samples) => {
                let samples = Arc::make_mut(samples);
                samples.elapsed_time = samples.time.iter().map(|time| time - start).collect();
            }
            Kept::Spilled { starts, .. } => starts.all = start,
        }
    }
}
