//! Values and derivatives of every elementary function, at regular and singular points.

use homepoint::number::{
    Dual, Gradient, NestedDual, Number, derivative, derivatives2, nested, nested_derivatives,
    partial, partials, variable, variable2, with_partials,
};

#[track_caller]
fn close(found: f64, expected: f64, tolerance: f64) {
    let scale = 1.0_f64.max(expected.abs());
    assert!(
        (found - expected).abs() <= tolerance * scale,
        "found {found:e}, expected {expected:e}"
    );
}

/// A function of one number, over every number type.
trait Function {
    fn at<N: Number>(&self, x: N) -> N;
}

/// Checks value, first and second derivative over five number types against closed forms.
#[track_caller]
fn check<F: Function>(function: &F, x: f64, expected: [f64; 3]) {
    let tolerance = 1e-14;
    close(function.at(x), expected[0], tolerance);
    let first = function.at(variable(x));
    assert_eq!(first.value(), function.at(x).value(), "values agree over number types at {x}");
    close(derivative(first), expected[1], tolerance);
    let second = function.at(variable2(x));
    let [d1, d2] = derivatives2(second);
    close(second.value(), expected[0], tolerance);
    close(d1, expected[1], tolerance);
    close(d2, expected[2], 10.0 * tolerance);
    let mixed = function.at(nested(x, [2.0, -3.0]));
    let [a, b, ab] = nested_derivatives(mixed);
    close(mixed.value(), expected[0], tolerance);
    close(a, 2.0 * expected[1], tolerance);
    close(b, -3.0 * expected[1], tolerance);
    close(ab, -6.0 * expected[2], 10.0 * tolerance);
    let vector = function.at(with_partials(x, [1.0, 0.0, -4.0]));
    close(vector.value(), expected[0], tolerance);
    let [p, q, r] = partials(&vector);
    close(p, expected[1], tolerance);
    close(q, 0.0, tolerance);
    close(r, -4.0 * expected[1], tolerance);
}

macro_rules! function {
    ($name:ident, $x:ident => $body:expr) => {
        struct $name;
        impl Function for $name {
            fn at<N: Number>(&self, $x: N) -> N {
                $body
            }
        }
    };
}

function!(Sin, x => x.sin());
function!(Cos, x => x.cos());
function!(Tan, x => x.tan());
function!(Asin, x => x.asin());
function!(Acos, x => x.acos());
function!(Atan, x => x.atan());
function!(Sqrt, x => x.sqrt());
function!(Exp, x => x.exp());
function!(Ln, x => x.ln());
function!(Tanh, x => x.tanh());
function!(Abs, x => x.abs());
function!(Signum, x => x.signum());
function!(Floor, x => x.floor());
function!(Fract, x => x.fract());
function!(Constant, x => N::constant(x.value()));

struct PowerInteger(i32);
impl Function for PowerInteger {
    fn at<N: Number>(&self, x: N) -> N {
        x.powi(self.0)
    }
}

struct Power(f64);
impl Function for Power {
    fn at<N: Number>(&self, x: N) -> N {
        x.pow(N::constant(self.0))
    }
}

#[test]
fn smooth_functions_have_their_closed_form_derivatives() {
    for x in [-2.5, -0.7, -1e-9, 0.0, 1e-9, 0.4, 1.3, 3.0] {
        let (s, c) = f64::sin_cos(x);
        check(&Sin, x, [s, c, -s]);
        check(&Cos, x, [c, -s, -c]);
        check(&Tan, x, [s / c, 1.0 / (c * c), 2.0 * s / (c * c * c)]);
        let q = 1.0 + x * x;
        check(&Atan, x, [x.atan(), 1.0 / q, -2.0 * x / (q * q)]);
        check(&Exp, x, [x.exp(); 3]);
        let t = x.tanh();
        check(&Tanh, x, [t, 1.0 - t * t, -2.0 * t * (1.0 - t * t)]);
        check(&Constant, x, [x, 0.0, 0.0]);
        check(&Fract, x, [x - x.floor(), 1.0, 0.0]);
        check(&Floor, x, [x.floor(), 0.0, 0.0]);
    }
    for x in [1e-3, 0.5, 1.0, 7.0] {
        check(&Ln, x, [x.ln(), 1.0 / x, -1.0 / (x * x)]);
        check(&Sqrt, x, [x.sqrt(), 0.5 / x.sqrt(), -0.25 / (x * x.sqrt())]);
        check(&Power(2.5), x, [x.powf(2.5), 2.5 * x.powf(1.5), 3.75 * x.sqrt()]);
        check(&Power(-1.5), x, [x.powf(-1.5), -1.5 * x.powf(-2.5), 3.75 * x.powf(-3.5)]);
    }
    for x in [-0.99, -0.3, 0.0, 0.8] {
        let root = f64::sqrt((1.0 - x) * (1.0 + x));
        let second = x / (root * root * root);
        check(&Asin, x, [x.asin(), 1.0 / root, second]);
        check(&Acos, x, [x.acos(), -1.0 / root, -second]);
    }
}

