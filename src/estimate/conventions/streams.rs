//! Streams smoothed as they are where a convention is set right in a campaign: by the uncertainty that
//! is stated of them, of values that are multiplied.

use std::sync::Arc;

use crate::campaign::signal::Track;
use crate::engine::Problem;

use super::one_run::OneRun;

/// Noises closer than this, as a part of them, smooth alike.
const SAME: f64 = 1e-9;

/// Smooths the streams of a changed problem by the noises that are stated of those as they were read.
pub(super) fn smooth_as_stated(changed: &mut Problem, read: &Problem) {
    for OneRun { part, run } in OneRun::all(read) {
        let stated = read.parts[part].runs[run].record.inputs();
        let record = &mut changed.parts[part].runs[run].record;
        let pairs = record.inputs().iter().zip(stated).enumerate();
        let again = pairs.filter_map(|(input, pair)| {
            let (Track::Logged(own), Track::Logged(stated)) = pair else { return None };
            let [noise, stated] = [own.stated_noise()?, stated.stated_noise()?];
            let is_same = (noise - stated).abs() <= SAME * stated;
            let curve = if is_same { None } else { own.smoothed_for(stated) };
            Some((input, Track::Logged(Arc::new(curve?))))
        });
        let again: Vec<(usize, Track)> = again.collect();
        if !again.is_empty() {
            record.replace_streams(again);
        }
    }
}
