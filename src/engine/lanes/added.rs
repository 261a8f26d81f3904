//! Sums of products over a chunk: `scale · Σ factor · a · b`.
//!
//! There is a loop for each number of terms and each choice of their kinds, so that nothing is
//! asked within it, nor multiplied by one.

use crate::engine::lanes::arithmetic::Aligned;
use crate::engine::lanes::instruction::{Kind, Product, Slot};
use crate::engine::lanes::registers::{ByRegister, Registers};
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

impl ByRegister for Added<'_> {
    #[inline(always)]
    fn by<R: Registers>(self, registers: R) {
        let terms = self.terms();
        match self.scale {
            None => self.shaped::<R, false>(registers, &terms),
            Some(_) => self.shaped::<R, true>(registers, &terms),
        }
    }
}

impl<'a> Added<'a> {
    #[inline(always)]
    fn shaped<R: Registers, const SCALED: bool>(self, registers: R, terms: &Terms<'_>) {
        let out = R::of_mut(self.out);
        let [a, b, c, d] = self.kinds;
        match self.products.len() {
            1 => of_kind!(a, K0 => terms.run::<R, 1, K0, 0, 0, 0, SCALED>(registers, out)),
            2 => first_of_kind!(a, K0 => of_kind!(b, K1 => {
                terms.run::<R, 2, K0, K1, 0, 0, SCALED>(registers, out);
            })),
            3 => first_of_kind!(a, K0 => of_kind!(b, K1 => of_kind!(c, K2 => {
                terms.run::<R, 3, K0, K1, K2, 0, SCALED>(registers, out);
            }))),
            _ => of_few_kinds!(a, K0 => of_few_kinds!(b, K1 => {
                of_few_kinds!(c, K2 => of_few_kinds!(d, K3 => {
                    terms.run::<R, 4, K0, K1, K2, K3, SCALED>(registers, out);
                }))
            })),
        }
    }

    /// The numbers of its terms; the first stands in for those that are not there.
    #[inline(always)]
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

/// The numbers of a sum.
struct Terms<'a> {
    factors: [f64; MOST_TERMS],
    left: [&'a Aligned; MOST_TERMS],
    right: [&'a Aligned; MOST_TERMS],
    scale: &'a Aligned,
}

impl Terms<'_> {
    #[inline(always)]
    fn run<
        R: Registers,
        const N: usize,
        const K0: u8,
        const K1: u8,
        const K2: u8,
        const K3: u8,
        const SCALED: bool,
    >(
        &self,
        registers: R,
        out: &mut [R::Numbers],
    ) {
        let kinds = [K0, K1, K2, K3];
        let mut factors = [registers.splat(self.factors[0]); N];
        let mut left = [R::of(self.left[0]); N];
        let mut right = [R::of(self.right[0]); N];
        for i in 1..N {
            factors[i] = registers.splat(self.factors[i]);
            left[i] = R::of(self.left[i]);
            right[i] = R::of(self.right[i]);
        }
        let scale = R::of(self.scale);
        // Short loops in a loop: those are unrolled.
        for first in (0..out.len()).step_by(UNROLLED) {
            for step in first..first + UNROLLED {
                let mut sum = factors[0];
                for i in 0..N {
                    let by = match kinds[i] {
                        NUMBER => {
                            sum = factors[i];
                            continue;
                        }
                        PAIR => registers.multiply(factors[i], left[i][step]),
                        UNIT => left[i][step],
                        MINUS => registers.negate(left[i][step]),
                        _ => factors[i],
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::lanes::instruction::ALL_KINDS;
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
                each_kind(|by, name| {
                    let (slots, stills) = (&slots, &stills);
                    let mut out = Box::<Aligned>::default();
                    let products = &products;
                    by.compute(Added { products, kinds, scale, slots, stills, out: &mut out });
                    for (lane, found) in out.iter().enumerate() {
                        assert_eq!(*found, expected(lane), "{chosen:?} {name}");
                    }
                });
            }
        }
    }
}
