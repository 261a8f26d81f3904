//! Sums of products over a chunk: `scale · Σ factor · a · b`.
//!
//! Answers: which loop computes a sum. Sums whose kinds of terms are in the table below have a loop of
//! their own, in which nothing is asked, nor multiplied by one. All others are computed term after
//! term, to the same bits: a loop for every choice of kinds would be 240 a set of instructions,
//! most of which no model needs.

use crate::engine::lanes::arithmetic::{Aligned, Arithmetic, LANES};
use crate::engine::lanes::dispatch::{Simd, Task};
use crate::engine::lanes::instruction::{Kind, MOST_TERMS, Product, Slot};
use crate::engine::lanes::registers::{ByRegister, Computer, Registers};

/// Registers computed without a look at whether the chunk ends.
const UNROLLED: usize = 4;

/// A sum of at most [`MOST_TERMS`] products.
#[derive(Debug)]
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
    /// Where it goes.
    pub(super) out: &'a mut Aligned,
}

/// The kinds of terms that have a loop of their own, by their number: the loop alone, or also one
/// that multiplies the sum by a scale.
macro_rules! fused {
    (
        plain: $($plain:literal $([$($kind:ident)+])+;)+
        scaled: $($scaled:literal $([$($scaled_kind:ident)+])+;)+
    ) => {
        /// Whether sums of such terms have a loop of their own.
        pub(super) fn is_fused(kinds: &[Kind]) -> bool {
            matches!(kinds, $($([$(Kind::$kind),+])|+)|+)
        }

        impl Added<'_> {
            /// Computes it.
            pub(super) fn compute(self, by: impl Computer) {
                let terms = self.terms();
                let (count, out) = (self.products.len(), self.out);
                match (&self.kinds[..count], self.scale) {
                    $($(([$(Kind::$kind),+], None) => by.compute(
                        Shaped::<$plain, { code(&[$(Kind::$kind),+]) }, false> { terms, out }
                    ),)+)+
                    $($(([$(Kind::$scaled_kind),+], Some(_)) => by.compute(
                        Shaped::<$scaled, { code(&[$(Kind::$scaled_kind),+]) }, true> { terms, out }
                    ),)+)+
                    (kinds, scale) => {
                        by.run(TermAfterTerm { terms, kinds, is_scaled: scale.is_some(), out });
                    }
                }
            }
        }
    };
}

// What the models of the library need often, and every choice of `Single` and `Pair`.
fused! {
    plain:
        1 [Single] [Pair] [Unit];
        2 [Single Single] [Single Pair] [Pair Single] [Pair Pair]
          [Unit Unit] [Minus Unit] [Unit Minus]
          [Number Single] [Number Pair] [Number Minus];
        3 [Single Single Single] [Single Single Pair] [Single Pair Single] [Single Pair Pair]
          [Pair Single Single] [Pair Single Pair] [Pair Pair Single] [Pair Pair Pair]
          [Unit Unit Unit]
          [Number Single Single] [Number Single Pair] [Number Pair Single] [Number Pair Pair];
        4 [Single Single Single Single] [Single Single Single Pair]
          [Single Single Pair Single] [Single Single Pair Pair]
          [Single Pair Single Single] [Single Pair Single Pair]
          [Single Pair Pair Single] [Single Pair Pair Pair]
          [Pair Single Single Single] [Pair Single Single Pair]
          [Pair Single Pair Single] [Pair Single Pair Pair]
          [Pair Pair Single Single] [Pair Pair Single Pair]
          [Pair Pair Pair Single] [Pair Pair Pair Pair];
    scaled:
        1 [Single] [Pair] [Unit];
        2 [Single Single] [Single Pair] [Pair Single] [Pair Pair] [Unit Unit];
}

/// Kinds as one number that is known when a loop is compiled: four bits each.
const fn code(kinds: &[Kind]) -> u16 {
    let (mut code, mut index) = (0, 0);
    while index < kinds.len() {
        code |= (kinds[index] as u16) << (4 * index);
        index += 1;
    }
    code
}

