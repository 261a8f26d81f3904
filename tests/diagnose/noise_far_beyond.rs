//! Autocorrelated noise may be several times as large as the white noise that is stated, but not by any factor.

use homepoint::diagnose::budget::answer::Verdict;

use crate::fast_oscillations::{diagnosed, even};
use crate::found::told;
use crate::stream::Stream;

#[test]
fn autocorrelated_noise_of_many_times_the_stated_one_is_a_remainder() {
    for (times, verdict) in [(4.0, Verdict::Explained), (16.0, Verdict::Unknown)] {
        let mut stream = Stream(31);
        let mut slow = 0.0;
        let mut next = || {
            slow = 0.8 * slow + 0.6 * stream.normal();
            0.01 * times * slow
        };
        let slow: Vec<f64> = (0..2001).map(|_| next()).collect();
        let found = diagnosed(even(100), 32, |time| slow[(100.0 * time).round() as usize]);
        assert!(!found.autocorrelation.is_empty(), "{}", told(&found));
        assert_eq!(found.verdict, verdict, "{}", told(&found));
    }
}
