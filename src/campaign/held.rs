//! Readings that are logged more often than the instrument reads: each stands in several rows, of
//! which the first alone is a measurement at its stamp.
//!
//! Readings repeat for other reasons, too: an instrument at rest, a coarse display. Those are held
//! whose repeats come in stretches of one length, and between them step by more than the last digit.
//! Single repeats of what moves on before and after them are stale: a stream whose holes were filled
//! with the last reading. Longer ones are for the diagnosis to judge.

use crate::campaign::declared::RunEntry;
use crate::campaign::loaded::LeftOut;
use crate::campaign::loader::Loader;
use crate::campaign::record::Record;
use crate::campaign::samples::Samples;
use crate::statistics::upper_median;

/// A run has so many samples at least.
const LEAST: usize = 30;
/// Part of its samples that repeat the one before at least.
const REPEATED: f64 = 0.4;
/// Part of the stretches whose length is the usual one, give or take one row.
const REGULAR: f64 = 0.8;
/// The median step of some reading is so many times its least.
const VARIOUS: f64 = 3.0;

/// Samples in a row that are stale at most; so many stretches of them at least.
const SHORT: usize = 2;
const STALE: usize = 8;
/// Part of such stretches beside which readings move, by so many times their least step.
const MOVING: f64 = 0.8;
const MOVES: f64 = 20.0;
/// Greatest number of repeats by chance, in parts of the steps by one digit.
const CHANCE: f64 = 2.0;

impl Loader<'_> {
    /// Leaves readings out that repeat the one before where they are logged more often than they are
    /// read. A run that is not in memory stays as it is.
    pub(crate) fn without_held(&mut self, entry: &RunEntry, mut record: Record) -> Record {
        let held = if record.is_in_memory() { held(record.whole()) } else { Vec::new() };
        if !held.is_empty() {
            let why = "they repeat the readings before them to the last digit, of which the first is kept: held values, or holes that were filled with the last one";
            let (run, why) = (entry.name.text.clone(), why.to_owned());
            self.left_out.push(LeftOut { run, samples: held.len(), why });
            record.edit(|samples| {
                for column in &mut samples.readings {
                    held.iter().for_each(|sample| column[*sample] = f64::NAN);
                }
            });
        }
        record
    }
}

/// The samples that repeat the readings of the one before, of a run whose readings are held.
fn held(samples: &Samples) -> Vec<usize> {
    let count = samples.len();
    let repeats = |sample: &usize| {
        let mut columns = samples.readings.iter();
        columns.all(|column| column[*sample].to_bits() == column[*sample - 1].to_bits())
    };
    let is_there = |sample: usize| samples.readings.iter().any(|column| !column[sample].is_nan());
    if count < LEAST {
        return Vec::new();
    }
    let repeated: Vec<usize> =
        (1..count).filter(|sample| is_there(*sample) && repeats(sample)).collect();
    if (repeated.len() as f64) < REPEATED * count as f64 {
        return stale(samples, &repeated);
    }
    let new: Vec<usize> = {
        let mut next = repeated.iter().copied().peekable();
        (0..count).filter(|sample| next.next_if_eq(sample).is_none()).collect()
    };
    let mut lengths: Vec<f64> = new.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
    let usual = upper_median(&mut lengths).unwrap_or(1.0);
    let is_usual = |length: &&f64| (*length - usual).abs() <= 1.0;
    let regular = lengths.iter().filter(is_usual).count();
    let is_held = usual > 1.0
        && regular as f64 >= REGULAR * lengths.len() as f64
        && samples.readings.iter().any(|column| is_various(column, &new));
    if is_held { repeated } else { Vec::new() }
}