/// The numbers of a sum.
struct Terms<'a> {
    factors: [f64; MOST_TERMS],
    left: [&'a Aligned; MOST_TERMS],
    right: [&'a Aligned; MOST_TERMS],
    scale: &'a Aligned,
}

impl<'a> Added<'a> {
    /// The numbers of its terms; the first stands in for those that are not there.
    fn terms(&self) -> Terms<'a> {
        let lanes = |slot: Slot| -> &'a Aligned { &self.slots[slot as usize] };
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

/// A sum of terms whose number and kinds are known when it is compiled.
struct Shaped<'a, const N: usize, const KINDS: u16, const SCALED: bool> {
    terms: Terms<'a>,
    out: &'a mut Aligned,
}

const SINGLE: u16 = Kind::Single as u16;
const PAIR: u16 = Kind::Pair as u16;
const UNIT: u16 = Kind::Unit as u16;
const MINUS: u16 = Kind::Minus as u16;

impl<const N: usize, const KINDS: u16, const SCALED: bool> ByRegister
    for Shaped<'_, N, KINDS, SCALED>
{
    #[inline(always)]
    fn by<R: Registers>(self, registers: R) {
        let terms = self.terms;
        let out = R::of_mut(self.out);
        let mut factors = [registers.splat(terms.factors[0]); N];
        let mut left = [R::of(terms.left[0]); N];
        let mut right = [R::of(terms.right[0]); N];
        for i in 1..N {
            factors[i] = registers.splat(terms.factors[i]);
            left[i] = R::of(terms.left[i]);
            right[i] = R::of(terms.right[i]);
        }
        let scale = R::of(terms.scale);
        // Short loops in a loop: those are unrolled.
        for first in (0..out.len()).step_by(UNROLLED) {
            for step in first..first + UNROLLED {
                let mut sum = factors[0];
                for i in 0..N {
                    let by = match KINDS >> (4 * i) & 0xf {
                        SINGLE => factors[i],
                        PAIR => registers.multiply(factors[i], left[i][step]),
                        UNIT => left[i][step],
                        MINUS => registers.negate(left[i][step]),
                        // A number, as the first term.
                        _ => continue,
                    };
                    let right = right[i][step];
                    sum = if i == 0 {
                        registers.multiply(by, right)
                    } else {
                        registers.multiply_add(by, right, sum)
                    };
                }
                out[step] = if SCALED { registers.multiply(sum, scale[step]) } else { sum };
            }
        }
    }
}

/// A sum of any terms.
struct TermAfterTerm<'a> {
    terms: Terms<'a>,
    kinds: &'a [Kind],
    is_scaled: bool,
    out: &'a mut Aligned,
}

impl Task for TermAfterTerm<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        let Self { terms, kinds, is_scaled, out } = self;
        for (i, kind) in kinds.iter().enumerate() {
            let (factor, left, right) = (terms.factors[i], terms.left[i], terms.right[i]);
            let by = |lane: usize| match kind {
                Kind::Single | Kind::Number => factor,
                Kind::Pair => factor * left[lane],
                Kind::Unit => left[lane],
                Kind::Minus => -left[lane],
            };
            for lane in 0..LANES {
                out[lane] = match (i, kind) {
                    (_, Kind::Number) => by(lane),
                    (0, _) => by(lane) * right[lane],
                    _ => A::mul_add(by(lane), right[lane], out[lane]),
                };
            }
        }
        if is_scaled {
            for lane in 0..LANES {
                out[lane] *= terms.scale[lane];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::lanes::registers::kinds::each_kind;

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
        (0..count).fold(vec![Vec::new()], |all, term| {
            let kinds = if term == 0 && count > 1 { &some[..] } else { &some[..4] };
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
                each_kind(|by, name| {
                    let (slots, stills) = (&slots, &stills);
                    let mut out = Box::<Aligned>::default();
                    let products = &products;
                    Added { products, kinds, scale, slots, stills, out: &mut out }.compute(by);
                    for (lane, found) in out.iter().enumerate() {
                        assert_eq!(*found, expected(lane), "{chosen:?} {name}");
                    }
                });
            }
        }
    }
}
