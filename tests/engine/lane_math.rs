//! Elementary functions over chunks: against tables of 60 digits, against the numbers of
//! `homepoint::number` at random and at singular points, and lane by lane.
//!
//! The tables in `tests/data/lane_math` hold, as bits, arguments and correctly rounded values; the
//! last column is what the true value lies above the rounded one, in thousandths of its last place.
//! `tests/data/lane_math/generate.py` made them.

use std::fs;

use homepoint::engine::lanes::arithmetic::{Arithmetic, Fused, LANES, Lanes, Plain};
use homepoint::engine::lanes::math;
use homepoint::graph::node::{Binary, Unary};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A function over chunks; those of one argument ignore the second.
trait Function {
    const NAME: &'static str;
    /// Number of arguments.
    const ARGUMENTS: usize = 1;
    /// Whether lanes are computed to the same bits as by `Number`.
    const SAME_BITS: bool = false;
    fn lanes<A: Arithmetic>(x: &Lanes, y: &Lanes, out: &mut Lanes);
    fn number(x: f64, y: f64) -> f64;
}

macro_rules! functions {
    ($($kind:ident $type:ident $name:literal
       ($x:ident, $y:ident, $out:ident) => $lanes:expr, $number:expr;)*) => {$(
        struct $type;
        impl Function for $type {
            const NAME: &'static str = $name;
            functions!(@$kind);
            #[inline(always)]
            fn lanes<A: Arithmetic>($x: &Lanes, $y: &Lanes, $out: &mut Lanes) {
                let _ = $y;
                $lanes
            }
            fn number($x: f64, $y: f64) -> f64 {
                let _ = $y;
                $number
            }
        }
    )*
    /// Calls the macro `$check!(Type)` for every function.
    macro_rules! for_all { ($check:ident) => { $($check!($type);)* } }
    };
    (@unary) => {};
    (@exact_unary) => { const SAME_BITS: bool = true; };
    (@binary) => { const ARGUMENTS: usize = 2; };
    (@exact_binary) => { const ARGUMENTS: usize = 2; const SAME_BITS: bool = true; };
}

functions! {
    unary Sin "sin" (x, y, out) => math::sin::<A>(x, out), Unary::Sin.apply(x);
    unary Cos "cos" (x, y, out) => math::cos::<A>(x, out), Unary::Cos.apply(x);
    unary Tan "tan" (x, y, out) => math::tan::<A>(x, out), Unary::Tan.apply(x);
    unary Asin "asin" (x, y, out) => math::asin::<A>(x, out), Unary::Asin.apply(x);
    unary Acos "acos" (x, y, out) => math::acos::<A>(x, out), Unary::Acos.apply(x);
    unary Atan "atan" (x, y, out) => math::atan::<A>(x, out), Unary::Atan.apply(x);
    unary Exp "exp" (x, y, out) => math::exp::<A>(x, out), Unary::Exp.apply(x);
    unary Ln "ln" (x, y, out) => math::ln::<A>(x, out), Unary::Ln.apply(x);
    unary Tanh "tanh" (x, y, out) => math::tanh::<A>(x, out), Unary::Tanh.apply(x);
    binary Pow "pow" (x, y, out) => math::pow::<A>(x, y, out), Binary::Power.apply(x, y);
    binary Atan2 "atan2" (x, y, out) => math::atan2::<A>(x, y, out), Binary::Atan2.apply(x, y);
    binary Hypot "hypot" (x, y, out) => math::hypot::<A>(x, y, out), Binary::Hypot.apply(x, y);
    exact_unary Negate "negate" (x, y, out) => math::negate(x, out), Unary::Negate.apply(x);
    exact_unary Sqrt "sqrt" (x, y, out) => math::sqrt(x, out), Unary::Sqrt.apply(x);
    exact_unary Abs "abs" (x, y, out) => math::abs(x, out), Unary::Abs.apply(x);
    exact_unary Sign "sign" (x, y, out) => math::sign(x, out), Unary::Sign.apply(x);
    exact_unary Floor "floor" (x, y, out) => math::floor(x, out), Unary::Floor.apply(x);
    exact_unary Fract "fract" (x, y, out) => math::fract(x, out), Unary::Fract.apply(x);
    exact_unary Reciprocal "reciprocal_or_zero" (x, y, out) =>
        math::reciprocal_or_zero(x, out), Unary::ReciprocalOrZero.apply(x);
    exact_unary PowerM3 "powi(-3)" (x, y, out) =>
        math::powi(x, -3, out), Unary::PowerInteger(-3).apply(x);
    exact_unary Power0 "powi(0)" (x, y, out) =>
        math::powi(x, 0, out), Unary::PowerInteger(0).apply(x);
    exact_unary Power2 "powi(2)" (x, y, out) =>
        math::powi(x, 2, out), Unary::PowerInteger(2).apply(x);
    exact_unary Power13 "powi(13)" (x, y, out) =>
        math::powi(x, 13, out), Unary::PowerInteger(13).apply(x);
    exact_unary PowerLowest "powi(i32::MIN)" (x, y, out) =>
        math::powi(x, i32::MIN, out), Unary::PowerInteger(i32::MIN).apply(x);
    exact_binary Add "add" (x, y, out) => math::add(x, y, out), Binary::Add.apply(x, y);
    exact_binary Subtract "subtract" (x, y, out) =>
        math::subtract(x, y, out), Binary::Subtract.apply(x, y);
    exact_binary Multiply "multiply" (x, y, out) =>
        math::multiply(x, y, out), Binary::Multiply.apply(x, y);
    exact_binary Divide "divide" (x, y, out) =>
        math::divide(x, y, out), Binary::Divide.apply(x, y);
    exact_binary Min "min" (x, y, out) => math::min(x, y, out), Binary::Min.apply(x, y);
    exact_binary Max "max" (x, y, out) => math::max(x, y, out), Binary::Max.apply(x, y);
}

