//! Where a gap lies that nothing explains, where other places do nearly as much.

use crate::found::told;
use crate::nameless::{best_place, with_a_nameless};

/// A distance that comes the later the farther the target is. Effects that are tried leave
/// something that is off in some runs, but these are little of what there is.
#[test]
fn what_wrong_effects_leave_in_few_runs_is_not_the_gap() {
    let text = "[parameters]\nlate = { unit = \"s/m^2\", typical = \"60 us/m^2\", scope = \"instrument\" }\n\
                [patch]\n\"distance.t\" = 't + late * distance^2'\n";
    for seed in [91, 92] {
        let found = with_a_nameless(text, seed, &|_| 60e-6);
        let place = best_place(&found);
        assert_eq!(place.words, "a timing error of `distance` over arm_angle", "{seed}");
        let most = found.remainder.iter().map(|one| one.gain.gain).fold(0.0, f64::max);
        assert_eq!(found.remainder[0].gain.gain, most, "{}", told(&found));
    }
}

/// A pull on the arm that grows with its rate: the fast runs, which hold most of it, are sampled
/// evenly and rarely, so that it has the frequency of some oscillation there.
#[test]
#[ignore = "a known wrong answer: docs/diagnosis-evidence.md"]
fn what_grows_with_the_rate_is_no_oscillation() {
    let text = "[parameters]\nby = { unit = \"m/(rad/s)\", typical = \"10 um/(rad/s)\", scope = \"instrument\" }\n\
                [patch]\ntarget = 'target + by * rate(arm_angle) * sin(arm_angle) * [1, 0, 0]'\n";
    for seed in [93, 94] {
        let found = with_a_nameless(text, seed, &|_| 8e-6);
        let place = best_place(&found);
        assert_ne!(place.covariate, "oscillation", "{}", told(&found));
        assert!(found.remainder[0].share > 0.9, "{}", told(&found));
        assert!(found.remainder.iter().all(|one| !one.place.is_oscillation()));
    }
}

/// A cable that drags the arm's bearing another way than it goes: for runs one way a wave, for
/// those the other way its reverse, which is an oscillation at each rate.
#[test]
fn what_goes_otherwise_there_than_back_is_no_oscillation() {
    let text = "[parameters]\ndrag = { unit = \"m\", typical = \"10 um\", scope = \"instrument\" }\n\
                [patch]\ntarget = 'target + drag * sign(rate(arm_angle)) * cos(3 * arm_angle) * [0, 0, 1]'\n";
    for (seed, size) in [(95, 12e-6), (96, 5e-6)] {
        let found = with_a_nameless(text, seed, &|_| size);
        let place = best_place(&found);
        assert_eq!(
            place.words,
            "an axial displacement of the target over arm_angle, of the other sign when it goes back",
            "{seed}: {}",
            told(&found)
        );
        assert_eq!(place.covariate, "arm_angle by sense");
        assert!(found.remainder[0].share > 0.9, "{}", told(&found));
    }
}
