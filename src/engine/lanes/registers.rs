//! Registers of an instruction set by name, for loops in which the compiler would choose worse
//! ones.
//!
//! Answers: lanes as registers, and what is done with them. Of an instruction set of two numbers a
//! register (SSE2) an instruction reads an operand from memory only where it is known to be
//! aligned, which the compiler does not see of lanes in a box.

use std::marker::PhantomData;

use pulp::bytemuck::{cast_slice, cast_slice_mut};

use crate::engine::lanes::arithmetic::{Aligned, Arithmetic, LANES};
use crate::engine::lanes::dispatch::{InstructionSet, Simd, Task};

/// Registers, and what is done with them.
pub(super) trait Registers: Copy {
    /// The numbers in one.
    type Numbers: Copy;

    /// Lanes, register after register.
    fn of(lanes: &Aligned) -> &[Self::Numbers];

    /// The same, to be written.
    fn of_mut(lanes: &mut Aligned) -> &mut [Self::Numbers];

    /// One number in all places.
    fn splat(self, number: f64) -> Self::Numbers;

    /// `-a`.
    fn negate(self, a: Self::Numbers) -> Self::Numbers;

    /// `a + b`.
    fn add(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;

    /// `a b`.
    fn multiply(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;

    /// `a b + c`.
    fn multiply_add(self, a: Self::Numbers, b: Self::Numbers, c: Self::Numbers) -> Self::Numbers;
}

/// A loop that names its registers.
pub(super) trait ByRegister {
    /// Does it.
    fn by<R: Registers>(self, registers: R);
}

/// What computes loops, each compiled by itself.
pub(super) trait Computer: Copy {
    /// Computes one that names its registers.
    fn compute(self, what: impl ByRegister);

    /// Computes one that does not.
    fn run(self, task: impl Task<Output = ()>);
}

impl Computer for InstructionSet {
    fn compute(self, what: impl ByRegister) {
        self.run(Loop(what));
    }

    fn run(self, task: impl Task<Output = ()>) {
        Self::run(self, task);
    }
}

/// A loop with the best registers of an instruction set.
struct Loop<W>(W);

impl<W: ByRegister> Task for Loop<W> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, simd: S) {
        by_register::<A, S>(simd, self.0);
    }
}

/// Computes something with the best registers of an instruction set.
#[inline(always)]
fn by_register<A: Arithmetic, S: Simd>(simd: S, what: impl ByRegister) {
    if S::F64_LANES > 2 {
        return what.by(Wide(simd, PhantomData::<A>));
    }
    // It multiplies and adds with two roundings.
    #[cfg(target_arch = "x86_64")]
    if !A::FUSED
        && let Some(set) = pulp::x86::V1::try_new()
    {
        return what.by(Sse2(set));
    }
    what.by(One(PhantomData::<A>));
}

/// Registers of four and eight numbers.
#[derive(Clone, Copy, Debug)]
struct Wide<A, S>(S, PhantomData<A>);

impl<A: Arithmetic, S: Simd> Registers for Wide<A, S> {
    type Numbers = S::f64s;

    #[inline(always)]
    fn of(lanes: &Aligned) -> &[S::f64s] {
        &S::as_simd_f64s(&lanes[..]).0[..LANES / S::F64_LANES]
    }

    #[inline(always)]
    fn of_mut(lanes: &mut Aligned) -> &mut [S::f64s] {
        &mut S::as_mut_simd_f64s(&mut lanes[..]).0[..LANES / S::F64_LANES]
    }

    #[inline(always)]
    fn splat(self, number: f64) -> S::f64s {
        self.0.splat_f64s(number)
    }

    #[inline(always)]
    fn negate(self, a: S::f64s) -> S::f64s {
        self.0.neg_f64s(a)
    }

    #[inline(always)]
    fn add(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.add_f64s(a, b)
    }

    #[inline(always)]
    fn multiply(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.mul_f64s(a, b)
    }

    #[inline(always)]
    fn multiply_add(self, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
        if A::FUSED { self.0.mul_add_f64s(a, b, c) } else { self.add(self.multiply(a, b), c) }
    }
}

