//! The special situations that are tried.
//!
//! Names of parameters are those of the polar models; a situation that moves what a model lacks
//! leaves readings as they are.

use super::Situation;
use super::channel::Channel;
use super::course::Course;
use super::disturbance::Disturbance;

/// A size in units of the stated noise, small for a reading and large in number.
const SMALL: f64 = 1.0;
/// A size in units of the stated noise for what a part of a run has.
const LARGE: f64 = 3.0;

/// All of them, in the order in which they are tried.
pub fn standard() -> Vec<Situation> {
    let mut all = replaced();
    all.extend(moments());
    all.extend(runs());
    all.extend(courses());
    all.extend(statements());
    all.extend(noise());
    all.extend(beside_an_effect());
    all
}

/// Readings replaced by others: they are to be left out, and nothing else is there.
fn replaced() -> Vec<Situation> {
    let bursts = Disturbance::OutlierBursts { bursts: 5, length: 8, size: 40.0 };
    let lost = Disturbance::LostSamples { periods: 1, length: 40 };
    vec![
        noise_only("error_codes_few", vec![codes(0.0, 0.03)]),
        noise_only("error_codes_many", vec![codes(99_999.0, 0.2)]),
        noise_only("lost_samples", vec![lost]),
        noise_only("outlier_bursts", vec![bursts.clone()]),
        noise_only("error_codes_and_bursts", vec![codes(0.0, 0.03), bursts]),
        unmodelled("wrong_unit_in_one_run", vec![Disturbance::WrongUnit { factor: 0.9 }]),
        noise_only("quantised", vec![Disturbance::Quantised { step: 4.0 }]),
    ]
}

/// Something changes at a moment.
fn moments() -> Vec<Situation> {
    let lasting = Course::WithinRun { lasting: true };
    let in_one = Course::WithinRun { lasting: false };
    vec![
        unmodelled("station_knocked", vec![moved(position(), Course::FromRun, SMALL)]),
        unmodelled("station_knocked_within_run", vec![moved(position(), lasting.clone(), SMALL)]),
        unmodelled("clock_jump_within_run", vec![moved(Channel::Time, in_one.clone(), LARGE)]),
        unmodelled("clock_jump_that_lasts", vec![moved(Channel::Time, lasting, SMALL)]),
        unmodelled("reading_step_within_run", vec![moved(Channel::Reading, in_one, LARGE)]),
    ]
}

/// Each run is off by a value of its own.
fn runs() -> Vec<Situation> {
    vec![
        unmodelled("run_offsets", vec![moved(Channel::Reading, Course::EachRun, SMALL)]),
        unmodelled("run_delays", vec![moved(Channel::Time, Course::EachRun, SMALL)]),
    ]
}

/// Something goes on in the course of runs or setups.
fn courses() -> Vec<Situation> {
    let walk = moved(position(), Course::Walk, SMALL);
    let drift = moved(position(), Course::Drift, SMALL);
    let settling = Course::Settling { time: 8.0 };
    let ringing = Course::Ringing { frequency: 0.37, coherence: 5.0 };
    vec![
        noise_only("random_walk", vec![walk.clone()]),
        Situation {
            names: vec!["station_drift".to_owned()],
            ..noise_only("random_walk_with_drift", vec![walk, drift])
        },
        unmodelled("settling_of_a_reading", vec![moved(Channel::Reading, settling.clone(), SMALL)]),
        unmodelled("settling_of_the_station", vec![moved(position(), settling, SMALL)]),
        unmodelled("hysteresis", vec![moved(Channel::Reading, Course::Direction, 0.5)]),
        unmodelled("ringing", vec![moved(Channel::Reading, ringing, SMALL)]),
    ]
}

/// A stated length is wrong: an effect that is the same length does as well for it.
fn statements() -> Vec<Situation> {
    let conflict = Disturbance::Misstated { by: 12.0, fixed: false };
    let wrong = Disturbance::Misstated { by: 25.0, fixed: true };
    let of = |name: &str, disturbance: Disturbance| Situation {
        names: ["arm_radius", "kinematic_scale", "distance_scale"].map(str::to_owned).into(),
        unmodelled: None,
        ..unmodelled(name, vec![disturbance])
    };
    vec![of("prior_conflict", conflict), of("misstated_length", wrong)]
}

/// The noise is not what is stated.
fn noise() -> Vec<Situation> {
    let every = |course| vec![moved(Channel::EveryReading, course, SMALL)];
    vec![
        noise_only("autocorrelated_noise", every(Course::Memory { time: 2.0 })),
        noise_only("noise_levels_by_run", every(Course::Levels)),
        noise_only("doubled_noise", vec![doubled()]),
        noise_only("timestamp_jitter", vec![moved(Channel::Time, Course::White, SMALL)]),
    ]
}

/// An effect of the library, and something else.
fn beside_an_effect() -> Vec<Situation> {
    let beside = |one: Situation| Situation { effects: 1, ..one };
    let bursts = Disturbance::OutlierBursts { bursts: 5, length: 8, size: 40.0 };
    let knocked = moved(position(), Course::FromRun, SMALL);
    let memory = moved(Channel::EveryReading, Course::Memory { time: 2.0 }, SMALL);
    vec![
        beside(noise_only("effect_and_error_codes", vec![codes(0.0, 0.03)])),
        beside(noise_only("effect_and_bursts", vec![bursts])),
        beside(noise_only("effect_and_doubled_noise", vec![doubled()])),
        beside(noise_only("effect_and_autocorrelated_noise", vec![memory])),
        beside(unmodelled("effect_and_station_knocked", vec![knocked])),
    ]
}

/// Nothing that an effect could explain, and nothing unknown.
fn noise_only(name: &str, disturbances: Vec<Disturbance>) -> Situation {
    Situation {
        name: name.to_owned(),
        disturbances,
        unmodelled: Some(false),
        ..Situation::default()
    }
}

/// A cause that the library lacks.
fn unmodelled(name: &str, disturbances: Vec<Disturbance>) -> Situation {
    Situation { unmodelled: Some(true), ..noise_only(name, disturbances) }
}

fn codes(code: f64, share: f64) -> Disturbance {
    Disturbance::ErrorCodes { code, share }
}

fn moved(channel: Channel, course: Course, size: f64) -> Disturbance {
    Disturbance::Moved { channel, course, size }
}

/// The place of the station.
fn position() -> Channel {
    Channel::Parameter("position".to_owned())
}

/// Noise that makes all scatter twice what is stated.
fn doubled() -> Disturbance {
    moved(Channel::EveryReading, Course::White, 3.0_f64.sqrt())
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn every_situation_has_its_name_and_comes_back_from_json() {
        let all = standard();
        let names: HashSet<&str> = all.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names.len(), all.len());
        for one in all {
            let text = serde_json::to_string(&one).unwrap_or_default();
            assert_eq!(serde_json::from_str::<Situation>(&text).ok(), Some(one), "{text}");
        }
    }
}
