//! Where logged attitudes leap: away and back, or for good.

use crate::campaign::spline::mean_spacing;
use crate::quaternion::Quaternion;

/// The least leap (rad), and how many times what the rows beside it turn in the same time.
const LEAP: (f64, f64) = (0.35, 8.0);
/// Attitudes at either end of a log that may be a burst of which one end is not seen.
const SHORT: usize = 10;
/// Steps on either side of one with which it is compared.
const BESIDE: usize = 8;
/// The largest part of all rows that can be bursts; else it is not known which rows are right.
const MOST_BURSTS: f64 = 0.3;

/// The angle between two attitudes (rad), 0 to π.
fn angle(a: Quaternion<f64>, b: Quaternion<f64>) -> f64 {
    2.0 * (a.conjugate() * b).w.abs().min(1.0).acos()
}

/// A turn from one attitude to the next.
struct Step {
    /// In the frame of the body and in that of the room.
    turns: [Quaternion<f64>; 2],
    /// Its angle (rad).
    angle: f64,
    /// How long it takes (s).
    time: f64,
}

/// Attitudes in bursts, and those at which one that lasts begins.
///
/// A leap back undoes a leap away, but for the motion of two steps: their product is nearly no turn,
/// in the frame of the body or in that of the room, however far the body moves in between.
pub(super) fn leaps(times: &[f64], turns: &[Quaternion<f64>]) -> (Vec<usize>, Vec<usize>) {
    let spacing = mean_spacing(times).max(f64::MIN_POSITIVE);
    let steps: Vec<Step> = times
        .windows(2)
        .zip(turns.windows(2))
        .map(|(time, turn)| Step {
            turns: [turn[0].conjugate() * turn[1], turn[1] * turn[0].conjugate()],
            angle: angle(turn[0], turn[1]),
            time: (time[1] - time[0]).max(spacing),
        })
        .collect();
    // Attitude behind the leap, and how far two steps may lead.
    let starts: Vec<(usize, f64)> = (0..steps.len())
        .filter_map(|at| {
            let typical = beside(&steps, at)? * steps[at].time;
            let is_leap = steps[at].angle > LEAP.0.max(LEAP.1 * typical);
            is_leap.then(|| (at + 1, (0.5 * LEAP.0 + 4.0 * typical).min(0.5 * steps[at].angle)))
        })
        .collect();
    let undoes = |at: usize, before: usize, way: f64| {
        let [one, other] = [&steps[before - 1].turns, &steps[at - 1].turns];
        (0..2).any(|frame| angle(one[frame] * other[frame], Quaternion::identity()) < way)
    };
    let repeats = |at: usize, before: usize, way: f64| {
        let [one, other] = [&steps[before - 1].turns, &steps[at - 1].turns];
        (0..2).any(|frame| angle(one[frame], other[frame]) < way)
    };
    // Branches that are left, with the leap away from each; leaps from one to another; stretches
    // with their branch.
    let mut left: Vec<(usize, usize)> = Vec::new();
    let mut known: Vec<(usize, usize, usize)> = Vec::new();
    let (mut branch, mut count) = (0, 1);
    let mut stretches = vec![(0, 0)];
    for (at, way) in &starts {
        match left.last() {
            Some((below, before)) if undoes(*at, *before, *way) => {
                branch = *below;
                left.pop();
            }
            _ => {
                left.push((branch, *at));
                let again = known
                    .iter()
                    .find(|(from, before, _)| *from == branch && repeats(*at, *before, *way));
                if let Some((_, _, to)) = again {
                    branch = *to;
                } else {
                    known.push((branch, *at, count));
                    branch = count;
                    count += 1;
                }
            }
        }
        stretches.push((branch, *at));
    }
    let end = |n: usize| stretches.get(n + 1).map_or(turns.len(), |next| next.1);
    let mut rows = vec![0; count];
    (0..stretches.len()).for_each(|n| rows[stretches[n].0] += end(n) - stretches[n].1);
    let main = (0..count).max_by_key(|own| rows[*own]).unwrap_or(0);
    let first = stretches.iter().position(|one| one.0 == main).unwrap_or(0);
    let last = stretches.iter().rposition(|one| one.0 == main).unwrap_or(0);
    // At the ends, where no leap back can be: what leaps elsewhere, too, or is short.
    let is_burst = |n: &usize| {
        let own = stretches[*n].0;
        let elsewhere = || (first..last).any(|other| stretches[other].0 == own);
        let is_short = || end(*n) - stretches[*n].1 <= SHORT.min(turns.len() / 50);
        own != main && ((first..last).contains(n) || elsewhere() || is_short())
    };
    let between: Vec<usize> = (0..stretches.len()).filter(is_burst).collect();
    let bursts: Vec<usize> = between.iter().flat_map(|n| stretches[*n].1..end(*n)).collect();
    if bursts.len() as f64 > MOST_BURSTS * turns.len() as f64 {
        return (Vec::new(), starts.into_iter().map(|(at, _)| at).collect());
    }
    let is_left_out = |n: usize| between.contains(&n);
    let lasting = (1..stretches.len()).filter(|n| *n <= first || *n > last);
    let lasting = lasting.filter(|n| !is_left_out(*n) && !is_left_out(*n - 1));
    (bursts, lasting.map(|n| stretches[n].1).collect())
}

/// The middle rate (rad/s) of the steps beside one; `None` where there are few.
fn beside(steps: &[Step], at: usize) -> Option<f64> {
    let all = at.saturating_sub(BESIDE)..(at + 1 + BESIDE).min(steps.len());
    let others = all.filter(|other| *other != at);
    let mut rates: Vec<f64> = others.map(|other| steps[other].angle / steps[other].time).collect();
    let middle = rates.len() / 2;
    (rates.len() >= BESIDE).then(|| *rates.select_nth_unstable_by(middle, f64::total_cmp).1)
}
