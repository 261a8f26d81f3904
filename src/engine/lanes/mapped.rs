//! Sums of the same numbers over a chunk, computed together: a matrix that stands still times numbers that move, as where
//! a rotation turns a point.
//!
//! What sums have in common is read once; where registers are narrow, to read is what sums cost.

use crate::engine::lanes::arithmetic::{Aligned, Arithmetic, LANES, Lanes};
use crate::engine::lanes::dispatch::Simd;
use crate::engine::lanes::instruction::{MOST_TOGETHER, Product};

/// Two or three sums.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mapped<'a> {
    /// Their terms, sum after sum.
    pub(super) products: &'a [Product],
    /// Values of a chunk, by slot.
    pub(super) slots: &'a [Box<Aligned>],
    /// Numbers that stand still.
    pub(super) stills: &'a [f64],
}

impl Mapped<'_> {
    /// Computes sums of `inputs` numbers each, `outputs` of them, and whether a number is added to each.
    #[inline(always)]
    pub(super) fn compute<A: Arithmetic, S: Simd>(
        &self,
        simd: S,
        shape: (u8, u8, bool),
        outs: [&mut Lanes; MOST_TOGETHER],
    ) {
        match shape {
            (2, 2, false) => self.shaped::<A, S, 2, 2, false>(simd, outs),
            (2, 2, true) => self.shaped::<A, S, 2, 2, true>(simd, outs),
            (2, _, false) => self.shaped::<A, S, 2, 3, false>(simd, outs),
            (2, _, true) => self.shaped::<A, S, 2, 3, true>(simd, outs),
            (_, 2, false) => self.shaped::<A, S, 3, 2, false>(simd, outs),
            (_, 2, true) => self.shaped::<A, S, 3, 2, true>(simd, outs),
            (_, _, false) => self.shaped::<A, S, 3, 3, false>(simd, outs),
            (_, _, true) => self.shaped::<A, S, 3, 3, true>(simd, outs),
        }
    }

    #[inline(always)]
    fn shaped<
        A: Arithmetic,
        S: Simd,
        const INPUTS: usize,
        const OUTPUTS: usize,
        const NUMBER: bool,
    >(
        &self,
        simd: S,
        outs: [&mut Lanes; MOST_TOGETHER],
    ) {
        let (mut factors, mut numbers) = ([[0.0; INPUTS]; OUTPUTS], [0.0; OUTPUTS]);
        let each = self.products.chunks(INPUTS + usize::from(NUMBER));
        for ((factors, number), products) in factors.iter_mut().zip(&mut numbers).zip(each) {
            for (factor, product) in factors.iter_mut().zip(products) {
                *factor = self.stills[product.factor as usize];
            }
            if NUMBER {
                *number = self.stills[products[INPUTS].factor as usize];
            }
        }
        let mut inputs: [&Lanes; INPUTS] = [&self.slots[self.products[0].a as usize]; INPUTS];
        for (input, product) in inputs.iter_mut().zip(self.products) {
            *input = &self.slots[product.a as usize];
        }
        let matrix = Matrix { factors, numbers, inputs };
        if S::F64_LANES > 2 {
            matrix.by_register::<A, S, NUMBER>(simd, outs);
        } else {
            matrix.by_lane::<A, NUMBER>(outs);
        }
    }
}

/// What is multiplied, and what is added.
struct Matrix<'a, const INPUTS: usize, const OUTPUTS: usize> {
    factors: [[f64; INPUTS]; OUTPUTS],
    numbers: [f64; OUTPUTS],
    inputs: [&'a Lanes; INPUTS],
}

