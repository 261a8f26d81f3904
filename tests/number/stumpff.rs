//! Stumpff functions against their power series in twice the digits, and against closed forms.

use homepoint::number::{Number, derivative, derivatives2, variable, variable2};

/// An unevaluated sum of two numbers: about 32 digits.
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn add(self, other: Self) -> Self {
        let s = self.0 + other.0;
        let b = s - self.0;
        let low = (self.0 - (s - b)) + (other.0 - b) + self.1 + other.1;
        Self(s + low, low - ((s + low) - s))
    }
    fn times(self, factor: f64) -> Self {
        let p = self.0 * factor;
        let low = self.0.mul_add(factor, -p) + self.1 * factor;
        Self(p + low, low - ((p + low) - p))
    }
    fn over(self, divisor: f64) -> Self {
        let q = self.0 / divisor;
        let rest = (-q).mul_add(divisor, self.0) + self.1;
        let low = rest / divisor;
        Self(q + low, low - ((q + low) - q))
    }
}

/// The `n`-th derivative of `c_k` at `x`: Σ (-1)^i i!/(i-n)! x^(i-n) / (k + 2 i)!.
fn reference(x: f64, k: u32, n: u32) -> f64 {
    let mut power = Double(1.0, 0.0); // (-x)^(i-n) / (k + 2 i)!
    for j in 2..=k + 2 * n {
        power = power.over(f64::from(j));
    }
    let mut sum = Double(0.0, 0.0);
    for i in n..n + 150 {
        let falling = (0..n).fold(1.0, |product, j| product * f64::from(i - j));
        sum = sum.add(power.times(falling));
        let next = f64::from(k + 2 * i);
        power = power.times(-x).over((next + 1.0) * (next + 2.0));
    }
    if n.is_multiple_of(2) { sum.0 } else { -sum.0 }
}

/// Size of the part of `c_k` and its derivatives that oscillates, `x^(-(k+n)/2) / 2^n`, for large
/// x.
fn oscillation(x: f64, k: u32, n: u32) -> f64 {
    let start = f64::from((k + 1) * (k + 2));
    x.abs().max(start).powf(-0.5 * f64::from(k + n)) / 2.0_f64.powi(n as i32)
}

/// Rounding errors allowed: a few units of the value or of its swing, and what half a unit of `√x`
/// does.
fn allowed(x: f64, k: u32, n: u32) -> f64 {
    let swing = oscillation(x, k, n);
    f64::EPSILON * (16.0 * reference(x, k, n).abs().max(swing) + x.abs().sqrt() * swing)
}

#[test]
fn value_and_two_derivatives_to_rounding_for_orders_0_to_8() {
    let mut points = vec![-20.0, -1.0, -1e-16, 0.0, 1e-300, 1e-16, 1e-8, 1e-3];
    points.extend((1..1200).map(|i| 0.173 * f64::from(i)));
    for k in 0..=8_u32 {
        let seam = f64::from((k + 1) * (k + 2));
        for x in points.iter().copied().chain([seam, seam.next_up(), seam - 1e-9, seam + 1e-9]) {
            let [d1, d2] = derivatives2(variable2(x).stumpff(k as u8));
            let value = x.stumpff(k as u8);
            let first = variable(x).stumpff(k as u8);
            assert_eq!(first.value(), value);
            let found = [value, d1, d2];
            for n in 0..3 {
                let error = (found[n as usize] - reference(x, k, n)).abs();
                let share = error / allowed(x, k, n);
                assert!(share <= 1.0, "c_{k}, derivative {n} at {x}: {share} of the error allowed");
            }
            assert!((derivative(first) - d1).abs() <= allowed(x, k, 1));
        }
    }
}

