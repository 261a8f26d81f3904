//! Medians: of numbers at hand, and of positive numbers, however many: exact up to `ENOUGH`, else from
//! a histogram whose classes are `WIDTH` wide on the scale of logarithms.
//!
//! The histogram's median is that of the numbers to half a class, 5 parts in 100,000, and its
//! memory does not grow with their count.

use std::collections::BTreeMap;

use rayon::prelude::*;

/// Numbers that are kept one by one.
pub const ENOUGH: usize = 1 << 16;
/// Width of a class: ratio of its ends, less one.
const WIDTH: f64 = 1e-4;
/// Classes that lie side by side in memory.
const PAGE: i32 = 1 << 10;
/// Numbers that one thread puts into classes at a time.
const SHARE: usize = 1 << 13;

/// Classes by page, as far as there are numbers in them.
type Classes = BTreeMap<i32, Vec<u64>>;

/// Numbers seen so far.
#[derive(Clone, Debug, Default)]
pub struct Median {
    /// All of them, as long as they are few; then those that have no class yet.
    few: Vec<f64>,
    classes: Classes,
}

impl Median {
    /// Takes a number; those that are not positive and finite count as the smallest or largest.
    pub fn see(&mut self, value: f64) {
        self.see_all(&[value]);
    }

    /// Takes numbers.
    pub fn see_all(&mut self, values: &[f64]) {
        for some in values.chunks(ENOUGH) {
            self.few.extend_from_slice(some);
            if self.few.len() > ENOUGH {
                classify(&mut self.classes, &self.few);
                self.few.clear();
            }
        }
    }

    /// The median; `None` if nothing was seen.
    pub fn value(&self) -> Option<f64> {
        if !self.classes.is_empty() {
            let mut classes = self.classes.clone();
            classify(&mut classes, &self.few);
            return of_classes(&classes);
        }
        median(&mut self.few.clone())
    }
}

/// The median of some numbers, which change their order: of an even number of them the mean of the
/// middle two.
pub fn median(numbers: &mut [f64]) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    let middle = numbers.len() / 2;
    match numbers.len() {
        0 => None,
        n if n % 2 == 1 => Some(numbers[middle]),
        _ => Some(0.5 * (numbers[middle - 1] + numbers[middle])),
    }
}

/// Counts numbers in their classes.
fn classify(classes: &mut Classes, values: &[f64]) {
    let of_some = |values: &[f64]| {
        let mut classes = Classes::new();
        for value in values {
            // Saturates where the number has no logarithm.
            let class = (value.ln() / WIDTH).floor() as i32;
            let page = classes.entry(class.div_euclid(PAGE)).or_insert_with(empty);
            page[class.rem_euclid(PAGE) as usize] += 1;
        }
        classes
    };
    let some: Vec<Classes> = values.par_chunks(SHARE).map(of_some).collect();
    for (number, page) in some.into_iter().flatten() {
        let own = classes.entry(number).or_insert_with(empty);
        own.iter_mut().zip(page).for_each(|(count, more)| *count += more);
    }
}

fn empty() -> Vec<u64> {
    vec![0; PAGE as usize]
}

fn of_classes(classes: &Classes) -> Option<f64> {
    let count: u64 = classes.values().flatten().sum();
    let mut below = 0;
    for (number, page) in classes {
        for (within, own) in page.iter().enumerate() {
            below += own;
            if *own > 0 && 2 * below >= count {
                let class = f64::from(*number) * f64::from(PAGE) + within as f64;
                return Some(((class + 0.5) * WIDTH).exp());
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_number_of_numbers_has_two_medians() {
        for (numbers, mean, upper) in [
            (vec![], None, None),
            (vec![3.0], Some(3.0), Some(3.0)),
            (vec![4.0, 1.0], Some(2.5), Some(4.0)),
            (vec![9.0, 1.0, 2.0], Some(2.0), Some(2.0)),
            (vec![9.0, 1.0, 4.0, 2.0], Some(3.0), Some(4.0)),
        ] {
            assert_eq!(super::median(&mut numbers.clone()), mean);
            assert_eq!(crate::statistics::upper_median(&mut numbers.clone()), upper);
        }
    }

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
        let mut at_once = Median::default();
        values.chunks(10_007).for_each(|some| at_once.see_all(some));
        assert_eq!(at_once.value(), median.value());
        assert!(median.few.capacity() <= 4 * ENOUGH && median.classes.len() < 40);
    }
}
