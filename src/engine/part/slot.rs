//! Where a measurand stands among predictions, reading columns and residuals, and its residual.

use std::ops::Range;

use crate::campaign::Sample;
use crate::graph::MeasurandKind;
use crate::number::Number;
use crate::quaternion::Quaternion;

/// Where a measurand stands among the program's outputs, the reading columns and the residuals.
#[derive(Clone, Debug)]
pub struct Slot {
    /// Plain, angle or rotation.
    pub kind: MeasurandKind,
    /// First output of its value.
    pub output: usize,
    /// Output of the factor on its standard uncertainty, if an effect patches it.
    pub sigma_factor: Option<usize>,
    /// First of its columns in [`crate::campaign::Samples::readings`].
    pub column: usize,
    /// Number of its columns: 4 for a rotation, else 1.
    pub width: usize,
    /// First of its residual components.
    pub residual: usize,
    /// Number of residual components: 3 for a rotation, else 1.
    pub components: usize,
}

impl Slot {
    /// Its reading columns.
    pub fn columns(&self) -> Range<usize> {
        self.column..self.column + self.width
    }

    /// The residual of its reading: see [`super::Part::residual`].
    pub(super) fn residual<N: Number>(&self, sample: Sample<'_>, outputs: &[N]) -> [N; 3] {
        let reading = |k: usize| sample.reading(self.column + k);
        let zero = N::constant(0.0);
        match self.kind {
            MeasurandKind::Plain => [-outputs[self.output] + reading(0), zero, zero],
            MeasurandKind::Angle { period } => {
                let difference = -outputs[self.output] + reading(0);
                [wrapped(difference, period), zero, zero]
            }
            MeasurandKind::Rotation => {
                let o = &outputs[self.output..self.output + 4];
                let predicted = Quaternion { w: o[0], v: [o[1], o[2], o[3]] };
                let read = Quaternion { w: reading(0), v: [reading(1), reading(2), reading(3)] };
                let read = Quaternion { w: N::constant(read.w), v: read.v.map(N::constant) };
                (predicted.conjugate() * read).to_rotation_vector()
            }
        }
    }
}

/// The number brought into (-period/2, period/2] by whole periods; unchanged for period 0.
pub fn wrapped<N: Number>(difference: N, period: f64) -> N {
    if period > 0.0 {
        difference - period * (difference.value() / period).round()
    } else {
        difference
    }
}