/// A Stumpff function of fixed order.
struct Stumpff<const ORDER: u8>;

impl<const ORDER: u8> Function for Stumpff<ORDER> {
    const NAME: &'static str = "stumpff";
    #[inline(always)]
    fn lanes<A: Arithmetic>(x: &Lanes, _: &Lanes, out: &mut Lanes) {
        math::stumpff::<A>(x, ORDER, out);
    }
    fn number(x: f64, _: f64) -> f64 {
        Unary::Stumpff(ORDER).apply(x)
    }
}

/// How a chunk is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Route {
    /// As the compiler does by default, without fused multiply-add.
    Plain,
    /// Compiled for AVX2 but without fused multiply-add.
    PlainV3,
    /// Fused multiply-add as a library call.
    Fused,
    /// Compiled for AVX2 with fused multiply-add.
    FusedV3,
    /// Compiled for AVX-512.
    FusedV4,
}

struct Chunk<'a, F, A>(&'a Lanes, &'a Lanes, &'a mut Lanes, std::marker::PhantomData<(F, A)>);

impl<F: Function, A: Arithmetic> pulp::NullaryFnOnce for Chunk<'_, F, A> {
    type Output = ();
    #[inline(always)]
    fn call(self) {
        F::lanes::<A>(self.0, self.1, self.2);
    }
}

/// One chunk; `None` if the processor lacks the instructions.
fn chunk<F: Function>(route: Route, x: &Lanes, y: &Lanes) -> Option<Lanes> {
    let mut out = [0.0; LANES];
    match route {
        Route::Plain => F::lanes::<Plain>(x, y, &mut out),
        Route::Fused => F::lanes::<Fused>(x, y, &mut out),
        #[cfg(target_arch = "x86_64")]
        Route::PlainV3 => pulp::x86::V3::try_new()?.vectorize(Chunk::<F, Plain>(
            x,
            y,
            &mut out,
            std::marker::PhantomData,
        )),
        #[cfg(target_arch = "x86_64")]
        Route::FusedV3 => pulp::x86::V3::try_new()?.vectorize(Chunk::<F, Fused>(
            x,
            y,
            &mut out,
            std::marker::PhantomData,
        )),
        #[cfg(target_arch = "x86_64")]
        Route::FusedV4 => pulp::x86::V4::try_new()?.vectorize(Chunk::<F, Fused>(
            x,
            y,
            &mut out,
            std::marker::PhantomData,
        )),
        #[cfg(not(target_arch = "x86_64"))]
        _ => return None,
    }
    Some(out)
}

