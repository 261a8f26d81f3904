//! The smoothing spline: its kernel, its derivatives, its searches, its ends.

use homepoint::campaign::signal::{Track, unwrap};
use homepoint::campaign::spline::{Smoothing, Spline, SplineError};
use homepoint::number::{Dual, derivative, variable};

use crate::stream::Stream;

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        count += 1.0;
    }
    f64::sqrt(sum / count)
}

#[test]
fn the_kernel_is_silvermans_with_the_stated_time_constant() {
    let (dt, s) = (0.01, 0.2);
    let times: Vec<f64> = (0..801).map(|i| f64::from(i) * dt).collect();
    let mut values = vec![0.0; times.len()];
    values[400] = 1.0;
    let spline = Spline::fit(&times, &values, Smoothing::TimeConstant(s)).unwrap();
    for x in [0.0_f64, 0.05, 0.1, 0.3, 0.5, 1.0] {
        let u = x / s / std::f64::consts::SQRT_2;
        let kernel = 0.5 * (-u).exp() * (u + std::f64::consts::FRAC_PI_4).sin() * dt / s;
        let found = spline.at(4.0 + x, 0.0, 0);
        assert!((found - kernel).abs() < 2e-4 * dt / s, "at {x}: {found} for {kernel}");
    }
    // Root of the mean leverage: the kernel's peak, but for the ends of the stream.
    let peak = 0.5 * std::f64::consts::FRAC_PI_4.sin() * dt / s;
    assert!((spline.noise_gain() / peak.sqrt() - 1.0).abs() < 0.05);
}

#[test]
fn the_time_constant_does_not_depend_on_the_density() {
    let s = 0.1;
    for (dt, jitter) in [(0.02, 0.0), (0.005, 0.0), (0.005, 0.4), (0.0004, 0.0)] {
        let mut noise = Stream(7);
        let times: Vec<f64> = (0..(8.0 / dt) as i32)
            .map(|i| f64::from(i) * dt + jitter * dt * noise.normal().clamp(-1.0, 1.0))
            .collect();
        // At ω = 1/s an amplitude halves.
        let values: Vec<f64> = times.iter().map(|t| (t / s).sin()).collect();
        let spline = Spline::fit(&times, &values, Smoothing::TimeConstant(s)).unwrap();
        let (mut along, mut all) = (0.0, 0.0);
        for i in 0..400 {
            let t = 2.0 + f64::from(i) * 0.01;
            along += spline.at(t, 0.0_f64, 0) * (t / s).sin();
            all += (t / s).sin().powi(2);
        }
        assert!((along / all - 0.5).abs() < 0.01, "dt {dt}: {}", along / all);
    }
}

#[test]
fn acceleration_of_a_noisy_sine() {
    let mut noise = Stream(1);
    let (dt, omega, sigma) = (0.008, 2.0, 1e-3);
    let start = 1.7e9;
    let times: Vec<f64> = (0..2500).map(|i| start + f64::from(i) * dt).collect();
    let values: Vec<f64> =
        times.iter().map(|t| (omega * (t - start)).sin() + sigma * noise.normal()).collect();
    let error = |spline: &Spline| {
        rms((0..1800).map(|i| {
            let t = 1.0 + f64::from(i) * 0.01;
            spline.at(start + t, 0.0, 2) + omega * omega * (omega * t).sin()
        }))
    };
    let smooth = Spline::fit(&times, &values, Smoothing::TimeConstant(0.1)).unwrap();
    let known = Spline::fit(&times, &values, Smoothing::Noise(sigma)).unwrap();
    let validated = Spline::fit(&times, &values, Smoothing::CrossValidation).unwrap();
    let interpolated = Spline::fit(&times, &values, Smoothing::TimeConstant(1e-5)).unwrap();
    assert!(error(&smooth) < 0.05 * omega * omega, "{}", error(&smooth));
    assert!(error(&known) < 0.15 * omega * omega, "{}", error(&known));
    assert!(error(&validated) < 0.15 * omega * omega, "{}", error(&validated));
    assert!(error(&interpolated) > 5.0 * omega * omega, "{}", error(&interpolated));
    // The curve follows its noise in part: what is left is smaller than it.
    let found = rms(times.iter().zip(&values).map(|(t, y)| y - known.at(*t, 0.0, 0)));
    assert!((0.9..1.0).contains(&(found / sigma)), "{found}");
    assert!(interpolated.noise_gain() > 0.99 && smooth.noise_gain() < 0.25);
}