#[test]
fn tanh_stays_finite_far_out() {
    for x in [-1e6, -800.0, 800.0, 1e300] {
        check(&Tanh, x, [x.signum(), 0.0, 0.0]);
    }
    assert_eq!(variable(f64::INFINITY).tanh().value(), 1.0);
}

#[test]
fn singular_points_follow_the_conventions() {
    for zero in [0.0, -0.0] {
        check(&Sqrt, zero, [0.0; 3]);
        check(&Abs, zero, [0.0; 3]);
        check(&Signum, zero, [0.0; 3]);
    }
    check(&Abs, -2.0, [2.0, -1.0, 0.0]);
    check(&Signum, -2.0, [-1.0, 0.0, 0.0]);
    for end in [-1.0_f64, 1.0] {
        check(&Asin, end, [end.asin(), 0.0, 0.0]);
        check(&Acos, end, [end.acos(), 0.0, 0.0]);
    }
}

#[test]
fn outside_the_domain_is_nan() {
    for x in [-1.0 - 1e-15, 1.0 + 1e-15, 2.0] {
        assert!(variable(x).asin().value().is_nan());
        assert!(variable(x).acos().value().is_nan());
    }
    assert!(variable(-1.0).sqrt().value().is_nan());
    assert!(variable(-1.0).ln().value().is_nan());
    assert!(variable(-8.0).pow(Dual::constant(1.5)).value().is_nan());
    let nan = f64::NAN;
    for (a, b) in [(nan, 1.0), (1.0, nan)] {
        assert!(Number::min(a, b).is_nan() && Number::max(a, b).is_nan());
        assert!(Number::atan2(a, b).is_nan() && Number::pow(a, b).is_nan());
        assert!(Number::hypot(a, b).is_nan());
    }
    assert!(Number::signum(nan).is_nan());
    assert!(Number::stumpff(nan, 3).is_nan());
}

#[test]
fn inverse_sine_keeps_its_digits_next_to_one() {
    // asin'(1 - d) = 1/√(2 d - d²): 1 - x² computed as such would be wrong in the sixth digit.
    let d = 2.0_f64.powi(-34);
    let expected = 1.0 / (2.0 * d - d * d).sqrt();
    close(derivative(variable(1.0 - d).asin()) / expected, 1.0, 1e-15);
    close(derivative(variable(1.0 - d).acos()) / expected, -1.0, 1e-15);
    close(derivative(variable(d - 1.0).acos()) / expected, -1.0, 1e-15);
}

