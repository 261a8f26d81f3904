//! Residual and non-zero derivatives of the three readings of one sample, analytically.

use std::f64::consts::{PI, TAU};

use super::{Columns, Parameters, column};

/// Columns that all three readings have: radius, orientation, position.
pub(crate) const COMMON: usize = 7;

/// Derivatives of one reading: by the common columns, then the residual `reading - prediction`; by
/// `N` columns of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<const N: usize> {
    pub(crate) common: [f64; COMMON + 1],
    pub(crate) own: [f64; N],
}

/// The three readings of a sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows {
    /// Own columns: delay, collimation, index error.
    pub(crate) horizontal: Row<3>,
    /// Own columns: delay, index error.
    pub(crate) vertical: Row<2>,
    /// Own columns: delay, distance offset.
    pub(crate) distance: Row<2>,
}

/// Where `Row::common` stands among all columns.
pub(crate) const COMMON_COLUMNS: [usize; COMMON + 1] = [
    column::RADIUS,
    column::ORIENTATION[0],
    column::ORIENTATION[1],
    column::ORIENTATION[2],
    column::POSITION[0],
    column::POSITION[1],
    column::POSITION[2],
    column::RESIDUAL,
];
/// Where the own columns of each measurand stand.
pub(crate) const HORIZONTAL_COLUMNS: [usize; 3] =
    [column::DELAY[0], column::COLLIMATION, column::INDEX_ERROR];
pub(crate) const VERTICAL_COLUMNS: [usize; 2] = [column::DELAY[1], column::INDEX_ERROR];
pub(crate) const DISTANCE_COLUMNS: [usize; 2] = [column::DELAY[2], column::DISTANCE_OFFSET];

/// What is the same for all samples of a run at one point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Model {
    pub(crate) parameters: Parameters,
    /// Columns of the rotation matrix.
    turn: [[f64; 3]; 3],
    /// Sine and cosine of the index error.
    index: (f64, f64),
}

/// The target as one measurand sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    sine: f64,
    cosine: f64,
    rate: f64,
    pub(crate) point: [f64; 3],
}

/// A predicted reading with its derivatives by the point and, where there are some, by effects.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Predicted {
    pub(crate) value: f64,
    pub(crate) gradient: [f64; 3],
    pub(crate) by_collimation: f64,
    pub(crate) by_index: f64,
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The horizontal residual without whole turns.
pub(crate) fn wrapped(mut difference: f64) -> f64 {
    while difference > PI {
        difference -= TAU;
    }
    while difference < -PI {
        difference += TAU;
    }
    difference
}

impl Model {
    pub(crate) fn new(parameters: Parameters) -> Self {
        let rows = parameters.orientation.matrix();
        let turn = [0, 1, 2].map(|column| [0, 1, 2].map(|row: usize| rows[row][column]));
        Self { parameters, turn, index: parameters.index_error.sin_cos() }
    }

    /// The target at arm angle `angle + rate · delay`.
    #[inline(always)]
    pub(crate) fn at(&self, angle: f64, rate: f64, delay: f64) -> Moment {
        let (sine, cosine) = (angle + rate * delay).sin_cos();
        let [a, b, _] = &self.turn;
        let Parameters { radius, position, .. } = &self.parameters;
        let point = [0, 1, 2].map(|k| radius * (cosine * a[k] + sine * b[k]) + position[k]);
        Moment { sine, cosine, rate, point }
    }

    /// Slope with time of a quantity whose gradient by the point is given.
    #[inline(always)]
    pub(crate) fn slope(&self, moment: &Moment, gradient: [f64; 3]) -> f64 {
        let [a, b, _] = self.turn.map(|column| dot(gradient, column));
        self.parameters.radius * moment.rate * (moment.cosine * b - moment.sine * a)
    }

