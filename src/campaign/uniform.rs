//! When the samples of a run were taken if its sampling is uniform: the straight line through the
//! stamps over the sample number, and the jumps by which the stamps depart from it for good.
//!
//! A clock that is set while it records makes such a jump; so do a pause and rows that are lost,
//! after which the stamps are right. Which it was only readings can say.

use std::ops::Range;

use crate::campaign::jumps::{Jump, jumps};

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
        let mut uniform = Self { line: Line::default(), levels };
        uniform.line = Line::through(len, |visit| {
            let mut sample = 0;
            each(&mut |time| {
                visit(time - uniform.jumped(sample));
                sample += 1;
            });
        });
        uniform
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

    /// The same at the first sample and at the last.
    pub(crate) fn jump_ends(&self) -> [f64; 2] {
        [self.levels.first(), self.levels.last()].map(|end| end.map_or(0.0, |(_, level)| *level))
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

#[cfg(test)]
mod tests {
    use super::Uniform;

    #[test]
    fn uniform_times_are_a_line_that_jumps_where_the_stamps_do() {
        let level = |sample: usize| match sample {
            0..300 => 0.0,
            300..1200 => 0.4,
            _ => 0.3,
        };
        let times: Vec<f64> = (0..1700).map(|n| 0.05 * n as f64 + level(n)).collect();
        let each = |visit: &mut dyn FnMut(f64)| times.iter().for_each(|time| visit(*time));
        let uniform = Uniform::through(times.len(), each);
        for (sample, time) in times.iter().enumerate() {
            assert!((uniform.at(sample) - time).abs() < 1e-9);
        }
        // Zero in the longest stretch.
        let jumped = [0, 299, 300, 1199, 1200].map(|sample| uniform.jumped(sample));
        let ends = uniform.jump_ends();
        for (jumped, known) in
            jumped.iter().chain(&ends).zip([-0.4, -0.4, 0.0, 0.0, -0.1, -0.4, -0.1])
        {
            assert!((jumped - known).abs() < 1e-9, "{jumped:?} {ends:?}");
        }
    }

    #[test]
    fn stamps_that_never_jump_have_not_jumped_at_their_ends() {
        let times: Vec<f64> = (0..500).map(|n| 0.05 * n as f64).collect();
        let each = |visit: &mut dyn FnMut(f64)| times.iter().for_each(|time| visit(*time));
        let uniform = Uniform::through(times.len(), each);
        assert!(uniform.jumps_at(0..500).is_empty());
        assert_eq!(uniform.jump_ends().map(f64::to_bits), [0, 0]);
    }
}
