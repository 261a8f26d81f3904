//! Sums of products over a chunk: `scale · Σ factor · a · b`.
//!
//! There is a loop for each number of terms and each pattern of pairs, so that nothing is asked within
//! it. Wide registers are named; for two numbers a register (SSE2) the compiler makes better ones of a
//! plain loop.

use crate::engine::lanes::arithmetic::{Aligned, Arithmetic, LANES, Lanes};
use crate::engine::lanes::dispatch::Simd;
use crate::engine::lanes::instruction::{Product, Slot};

/// Registers computed without a look at whether the chunk ends.
const UNROLLED: usize = 4;

/// A sum of at most [`MOST_TERMS`](super::sums::MOST_TERMS) products.
#[derive(Clone, Copy, Debug)]
pub(super) struct Added<'a> {
    /// Its terms.
    pub(super) products: &'a [Product],
    /// Bit i says whether the i-th has two moving factors.
    pub(super) pairs: u8,
    /// Multiplies the sum.
    pub(super) scale: Option<Slot>,
    /// Values of a chunk, by slot.
    pub(super) slots: &'a [Box<Aligned>],
    /// Numbers that stand still.
    pub(super) stills: &'a [f64],
}

impl<'a> Added<'a> {
    #[inline(always)]
    pub(super) fn compute<A: Arithmetic, S: Simd>(&self, simd: S, out: &mut Lanes) {
        match self.scale {
            None => self.shaped::<A, S, false>(simd, out),
            Some(_) => self.shaped::<A, S, true>(simd, out),
        }
    }

    #[inline(always)]
    fn shaped<A: Arithmetic, S: Simd, const SCALED: bool>(&self, simd: S, out: &mut Lanes) {
        macro_rules! shapes {
            ($($count:literal: $($pairs:literal)*;)*) => {
                match (self.products.len(), self.pairs) {
                    $($(($count, $pairs) => {
                        let terms = self.terms::<$count>();
                        if S::F64_LANES > 2 {
                            terms.by_register::<A, S, $pairs, SCALED>(simd, out);
                        } else {
                            terms.by_lane::<A, $pairs, SCALED>(out);
                        }
                    })*)*
                    _ => out.fill(f64::NAN),
                }
            };
        }
        shapes! {
            1: 0 1;
            2: 0 1 2 3;
            3: 0 1 2 3 4 5 6 7;
            4: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15;
        }
    }

    #[inline(always)]
    fn terms<const N: usize>(&self) -> Terms<'a, N> {
        let lanes = |slot: Slot| -> &'a Lanes { &self.slots[slot as usize] };
        let product = |index: usize| self.products[index];
        Terms {
            factors: std::array::from_fn(|i| self.stills[product(i).factor as usize]),
            left: std::array::from_fn(|i| lanes(product(i).a)),
            right: std::array::from_fn(|i| lanes(product(i).b)),
            scale: lanes(self.scale.unwrap_or(product(0).a)),
        }
    }
}

/// The numbers of a sum.
struct Terms<'a, const N: usize> {
    factors: [f64; N],
    left: [&'a Lanes; N],
    right: [&'a Lanes; N],
    scale: &'a Lanes,
}

#[expect(clippy::needless_range_loop, reason = "indices say which product is meant")]
impl<const N: usize> Terms<'_, N> {
    #[inline(always)]
    fn by_lane<A: Arithmetic, const PAIRS: u8, const SCALED: bool>(&self, out: &mut Lanes) {
        let Self { factors, left, right, scale } = *self;
        for lane in 0..LANES {
            let scaled = |i: usize| {
                if PAIRS >> i & 1 == 1 { factors[i] * left[i][lane] } else { factors[i] }
            };
            let mut sum = scaled(0) * right[0][lane];
            for i in 1..N {
                sum = A::mul_add(scaled(i), right[i][lane], sum);
            }
            out[lane] = if SCALED { sum * scale[lane] } else { sum };
        }
    }

    #[inline(always)]
    fn by_register<A: Arithmetic, S: Simd, const PAIRS: u8, const SCALED: bool>(
        &self,
        simd: S,
        out: &mut Lanes,
    ) {
        let steps = LANES / S::F64_LANES;
        let factors = self.factors.map(|factor| simd.splat_f64s(factor));
        let left = self.left.map(|lanes| &S::as_simd_f64s(lanes).0[..steps]);
        let right = self.right.map(|lanes| &S::as_simd_f64s(lanes).0[..steps]);
        let scale = &S::as_simd_f64s(self.scale).0[..steps];
        let out = &mut S::as_mut_simd_f64s(out).0[..steps];
        // Short loops in a loop: those are unrolled.
        for first in (0..steps).step_by(UNROLLED) {
            for step in first..first + UNROLLED {
                let scaled = |i: usize| {
                    if PAIRS >> i & 1 == 1 {
                        simd.mul_f64s(factors[i], left[i][step])
                    } else {
                        factors[i]
                    }
                };
                let mut sum = simd.mul_f64s(scaled(0), right[0][step]);
                for i in 1..N {
                    sum = if A::FUSED {
                        simd.mul_add_f64s(scaled(i), right[i][step], sum)
                    } else {
                        simd.add_f64s(simd.mul_f64s(scaled(i), right[i][step]), sum)
                    };
                }
                out[step] = if SCALED { simd.mul_f64s(sum, scale[step]) } else { sum };
            }
        }
    }
}