/// Values at many points, the last chunk filled up with the last point.
fn values<F: Function>(route: Route, points: &[[f64; 2]]) -> Option<Vec<f64>> {
    let mut found = Vec::new();
    for points in points.chunks(LANES) {
        let point = |i: usize| points[i.min(points.len() - 1)];
        let x: Lanes = std::array::from_fn(|i| point(i)[0]);
        let y: Lanes = std::array::from_fn(|i| point(i)[1]);
        found.extend_from_slice(&chunk::<F>(route, &x, &y)?[..points.len()]);
    }
    Some(found)
}

/// Distance to the next larger number in size.
fn last_place(x: f64) -> f64 {
    let size = x.abs().min(f64::MAX);
    if size == f64::MAX { size - size.next_down() } else { size.next_up() - size }
}

/// Error in units of the last place; the true value is `expected` and `above` such units.
fn error(found: f64, expected: f64, above: f64) -> f64 {
    if found == expected || (found.is_nan() && expected.is_nan()) {
        return above.abs();
    }
    // Differences of large numbers are taken by halves, not to overflow.
    let scale = if expected.abs() > 1.0 { 0.5 } else { 1.0 };
    let units = (scale * found - scale * expected) / (scale * last_place(expected));
    if units.is_nan() { f64::INFINITY } else { (units - above).abs() }
}