#[test]
fn integer_powers_are_right_at_zero_and_far_out() {
    check(&PowerInteger(0), 0.0, [1.0, 0.0, 0.0]);
    check(&PowerInteger(1), 0.0, [0.0, 1.0, 0.0]);
    check(&PowerInteger(2), 0.0, [0.0, 0.0, 2.0]);
    check(&PowerInteger(3), 0.0, [0.0; 3]);
    check(&PowerInteger(5), -1.5, [-7.59375, 25.3125, -67.5]);
    check(&PowerInteger(-2), -2.0, [0.25, 0.25, 0.375]);
    check(
        &PowerInteger(i32::MAX),
        1.0,
        [1.0, f64::from(i32::MAX), f64::from(i32::MAX) * (f64::from(i32::MAX) - 1.0)],
    );
    check(
        &PowerInteger(i32::MIN),
        0.0_f64.cos(),
        [1.0, f64::from(i32::MIN), f64::from(i32::MIN) * (f64::from(i32::MIN) - 1.0)],
    );
    assert_eq!(variable(0.0).powi(-1).value(), f64::INFINITY);
    close(variable(1e-100).powi(-1).value() / 1e100, 1.0, 1e-15);
    close(derivative(variable(1e-100).powi(-1)) / -1e200, 1.0, 1e-14);
}

#[test]
fn powers_at_base_zero() {
    check(&Power(0.0), 0.0, [1.0, 0.0, 0.0]);
    check(&Power(1.0), 0.0, [0.0, 1.0, 0.0]);
    check(&Power(2.0), 0.0, [0.0, 0.0, 2.0]);
    check(&Power(3.0), 0.0, [0.0; 3]);
    check(&Power(2.5), 0.0, [0.0; 3]);
    check(&Power(0.5), 0.0, [0.0; 3]);
    assert_eq!(variable(0.0).pow(Dual::constant(-1.5)).value(), f64::INFINITY);
    // Both arguments vary: d(x^y) = y x^(y-1) dx + x^y ln x dy.
    let (x, y) = (1.7_f64, 2.3_f64);
    let found = partial::<2>(x, 0).pow(partial(y, 1));
    let [dx, dy] = partials(&found);
    assert_eq!(found.value(), x.powf(y));
    close(dx, y * x.powf(y - 1.0), 1e-15);
    close(dy, x.powf(y) * x.ln(), 1e-15);
}

#[test]
fn smaller_and_larger_carry_the_derivative_of_the_one_taken() {
    let (a, b) = (with_partials(1.0, [1.0, 0.0]), with_partials(2.0, [0.0, 1.0]));
    assert_eq!(partials(&a.min(b)), [1.0, 0.0]);
    assert_eq!(partials(&b.min(a)), [1.0, 0.0]);
    assert_eq!(partials(&a.max(b)), [0.0, 1.0]);
    assert_eq!(partials(&b.max(a)), [0.0, 1.0]);
    let tie = with_partials(1.0, [5.0, 0.0]);
    assert_eq!(partials(&tie.min(a)), [5.0, 0.0]);
    assert_eq!(partials(&tie.max(a)), [5.0, 0.0]);
}

#[test]
fn atan2_on_every_axis_and_across_the_cut() {
    let r = 2.5;
    for eighth in -8..=8 {
        for offset in [-1e-13, 0.0, 1e-13] {
            let angle = f64::from(eighth) * std::f64::consts::FRAC_PI_4 + offset;
            check_atan2(r * angle.sin(), r * angle.cos());
        }
    }
    for zero in [0.0, -0.0] {
        for leg in [-3.0, 3.0, 1e-200, -1e-200, 1e200] {
            check_atan2(zero, leg);
            check_atan2(leg, zero);
        }
    }
}

fn check_atan2(y: f64, x: f64) {
    let found: Gradient<2> = partial::<2>(y, 0).atan2(partial(x, 1));
    assert_eq!(found.value(), y.atan2(x), "at ({x}, {y})");
    assert_eq!(Number::atan2(y, x), y.atan2(x), "at ({x}, {y})");
    let r = y.hypot(x);
    let [dy, dx] = partials(&found);
    close(dy * r, x / r, 1e-15);
    close(dx * r, -y / r, 1e-15);
    if (1e-100..1e100).contains(&r) {
        // Mixed derivative (y² - x²) / r⁴ and the one across y, -2 x y / r⁴.
        let [_, _, yx] = nested_derivatives(nested(y, [1.0, 0.0]).atan2(nested(x, [0.0, 1.0])));
        close(yx, (y - x) * (y + x) / r.powi(4), 1e-14);
        let [_, yy] = derivatives2(variable2(y).atan2(Number::constant(x)));
        close(yy, -2.0 * x * y / r.powi(4), 1e-14);
    }
}

