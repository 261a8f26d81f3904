//! By how much larger the turns of one log are than those of another: the scale of its heading. The
//! clocks of the two may differ, in their rates, too.

/// Samples of the data that are compared, about.
const COMPARED: usize = 500;
/// Delays that are tried.
const DELAYS: usize = 2000;
/// A part of the samples that must lie within the stream.
const WITHIN: f64 = 0.5;
/// Fewest headings that show a scale.
const FEWEST: usize = 20;
/// Headings are alike where they differ by less than such a part of their own standard deviation.
const ALIKE: f64 = 0.05;
/// Scales that a path of dead reckoning may have.
pub(super) const POSSIBLE: std::ops::Range<f64> = 0.5..2.0;
/// Rates of the clock that are tried, either way, and their steps.
const MOST_RATE: i32 = 10;
const RATE_STEP: f64 = 0.005;
/// A rate of the clock must lessen the misfit to such a part: a turn at one rate does not separate the
/// two scales, and one that begins and ends hardly does.
const NEEDED: f64 = 0.95;
/// Rounds of the search: steps become smaller by a thousand and more.
const ROUNDS: usize = 60;

/// A stamp (s) with the heading there (rad), without jumps by whole turns.
pub(super) type Heading = (f64, f64);

/// How the headings of the data follow from those of a stream at one delay and rate of the clock.
#[derive(Clone, Copy, Debug)]
struct Match {
    clock: [f64; 2],
    scale: f64,
    misfit: f64,
}

/// The part by which the turns of `data` are larger than those of `stream`, both in the order of time;
/// `None` where they do not go along with each other.
pub(super) fn heading_scale(data: &[Heading], stream: &[Heading]) -> Option<f64> {
    let few: Vec<Heading> = data.iter().copied().step_by(data.len() / COMPARED + 1).collect();
    let ([first, .., last], [begin, .., end]) = (&few[..], stream) else { return None };
    let middle = 0.5 * (first.0 + last.0);
    let matched = |clock: [f64; 2]| compared(&few, stream, middle, clock);
    let (least, most) = (begin.0 - last.0, end.0 - first.0);
    let step = (most - least) / DELAYS as f64;
    let all = (0..=DELAYS).filter_map(|n| matched([least + step * n as f64, 0.0]));
    let best = all.min_by(|a, b| a.misfit.total_cmp(&b.misfit))?;
    let even = refined(best, [step, 0.0], &matched);
    // Delay, rate and scale make a long valley: each rate has its own delay.
    let with_rate = (-MOST_RATE..=MOST_RATE).filter_map(|n| {
        let begin = matched([even.clock[0], RATE_STEP * f64::from(n)])?;
        let at_rate = refined(begin, [step, 0.0], &matched);
        Some(refined(at_rate, [step, step / (last.0 - middle)], &matched))
    });
    let with_rate = with_rate.min_by(|a, b| a.misfit.total_cmp(&b.misfit)).unwrap_or(even);
    let best = if with_rate.misfit < NEEDED * even.misfit { with_rate } else { even };
    (best.misfit < ALIKE && POSSIBLE.contains(&best.scale)).then_some(best.scale - 1.0)
}

/// The line that goes best through headings of the data over those of the stream.
fn compared(data: &[Heading], stream: &[Heading], middle: f64, clock: [f64; 2]) -> Option<Match> {
    let at = |time: f64| {
        let time = time + clock[0] + clock[1] * (time - middle);
        let next = stream.partition_point(|own| own.0 <= time);
        let (from, to) = (stream.get(next.checked_sub(1)?)?, stream.get(next)?);
        Some(from.1 + (time - from.0) / (to.0 - from.0) * (to.1 - from.1))
    };
    let pairs: Vec<[f64; 2]> = data.iter().filter_map(|own| Some([at(own.0)?, own.1])).collect();
    let count = pairs.len() as f64;
    if pairs.len() < FEWEST || count < WITHIN * data.len() as f64 {
        return None;
    }
    let mean = |side: usize| pairs.iter().map(|pair| pair[side]).sum::<f64>() / count;
    let means = [mean(0), mean(1)];
    let moment = |a: usize, b: usize| {
        pairs.iter().map(|pair| (pair[a] - means[a]) * (pair[b] - means[b])).sum::<f64>()
    };
    let (of_stream, both, of_data) = (moment(0, 0), moment(0, 1), moment(1, 1));
    let scale = both / of_stream;
    let misfit = ((of_data - scale * both).max(0.0) / of_data).sqrt();
    misfit.is_finite().then_some(Match { clock, scale, misfit })
}

/// The delay and rate of the clock of least misfit near one that is known.
fn refined(
    mut best: Match,
    mut steps: [f64; 2],
    matched: &impl Fn([f64; 2]) -> Option<Match>,
) -> Match {
    for _ in 0..ROUNDS {
        let near = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        let near = near.map(|by| [0, 1].map(|axis| best.clock[axis] + by[axis] * steps[axis]));
        let near = near.into_iter().filter_map(matched);
        match near.min_by(|a, b| a.misfit.total_cmp(&b.misfit)) {
            Some(better) if better.misfit < best.misfit => best = better,
            _ => steps = steps.map(|step| 0.5 * step),
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Headings on a clock that is off by 40 s and runs at a rate.
    fn logged(every: f64, scale: f64, rate: f64, course: impl Fn(f64) -> f64) -> Vec<Heading> {
        let times = (0..(120.0 / every) as usize).map(|n| every * n as f64);
        times.map(|t| ((1.0 + rate) * t + 40.0, scale * course(t) + 0.7)).collect()
    }

    #[test]
    fn scales_of_headings_are_found_on_clocks_that_differ() {
        let course = |t: f64| 0.15 * t - 1.2 * (0.57 * t).cos() - 2.0 * (0.2 * t + 1.0).cos();
        let stream: Vec<Heading> =
            logged(0.01, 1.0, 0.0, course).into_iter().map(|(t, own)| (t - 9.0, own)).collect();
        for (scale, rate) in [(1.0, 0.0), (0.97, 0.0), (1.03, 1e-4), (1.01, 0.024)] {
            let found = heading_scale(&logged(0.05, scale, rate, course), &stream);
            let found = found.unwrap_or(f64::NAN);
            assert!((found + 1.0 - scale).abs() < 3e-4, "{scale} {rate}: {found}");
        }
        // A steady turn has its scale; other turns and none have no scale.
        let steady = heading_scale(&logged(0.05, 0.98, 0.0, |t| t), &logged(0.01, 1.0, 0.0, |t| t));
        assert!((steady.unwrap_or(f64::NAN) + 0.02).abs() < 1e-6, "{steady:?}");
        let other = |t: f64| 3.0 * (0.31 * t).sin() + (1.7 * t).sin();
        for own in [logged(0.05, 1.0, 0.0, other), logged(0.05, 1.0, 0.0, |_| 0.0), Vec::new()] {
            assert_eq!(heading_scale(&own, &stream), None);
        }
    }
}
