//! A sample while time runs on from its reference time: rates of whatever the graph holds.
//!
//! Every moving input and every clock takes the offset on top of its own, so the derivative with
//! respect to the offset is the total rate of a node: a measurand's (what the instrument's head
//! must follow) or the target's velocity. Parameters, readings and random quantities stand still.

use crate::engine::part::SampleLeaves;
use crate::engine::pointwise::Leaves;
use crate::graph::{Clock, Leaf};
use crate::number::{Dual, Number, variable};

/// The leaves of a sample, some time after its reference time.
#[derive(Clone, Copy, Debug)]
pub struct MovingLeaves<'a> {
    /// The sample.
    pub sample: SampleLeaves<'a, Dual>,
    /// How long after (s), with derivative 1.
    pub offset: Dual,
}

impl<'a> MovingLeaves<'a> {
    /// The sample `offset` seconds after its reference time.
    pub fn after(sample: SampleLeaves<'a, Dual>, offset: f64) -> Self {
        Self { sample, offset: variable(offset) }
    }
}

impl Leaves<Dual> for MovingLeaves<'_> {
    fn leaf(&self, leaf: Leaf) -> Dual {
        match leaf {
            Leaf::Input(input) => self.signal(input, 0, Dual::constant(0.0)),
            Leaf::Clock(Clock::Time | Clock::RunTime | Clock::SetupTime) => {
                self.sample.leaf(leaf) + self.offset
            }
            other => self.sample.leaf(other),
        }
    }

    fn signal(&self, input: u32, order: u8, offset: Dual) -> Dual {
        self.sample.signal(input, order, offset + self.offset)
    }
}
