//! Where the stamps of a run jump, if its sampling is uniform otherwise, and by how much.
//!
//! Means of stamps before and after a jump are farther apart than elsewhere, and stamps stay where it
//! put them. Stamps that scatter, come in bursts or are late once have no jumps.

use crate::statistics::{NORMAL, upper_median};

/// Samples from which it is known how far means of stamps are apart, at most.
const MOST_PLACES: usize = 10_000;
/// Samples on each side by which a jump is recognised.
const BESIDE: usize = 16;
/// Samples on each side from which its size is taken at most.
const LEVEL: usize = 256;
/// A jump in parts of the usual interval at least, and in standard deviations of the stamps beside
/// it.
const LEAST: f64 = 0.03;
const DEVIATIONS: f64 = 2.5;
/// A jump is suspected where means of stamps are apart by so many robust standard deviations of how
/// far they are apart elsewhere.
const SUSPECT: f64 = 8.0;
/// Jumps at most: stamps with more of them are not uniform.
const MOST: usize = 50;

/// A jump of the stamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jump {
    /// The first sample after it.
    pub(crate) sample: usize,
    /// By how much longer than usual the interval before it is (s).
    pub(crate) size: f64,
}

/// The jumps of stamps that are uniform between them; none where they are not.
pub(crate) fn jumps(len: usize, each: &mut impl FnMut(&mut dyn FnMut(f64))) -> Vec<Jump> {
    if len < 2 * BESIDE {
        return Vec::new();
    }
    let step = len.div_ceil(MOST_PLACES);
    let mut spread = Vec::with_capacity(len / step);
    advances(each, |sample, advance| {
        if sample % step == 0 {
            spread.push(advance);
        }
    });
    let Some(usual) = upper_median(&mut spread.clone()).filter(|usual| *usual > 0.0) else {
        return Vec::new();
    };
    spread.iter_mut().for_each(|advance| *advance = (*advance - usual).abs());
    let scatter = NORMAL * upper_median(&mut spread).unwrap_or(f64::INFINITY);
    let usual = usual / BESIDE as f64;
    let least = (LEAST * usual).max(SUSPECT * scatter);
    // Of those side by side the largest.
    let mut suspected: Vec<(f64, usize)> = Vec::new();
    advances(each, |sample, advance| {
        let off = (advance - BESIDE as f64 * usual).abs();
        let is_new = suspected.last().is_none_or(|last| sample >= last.1 + BESIDE);
        if off <= least {
            return;
        }
        if is_new && suspected.len() <= MOST {
            suspected.push((off, sample));
        } else if let Some(last) = suspected.last_mut().filter(|last| !is_new && off > last.0) {
            *last = (off, sample);
        }
    });
    if suspected.is_empty() || suspected.len() > MOST {
        return Vec::new();
    }
    let stays = for_good(usual, &suspected, each);
    let kept = suspected.iter().zip(stays).filter(|(_, stays)| *stays);
    let jumps: Vec<usize> = kept.map(|((_, sample), _)| *sample).collect();
    sized(len, &jumps, each)
}

/// For each sample with enough on either side by how much the mean of the stamps from it on is
/// beyond that of the stamps before it.
fn advances(each: &mut impl FnMut(&mut dyn FnMut(f64)), mut visit: impl FnMut(usize, f64)) {
    let mut stamps = [0.0; BESIDE];
    let mut lagged = [0.0; BESIDE];
    let mut sample = 0;
    each(&mut |time| {
        let place = sample % BESIDE;
        lagged[place] = time - stamps[place];
        stamps[place] = time;
        sample += 1;
        if sample >= 2 * BESIDE {
            visit(sample - BESIDE, lagged.iter().sum::<f64>() / BESIDE as f64);
        }
    });
}

/// Whether stamps stay, after suspected jumps, where the jump put them: by the medians of the samples
/// beside it.
fn for_good(
    usual: f64,
    suspected: &[(f64, usize)],
    each: &mut impl FnMut(&mut dyn FnMut(f64)),
) -> Vec<bool> {
    let mut beside: Vec<[Vec<f64>; 2]> = vec![Default::default(); suspected.len()];
    let (mut near, mut sample) = (0, 0);
    each(&mut |time| {
        while suspected.get(near).is_some_and(|(_, at)| at + BESIDE <= sample) {
            near += 1;
        }
        for ((_, at), own) in suspected.iter().zip(&mut beside).skip(near) {
            if *at > sample + BESIDE {
                break;
            }
            // From where uniform sampling at the jump would put it.
            own[usize::from(sample >= *at)].push(time - usual * (sample as f64 - *at as f64));
        }
        sample += 1;
    });
    let judge = |[before, after]: [Vec<f64>; 2]| {
        let (Some(low), Some(high)) =
            (upper_median(&mut before.clone()), upper_median(&mut after.clone()))
        else {
            return false;
        };
        let off = before.iter().map(|time| time - low).chain(after.iter().map(|time| time - high));
        let scatter =
            NORMAL * upper_median(&mut off.map(f64::abs).collect::<Vec<f64>>()).unwrap_or(f64::NAN);
        (high - low).abs() > (LEAST * usual).max(DEVIATIONS * scatter)
    };
    beside.into_iter().map(judge).collect()
}