/// Arguments, correctly rounded value and what the true value lies above it, in last places.
fn table(name: &str, arguments: usize) -> Vec<([f64; 2], f64, f64)> {
    let path = format!("{}/tests/data/lane_math/{name}.txt", env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(&path).unwrap_or_else(|fault| panic!("{path}: {fault}"));
    let mut rows = Vec::new();
    for line in text.lines() {
        let mut words = line.split(' ');
        let mut bits = || f64::from_bits(u64::from_str_radix(words.next().unwrap(), 16).unwrap());
        let x = bits();
        let y = if arguments == 2 { bits() } else { 0.0 };
        let value = bits();
        let above: f64 = words.next().unwrap().parse().unwrap();
        rows.push(([x, y], value, above / 1000.0));
    }
    assert!(rows.len() > 200, "{path} has {} rows", rows.len());
    rows
}

/// The largest error over a table, and where it is.
fn worst<F: Function>(route: Route, name: &str) -> Option<(f64, [f64; 2])> {
    let rows = table(name, F::ARGUMENTS);
    let points: Vec<_> = rows.iter().map(|row| row.0).collect();
    let found = values::<F>(route, &points)?;
    let errors = rows
        .iter()
        .zip(found)
        .map(|(&(point, expected, above), found)| (error(found, expected, above), point));
    errors.max_by(|a, b| a.0.total_cmp(&b.0))
}

#[track_caller]
fn check_table<F: Function>(name: &str) {
    for route in [Route::Plain, Route::Fused, Route::FusedV3, Route::FusedV4] {
        if let Some((error, [x, y])) = worst::<F>(route, name) {
            assert!(error <= 2.0, "{name}({x:e}, {y:e}) by {route:?}: {error:.2} ulp");
        }
    }
}

#[test]
fn within_two_units_of_the_tables() {
    macro_rules! check {
        ($type:ident) => {
            if !$type::SAME_BITS {
                check_table::<$type>($type::NAME);
            }
        };
    }
    for_all!(check);
}

/// Random arguments: of any bits, of moderate size, and whole numbers and halves.
fn random_points(count: usize) -> Vec<[f64; 2]> {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let mut any = |kind: u32| match kind {
        0 => f64::from_bits(random.next_u64()),
        1 => random.random_range(-1.0..1.0),
        2 => random.random_range(-20.0..20.0),
        3 => random.random_range(-1000.0..1000.0),
        _ => 0.5 * f64::from(random.random_range(-30..30)),
    };
    (0..count as u32).map(|i| [any(i % 5), any(i / 5 % 5)]).collect()
}

/// The standard library is right to one unit, `asin` and `acos` of `Number` to two.
fn check_random<F: Function>() {
    let points = random_points(20_000);
    for route in [Route::Plain, Route::FusedV3] {
        let Some(found) = values::<F>(route, &points) else { continue };
        for ([x, y], found) in points.iter().copied().zip(found) {
            let expected = F::number(x, y);
            let name = F::NAME;
            if F::SAME_BITS && !expected.is_nan() {
                assert_eq!(found.to_bits(), expected.to_bits(), "{name}({x:e}, {y:e}), {route:?}");
            }
            assert!(
                error(found, expected, 0.0) <= 3.0,
                "{name}({x:e}, {y:e}) by {route:?}: {found:e}, by numbers {expected:e}"
            );
        }
    }
}

#[test]
fn agree_with_numbers_at_random() {
    macro_rules! check {
        ($type:ident) => {
            check_random::<$type>()
        };
    }
    for_all!(check);
}

/// Where something happens: zeros, ends of ranges, kinks, poles, and their neighbours.
fn singular_arguments() -> Vec<f64> {
    let sizes = [
        0.0,
        f64::from_bits(1),
        f64::MIN_POSITIVE.next_down(),
        f64::MIN_POSITIVE,
        4.0 * f64::MIN_POSITIVE,
        1e-300,
        0.25,
        0.5,
        1.0,
        1.5,
        2.0,
        3.0,
        708.0,
        710.0,
        750.0,
        1_048_576.0,
        4_503_599_627_370_495.5,
        4_503_599_627_370_496.0,
        9_007_199_254_740_993.0,
        1e200,
        1e308,
        f64::MAX,
        f64::INFINITY,
        f64::NAN,
    ];
    let near = |size: f64| [size, size.next_up(), size.next_down()];
    sizes.into_iter().flat_map(near).flat_map(|x| [x, -x]).collect()
}

fn check_singular<F: Function>() {
    let arguments = singular_arguments();
    let second = if F::ARGUMENTS == 2 { &arguments[..] } else { &[0.0] };
    let pair = |&x: &f64| second.iter().map(move |&y| [x, y]);
    let points: Vec<_> = arguments.iter().flat_map(pair).collect();
    for route in [Route::Plain, Route::FusedV3] {
        let Some(found) = values::<F>(route, &points) else { continue };
        for ([x, y], found) in points.iter().copied().zip(found) {
            let expected = F::number(x, y);
            let zero = expected == 0.0 && found.to_bits() == expected.to_bits();
            let alike = zero || (expected != 0.0 && error(found, expected, 0.0) <= 3.0);
            let name = F::NAME;
            assert!(alike, "{name}({x:e}, {y:e}) by {route:?}: {found:e}, by numbers {expected:e}");
        }
    }
}

#[test]
fn singular_points_are_those_of_numbers_with_the_signs_of_zeros() {
    macro_rules! check {
        ($type:ident) => {
            check_singular::<$type>()
        };
    }
    for_all!(check);
}

/// A lane's value must not depend on its neighbours, nor on the instruction set.
fn check_lanes<F: Function>() {
    let calm = random_points(5 * LANES);
    let calm: Vec<_> = calm.iter().filter(|[x, y]| x.abs().max(y.abs()) <= 20.0).collect();
    let arguments = singular_arguments();
    let x: Lanes = std::array::from_fn(|i| calm[i][0]);
    let y: Lanes = std::array::from_fn(|i| calm[i][1]);
    for (fused, routes) in [
        (false, [Route::Plain, Route::PlainV3, Route::PlainV3]),
        (true, [Route::Fused, Route::FusedV3, Route::FusedV4]),
    ] {
        for (i, &odd) in arguments.iter().enumerate() {
            let (mut x, mut y) = (x, y);
            let lane = 37 * i % LANES;
            (x[lane], y[lane]) = if i % 2 == 0 { (odd, y[lane]) } else { (x[lane], odd) };
            let first = chunk::<F>(routes[0], &x, &y).unwrap();
            for route in &routes[1..] {
                let Some(found) = chunk::<F>(*route, &x, &y) else { continue };
                assert_eq!(bits(&found), bits(&first), "{}: {route:?}", F::NAME);
            }
            // Slow where multiply-adds are library calls: a few lanes stand for all.
            for other in [lane, (lane + 1) % LANES, (lane + 64) % LANES] {
                let (x, y) = ([x[other]; LANES], [y[other]; LANES]);
                let alone = chunk::<F>(routes[0], &x, &y).unwrap();
                let name = F::NAME;
                assert_eq!(bits(&alone)[0], bits(&first)[other], "{name}, fused {fused}");
            }
        }
    }
}

/// Bits of a chunk, one pattern for all NaN.
fn bits(lanes: &Lanes) -> Vec<u64> {
    lanes.iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }).collect()
}

