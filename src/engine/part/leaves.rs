//! A sample, or what stands still in a run, as the leaves of a graph.

use crate::campaign::Sample;
use crate::engine::pointwise::Leaves;
use crate::graph::{Clock, Leaf};
use crate::number::Number;

/// One sample as the graph's leaves.
#[derive(Clone, Copy, Debug)]
pub struct SampleLeaves<'a, N> {
    /// Four numbers a parameter, in the order of the model's parameters.
    pub parameters: &'a [[N; 4]],
    /// One a random quantity.
    pub randoms: &'a [N],
    /// First reading column of each measurand.
    pub columns: &'a [usize],
    /// The sample.
    pub sample: Sample<'a>,
}

impl<N: Number> Leaves<N> for SampleLeaves<'_, N> {
    fn leaf(&self, leaf: Leaf) -> N {
        let Sample { samples, at: i, number } = self.sample;
        match leaf {
            Leaf::Parameter { parameter, component } => {
                self.parameters[parameter as usize][component as usize]
            }
            Leaf::Random(random) => self.randoms[random as usize],
            // Only the lanes supply such values.
            Leaf::Given(_) => N::constant(f64::NAN),
            Leaf::Input(input) => {
                samples.inputs[input as usize].at(i, samples.time[i], N::constant(0.0), 0)
            }
            Leaf::Clock(clock) => N::constant(match clock {
                Clock::Time => samples.elapsed_time[i],
                Clock::RunTime => samples.run_time[i],
                Clock::SetupTime => samples.setup_time[i],
                Clock::Index => number as f64,
                Clock::UniformTime => samples.uniform_time[i],
                Clock::JumpTime => samples.jump_time.get(i).copied().unwrap_or(0.0),
                Clock::FirstJumpTime => samples.jump_ends[0],
                Clock::LastJumpTime => samples.jump_ends[1],
            }),
            Leaf::Reading { measurand, component } => {
                let column = self.columns[measurand as usize] + component as usize;
                N::constant(samples.readings[column][i])
            }
        }
    }

    fn signal(&self, input: u32, order: u8, offset: N) -> N {
        let Sample { samples, at, .. } = self.sample;
        samples.inputs[input as usize].at(at, samples.time[at], offset, order)
    }
}

/// The parameters of a run, where nothing else is asked for: what stands still.
#[derive(Clone, Copy, Debug)]
pub struct ParameterLeaves<'a>(
    /// Four numbers a parameter.
    pub &'a [[f64; 4]],
);

impl Leaves<f64> for ParameterLeaves<'_> {
    fn leaf(&self, leaf: Leaf) -> f64 {
        match leaf {
            Leaf::Parameter { parameter, component } => {
                self.0[parameter as usize][component as usize]
            }
            _ => f64::NAN,
        }
    }

    fn signal(&self, _: u32, _: u8, _: f64) -> f64 {
        f64::NAN
    }
}
