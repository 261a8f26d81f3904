//! When the samples of a run were taken if its sampling is uniform: the straight line through the
//! stamps over the sample number, and the jumps by which the stamps depart from it for good.
//!
//! A clock that is set while it records makes such a jump; so do a pause and rows that are lost,
//! after which the stamps are right. Which it was only readings can say. Stamps that scatter about
//! the line, or come in bursts, have no jumps.

use std::ops::Range;

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
/// Standard deviation over median absolute deviation of a normal distribution.
const NORMAL: f64 = 1.482_602_2;

/// A jump of the stamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jump {
    /// The first sample after it.
    pub(crate) sample: usize,
    /// By how much longer than usual the interval before it is (s).
    pub(crate) size: f64,
}

/// The times of uniform sampling.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Uniform {
    line: Line,
    /// From which sample on the stamps are how far (s) from where they are in the longest stretch.
    levels: Vec<(usize, f64)>,
}

impl Uniform {
    /// Of `len` stamps since the start of the run (s), which `each` shows in their order, every time
    /// it is called.
    pub(crate) fn through(len: usize, mut each: impl FnMut(&mut dyn FnMut(f64))) -> Self {
        let jumps = jumps(len, &mut each);
        let levels = levels(len, &jumps);
        let mut next = Cursor::default();
        let line = Line::through(len, |visit| {
            next = Cursor::default();
            each(&mut |time| visit(time - next.step(&levels)));
        });
        Self { line, levels }
    }

    /// The time of a sample on the line, with the jumps before it (s).
    pub(crate) fn at(&self, sample: usize) -> f64 {
        self.line.at(sample) + self.jumped(sample)
    }

    /// How far the stamps have jumped at each of some samples (s); empty where they never do.
    pub(crate) fn jumps_at(&self, samples: Range<usize>) -> Vec<f64> {
        let samples = if self.levels.is_empty() { 0..0 } else { samples };
        samples.map(|sample| self.jumped(sample)).collect()
    }

    /// The same at one sample; zero in the longest stretch between jumps.
    fn jumped(&self, sample: usize) -> f64 {
        let after = self.levels.partition_point(|(first, _)| *first <= sample);
        after.checked_sub(1).map_or(0.0, |last| self.levels[last].1)
    }
}

/// A straight line over the sample number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Line {
    middle: f64,
    mean: f64,
    slope: f64,
}

impl Line {
    /// The straight line through `len` values, which `each` shows in their order, twice.
    fn through(len: usize, mut each: impl FnMut(&mut dyn FnMut(f64))) -> Self {
        let middle = (len as f64 - 1.0) / 2.0;
        let mut sum = 0.0;
        each(&mut |value| sum += value);
        let mean = sum / len as f64;
        let (mut x, mut along, mut square) = (-middle, 0.0, 0.0);
        each(&mut |value| {
            along += x * (value - mean);
            square += x * x;
            x += 1.0;
        });
        let slope = if square > 0.0 { along / square } else { 0.0 };
        Self { middle, mean, slope }
    }

    /// Its value at a sample.
    fn at(&self, sample: usize) -> f64 {
        self.mean + self.slope * (sample as f64 - self.middle)
    }
}

/// The level at each sample in turn.
#[derive(Default)]
struct Cursor {
    sample: usize,
    passed: usize,
}

impl Cursor {
    fn step(&mut self, levels: &[(usize, f64)]) -> f64 {
        while levels.get(self.passed).is_some_and(|(first, _)| *first <= self.sample) {
            self.passed += 1;
        }
        self.sample += 1;
        self.passed.checked_sub(1).map_or(0.0, |last| levels[last].1)
    }
}

/// The sums of jumps from each on, and from the start on, less that in the longest stretch.
fn levels(len: usize, jumps: &[Jump]) -> Vec<(usize, f64)> {
    if jumps.is_empty() {
        return Vec::new();
    }
    let mut levels = vec![(0, 0.0)];
    for jump in jumps {
        levels.push((jump.sample, levels[levels.len() - 1].1 + jump.size));
    }
    let end = |number: usize| levels.get(number + 1).map_or(len, |next| next.0);
    let longest = (0..levels.len()).max_by_key(|number| end(*number) - levels[*number].0);
    let zero = longest.map_or(0.0, |number| levels[number].1);
    levels.iter().map(|(first, level)| (*first, level - zero)).collect()
}

/// The jumps of stamps that are uniform between them; none where they are not.
fn jumps(len: usize, each: &mut impl FnMut(&mut dyn FnMut(f64))) -> Vec<Jump> {
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
    let Some(usual) = median(spread.clone()).filter(|usual| *usual > 0.0) else {
        return Vec::new();
    };
    spread.iter_mut().for_each(|advance| *advance = (*advance - usual).abs());
    let scatter = NORMAL * median(spread).unwrap_or(f64::INFINITY);
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
        let (Some(low), Some(high)) = (median(before.clone()), median(after.clone())) else {
            return false;
        };
        let off = before.iter().map(|time| time - low).chain(after.iter().map(|time| time - high));
        let scatter = NORMAL * median(off.map(f64::abs).collect()).unwrap_or(f64::NAN);
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

fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::{Uniform, jumps};

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

    #[test]
    fn uniform_times_are_a_line_that_jumps_where_the_stamps_do() {
        let times = stamps(&[(300, 0.4), (900, -0.1), (500, 0.0)], 0.0);
        let each = |visit: &mut dyn FnMut(f64)| times.iter().for_each(|time| visit(*time));
        let uniform = Uniform::through(times.len(), each);
        for (sample, time) in times.iter().enumerate() {
            assert!((uniform.at(sample) - time).abs() < 1e-9);
        }
        // Zero in the longest stretch.
        let jumped = [0, 299, 300, 1199, 1200].map(|sample| uniform.jumped(sample));
        for (jumped, known) in jumped.iter().zip([-0.4, -0.4, 0.0, 0.0, -0.1]) {
            assert!((jumped - known).abs() < 1e-9, "{jumped:?}");
        }
    }
}
