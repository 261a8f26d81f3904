//! The functions of a graph's nodes over a chunk, compiled for every instruction set.
//!
//! Answers: which loop computes a function. Each loop is a machine function of its own that is
//! called once for the 192 samples of a chunk, which costs a hundredth of it. In one function, all
//! loops together took minutes to compile: the effort grows faster than the function.

use crate::engine::lanes::arithmetic::{Arithmetic, Lanes};
use crate::engine::lanes::dispatch::{InstructionSet, Simd, Task};
use crate::engine::lanes::math;
use crate::graph::{Binary, Unary};

/// Runs a kernel as a task of its own: the arguments with their types, then the computation, in
/// which `A` is the [`Arithmetic`].
macro_rules! run {
    ($set:ident, ($($argument:ident: $kind:ty),*), $compute:expr) => {{
        struct Kernel<'a> {
            $($argument: $kind,)*
        }

        impl Task for Kernel<'_> {
            type Output = ();

            #[inline(always)]
            fn run<A: Arithmetic, S: Simd>(self, _: S) {
                let Self { $($argument),* } = self;
                $compute;
            }
        }

        $set.run(Kernel { $($argument),* });
    }};
}

/// A function of one number.
pub(super) fn unary(set: InstructionSet, function: Unary, a: &Lanes, out: &mut Lanes) {
    macro_rules! kernel {
        ($function:expr) => {
            run!(set, (a: &'a Lanes, out: &'a mut Lanes), $function(a, out))
        };
    }
    match function {
        Unary::Negate => kernel!(math::negate),
        Unary::Sin => kernel!(math::sin::<A>),
        Unary::Cos => kernel!(math::cos::<A>),
        Unary::Tan => kernel!(math::tan::<A>),
        Unary::Asin => kernel!(math::asin::<A>),
        Unary::Acos => kernel!(math::acos::<A>),
        Unary::Atan => kernel!(math::atan::<A>),
        Unary::Sqrt => kernel!(math::sqrt),
        Unary::Exp => kernel!(math::exp::<A>),
        Unary::Ln => kernel!(math::ln::<A>),
        Unary::Abs => kernel!(math::abs),
        Unary::Sign => kernel!(math::sign),
        Unary::Tanh => kernel!(math::tanh::<A>),
        Unary::Floor => kernel!(math::floor),
        Unary::Fract => kernel!(math::fract),
        Unary::ReciprocalOrZero => kernel!(math::reciprocal_or_zero),
        Unary::PowerInteger(exponent) => {
            run!(set, (a: &'a Lanes, exponent: i32, out: &'a mut Lanes), {
                math::powi(a, exponent, out);
            });
        }
        Unary::Stumpff(order) => {
            run!(set, (a: &'a Lanes, order: u8, out: &'a mut Lanes), {
                math::stumpff::<A>(a, order, out);
            });
        }
    }
}

/// A function of two numbers.
pub(super) fn binary(set: InstructionSet, function: Binary, a: &Lanes, b: &Lanes, out: &mut Lanes) {
    macro_rules! kernel {
        ($function:expr) => {
            run!(set, (a: &'a Lanes, b: &'a Lanes, out: &'a mut Lanes), $function(a, b, out))
        };
    }
    match function {
        Binary::Add => kernel!(math::add),
        Binary::Subtract => kernel!(math::subtract),
        Binary::Multiply => kernel!(math::multiply),
        Binary::Divide => kernel!(math::divide),
        Binary::Power => kernel!(math::pow::<A>),
        Binary::Atan2 => kernel!(math::atan2::<A>),
        Binary::Hypot => kernel!(math::hypot::<A>),
        Binary::Min => kernel!(math::min),
        Binary::Max => kernel!(math::max),
    }
}

/// Sine and cosine of one angle.
pub(super) fn sin_cos(set: InstructionSet, a: &Lanes, sin: &mut Lanes, cos: &mut Lanes) {
    run!(set, (a: &'a Lanes, sin: &'a mut Lanes, cos: &'a mut Lanes), {
        math::sin_cos::<A>(a, sin, cos);
    });
}

/// `a / b`, lane by lane.
pub(super) fn divide(set: InstructionSet, a: &Lanes, b: &Lanes, out: &mut Lanes) {
    run!(set, (a: &'a Lanes, b: &'a Lanes, out: &'a mut Lanes), math::divide(a, b, out));
}

/// `b / a`, one number by each lane.
pub(super) fn divide_into(set: InstructionSet, a: &Lanes, b: f64, out: &mut Lanes) {
    run!(set, (a: &'a Lanes, b: f64, out: &'a mut Lanes), math::map(a, out, |a| b / a));
}