#[test]
fn closed_forms_far_out() {
    for x in [500.0, 1e4, 123_456.7, 1e6_f64] {
        let r = x.sqrt();
        let (s, c) = r.sin_cos();
        let tolerance = 2.0 * f64::EPSILON * r;
        let expected = [
            (0, c, -s / (2.0 * r), -c / (4.0 * x) + s / (4.0 * x * r)),
            (
                1,
                s / r,
                (c - s / r) / (2.0 * x),
                (-s * x + 3.0 * s - 3.0 * c * r) / (4.0 * x * x * r),
            ),
            (2, (1.0 - c) / x, s / (2.0 * x * r) - (1.0 - c) / (x * x), f64::NAN),
            (
                3,
                (r - s) / (x * r),
                (1.0 - c) / (2.0 * x * x) - 1.5 * (r - s) / (x * x * r),
                f64::NAN,
            ),
        ];
        for (k, value, first, second) in expected {
            let [d1, d2] = derivatives2(variable2(x).stumpff(k));
            assert!(
                (x.stumpff(k) - value).abs() <= tolerance / x.powf(0.5 * f64::from(k)),
                "c_{k}({x})"
            );
            assert!(
                (d1 - first).abs() <= tolerance / x.powf(0.5 + 0.5 * f64::from(k)),
                "c_{k}'({x})"
            );
            if second.is_finite() {
                let size = x.powf(1.0 + 0.5 * f64::from(k));
                assert!((d2 - second).abs() <= tolerance / size, "c_{k}''({x})");
            }
        }
    }
}

#[test]
fn derivative_is_the_recurrence_between_orders() {
    for k in 0..=6_u8 {
        for x in [0.0, 0.5, 3.0, 25.0, 70.0, 1000.0] {
            let expected = 0.5 * (f64::from(k) * x.stumpff(k + 2) - x.stumpff(k + 1));
            let found = derivative(variable(x).stumpff(k));
            assert!(
                (found - expected).abs() <= 1e-14 / (1.0 + x),
                "c_{k}'({x}): {found} {expected}"
            );
        }
    }
}

/// Far out only the recurrence `c_k + x c_{k+2} = 1/k!` and the derivative rule are left as
/// witnesses for all orders; both are taken relative to the size of the terms.
#[test]
fn orders_0_to_6_from_0_to_10_000() {
    let factorial = [1.0, 1.0, 2.0, 6.0, 24.0, 120.0, 720.0];
    for i in 0..=5000 {
        let x = 1e4 * (f64::from(i) / 5000.0).powi(3);
        for k in 0..=6_u8 {
            let [this, next, after] = [k, k + 1, k + 2].map(|k| x.stumpff(k));
            let inverse = 1.0 / factorial[usize::from(k)];
            let slack = 8.0 * f64::EPSILON * (1.0 + x.sqrt());
            assert!((this + x * after - inverse).abs() <= slack * inverse, "c_{k}({x})");
            assert!(this.abs() <= inverse * (1.0 + slack), "c_{k}({x}) = {this} is above 1/k!");
            let expected = 0.5 * (f64::from(k) * after - next);
            let number = variable(x).stumpff(k);
            assert_eq!(number.value(), this);
            let found = derivative(number);
            let size = f64::from(k) * after.abs() + next.abs() + oscillation(x, u32::from(k), 1);
            assert!((found - expected).abs() <= 4.0 * slack * size, "c_{k}'({x})");
        }
    }
}

#[test]
fn no_step_where_the_branches_meet() {
    for k in 0..=6_u8 {
        let seam = f64::from((k + 1) * (k + 2));
        let [here, beyond] = [seam, seam.next_up()].map(variable2).map(|x| x.stumpff(k));
        let units = 16.0 * f64::EPSILON;
        let size =
            |n| reference(seam, u32::from(k), n).abs().max(oscillation(seam, u32::from(k), n));
        assert!((here.value() - beyond.value()).abs() <= units * size(0), "c_{k}");
        let (a, b) = (derivatives2(here), derivatives2(beyond));
        assert!((a[0] - b[0]).abs() <= units * size(1), "c_{k}'");
        assert!((a[1] - b[1]).abs() <= 4.0 * units * size(2), "c_{k}''");
    }
}