#[test]
fn atan2_at_the_origin_and_at_infinity() {
    for y in [0.0, -0.0] {
        for x in [0.0, -0.0] {
            let found: Gradient<2> = partial::<2>(y, 0).atan2(partial(x, 1));
            assert_eq!(found.value(), 0.0);
            assert_eq!(partials(&found), [0.0, 0.0]);
        }
    }
    let infinite = variable(f64::INFINITY).atan2(Dual::constant(1.0));
    assert_eq!((infinite.value(), derivative(infinite)), (std::f64::consts::FRAC_PI_2, 0.0));
}

#[test]
fn hypot_at_the_origin_on_the_axes_and_at_extreme_sizes() {
    let origin: Gradient<2> = partial::<2>(0.0, 0).hypot(partial(-0.0, 1));
    assert_eq!((origin.value(), partials(&origin)), (0.0, [0.0, 0.0]));
    for (a, b) in [(3.0, 4.0), (-3.0, 0.0), (0.0, -2.0), (1e-200, 2e-200), (-1e200, 3e200)] {
        let found: Gradient<2> = partial::<2>(a, 0).hypot(partial(b, 1));
        let r = f64::hypot(a, b);
        assert_eq!(found.value(), r);
        assert_eq!(Number::hypot(a, b), r);
        let [da, db] = partials(&found);
        close(da, a / r, 1e-15);
        close(db, b / r, 1e-15);
    }
    // Second derivatives b²/r³, -a b/r³.
    let [_, second] = derivatives2(variable2(3.0).hypot(Number::constant(4.0)));
    close(second, 16.0 / 125.0, 1e-15);
    let mixed: NestedDual = nested(3.0, [1.0, 0.0]).hypot(nested(4.0, [0.0, 1.0]));
    close(nested_derivatives(mixed)[2], -12.0 / 125.0, 1e-15);
}

#[test]
fn a_gradient_beyond_its_width_is_constant() {
    assert_eq!(partials(&partial::<2>(1.0, 2)), [0.0, 0.0]);
    assert_eq!(partials(&partial::<2>(1.0, 1)), [0.0, 1.0]);
}

/// A smooth number in (-1, 1) from a counter.
fn spread(i: u32) -> f64 {
    2.0 * (f64::from(i) * 0.618_033_988_749_894_9).fract() - 1.0
}

#[test]
fn tanh_has_its_digits_wherever_it_has_any() {
    for i in 0..=4000 {
        let x = 0.5 * f64::from(i) - 1000.0;
        let number = variable(x).tanh();
        assert_eq!(number.value(), x.tanh());
        // 1 - tanh² = 4 e^(-2|x|) / (1 + e^(-2|x|))², which does not cancel.
        let e = (-2.0 * x.abs()).exp();
        let expected = 4.0 * e / (1.0 + e).powi(2);
        assert!((derivative(number) - expected).abs() <= 4.0 * f64::EPSILON, "{x}");
        let [first, second] = derivatives2(variable2(x).tanh());
        assert!(first.is_finite() && second.is_finite(), "{x}");
        if x.abs() >= 20.0 {
            assert_eq!([first, second], [0.0, 0.0], "{x}");
        }
    }
}