#[test]
fn lanes_do_not_depend_on_each_other_nor_on_the_processor() {
    macro_rules! check {
        ($type:ident) => {
            check_lanes::<$type>()
        };
    }
    for_all!(check);
    check_lanes::<Stumpff<0>>();
    check_lanes::<Stumpff<1>>();
    check_lanes::<Stumpff<5>>();
}

#[test]
fn sine_and_cosine_together_are_those_alone() {
    for points in random_points(40 * LANES).chunks_exact(LANES) {
        let x: Lanes = std::array::from_fn(|i| points[i][0]);
        let (mut sin, mut cos) = ([0.0; LANES], [0.0; LANES]);
        math::sin_cos::<Plain>(&x, &mut sin, &mut cos);
        assert_eq!(bits(&sin), bits(&chunk::<Sin>(Route::Plain, &x, &x).unwrap()));
        assert_eq!(bits(&cos), bits(&chunk::<Cos>(Route::Plain, &x, &x).unwrap()));
    }
}

/// Size of `c_k` where it oscillates: `x^(-k/2)`, and `1/k!` near 0.
fn swing(x: f64, k: u8) -> f64 {
    let inverse_factorial: f64 = (1..=k).map(|n| 1.0 / f64::from(n)).product();
    if x <= 0.0 { 0.0 } else { x.powf(-0.5 * f64::from(k)).min(inverse_factorial) }
}

fn check_stumpff<const ORDER: u8>(tabulated: bool) {
    if tabulated {
        for route in [Route::Plain, Route::Fused, Route::FusedV3] {
            let rows = table(&format!("stumpff{ORDER}"), 1);
            let points: Vec<_> = rows.iter().map(|row| row.0).collect();
            let Some(found) = values::<Stumpff<ORDER>>(route, &points) else { continue };
            for (([x, _], expected, above), found) in rows.into_iter().zip(found) {
                let units = error(found, expected, above);
                let error = units * last_place(expected);
                let far = f64::from((ORDER + 1) * (ORDER + 2));
                if x < -far {
                    assert_eq!(found, Stumpff::<ORDER>::number(x, 0.0), "left to the numbers");
                    continue;
                }
                // Each step of the recurrence to orders above 4 adds its roundings.
                let most = if ORDER <= 4 { 2.0 } else { 3.0 };
                let allowed = most * last_place(expected.abs().max(swing(x, ORDER)));
                assert!(error <= allowed, "c_{ORDER}({x:e}) by {route:?}: {units:.2} ulp");
            }
        }
    }
    for route in [Route::Plain, Route::FusedV3] {
        let points = random_points(5_000);
        let Some(found) = values::<Stumpff<ORDER>>(route, &points) else { continue };
        for ([x, _], found) in points.into_iter().zip(found) {
            let expected = Stumpff::<ORDER>::number(x, 0.0);
            if expected.is_nan() || expected.is_infinite() {
                assert_eq!(found.is_nan(), expected.is_nan(), "c_{ORDER}({x:e})");
                continue;
            }
            // What tests/number/stumpff.rs allows the numbers themselves, and two units.
            let swing = swing(x, ORDER);
            let units = 18.0 * expected.abs().max(swing) + x.abs().sqrt() * swing;
            let error = (found - expected).abs();
            assert!(error <= f64::EPSILON * units, "c_{ORDER}({x:e}): {found:e}, {expected:e}");
        }
    }
}

#[test]
fn stumpff_functions_of_low_and_high_order() {
    check_stumpff::<0>(true);
    check_stumpff::<1>(true);
    check_stumpff::<2>(true);
    check_stumpff::<3>(true);
    check_stumpff::<4>(true);
    check_stumpff::<5>(true);
    check_stumpff::<8>(true);
    check_stumpff::<11>(false);
    check_stumpff::<12>(false);
    check_stumpff::<13>(false);
}
