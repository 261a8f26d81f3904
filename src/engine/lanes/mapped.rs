//! Sums of the same numbers over a chunk, computed together: a matrix that stands still times
//! numbers that move, as where a rotation turns a point.
//!
//! What sums have in common is read once; where registers are narrow, to read is what sums cost.

use crate::engine::lanes::arithmetic::Aligned;
use crate::engine::lanes::instruction::{MOST_TOGETHER, Product};
use crate::engine::lanes::registers::{ByRegister, Computer, Registers};

/// Two or three sums.
#[derive(Debug)]
pub(super) struct Mapped<'a> {
    /// How many numbers each is of, how many there are, and whether a number is added to each.
    pub(super) shape: (u8, u8, bool),
    /// Their terms, sum after sum.
    pub(super) products: &'a [Product],
    /// Values of a chunk, by slot.
    pub(super) slots: &'a [Box<Aligned>],
    /// Numbers that stand still.
    pub(super) stills: &'a [f64],
    /// Where they go.
    pub(super) outs: [&'a mut Aligned; MOST_TOGETHER],
}

impl Mapped<'_> {
    /// Computes them.
    pub(super) fn compute(self, by: impl Computer) {
        match self.shape {
            (2, 2, false) => by.compute(Shaped::<2, 2, false>(self)),
            (2, 2, true) => by.compute(Shaped::<2, 2, true>(self)),
            (2, _, false) => by.compute(Shaped::<2, 3, false>(self)),
            (2, _, true) => by.compute(Shaped::<2, 3, true>(self)),
            (_, 2, false) => by.compute(Shaped::<3, 2, false>(self)),
            (_, 2, true) => by.compute(Shaped::<3, 2, true>(self)),
            (_, _, false) => by.compute(Shaped::<3, 3, false>(self)),
            (_, _, true) => by.compute(Shaped::<3, 3, true>(self)),
        }
    }
}

/// Sums whose shape is known when it is compiled.
struct Shaped<'a, const INPUTS: usize, const OUTPUTS: usize, const NUMBER: bool>(Mapped<'a>);

impl<const INPUTS: usize, const OUTPUTS: usize, const NUMBER: bool> ByRegister
    for Shaped<'_, INPUTS, OUTPUTS, NUMBER>
{
    #[expect(
        clippy::needless_range_loop,
        reason = "indices say which sum and which number are meant"
    )]
    #[inline(always)]
    fn by<R: Registers>(self, registers: R) {
        let Mapped { products, slots, stills, outs, .. } = self.0;
        let zero = registers.splat(0.0);
        let (mut factors, mut numbers) = ([[zero; INPUTS]; OUTPUTS], [zero; OUTPUTS]);
        let each = products.chunks(INPUTS + usize::from(NUMBER));
        for ((factors, number), products) in factors.iter_mut().zip(&mut numbers).zip(each) {
            let still = |i: usize| registers.splat(stills[products[i].factor as usize]);
            for i in 0..INPUTS {
                factors[i] = still(i);
            }
            if NUMBER {
                *number = still(INPUTS);
            }
        }
        let input = |i: usize| R::of(&slots[products[i].a as usize]);
        let mut inputs = [input(0); INPUTS];
        for i in 1..INPUTS {
            inputs[i] = input(i);
        }
        let outs = outs.map(R::of_mut);
        for step in 0..outs[0].len() {
            // All is read before anything is written: it would be read again.
            let (mut read, mut sums) = ([zero; INPUTS], [zero; OUTPUTS]);
            for i in 0..INPUTS {
                read[i] = inputs[i][step];
            }
            for row in 0..OUTPUTS {
                sums[row] = registers.multiply(factors[row][0], read[0]);
                for i in 1..INPUTS {
                    sums[row] = registers.multiply_add(factors[row][i], read[i], sums[row]);
                }
            }
            for row in 0..OUTPUTS {
                let sum = sums[row];
                outs[row][step] = if NUMBER { registers.add(sum, numbers[row]) } else { sum };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::lanes::LANES;
    use crate::engine::lanes::registers::kinds::each_kind;

    #[test]
    fn every_shape_is_a_matrix_times_its_numbers() {
        let slots: Vec<Box<Aligned>> = (0..3)
            .map(|slot| {
                let mut lanes = Box::<Aligned>::default();
                // Whole numbers: exact in any order.
                let number = |lane: usize| ((lane * 5 + slot * 17) % 19) as f64 - 9.0;
                lanes.iter_mut().enumerate().for_each(|(lane, x)| *x = number(lane));
                lanes
            })
            .collect();
        let stills: Vec<f64> = (0..12).map(|still| f64::from(still) - 4.0).collect();
        let shapes = [2, 3].into_iter().flat_map(|i| [2, 3].map(|o| (i, o)));
        for (inputs, outputs) in shapes {
            for has_number in [false, true] {
                let width = inputs + usize::from(has_number);
                let product = |at: usize| {
                    let slot = (at % width).min(inputs - 1) as u32;
                    Product { factor: at as u32, a: slot, b: slot }
                };
                let products: Vec<Product> = (0..width * outputs).map(product).collect();
                let shape = (inputs as u8, outputs as u8, has_number);
                each_kind(|by, name| {
                    let mut made: [Box<Aligned>; MOST_TOGETHER] = Default::default();
                    let (products, slots, stills) = (&products, &slots, &stills);
                    let outs = made.each_mut().map(|lanes| &mut **lanes);
                    Mapped { shape, products, slots, stills, outs }.compute(by);
                    for (row, lane) in (0..outputs).flat_map(|r| (0..LANES).map(move |l| (r, l))) {
                        let term = |i: usize| {
                            let by = if i < inputs { slots[i][lane] } else { 1.0 };
                            stills[row * width + i] * by
                        };
                        let expected: f64 = (0..width).map(term).sum();
                        assert_eq!(made[row][lane], expected, "{shape:?} {name}");
                    }
                });
            }
        }
    }
}