/// Central differences know nothing of the rules of differentiation.
#[test]
fn derivatives_agree_with_central_differences() {
    fn agrees<F: Function>(name: &str, function: &F, x: f64) {
        let h = 1e-5;
        let slope = (function.at(x + h) - function.at(x - h)) / (2.0 * h);
        let exact = derivative(function.at(variable(x)));
        let scale = 1.0_f64.max(exact.abs());
        assert!((slope - exact).abs() < 1e-8 * scale, "{name} at {x}: {slope} {exact}");
        let rate = |x: f64| derivative(function.at(variable(x)));
        let slope = (rate(x + h) - rate(x - h)) / (2.0 * h);
        let [_, exact] = derivatives2(function.at(variable2(x)));
        let scale = 1.0_f64.max(exact.abs());
        assert!((slope - exact).abs() < 1e-7 * scale, "{name}'' at {x}: {slope} {exact}");
    }
    for i in 0..200 {
        let x = 0.9 * spread(i);
        agrees("sin", &Sin, 4.0 * x);
        agrees("cos", &Cos, 4.0 * x);
        agrees("tan", &Tan, 1.2 * x);
        agrees("asin", &Asin, x);
        agrees("acos", &Acos, x);
        agrees("atan", &Atan, 5.0 * x);
        agrees("exp", &Exp, 2.0 * x);
        agrees("tanh", &Tanh, 3.0 * x);
        let positive = 1.5 + x;
        agrees("sqrt", &Sqrt, positive);
        agrees("ln", &Ln, positive);
        agrees("power", &Power(1.7), positive);
        agrees("negative power", &Power(-0.3), positive);
        agrees("whole power", &PowerInteger(-3), positive);
        agrees("square", &PowerInteger(2), x);
        agrees("cube", &PowerInteger(3), x);
        agrees("fourth power", &PowerInteger(4), x);
    }
}

#[test]
fn mixed_derivatives_of_functions_of_two() {
    for i in 0..100 {
        let (x, y) = (1.3 + spread(i), 2.0 * spread(i + 1000));
        let both = |f: fn(NestedDual, NestedDual) -> NestedDual| {
            nested_derivatives(f(nested(x, [1.0, 0.0]), nested(y, [0.0, 1.0])))
        };
        let [dx, dy, xy] = both(Number::pow);
        let (power, ln) = (x.powf(y), x.ln());
        close(dx, y * power / x, 1e-13);
        close(dy, power * ln, 1e-13);
        close(xy, power / x * (1.0 + y * ln), 1e-13);
        let [dx, dy, xy] = both(Number::hypot);
        let r = f64::hypot(x, y);
        close(dx, x / r, 1e-14);
        close(dy, y / r, 1e-14);
        close(xy, -x * y / r.powi(3), 1e-13);
        let [dx, dy, xy] = both(Number::atan2);
        close(dx, y / (r * r), 1e-13);
        close(dy, -x / (r * r), 1e-13);
        close(xy, (x - y) * (x + y) / r.powi(4), 1e-12);
    }
}

#[test]
fn a_path_across_the_cut_jumps_by_a_turn_and_keeps_its_rate() {
    // A point that passes (-2, 0) downwards at 3 m/s: the angle grows at 3 / 2 rad/s on both sides.
    for height in [1e-9, 1e-300, 0.0, -0.0, -1e-300, -1e-9] {
        let y = Dual::constant(height) - variable(0.0) * 3.0;
        let angle = y.atan2(Dual::constant(-2.0));
        assert!((angle.value().abs() - std::f64::consts::PI).abs() < 1e-9);
        close(derivative(angle), 1.5, 1e-15);
    }
    assert_eq!(Number::atan2(-0.0, -2.0), -std::f64::consts::PI);
    assert_eq!(Number::atan2(0.0, -2.0), std::f64::consts::PI);
}

#[test]
fn powers_at_infinity_are_those_of_plain_numbers() {
    let infinite = f64::INFINITY;
    for (base, power) in
        [(infinite, 2.0), (infinite, 0.0), (infinite, -1.5), (2.0, infinite), (0.5, infinite)]
    {
        let expected = base.powf(power);
        assert_eq!(Number::pow(base, power), expected, "{base} {power}");
        assert_eq!(variable(base).pow(Dual::constant(power)).value(), expected, "{base} {power}");
    }
    // A zero base of either sign; a negative power of it is infinite, never NaN.
    for zero in [0.0, -0.0] {
        let number = variable(zero).pow(Dual::constant(2.0));
        assert_eq!((number.value(), derivative(number)), (0.0, 0.0));
        assert!(variable(zero).pow(Dual::constant(-2.5)).value().is_infinite());
    }
}

#[test]
fn a_whole_power_that_vanishes_has_no_derivative_left() {
    // 1e200² overflows on the way to its inverse, which is 0.
    let number = variable(1e200).powi(-2);
    assert_eq!((number.value(), derivative(number)), (0.0, 0.0));
}