/// A stage whose encoder errs once a pitch: a wave of 1.5 over a slow motion, fifty times its noise.
/// With the standard deviation of the noise known, the wave keeps its amplitude to a hundredth (a
/// misfit as large as the noise takes three off), and the curve is nearer to the truth than the
/// values are.
#[test]
fn known_noise_takes_nothing_off_a_fast_wave() {
    let (dt, sigma) = (0.005, 0.03);
    let mut noise = Stream(7);
    let truth =
        |t: f64| 400.0 * (0.4 * t).sin() + 1.5 * (2.0 * std::f64::consts::PI * 25.0 * t).sin();
    let times: Vec<f64> = (0..8000).map(|i| f64::from(i) * dt).collect();
    let values: Vec<f64> = times.iter().map(|t| truth(*t) + sigma * noise.normal()).collect();
    let known = Spline::fit(&times, &values, Smoothing::Noise(sigma)).unwrap();
    let inner = || times[200..7800].iter().copied();
    let error = rms(inner().map(|t| known.at(t, 0.0, 0) - truth(t)));
    assert!(error < sigma, "{error}");
    let wave = |t: f64| (2.0 * std::f64::consts::PI * 25.0 * t).sin();
    let slow = |t: f64| 400.0 * (0.4 * t).sin();
    let product: f64 = inner().map(|t| (known.at(t, 0.0, 0) - slow(t)) * wave(t)).sum();
    let amplitude = product / inner().map(|t| wave(t).powi(2)).sum::<f64>();
    assert!((amplitude / 1.5 - 1.0).abs() < 1e-2, "{amplitude}");
}

#[test]
fn derivatives_agree_with_dual_numbers() {
    let times: Vec<f64> = (0..60).map(|i| f64::from(i) * 0.1 + 0.03 * f64::from(i % 3)).collect();
    let values: Vec<f64> = times.iter().map(|t| (1.3 * t).sin() + 0.2 * t * t).collect();
    let spline = Spline::fit(&times, &values, Smoothing::TimeConstant(0.1)).unwrap();
    for order in 0..4_u8 {
        for i in 0..57 {
            let t = 0.05 + f64::from(i) * 0.1;
            let dual: Dual = spline.at(t, variable(0.013), order);
            let next = spline.at(t, 0.013, order + 1);
            assert!((derivative(dual) - next).abs() <= 1e-9 * (1.0 + next.abs()), "{order} at {t}");
            assert_eq!(spline.at(t, 0.013, order), spline.at(t, variable(0.013), order).re);
        }
    }
}

#[test]
fn a_straight_line_stays_and_the_ends_stand_still() {
    let times = [0.0, 0.5, 0.5, 1.0, 5.0, 5.5];
    let values: Vec<f64> = times.iter().map(|t| 3.0 * t - 1.0).collect();
    let spline = Spline::fit(&times, &values, Smoothing::TimeConstant(0.3)).unwrap();
    for t in [0.0, 0.7, 3.0, 5.5] {
        assert!((spline.at(t, 0.0_f64, 0) - (3.0 * t - 1.0)).abs() < 1e-9);
        assert!((spline.at(t, 0.0_f64, 1) - 3.0).abs() < 1e-9);
    }
    for (t, value) in [(-4.0, -1.0), (9.0, 15.5)] {
        assert!((spline.at(t, 0.0_f64, 0) - value).abs() < 1e-9);
        assert_eq!(spline.at(t, 0.0_f64, 1), 0.0);
        assert_eq!(derivative(spline.at(t, variable(0.1), 0)), 0.0);
    }
    assert!(spline.covers(0.0, 5.5) && !spline.covers(-0.1, 1.0) && !spline.covers(1.0, 5.6));
}

#[test]
fn few_values_and_bad_values() {
    let fit = |t: &[f64], y: &[f64]| Spline::fit(t, y, Smoothing::CrossValidation);
    assert_eq!(fit(&[4.0], &[2.0]).unwrap().at(7.0, 0.0, 0), 2.0);
    assert_eq!(fit(&[4.0, 6.0], &[2.0, 4.0]).unwrap().at(5.0, 0.0, 1), 1.0);
    assert_eq!(fit(&[4.0, 4.0], &[2.0, 4.0]).unwrap().at(4.0, 0.0, 0), 3.0);
    assert_eq!(fit(&[], &[]).unwrap_err(), SplineError::Empty);
    assert_eq!(fit(&[1.0, 0.0], &[1.0, 1.0]).unwrap_err(), SplineError::Decreasing { index: 1 });
    assert_eq!(fit(&[1.0], &[f64::NAN]).unwrap_err(), SplineError::NotFinite { index: 0 });
    assert_eq!(
        Spline::fit(&[1.0], &[1.0], Smoothing::Noise(0.0)).unwrap_err(),
        SplineError::Smoothing
    );
}

