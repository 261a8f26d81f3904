//! The delay of each reading by dual numbers: the model written once over any number type, Newton's
//! slope from one dual part, the sensitivities from a gradient of 13.

use homepoint::number::{Dual, Gradient, Number, derivative, partial, partials, variable};
use homepoint::quaternion::Quaternion;

use super::delay::{Delay, solve};
use super::jacobian::wrapped;
use super::{COLUMNS, Columns, Parameters, column};

/// The unknowns that a reading depends on, its delay not among them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unknowns<N> {
    radius: N,
    orientation: [[N; 3]; 3],
    position: [N; 3],
    collimation: N,
    index_error: N,
    distance_offset: N,
}

impl<N: Number> Unknowns<N> {
    /// `seed(value, column)` makes the unknown of a column; `turn` is the tangent at the
    /// orientation.
    fn new(parameters: &Parameters, seed: impl Fn(f64, usize) -> N) -> Self {
        let turn = Quaternion::turn(column::ORIENTATION.map(|column| seed(0.0, column)));
        let orientation = Quaternion::constant(parameters.orientation.components()) * turn;
        let [x, y, z] = parameters.position;
        let [px, py, pz] = column::POSITION;
        Self {
            radius: seed(parameters.radius, column::RADIUS),
            orientation: orientation.matrix(),
            position: [seed(x, px), seed(y, py), seed(z, pz)],
            collimation: seed(parameters.collimation, column::COLLIMATION),
            index_error: seed(parameters.index_error, column::INDEX_ERROR),
            distance_offset: seed(parameters.distance_offset, column::DISTANCE_OFFSET),
        }
    }

    /// The predicted reading of a measurand at an arm angle.
    #[inline(always)]
    pub(crate) fn predict(&self, measurand: usize, arm_angle: N) -> N {
        let (along, across) = (arm_angle.cos() * self.radius, arm_angle.sin() * self.radius);
        let [x, y, z] = [0, 1, 2].map(|k| {
            self.orientation[k][0] * along + self.orientation[k][1] * across + self.position[k]
        });
        match measurand {
            0 => {
                let vertical = x.hypot(y).atan2(z) + self.index_error;
                y.atan2(x) + self.collimation / vertical.sin()
            }
            1 => x.hypot(y).atan2(z) + self.index_error,
            _ => (x * x + y * y + z * z).sqrt() + self.distance_offset,
        }
    }
}

/// As [`super::delay::delays`].
pub(crate) fn delays(
    parameters: &Parameters,
    data: &Columns<'_>,
    covariance: &[[f64; COLUMNS]; COLUMNS],
    sigma: [f64; 3],
    range: f64,
) -> [Vec<Delay>; 3] {
    let plain = Unknowns::<Dual>::new(parameters, |value, _| Dual::constant(value));
    let seeded = Unknowns::<Gradient<COLUMNS>>::new(parameters, partial::<COLUMNS>);
    [0, 1, 2].map(|measurand: usize| {
        let samples = data.angle.iter().zip(data.rate).zip(data.readings[measurand]);
        samples
            .map(|((angle, rate), reading)| {
                let found = solve(range, |t| {
                    let predicted = plain.predict(measurand, variable(t) * *rate + *angle);
                    let difference = predicted.value() - reading;
                    let difference = if measurand == 0 { wrapped(difference) } else { difference };
                    (difference, derivative(predicted), ())
                });
                let Some((delay, slope, ())) = found else { return Delay::NONE };
                let moment = Gradient::constant(rate * delay + angle);
                let row = partials(&seeded.predict(measurand, moment));
                let variance: f64 = (0..COLUMNS)
                    .map(|i| row[i] * (0..COLUMNS).map(|j| covariance[i][j] * row[j]).sum::<f64>())
                    .sum();
                let seconds = 1.0 / slope.abs();
                Delay {
                    delay,
                    slope,
                    random: sigma[measurand] * seconds,
                    common: variance.max(0.0).sqrt() * seconds,
                }
            })
            .collect()
    })
}
