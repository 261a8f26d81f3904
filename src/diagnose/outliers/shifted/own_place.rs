//! A stretch of readings at their own samples, against the samples to which they may belong.

use std::collections::BTreeMap;
use std::ops::Range;

use super::{NEAR, Shifted, WORSE, square};

impl Shifted<'_> {
    /// Whether a stretch fits better so many samples away than at its own samples with an offset of its
    /// own. Where an instrument goes on by equal steps, a shift is an offset.
    pub(in crate::diagnose::outliers) fn is_no_offset(
        &self,
        periods: isize,
        samples: &Range<usize>,
    ) -> bool {
        // By how many readings a sample has: how many there are, their sums, the sum of squares.
        let mut here: BTreeMap<usize, (f64, Vec<f64>, f64)> = BTreeMap::new();
        let (mut there, mut count) = (0.0, 0.0);
        self.walk(samples, |number, residuals| {
            let away = number.checked_add_signed(periods).and_then(residuals);
            let (Some(own), Some(away)) = (residuals(number), away) else { return };
            there += square(&away);
            count += own.len() as f64;
            let sums = here.entry(own.len()).or_insert_with(|| (0.0, vec![0.0; own.len()], 0.0));
            sums.0 += 1.0;
            sums.1.iter_mut().zip(&own).for_each(|(sum, value)| *sum += value);
            sums.2 += square(&own);
        });
        let scatter = here.values().map(|(count, sums, squares)| squares - square(sums) / count);
        scatter.sum::<f64>() - there > WORSE * (there / f64::max(count, 1.0)).max(1.0)
    }

    /// Whether a stretch is among the other readings at its own samples, by the measure by which a shift
    /// carries one there, and fits no worse than so many samples away: a loss fits there far better,
    /// however much is not explained.
    pub(in crate::diagnose::outliers) fn fits_at_its_own(
        &self,
        periods: isize,
        samples: &Range<usize>,
    ) -> bool {
        let at = |shift: isize| {
            let index = usize::try_from(self.reach + shift).ok()?;
            self.squares.get(index)?.get(samples.clone())
        };
        let (Some(here), Some(there)) = (at(0), at(periods)) else { return false };
        let (mut sums, mut count) = ([0.0; 2], 0);
        let readings = &self.readings[samples.clone()];
        for ((here, there), readings) in here.iter().zip(there).zip(readings) {
            // Near an end of the run there is nothing to compare with.
            if !here.is_nan() && !there.is_nan() {
                sums[0] += f64::from(*here);
                sums[1] += f64::from(*there);
                count += readings;
            }
        }
        count > 0 && sums[0] <= NEAR * count as f64 && sums[0] <= sums[1]
    }
}