#[test]
fn tracks_and_their_derivatives() {
    let track = Track::Captured {
        value: vec![0.0, 2.0],
        rate: Some(vec![0.0, 3.0]),
        acceleration: Some(vec![0.0, 4.0]),
    };
    assert_eq!(track.at(1, 100.0, 0.5, 0), 2.0 + 1.5 + 0.5);
    assert_eq!(track.at(1, 100.0, 0.5, 1), 3.0 + 2.0);
    assert_eq!(track.at(1, 100.0, 0.5, 2), 4.0);
    assert_eq!(track.at(1, 100.0, 0.5, 3), 0.0);
    for order in 0..3 {
        let dual = track.at(1, 100.0, variable(0.5), order);
        assert_eq!(derivative(dual), track.at(1, 100.0, 0.5, order + 1));
    }
    assert!(track.moves() && !Track::Constant(1.0).moves() && !Track::Absent.moves());
    let still = Track::Captured { value: vec![5.0], rate: None, acceleration: None };
    assert!(!still.moves());
    assert_eq!(derivative(still.at(0, 0.0, variable(1.0), 0)), 0.0);
    assert_eq!(Track::Constant(5.0).at(0, 0.0, 1.0, 1), 0.0);
    assert!(Track::Absent.at(0, 0.0, 1.0_f64, 0).is_nan());
}

#[test]
fn periods_are_unwrapped() {
    let mut values = vec![350.0, f64::NAN, 5.0, 20.0, 355.0];
    unwrap(&mut values, 360.0, |_, _| 0.0);
    assert_eq!(values[2..], [365.0, 380.0, 355.0]);
    // Half a turn and more between values: only the rate can tell.
    let mut fast = vec![0.0, 300.0, 240.0];
    unwrap(&mut fast, 360.0, |_, _| 300.0);
    assert_eq!(fast, [0.0, 300.0, 600.0]);
}

#[test]
fn a_pause_over_which_the_curve_is_a_guess_is_not_covered() {
    let times = (0..2000).map(|n| f64::from(n) * 0.01).filter(|t| *t < 8.0 || *t > 11.0);
    let times: Vec<f64> = times.collect();
    let mut noise = Stream(3);
    let mut fit = |of: &dyn Fn(f64) -> f64, smoothing| {
        let values: Vec<f64> = times.iter().map(|t| of(*t) + 1e-4 * noise.normal()).collect();
        Spline::fit(&times, &values, smoothing).unwrap()
    };
    let swinging = fit(&|t| (5.0 * t).sin(), Smoothing::Noise(1e-4));
    for (from, to, is_known) in [
        (7.0, 7.9, true),
        (7.5, 8.5, false),
        (9.0, 9.1, false),
        (10.9, 11.5, false),
        (11.1, 12.0, true),
    ] {
        assert_eq!(swinging.covers(from, to), is_known, "{from} to {to}");
    }
    // Nothing is lost where the curve is too smooth for the pause, or stands still in it.
    assert!(fit(&|t| 3.0 * t, Smoothing::Noise(1.1e-4)).covers(9.0, 10.0));
    assert!(fit(&|_| 2.0, Smoothing::TimeConstant(0.05)).covers(9.0, 10.0));
    assert!(!fit(&|t| 3.0 * t, Smoothing::TimeConstant(0.05)).covers(9.0, 10.0));
}

/// From any piece of the last call, forwards and backwards, at knots and outside.
#[test]
fn from_any_piece_values_are_the_same() {
    let times: Vec<f64> = (0..60).map(|k| 0.1 * f64::from(k) + 0.03 * f64::from(k % 3)).collect();
    let values: Vec<f64> = times.iter().map(|time| (1.7 * time).sin()).collect();
    let spline = Spline::fit(&times, &values, Smoothing::TimeConstant(0.1)).unwrap();
    let (first, last) = spline.span();
    let between = (-5..130).map(|k| first + (last - first) * f64::from(k) / 120.0);
    for moment in between.chain(times.iter().copied()) {
        for order in [0, 1, 2] {
            let due: f64 = spline.at(moment, 0.0, order);
            for start in [0, 1, 30, 57, 58, 59, 500] {
                let mut piece = start;
                let found = spline.at_near(moment, 0.0, order, &mut piece);
                assert_eq!(found.to_bits(), due.to_bits(), "{moment} {order} {start}");
            }
        }
    }
}
