//! What a lane program is made of.

use crate::graph::{Binary, Clock, Unary};

/// Where the values of one quantity over the chunk are kept.
pub(super) type Slot = u32;

/// Index of a number that is the same for all samples of a run.
pub(super) type Still = u32;

/// Lanes, or one number for all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Operand {
    /// One number a sample.
    Lane(Slot),
    /// One number for all.
    Still(Still),
}

/// What is read from the samples before a chunk is computed; it fills the first slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Column {
    /// A time of the sample.
    Clock(Clock),
    /// An input at the reference time, or its rate (1) or acceleration (2) there. For a logged
    /// stream nothing.
    Input(u32, u8),
    /// A component of a measurand's reading; 0 where it is missing.
    Reading(u32, u8),
    /// A value that the caller supplies.
    Given(u32),
    /// The time of the sample, where a logged stream needs it.
    SignalTime,
    /// 1.
    One,
}

/// A term of a sum: what its [`Kind`] says of `factor · a · b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Product {
    pub(super) factor: Still,
    pub(super) a: Slot,
    /// `a` again where the product has no second moving factor.
    pub(super) b: Slot,
}

/// What moves in a term, and whether its factor is one: nothing is multiplied that need not be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Kind {
    /// `factor · a`
    #[default]
    Single,
    /// `factor · a · b`
    Pair,
    /// `a · b`
    Unit,
    /// `-a · b`
    Minus,
    /// `factor`, as the first term alone
    Number,
}

/// A sum of one instruction has at most this many terms.
pub(super) const MOST_TERMS: usize = 4;

impl Kind {
    /// Whether the factor is 1 or -1 and not multiplied with.
    pub(super) fn has_unit_factor(self) -> bool {
        matches!(self, Self::Unit | Self::Minus)
    }
}

/// Terms up to which a sum may begin with a [`Kind::Number`].
pub(super) const MOST_WITH_NUMBER: usize = 3;

/// Sums of the same numbers that are computed together, at most: as many as registers hold.
pub(super) const MOST_TOGETHER: usize = 3;

/// One step over all samples of the chunk; `out` differs from all operands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Instruction {
    /// One number in all lanes.
    Fill { value: Still, out: Slot },
    /// A moving input's derivative of an order at an offset from the reference time. `columns` are
    /// the slots of its value, rate and acceleration at that time, `time` that of the time.
    Signal { input: u32, order: u8, offset: Operand, columns: [Slot; 3], time: Slot, out: Slot },
    /// A function of one number.
    Unary { function: Unary, a: Slot, out: Slot },
    /// Sine and cosine of one angle.
    SinCos { a: Slot, sin: Slot, cos: Slot },
    /// A function of two numbers that is no sum, difference, product or quotient.
    Binary { function: Binary, a: Slot, b: Slot, out: Slot },
    /// `a / b`
    Divide { a: Slot, b: Slot, out: Slot },
    /// `b / a`
    DivideInto { a: Slot, b: Still, out: Slot },
    /// The sum of `count` products from number `first` on, of these kinds. Times `scale`, if there
    /// is one.
    Sum { first: u32, count: u8, kinds: [Kind; MOST_TERMS], scale: Option<Slot>, out: Slot },
    /// Two or three sums `Σ factor · a` of the same two or three numbers `a`, with a number that
    /// stands still added to each where `has_number`: products from number `first` on, sum after
    /// sum.
    Map { first: u32, inputs: u8, has_number: bool, outs: [Slot; MOST_TOGETHER], outputs: u8 },
}
