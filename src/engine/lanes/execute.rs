//! The instructions over one chunk: each a loop that the compiler makes vectors of.

use crate::engine::lanes::dispatch::Simd;

use crate::campaign::Track;
use crate::engine::lanes::added::Added;
use crate::engine::lanes::arithmetic::{Aligned, Arithmetic, LANES, Lanes};
use crate::engine::lanes::dispatch::Task;
use crate::engine::lanes::instruction::{Instruction, MOST_TOGETHER, Operand, Product, Slot};
use crate::engine::lanes::mapped::Mapped;
use crate::engine::lanes::math::{self, map, map2};
use crate::engine::lanes::registers::by_register;
use crate::graph::{Binary, Unary};

/// Some instructions over one chunk.
#[derive(Debug)]
pub(super) struct Execution<'a> {
    /// What to compute.
    pub(super) instructions: &'a [Instruction],
    /// The products of its sums.
    pub(super) products: &'a [Product],
    /// Values of a chunk, by slot.
    pub(super) slots: &'a mut [Box<Aligned>],
    /// Further ones: results come here first, so that no step reads where it writes.
    pub(super) spare: &'a mut [Box<Aligned>; MOST_TOGETHER],
    /// Numbers that stand still.
    pub(super) stills: &'a [f64],
    /// Inputs of the run.
    pub(super) tracks: &'a [Track],
}

impl Task for Execution<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, simd: S) {
        let Self { instructions, products, slots, spare, stills, tracks } = self;
        for instruction in instructions {
            step::<A, S>(simd, instruction, products, slots, spare, stills, tracks);
        }
    }
}

/// `out[i] = value[i] + offset · rate[i]`
#[inline(always)]
fn advance<A: Arithmetic>(
    out: &mut Lanes,
    value: &Lanes,
    rate: &Lanes,
    offset: Operand,
    slots: &[Box<Aligned>],
    stills: &[f64],
) {
    match offset {
        Operand::Lane(slot) => {
            let offset = &slots[slot as usize];
            for i in 0..LANES {
                out[i] = A::mul_add(rate[i], offset[i], value[i]);
            }
        }
        Operand::Still(still) => {
            let offset = stills[still as usize];
            map2(rate, value, out, |rate, value| A::mul_add(rate, offset, value));
        }
    }
}

#[inline(always)]
fn step<A: Arithmetic, S: Simd>(
    simd: S,
    instruction: &Instruction,
    products: &[Product],
    slots: &mut [Box<Aligned>],
    spare: &mut [Box<Aligned>; MOST_TOGETHER],
    stills: &[f64],
    tracks: &[Track],
) {
    let [first, second, third] = spare;
    let target = match *instruction {
        Instruction::Fill { value, out } => {
            first.fill(stills[value as usize]);
            out
        }
        Instruction::Signal { input, order, offset, columns, time, out } => {
            let track = &tracks[input as usize];
            signal::<A>(track, order, offset, columns, time, slots, stills, first);
            out
        }
        Instruction::Unary { function, a, out } => {
            unary::<A>(function, &slots[a as usize], first);
            out
        }
        Instruction::SinCos { a, sin, cos } => {
            math::sin_cos::<A>(&slots[a as usize], first, second);
            std::mem::swap(&mut slots[cos as usize], second);
            sin
        }
        Instruction::Binary { function, a, b, out } => {
            binary::<A>(function, &slots[a as usize], &slots[b as usize], first);
            out
        }
        Instruction::Divide { a, b, out } => {
            math::divide(&slots[a as usize], &slots[b as usize], first);
            out
        }
        Instruction::DivideInto { a, b, out } => {
            let b = stills[b as usize];
            map(&slots[a as usize], first, |a| b / a);
            out
        }
        Instruction::Sum { first: start, count, kinds, scale, out } => {
            let start = start as usize;
            let sum = Added {
                products: &products[start..start + usize::from(count)],
                kinds,
                scale,
                slots,
                stills,
                out: first,
            };
            by_register::<A, S>(simd, sum);
            out
        }
        Instruction::Map { first: start, inputs, has_number, outs, outputs } => {
            let (shape, products) = ((inputs, outputs, has_number), &products[start as usize..]);
            let into = [&mut **first, &mut **second, &mut **third];
            by_register::<A, S>(simd, Mapped { shape, products, slots, stills, outs: into });
            std::mem::swap(&mut slots[outs[1] as usize], second);
            if outputs == 3 {
                std::mem::swap(&mut slots[outs[2] as usize], third);
            }
            outs[0]
        }
    };
    std::mem::swap(&mut slots[target as usize], first);
}

