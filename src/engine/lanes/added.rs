//! Sums of products over a chunk: `scale · Σ factor · a · b`.
//!
//! There is a loop for each number of terms and each choice of their kinds, so that nothing is asked within
//! it, nor multiplied by one. Wide registers are named; for two numbers a register (SSE2) the compiler makes
//! better ones of a plain loop.

use crate::engine::lanes::arithmetic::{Aligned, Arithmetic, LANES, Lanes};
use crate::engine::lanes::dispatch::Simd;
use crate::engine::lanes::instruction::{Kind, Product, Slot};
use crate::engine::lanes::sums::MOST_TERMS;

/// Registers computed without a look at whether the chunk ends.
const UNROLLED: usize = 4;

const SINGLE: u8 = Kind::Single as u8;
const PAIR: u8 = Kind::Pair as u8;
const UNIT: u8 = Kind::Unit as u8;
const MINUS: u8 = Kind::Minus as u8;
const NUMBER: u8 = Kind::Number as u8;

/// What is done for a term of some kind, the kind known when it is compiled.
macro_rules! of_kind {
    ($kind:expr, $known:ident => $then:expr) => {
        match $kind {
            Kind::Pair => of_kind!(@ $known, PAIR, $then),
            Kind::Unit => of_kind!(@ $known, UNIT, $then),
            Kind::Minus => of_kind!(@ $known, MINUS, $then),
            Kind::Single | Kind::Number => of_kind!(@ $known, SINGLE, $then),
        }
    };
    (@ $known:ident, $kind:ident, $then:expr) => {{
        const $known: u8 = $kind;
        $then
    }};
}

/// The same of the first term of several.
macro_rules! first_of_kind {
    ($kind:expr, $known:ident => $then:expr) => {
        match $kind {
            Kind::Number => of_kind!(@ $known, NUMBER, $then),
            kind => of_kind!(kind, $known => $then),
        }
    };
}

/// The same in sums of more than [`ALL_KINDS`](super::instruction::ALL_KINDS) terms.
macro_rules! of_few_kinds {
    ($kind:expr, $known:ident => $then:expr) => {
        match $kind {
            Kind::Single => of_kind!(@ $known, SINGLE, $then),
            _ => of_kind!(@ $known, PAIR, $then),
        }
    };
}

/// A sum of at most [`MOST_TERMS`] products.
#[derive(Clone, Copy, Debug)]
pub(super) struct Added<'a> {
    /// Its terms.
    pub(super) products: &'a [Product],
    /// What each of them is.
    pub(super) kinds: [Kind; MOST_TERMS],
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
        let terms = self.terms();
        match self.scale {
            None => self.shaped::<A, S, false>(simd, &terms, out),
            Some(_) => self.shaped::<A, S, true>(simd, &terms, out),
        }
    }

    #[inline(always)]
    fn shaped<A: Arithmetic, S: Simd, const SCALED: bool>(
        &self,
        simd: S,
        terms: &Terms<'_>,
        out: &mut Lanes,
    ) {
        let [a, b, c, d] = self.kinds;
        match self.products.len() {
            1 => of_kind!(a, K0 => terms.run::<A, S, 1, K0, 0, 0, 0, SCALED>(simd, out)),
            2 => first_of_kind!(a, K0 => of_kind!(b, K1 => {
                terms.run::<A, S, 2, K0, K1, 0, 0, SCALED>(simd, out);
            })),
            3 => first_of_kind!(a, K0 => of_kind!(b, K1 => of_kind!(c, K2 => {
                terms.run::<A, S, 3, K0, K1, K2, 0, SCALED>(simd, out);
            }))),
            _ => of_few_kinds!(a, K0 => of_few_kinds!(b, K1 => {
                of_few_kinds!(c, K2 => of_few_kinds!(d, K3 => {
                    terms.run::<A, S, 4, K0, K1, K2, K3, SCALED>(simd, out);
                }))
            })),
        }
    }

    /// The numbers of its terms; the first stands in for those that are not there.
    #[inline(always)]
    fn terms(&self) -> Terms<'a> {
        let lanes = |slot: Slot| -> &'a Lanes { &self.slots[slot as usize] };
        let first = self.products[0];
        let mut terms = Terms {
            factors: [0.0; MOST_TERMS],
            left: [lanes(first.a); MOST_TERMS],
            right: [lanes(first.b); MOST_TERMS],
            scale: lanes(self.scale.unwrap_or(first.a)),
        };
        for (i, product) in self.products.iter().enumerate().take(MOST_TERMS) {
            terms.factors[i] = self.stills[product.factor as usize];
            terms.left[i] = lanes(product.a);
            terms.right[i] = lanes(product.b);
        }
        terms
    }
}

