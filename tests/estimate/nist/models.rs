//! The model functions of the 27 data sets, over any number.

use homepoint::number::Number;

/// A model with `N` parameters; `x` holds the predictors.
pub(crate) trait Model<const N: usize> {
    fn predict<T: Number>(b: [T; N], x: [f64; 2]) -> T;
    /// What the model predicts: the response, or a function of it.
    fn response(y: f64) -> f64 {
        y
    }
}

macro_rules! model {
    ($name:ident, $n:literal, |$b:ident, $x:ident| $body:expr) => {
        pub(crate) struct $name;
        impl Model<$n> for $name {
            fn predict<T: Number>($b: [T; $n], x: [f64; 2]) -> T {
                let $x = T::constant(x[0]);
                $body
            }
        }
    };
}

fn c<T: Number>(value: f64) -> T {
    T::constant(value)
}

model!(Saturation, 2, |b, x| b[0] * (c::<T>(1.0) - (-b[1] * x).exp()));
model!(Misra1b, 2, |b, x| b[0] * (c::<T>(1.0) - (b[1] * x * 0.5 + 1.0).powi(-2)));
model!(Misra1c, 2, |b, x| b[0] * (c::<T>(1.0) - c::<T>(1.0) / (b[1] * x * 2.0 + 1.0).sqrt()));
model!(Misra1d, 2, |b, x| b[0] * b[1] * x / (b[1] * x + 1.0));
model!(Chwirut, 3, |b, x| (-b[0] * x).exp() / (b[1] + b[2] * x));
model!(Lanczos, 6, |b, x| b[0] * (-b[1] * x).exp()
    + b[2] * (-b[3] * x).exp()
    + b[4] * (-b[5] * x).exp());
model!(Gauss, 8, |b, x| b[0] * (-b[1] * x).exp()
    + b[2] * (-((x - b[3]) / b[4]).powi(2)).exp()
    + b[5] * (-((x - b[6]) / b[7]).powi(2)).exp());
model!(DanWood, 2, |b, x| b[0] * (x.ln() * b[1]).exp());
model!(Kirby2, 5, |b, x| (b[0] + x * (b[1] + x * b[2])) / (x * (b[3] + x * b[4]) + 1.0));
model!(Cubic, 7, |b, x| (b[0] + x * (b[1] + x * (b[2] + x * b[3])))
    / (x * (b[4] + x * (b[5] + x * b[6])) + 1.0));
model!(Mgh17, 5, |b, x| b[0] + b[1] * (-x * b[3]).exp() + b[2] * (-x * b[4]).exp());
model!(Roszman1, 4, |b, x| b[0] - b[1] * x - (b[2] / (x - b[3])).atan() / std::f64::consts::PI);
model!(Enso, 9, |b, x| {
    let turn = x * std::f64::consts::TAU;
    let year = turn / 12.0;
    let (p, q) = (turn / b[3], turn / b[6]);
    b[0] + b[1] * year.cos()
        + b[2] * year.sin()
        + b[4] * p.cos()
        + b[5] * p.sin()
        + b[7] * q.cos()
        + b[8] * q.sin()
});
model!(Mgh09, 4, |b, x| b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]));
model!(Rat42, 3, |b, x| b[0] / ((b[1] - b[2] * x).exp() + 1.0));
model!(Rat43, 4, |b, x| b[0] / (((b[1] - b[2] * x).exp() + 1.0).ln() / b[3]).exp());
model!(Mgh10, 3, |b, x| b[0] * (b[1] / (x + b[2])).exp());
model!(Eckerle4, 3, |b, x| b[0] / b[1] * (((x - b[2]) / b[1]).powi(2) * -0.5).exp());
model!(Bennett5, 3, |b, x| b[0] * ((b[1] + x).ln() * -1.0 / b[2]).exp());

pub(crate) struct Nelson;
impl Model<3> for Nelson {
    fn predict<T: Number>(b: [T; 3], x: [f64; 2]) -> T {
        b[0] - b[1] * x[0] * (-b[2] * x[1]).exp()
    }
    fn response(y: f64) -> f64 {
        y.ln()
    }
}