#[inline(always)]
fn unary<A: Arithmetic>(function: Unary, a: &Lanes, out: &mut Lanes) {
    match function {
        Unary::Negate => math::negate(a, out),
        Unary::Sin => math::sin::<A>(a, out),
        Unary::Cos => math::cos::<A>(a, out),
        Unary::Tan => math::tan::<A>(a, out),
        Unary::Asin => math::asin::<A>(a, out),
        Unary::Acos => math::acos::<A>(a, out),
        Unary::Atan => math::atan::<A>(a, out),
        Unary::Sqrt => math::sqrt(a, out),
        Unary::Exp => math::exp::<A>(a, out),
        Unary::Ln => math::ln::<A>(a, out),
        Unary::Abs => math::abs(a, out),
        Unary::Sign => math::sign(a, out),
        Unary::Tanh => math::tanh::<A>(a, out),
        Unary::Floor => math::floor(a, out),
        Unary::Fract => math::fract(a, out),
        Unary::PowerInteger(exponent) => math::powi(a, exponent, out),
        Unary::Stumpff(order) => math::stumpff::<A>(a, order, out),
        Unary::ReciprocalOrZero => math::reciprocal_or_zero(a, out),
    }
}

#[inline(always)]
fn binary<A: Arithmetic>(function: Binary, a: &Lanes, b: &Lanes, out: &mut Lanes) {
    match function {
        Binary::Add => math::add(a, b, out),
        Binary::Subtract => math::subtract(a, b, out),
        Binary::Multiply => math::multiply(a, b, out),
        Binary::Divide => math::divide(a, b, out),
        Binary::Power => math::pow::<A>(a, b, out),
        Binary::Atan2 => math::atan2::<A>(a, b, out),
        Binary::Hypot => math::hypot::<A>(a, b, out),
        Binary::Min => math::min(a, b, out),
        Binary::Max => math::max(a, b, out),
    }
}

/// A moving input's derivative at an offset from the reference time, see [`Track::at`].
#[expect(clippy::too_many_arguments, reason = "the fields of one instruction")]
#[inline(always)]
fn signal<A: Arithmetic>(
    track: &Track,
    order: u8,
    offset: Operand,
    columns: [Slot; 3],
    time: Slot,
    slots: &[Box<Aligned>],
    stills: &[f64],
    out: &mut Lanes,
) {
    let [value, rate, acceleration] = columns.map(|slot| &slots[slot as usize]);
    let (moves, bends) = match track {
        Track::Captured { rate, acceleration, .. } => (rate.is_some(), acceleration.is_some()),
        Track::Absent | Track::Constant(_) | Track::Logged(_) => (false, false),
    };
    match (track, order) {
        (Track::Absent, _) => out.fill(f64::NAN),
        (Track::Logged(spline), _) => {
            let time = &slots[time as usize];
            let mut piece = 0;
            for i in 0..LANES {
                let offset = match offset {
                    Operand::Lane(slot) => slots[slot as usize][i],
                    Operand::Still(still) => stills[still as usize],
                };
                out[i] = spline.at_near(time[i], offset, order, &mut piece);
            }
        }
        (_, 0) if bends => match offset {
            Operand::Still(still) => {
                let offset = stills[still as usize];
                let half = 0.5 * offset;
                for i in 0..LANES {
                    let slope = A::mul_add(half, acceleration[i], rate[i]);
                    out[i] = A::mul_add(slope, offset, value[i]);
                }
            }
            Operand::Lane(slot) => {
                let offset = &slots[slot as usize];
                for i in 0..LANES {
                    let slope = A::mul_add(0.5 * offset[i], acceleration[i], rate[i]);
                    out[i] = A::mul_add(slope, offset[i], value[i]);
                }
            }
        },
        (_, 0) if moves => {
            advance::<A>(out, value, rate, offset, slots, stills);
        }
        (_, 0) => *out = ***value,
        (_, 1) if bends => {
            advance::<A>(out, rate, acceleration, offset, slots, stills);
        }
        (_, 1) if moves => *out = ***rate,
        (_, 2) if bends => *out = ***acceleration,
        _ => out.fill(0.0),
    }
}