/// The numbers of a sum.
struct Terms<'a> {
    factors: [f64; MOST_TERMS],
    left: [&'a Lanes; MOST_TERMS],
    right: [&'a Lanes; MOST_TERMS],
    scale: &'a Lanes,
}

impl Terms<'_> {
    #[inline(always)]
    fn run<
        A: Arithmetic,
        S: Simd,
        const N: usize,
        const K0: u8,
        const K1: u8,
        const K2: u8,
        const K3: u8,
        const SCALED: bool,
    >(
        &self,
        simd: S,
        out: &mut Lanes,
    ) {
        if S::F64_LANES > 2 {
            self.by_register::<A, S, N, K0, K1, K2, K3, SCALED>(simd, out);
        } else {
            self.by_lane::<A, N, K0, K1, K2, K3, SCALED>(out);
        }
    }

    #[inline(always)]
    fn by_lane<
        A: Arithmetic,
        const N: usize,
        const K0: u8,
        const K1: u8,
        const K2: u8,
        const K3: u8,
        const SCALED: bool,
    >(
        &self,
        out: &mut Lanes,
    ) {
        let kinds = [K0, K1, K2, K3];
        let Self { factors, left, right, scale } = *self;
        for lane in 0..LANES {
            let mut sum = 0.0;
            for i in 0..N {
                let by = match kinds[i] {
                    NUMBER => {
                        sum = factors[i];
                        continue;
                    }
                    PAIR => factors[i] * left[i][lane],
                    UNIT => left[i][lane],
                    MINUS => -left[i][lane],
                    _ => factors[i],
                };
                let right = right[i][lane];
                sum = if i == 0 { by * right } else { A::mul_add(by, right, sum) };
            }
            out[lane] = if SCALED { sum * scale[lane] } else { sum };
        }
    }

    #[inline(always)]
    fn by_register<
        A: Arithmetic,
        S: Simd,
        const N: usize,
        const K0: u8,
        const K1: u8,
        const K2: u8,
        const K3: u8,
        const SCALED: bool,
    >(
        &self,
        simd: S,
        out: &mut Lanes,
    ) {
        let kinds = [K0, K1, K2, K3];
        let steps = LANES / S::F64_LANES;
        let mut factors = [simd.splat_f64s(self.factors[0]); N];
        let mut left = [&S::as_simd_f64s(self.left[0]).0[..steps]; N];
        let mut right = [&S::as_simd_f64s(self.right[0]).0[..steps]; N];
        for i in 1..N {
            factors[i] = simd.splat_f64s(self.factors[i]);
            left[i] = &S::as_simd_f64s(self.left[i]).0[..steps];
            right[i] = &S::as_simd_f64s(self.right[i]).0[..steps];
        }
        let scale = &S::as_simd_f64s(self.scale).0[..steps];
        let out = &mut S::as_mut_simd_f64s(out).0[..steps];
        // Short loops in a loop: those are unrolled.
        for first in (0..steps).step_by(UNROLLED) {
            for step in first..first + UNROLLED {
                let mut sum = factors[0];
                for i in 0..N {
                    let by = match kinds[i] {
                        NUMBER => {
                            sum = factors[i];
                            continue;
                        }
                        PAIR => simd.mul_f64s(factors[i], left[i][step]),
                        UNIT => left[i][step],
                        MINUS => simd.neg_f64s(left[i][step]),
                        _ => factors[i],
                    };
                    let right = right[i][step];
                    sum = match i {
                        0 => simd.mul_f64s(by, right),
                        _ if A::FUSED => simd.mul_add_f64s(by, right, sum),
                        _ => simd.add_f64s(simd.mul_f64s(by, right), sum),
                    };
                }
                out[step] = if SCALED { simd.mul_f64s(sum, scale[step]) } else { sum };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::lanes::dispatch::{InstructionSet, Task};
    use crate::engine::lanes::instruction::ALL_KINDS;

    struct Sum<'a>(Added<'a>, &'a mut Lanes);

    impl Task for Sum<'_> {
        type Output = ();

        #[inline(always)]
        fn run<A: Arithmetic, S: Simd>(self, simd: S) {
            self.0.compute::<A, S>(simd, self.1);
        }
    }

    /// Small whole numbers: exact in any order.
    #[expect(clippy::vec_box, reason = "as in a workspace")]
    fn slots() -> Vec<Box<Aligned>> {
        let number = |slot: usize, lane: usize| ((lane * 7 + slot * 31) % 23) as f64 - 11.0;
        let of = |slot| {
            let mut lanes = Box::<Aligned>::default();
            lanes.iter_mut().enumerate().for_each(|(lane, x)| *x = number(slot, lane));
            lanes
        };
        (0..9).map(of).collect()
    }

    /// All choices of so many kinds.
    fn choices(count: usize) -> Vec<Vec<Kind>> {
        let some = [Kind::Single, Kind::Pair, Kind::Unit, Kind::Minus, Kind::Number];
        let known = if count <= ALL_KINDS { &some[..4] } else { &some[..2] };
        (0..count).fold(vec![Vec::new()], |all, term| {
            let takes_number = term == 0 && (2..=ALL_KINDS).contains(&count);
            let kinds = if takes_number { &some[..] } else { known };
            let with = |one: &Vec<Kind>| {
                kinds.iter().map(|kind| [&one[..], &[*kind]].concat()).collect::<Vec<_>>()
            };
            all.iter().flat_map(with).collect()
        })
    }

    #[test]
    fn every_kind_of_term_is_what_it_says_at_every_place() {
        let (slots, stills) = (slots(), [3.0, -2.0, 5.0, 7.0]);
        let product = |term: usize| {
            let slot = 2 * term as Slot;
            Product { factor: term as u32, a: slot, b: slot + 1 }
        };
        let products: Vec<Product> = (0..MOST_TERMS).map(product).collect();
        for (count, scale) in (1..=MOST_TERMS).flat_map(|n| [(n, None), (n, Some(8))]) {
            for chosen in choices(count) {
                let mut products = products[..count].to_vec();
                let mut kinds = [Kind::default(); MOST_TERMS];
                kinds[..count].copy_from_slice(&chosen);
                for (product, kind) in products.iter_mut().zip(&chosen) {
                    if matches!(kind, Kind::Single | Kind::Number) {
                        product.b = product.a;
                    }
                }
                let expected = |lane: usize| {
                    let term = |(product, kind): (&Product, &Kind)| {
                        let [a, b] = [product.a, product.b].map(|slot| slots[slot as usize][lane]);
                        let factor = stills[product.factor as usize];
                        match kind {
                            Kind::Single => factor * a,
                            Kind::Pair => factor * a * b,
                            Kind::Unit => a * b,
                            Kind::Minus => -a * b,
                            Kind::Number => factor,
                        }
                    };
                    let sum: f64 = products.iter().zip(&chosen).map(term).sum();
                    sum * scale.map_or(1.0, |scale: Slot| slots[scale as usize][lane])
                };
                for set in InstructionSet::available() {
                    let (slots, stills) = (&slots, &stills);
                    let mut out = Box::<Aligned>::default();
                    let sum = Added { products: &products, kinds, scale, slots, stills };
                    set.run(Sum(sum, &mut out));
                    for (lane, found) in out.iter().enumerate() {
                        assert_eq!(*found, expected(lane), "{chosen:?} {}", set.name());
                    }
                }
            }
        }
    }
}