    /// Derivatives by the common columns (the residual's place is left 0) and by the delay.
    #[inline(always)]
    pub(crate) fn chain(&self, moment: &Moment, gradient: [f64; 3]) -> ([f64; COMMON + 1], f64) {
        let Moment { sine, cosine, rate, .. } = *moment;
        let radius = self.parameters.radius;
        let [a, b, c] = self.turn.map(|column| dot(gradient, column));
        let third = radius * (cosine * b - sine * a);
        let tilt = radius * c;
        let [x, y, z] = gradient;
        let radial = cosine * a + sine * b;
        ([radial, sine * tilt, -cosine * tilt, third, x, y, z, 0.0], rate * third)
    }

    #[inline(always)]
    pub(crate) fn horizontal(&self, [x, y, z]: [f64; 3]) -> Predicted {
        let square = x * x + y * y;
        let (leg, length) = (square.sqrt(), (square + z * z).sqrt());
        let inverse = 1.0 / (leg * length);
        let (by_leg, by_length) = (inverse * length, inverse * leg);
        // Sine and cosine of W = vertical + index error.
        let (sin_v, cos_v) = (leg * by_length, z * by_length);
        let (sin_i, cos_i) = self.index;
        let sine = sin_v * cos_i + cos_v * sin_i;
        let cosine = cos_v * cos_i - sin_v * sin_i;
        let cosecant = 1.0 / sine;
        let by_index = -self.parameters.collimation * cosine * cosecant * cosecant;
        let value = y.atan2(x) + self.parameters.collimation * cosecant;
        // By the point: that of atan2, and that of the vertical angle times `by_index`.
        let (ux, uy) = (x * by_leg, y * by_leg);
        let along = by_index * by_length;
        let gradient =
            [along * cos_v * ux - uy * by_leg, along * cos_v * uy + ux * by_leg, -along * sin_v];
        Predicted { value, gradient, by_collimation: cosecant, by_index }
    }

    #[inline(always)]
    pub(crate) fn vertical(&self, [x, y, z]: [f64; 3]) -> Predicted {
        let square = x * x + y * y;
        let leg = square.sqrt();
        let inverse = 1.0 / ((square + z * z) * leg);
        let by_square = inverse * leg;
        let along = z * inverse;
        Predicted {
            value: leg.atan2(z) + self.parameters.index_error,
            gradient: [along * x, along * y, -leg * by_square],
            by_collimation: 0.0,
            by_index: 1.0,
        }
    }

    #[inline(always)]
    pub(crate) fn distance(&self, [x, y, z]: [f64; 3]) -> Predicted {
        let length = (x * x + y * y + z * z).sqrt();
        let inverse = 1.0 / length;
        Predicted {
            value: length + self.parameters.distance_offset,
            gradient: [x * inverse, y * inverse, z * inverse],
            by_collimation: 0.0,
            by_index: 0.0,
        }
    }

    /// The rows of one sample, each times its `weight` (1 / standard uncertainty; 1 for the plain
    /// Jacobian).
    #[inline(always)]
    pub(crate) fn rows(&self, data: &Columns<'_>, sample: usize, weights: [f64; 3]) -> Rows {
        let (angle, rate) = (data.angle[sample], data.rate[sample]);
        let [w_h, w_v, w_d] = weights;
        let read = data.readings.map(|column| column[sample]);
        let delays = self.parameters.delays;

        let moment = self.at(angle, rate, delays[0]);
        let h = self.horizontal(moment.point);
        let (mut common, delay) = self.chain(&moment, h.gradient.map(|g| g * w_h));
        common[COMMON] = w_h * wrapped(read[0] - h.value);
        let horizontal = Row { common, own: [delay, w_h * h.by_collimation, w_h * h.by_index] };

        let moment = self.at(angle, rate, delays[1]);
        let v = self.vertical(moment.point);
        let (mut common, delay) = self.chain(&moment, v.gradient.map(|g| g * w_v));
        common[COMMON] = w_v * (read[1] - v.value);
        let vertical = Row { common, own: [delay, w_v] };

        let moment = self.at(angle, rate, delays[2]);
        let d = self.distance(moment.point);
        let (mut common, delay) = self.chain(&moment, d.gradient.map(|g| g * w_d));
        common[COMMON] = w_d * (read[2] - d.value);
        let distance = Row { common, own: [delay, w_d] };
        Rows { horizontal, vertical, distance }
    }
}
