//! The instructions over one chunk: each a loop that the compiler makes vectors of, compiled by
//! itself for every instruction set.

use crate::campaign::Track;
use crate::engine::lanes::added::Added;
use crate::engine::lanes::arithmetic::{Aligned, Arithmetic, LANES, Lanes};
use crate::engine::lanes::dispatch::{InstructionSet, Simd, Task};
use crate::engine::lanes::instruction::{Instruction, MOST_TOGETHER, Operand, Product, Slot};
use crate::engine::lanes::kernels;
use crate::engine::lanes::mapped::Mapped;
use crate::engine::lanes::math::map2;

/// A program's numbers over one chunk.
#[derive(Debug)]
pub(super) struct Execution<'a> {
    /// What its loops are computed with.
    pub(super) set: InstructionSet,
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

impl Execution<'_> {
    /// Computes some instructions, one after the other.
    pub(super) fn compute(&mut self, instructions: &[Instruction]) {
        for instruction in instructions {
            self.step(instruction);
        }
    }

    fn step(&mut self, instruction: &Instruction) {
        let Self { set, products, slots, spare, stills, tracks } = self;
        let (set, products, stills) = (*set, *products, *stills);
        let [first, second, third] = &mut **spare;
        let target = match *instruction {
            Instruction::Fill { value, out } => {
                first.fill(stills[value as usize]);
                out
            }
            Instruction::Signal { input, order, offset, columns, time, out } => {
                let track = &tracks[input as usize];
                set.run(Signal { track, order, offset, columns, time, slots, stills, out: first });
                out
            }
            Instruction::Unary { function, a, out } => {
                kernels::unary(set, function, &slots[a as usize], first);
                out
            }
            Instruction::SinCos { a, sin, cos } => {
                kernels::sin_cos(set, &slots[a as usize], first, second);
                std::mem::swap(&mut slots[cos as usize], second);
                sin
            }
            Instruction::Binary { function, a, b, out } => {
                kernels::binary(set, function, &slots[a as usize], &slots[b as usize], first);
                out
            }
            Instruction::Divide { a, b, out } => {
                kernels::divide(set, &slots[a as usize], &slots[b as usize], first);
                out
            }
            Instruction::DivideInto { a, b, out } => {
                kernels::divide_into(set, &slots[a as usize], stills[b as usize], first);
                out
            }
            Instruction::Sum { first: start, count, kinds, scale, out } => {
                let start = start as usize;
                let products = &products[start..start + usize::from(count)];
                Added { products, kinds, scale, slots, stills, out: first }.compute(set);
                out
            }
            Instruction::Map { first: start, inputs, has_number, outs, outputs } => {
                let (shape, products) =
                    ((inputs, outputs, has_number), &products[start as usize..]);
                let into = [&mut **first, &mut **second, &mut **third];
                Mapped { shape, products, slots, stills, outs: into }.compute(set);
                std::mem::swap(&mut slots[outs[1] as usize], second);
                if outputs == 3 {
                    std::mem::swap(&mut slots[outs[2] as usize], third);
                }
                outs[0]
            }
        };
        std::mem::swap(&mut slots[target as usize], first);
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

/// A moving input's derivative at an offset from the reference time, see [`Track::at`].
struct Signal<'a> {
    track: &'a Track,
    order: u8,
    offset: Operand,
    columns: [Slot; 3],
    time: Slot,
    slots: &'a [Box<Aligned>],
    stills: &'a [f64],
    out: &'a mut Lanes,
}

impl Task for Signal<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        let Self { track, order, offset, columns, time, slots, stills, out } = self;
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
}