#[expect(clippy::needless_range_loop, reason = "indices say which sum and which number are meant")]
impl<const INPUTS: usize, const OUTPUTS: usize> Matrix<'_, INPUTS, OUTPUTS> {
    #[inline(always)]
    fn by_lane<A: Arithmetic, const NUMBER: bool>(&self, outs: [&mut Lanes; MOST_TOGETHER]) {
        let Self { factors, numbers, inputs } = self;
        for lane in 0..LANES {
            // All is read before anything is written: it would be read again.
            let (mut read, mut sums) = ([0.0; INPUTS], [0.0; OUTPUTS]);
            for i in 0..INPUTS {
                read[i] = inputs[i][lane];
            }
            for row in 0..OUTPUTS {
                sums[row] = factors[row][0] * read[0];
                for i in 1..INPUTS {
                    sums[row] = A::mul_add(factors[row][i], read[i], sums[row]);
                }
            }
            for row in 0..OUTPUTS {
                outs[row][lane] = if NUMBER { sums[row] + numbers[row] } else { sums[row] };
            }
        }
    }

    #[inline(always)]
    fn by_register<A: Arithmetic, S: Simd, const NUMBER: bool>(
        &self,
        simd: S,
        outs: [&mut Lanes; MOST_TOGETHER],
    ) {
        let steps = LANES / S::F64_LANES;
        let mut factors = [[simd.splat_f64s(0.0); INPUTS]; OUTPUTS];
        let mut numbers = [simd.splat_f64s(0.0); OUTPUTS];
        for row in 0..OUTPUTS {
            numbers[row] = simd.splat_f64s(self.numbers[row]);
            for i in 0..INPUTS {
                factors[row][i] = simd.splat_f64s(self.factors[row][i]);
            }
        }
        let mut inputs = [&S::as_simd_f64s(self.inputs[0]).0[..steps]; INPUTS];
        for i in 1..INPUTS {
            inputs[i] = &S::as_simd_f64s(self.inputs[i]).0[..steps];
        }
        let [first, second, third] = outs;
        let outs = [
            &mut S::as_mut_simd_f64s(first).0[..steps],
            &mut S::as_mut_simd_f64s(second).0[..steps],
            &mut S::as_mut_simd_f64s(third).0[..steps],
        ];
        let (mut read, mut sums) = ([factors[0][0]; INPUTS], [factors[0][0]; OUTPUTS]);
        for step in 0..steps {
            for i in 0..INPUTS {
                read[i] = inputs[i][step];
            }
            for row in 0..OUTPUTS {
                sums[row] = simd.mul_f64s(factors[row][0], read[0]);
                for i in 1..INPUTS {
                    sums[row] = if A::FUSED {
                        simd.mul_add_f64s(factors[row][i], read[i], sums[row])
                    } else {
                        simd.add_f64s(simd.mul_f64s(factors[row][i], read[i]), sums[row])
                    };
                }
            }
            for row in 0..OUTPUTS {
                let number = numbers[row];
                outs[row][step] = if NUMBER { simd.add_f64s(sums[row], number) } else { sums[row] };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::lanes::dispatch::{InstructionSet, Task};

    struct Map<'a>(Mapped<'a>, (u8, u8, bool), [&'a mut Lanes; MOST_TOGETHER]);

    impl Task for Map<'_> {
        type Output = ();

        #[inline(always)]
        fn run<A: Arithmetic, S: Simd>(self, simd: S) {
            self.0.compute::<A, S>(simd, self.1, self.2);
        }
    }

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
                for set in InstructionSet::available() {
                    let mut outs: [Box<Aligned>; MOST_TOGETHER] = Default::default();
                    let map = Mapped { products: &products, slots: &slots, stills: &stills };
                    let shape = (inputs as u8, outputs as u8, has_number);
                    set.run(Map(map, shape, outs.each_mut().map(|lanes| &mut ***lanes)));
                    for (row, lane) in (0..outputs).flat_map(|r| (0..LANES).map(move |l| (r, l))) {
                        let term = |i: usize| {
                            let by = if i < inputs { slots[i][lane] } else { 1.0 };
                            stills[row * width + i] * by
                        };
                        let expected: f64 = (0..width).map(term).sum();
                        assert_eq!(outs[row][lane], expected, "{shape:?} {}", set.name());
                    }
                }
            }
        }
    }
}