/// The samples, of those that repeat the readings before them, that are stale.
fn stale(samples: &Samples, repeated: &[usize]) -> Vec<usize> {
    let short: Vec<&[usize]> =
        repeated.chunk_by(|a, b| b - a == 1).filter(|own| own.len() <= SHORT).collect();
    let least = |column: &Vec<f64>| {
        let steps = column.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min)
    };
    let columns: Vec<(&Vec<f64>, f64)> =
        samples.readings.iter().map(|column| (column, least(column))).collect();
    // Noise that is much larger than the last digit repeats readings by chance, and steps by one digit
    // either way as often as that; of several readings together far more often.
    let is_repeated = |sample: &usize| repeated.binary_search(sample).is_ok();
    let steps_by_one = |sample: &usize| {
        let step = |(column, least): &(&Vec<f64>, f64)| {
            let pair = [column[*sample - 1], column[*sample]];
            pair[0].to_bits() == pair[1].to_bits() || (pair[1] - pair[0]).abs() < 1.5 * least
        };
        columns.iter().all(step)
    };
    let steps = (1..samples.len()).filter(|at| !is_repeated(at) && steps_by_one(at)).count();
    if repeated.len() as f64 <= CHANCE * steps as f64 {
        return Vec::new();
    }
    let is_moving = |own: &&[usize]| {
        let (Some(before), next) = (own[0].checked_sub(2), own[own.len() - 1] + 1) else {
            return false;
        };
        let moves = |column: &Vec<f64>, least: f64, from: usize, to: usize| {
            column.get(to).is_some_and(|to| (to - column[from]).abs() > MOVES * least)
        };
        columns.iter().any(|(column, least)| {
            moves(column, *least, before, before + 1) && moves(column, *least, next - 1, next)
        })
    };
    let moving: Vec<&[usize]> = short.iter().copied().filter(is_moving).collect();
    let are_stale = moving.len() >= STALE && moving.len() as f64 >= MOVING * short.len() as f64;
    if are_stale { moving.concat() } else { Vec::new() }
}

/// Whether the steps of a reading differ by more than those of a coarse display.
fn is_various(column: &[f64], new: &[usize]) -> bool {
    let steps = new.windows(2).map(|pair| (column[pair[1]] - column[pair[0]]).abs());
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    steps.first().is_some_and(|least| steps[steps.len() / 2] >= VARIOUS * least)
}

#[cfg(test)]
mod tests {
    use super::held;
    use crate::campaign::samples::Samples;
    use crate::stream::Stream;

    fn of(readings: impl Fn(usize) -> f64) -> Vec<usize> {
        of_many(600, readings)
    }

    fn of_many(count: usize, readings: impl Fn(usize) -> f64) -> Vec<usize> {
        let readings = vec![(0..count).map(readings).collect()];
        let time = (0..count).map(|number| 0.02 * number as f64).collect();
        held(&Samples { time, readings, ..Samples::default() })
    }

    #[test]
    fn readings_that_are_held_are_their_first_row() {
        let wave = |number: usize| (0.013 * number as f64).sin();
        let found = of(|number| wave(number / 10 * 10));
        assert_eq!(found.len(), 540);
        assert!(found.iter().all(|sample| sample % 10 != 0));
        // Each in two or three rows.
        assert_eq!(of(|number| wave(number * 2 / 5)).len(), 360);
    }

    #[test]
    fn single_repeats_of_what_moves_are_stale() {
        let wave = |number: usize| (0.013 * number as f64).sin();
        let last = |number: usize| if number % 8 == 5 { number - 1 } else { number };
        let found = of(|number| wave(last(number)));
        assert!(found.len() > 60 && found.iter().all(|sample| sample % 8 == 5), "{found:?}");
        // Noise of eighty digits repeats now and then.
        let mut random = Stream(5);
        let noisy: Vec<f64> = (0..6000).map(|_| (80.0 * random.normal()).round()).collect();
        assert!(noisy.windows(2).filter(|pair| pair[0] == pair[1]).count() > 10);
        assert!(of_many(6000, |number| noisy[number]).is_empty());
        // A second column that is logged now and then, or never, changes nothing.
        for every in [7, usize::MAX] {
            let column = |number: usize| if number % every == 3 { 0.5 } else { f64::NAN };
            let columns: Vec<Vec<f64>> = vec![
                (0..600).map(|number| wave(last(number))).collect(),
                (0..600).map(column).collect(),
            ];
            let time = (0..600).map(|number| 0.02 * number as f64).collect();
            let found = held(&Samples { time, readings: columns, ..Samples::default() });
            assert!(found.len() > 40, "{every}: {}", found.len());
        }
        // Seven are not enough; a coarse display repeats by chance.
        assert!(of(|number| wave(if number < 56 { last(number) } else { number })).is_empty());
        assert!(of(|number| (200.0 * wave(last(number))).round() / 200.0).is_empty());
    }

    #[test]
    fn rests_and_coarse_displays_are_not_held() {
        let wave = |number: usize| (0.013 * number as f64).sin();
        assert!(of(wave).is_empty());
        assert!(of(|number| (20.0 * wave(number)).round() / 20.0).is_empty());
        assert!(of(|number| (number / 4) as f64).is_empty());
        // Moves for a while and rests for the rest.
        assert!(of(|number| wave(number.min(150))).is_empty());
        assert!(of(|number| wave(number % 200 / 100 * (number % 100))).is_empty());
        assert!(of(|_| 1.0).is_empty());
    }
}