/// Registers of two numbers, of every processor of this kind.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug)]
struct Sse2(pulp::x86::V1);

#[cfg(target_arch = "x86_64")]
impl Registers for Sse2 {
    type Numbers = std::arch::x86_64::__m128d;

    #[inline(always)]
    fn of(lanes: &Aligned) -> &[Self::Numbers] {
        &cast_slice(&lanes[..])[..LANES / 2]
    }

    #[inline(always)]
    fn of_mut(lanes: &mut Aligned) -> &mut [Self::Numbers] {
        &mut cast_slice_mut(&mut lanes[..])[..LANES / 2]
    }

    #[inline(always)]
    fn splat(self, number: f64) -> Self::Numbers {
        self.0.sse2._mm_set1_pd(number)
    }

    #[inline(always)]
    fn negate(self, a: Self::Numbers) -> Self::Numbers {
        self.0.sse2._mm_xor_pd(self.splat(-0.0), a)
    }

    #[inline(always)]
    fn add(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers {
        self.0.sse2._mm_add_pd(a, b)
    }

    #[inline(always)]
    fn multiply(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers {
        self.0.sse2._mm_mul_pd(a, b)
    }

    #[inline(always)]
    fn multiply_add(self, a: Self::Numbers, b: Self::Numbers, c: Self::Numbers) -> Self::Numbers {
        self.add(self.multiply(a, b), c)
    }
}

/// No registers by name: one number at a time, of which the compiler makes vectors.
#[derive(Clone, Copy, Debug)]
struct One<A>(PhantomData<A>);

impl<A: Arithmetic> Registers for One<A> {
    type Numbers = f64;

    #[inline(always)]
    fn of(lanes: &Aligned) -> &[f64] {
        &lanes[..]
    }

    #[inline(always)]
    fn of_mut(lanes: &mut Aligned) -> &mut [f64] {
        &mut lanes[..]
    }

    #[inline(always)]
    fn splat(self, number: f64) -> f64 {
        number
    }

    #[inline(always)]
    fn negate(self, a: f64) -> f64 {
        -a
    }

    #[inline(always)]
    fn add(self, a: f64, b: f64) -> f64 {
        a + b
    }

    #[inline(always)]
    fn multiply(self, a: f64, b: f64) -> f64 {
        a * b
    }

    #[inline(always)]
    fn multiply_add(self, a: f64, b: f64, c: f64) -> f64 {
        A::mul_add(a, b, c)
    }
}

/// All kinds of registers, for tests of what is computed with them.
#[cfg(test)]
pub(super) mod kinds {
    use super::*;
    use crate::engine::lanes::arithmetic::{Fused, Plain};

    /// Some kind of registers.
    #[derive(Clone, Copy, Debug)]
    pub(in crate::engine::lanes) enum AnyKind {
        /// The best ones of an instruction set.
        Of(InstructionSet),
        /// None by name, with products that are rounded.
        Plain,
        /// None by name, with products that are not.
        Fused,
    }

    impl Computer for AnyKind {
        fn compute(self, what: impl ByRegister) {
            match self {
                Self::Of(set) => set.compute(what),
                Self::Plain => what.by(One(PhantomData::<Plain>)),
                Self::Fused => what.by(One(PhantomData::<Fused>)),
            }
        }

        fn run(self, task: impl Task<Output = ()>) {
            match self {
                Self::Of(set) => set.run(task),
                Self::Plain => task.run::<Plain, _>(pulp::Scalar128b),
                Self::Fused => task.run::<Fused, _>(pulp::Scalar128b),
            }
        }
    }

    /// All kinds, with their names.
    pub(in crate::engine::lanes) fn each_kind(mut with: impl FnMut(AnyKind, &str)) {
        for set in InstructionSet::available() {
            with(AnyKind::Of(set), set.name());
        }
        with(AnyKind::Plain, "one by one");
        with(AnyKind::Fused, "one by one, fused");
    }
}
