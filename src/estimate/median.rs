//! The median of positive numbers, however many: exact up to `ENOUGH`, else from a histogram whose
//! classes are `WIDTH` wide on the scale of logarithms.
//!
//! The histogram's median is that of the numbers to half a class, 5 parts in 100,000, and its
//! memory does not grow with their count.

use std::collections::BTreeMap;

/// Numbers that are kept one by one.
pub const ENOUGH: usize = 1 << 16;
/// Width of a class: ratio of its ends, less one.
const WIDTH: f64 = 1e-4;

/// Numbers seen so far.
#[derive(Clone, Debug, Default)]
pub struct Median {
    /// All of them, as long as they are few.
    few: Vec<f64>,
    classes: BTreeMap<i32, u64>,
}

impl Median {
    /// Takes a number; those that are not positive and finite count as the smallest or largest.
    pub fn see(&mut self, value: f64) {
        if !self.classes.is_empty() {
            self.class(value);
            return;
        }
        self.few.push(value);
        if self.few.len() > ENOUGH {
            std::mem::take(&mut self.few).into_iter().for_each(|value| self.class(value));
        }
    }

    fn class(&mut self, value: f64) {
        // Saturates where the number has no logarithm.
        let class = (value.ln() / WIDTH).floor() as i32;
        *self.classes.entry(class).or_default() += 1;
    }

    /// The median; `None` if nothing was seen.
    pub fn value(&self) -> Option<f64> {
        let mut values = self.few.clone();
        values.sort_by(f64::total_cmp);
        let middle = values.len() / 2;
        match values.len() {
            0 => self.of_classes(),
            n if n % 2 == 1 => Some(values[middle]),
            _ => Some(0.5 * (values[middle - 1] + values[middle])),
        }
    }

    fn of_classes(&self) -> Option<f64> {
        let count: u64 = self.classes.values().sum();
        let mut below = 0;
        for (class, own) in &self.classes {
            below += own;
            if 2 * below >= count {
                return Some(((f64::from(*class) + 0.5) * WIDTH).exp());
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_give_the_exact_median_and_many_the_same_to_half_a_class() {
        let mut median = Median::default();
        assert_eq!(median.value(), None);
        let values: Vec<f64> = (0..4 * ENOUGH)
            .map(|i| 1e-6 * (3.0 * (i as f64 * 0.754_877_666).fract() - 1.0).exp())
            .collect();
        for (count, value) in values.iter().enumerate() {
            median.see(*value);
            if [1, 2, 777, ENOUGH, ENOUGH + 1, values.len()].contains(&(count + 1)) {
                let mut sorted = values[..=count].to_vec();
                sorted.sort_by(f64::total_cmp);
                let exact = 0.5 * (sorted[count / 2] + sorted[count.div_ceil(2)]);
                let found = median.value().unwrap_or(f64::NAN);
                let tolerance = if count < ENOUGH { 0.0 } else { 0.51 * WIDTH };
                assert!((found / exact - 1.0).abs() <= tolerance, "{count}: {found} {exact}");
            }
        }
        assert!(median.few.capacity() == 0 && median.classes.len() < 40_000);
    }
}