/// Sums over samples, counted from a first one.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    number: f64,
    time: f64,
    square: f64,
    product: f64,
}

impl Sums {
    fn add(&mut self, number: f64, time: f64) {
        self.count += 1.0;
        self.number += number;
        self.time += time;
        self.square += number * number;
        self.product += number * time;
    }

    /// The centred sum of squares of numbers, and of products with times.
    fn centred(&self) -> (f64, f64) {
        let mean = self.number / self.count;
        (self.square - mean * self.number, self.product - mean * self.time)
    }
}

/// Samples between jumps: the first one with its time; sums of all, of the first and of the last ones.
#[derive(Clone, Debug, Default)]
struct Between {
    first: (usize, f64),
    all: Sums,
    begin: Sums,
    end: Sums,
}

/// Jumps at samples with their sizes: by how much farther the means of the samples beside a jump are
/// apart than the interval within all stretches says.
fn sized(len: usize, jumps: &[usize], each: &mut impl FnMut(&mut dyn FnMut(f64))) -> Vec<Jump> {
    let mut stretches: Vec<Between> = Vec::new();
    let mut sample = 0;
    each(&mut |time| {
        if sample == 0 || jumps.get(stretches.len() - 1) == Some(&sample) {
            stretches.push(Between { first: (sample, time), ..Between::default() });
        }
        let next = stretches.len() - 1;
        let end = jumps.get(next).copied().unwrap_or(len);
        let own = &mut stretches[next];
        let (number, time) = ((sample - own.first.0) as f64, time - own.first.1);
        own.all.add(number, time);
        if sample < own.first.0 + LEVEL {
            own.begin.add(number, time);
        }
        if sample + LEVEL >= end {
            own.end.add(number, time);
        }
        sample += 1;
    });
    let (mut square, mut product) = (0.0, 0.0);
    for own in &stretches {
        let (of_numbers, of_times) = own.all.centred();
        square += of_numbers;
        product += of_times;
    }
    let interval = product / square;
    let mean = |own: &Between, sums: &Sums| {
        let number = own.first.0 as f64 + sums.number / sums.count;
        own.first.1 + sums.time / sums.count - interval * number
    };
    let size = |pair: &[Between]| mean(&pair[1], &pair[1].begin) - mean(&pair[0], &pair[0].end);
    let sizes = stretches.windows(2).map(size);
    jumps.iter().zip(sizes).map(|(sample, size)| Jump { sample: *sample, size }).collect()
}

#[cfg(test)]
mod tests {
    use super::jumps;

    /// Stamps every 50 ms of a stretch of samples each, shaken, with jumps before the next ones.
    fn stamps(stretches: &[(usize, f64)], shake: f64) -> Vec<f64> {
        let mut times = Vec::new();
        let mut level = 0.0;
        for (count, jump) in stretches {
            for _ in 0..*count {
                let sample = times.len() as f64;
                times.push(0.05 * sample + level + shake * (12.9898 * sample).sin());
            }
            level += jump;
        }
        times
    }

    fn found(times: &[f64]) -> Vec<(usize, f64)> {
        let mut each = |visit: &mut dyn FnMut(f64)| times.iter().for_each(|time| visit(*time));
        jumps(times.len(), &mut each).iter().map(|one| (one.sample, one.size)).collect()
    }

    #[test]
    fn jumps_of_uniform_stamps_are_found_with_their_sizes() {
        for shake in [0.0, 1e-3] {
            let all = found(&stamps(&[(400, 0.083), (700, -0.03), (900, 0.0)], shake));
            assert_eq!(all.iter().map(|one| one.0).collect::<Vec<_>>(), [400, 1100], "{all:?}");
            for ((_, size), known) in all.iter().zip([0.083, -0.03]) {
                assert!((size - known).abs() < 1e-9 + 0.2 * shake, "{all:?}");
            }
        }
    }

    #[test]
    fn scatter_glitches_rounding_bursts_and_rates_are_no_jumps() {
        let even = stamps(&[(2000, 0.0)], 1e-3);
        assert_eq!(found(&even), []);
        // One late stamp.
        let mut late = even.clone();
        late[700] += 0.04;
        assert_eq!(found(&late), []);
        // Rounded to 10 ms; another rate; arrivals four at a time; none; few.
        let map = |change: fn(usize, f64) -> f64| -> Vec<f64> {
            even.iter().enumerate().map(|(number, time)| change(number, *time)).collect()
        };
        assert_eq!(found(&map(|_, time| (70.0 * time).round() / 100.0)), []);
        assert_eq!(found(&map(|_, time| 1.01 * time)), []);
        assert_eq!(
            found(&map(|number, _| 0.2 * (number / 4) as f64 + 1e-3 * (number % 4) as f64)),
            []
        );
        assert_eq!(found(&[]), []);
        assert_eq!(found(&even[..20]), []);
    }
}
