//! Two steps from the reference time for all readings of a chunk at once, without questions.
//!
//! The first is Newton's. With values and slopes at both its ends the inverse function is known as
//! a cubic (Hermite's), whose value at zero is the second step: its error is of the order
//! `e₀² e₁²`, where Newton's would be `e₁²`. An evaluation there tells which readings are solved:
//! those that came steadily nearer, in shrinking steps, and for which Newton's next step is below
//! the tolerance. The others are for [`super::careful`].

use crate::engine::lanes::arithmetic::Arithmetic;
use crate::engine::lanes::dispatch::{InstructionSet, Simd, Task};
use crate::engine::lanes::{LANES, Lanes};
use crate::estimate::newton::careful::TOLERANCE;

/// A step and a value must be less than this part of those before.
const STEADY: f64 = 0.5;

/// `prediction - reading` and its derivative by the delay, at some delay of each reading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evaluated {
    pub(super) value: Lanes,
    pub(super) slope: Lanes,
}

/// Where the steps led.
#[derive(Debug)]
pub(super) struct Quick {
    /// Delay (s).
    pub(super) delay: Lanes,
    /// Derivative of the prediction by the delay there.
    pub(super) slope: Lanes,
    /// Whether the reading is solved.
    pub(super) is_solved: [bool; LANES],
}

/// Newton steps of a reading that is solved this way.
pub(super) const STEPS: u32 = 2;

impl Quick {
    /// From values and slopes at the reference time; the last evaluation is at the delays that come
    /// back, but for a step below the tolerance.
    pub(super) fn find(
        set: InstructionSet,
        at_reference: &Evaluated,
        reading: &Lanes,
        range: f64,
        mut evaluate: impl FnMut(&Lanes) -> Evaluated,
    ) -> Self {
        let mut first = [0.0; LANES];
        set.run(First { from: at_reference, range, delay: &mut first });
        let between = evaluate(&first);
        let mut second = [0.0; LANES];
        set.run(Second {
            ends: [at_reference, &between],
            first: &first,
            range,
            delay: &mut second,
        });
        let last = evaluate(&second);
        let (mut delay, mut is_solved) = (second, [false; LANES]);
        set.run(Last {
            values: [&at_reference.value, &between.value],
            last: &last,
            first: &first,
            reading,
            range,
            delay: &mut delay,
            is_solved: &mut is_solved,
        });
        Self { delay, slope: last.slope, is_solved }
    }
}

/// Newton's step from the reference time.
struct First<'a> {
    from: &'a Evaluated,
    range: f64,
    delay: &'a mut Lanes,
}

impl Task for First<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        for lane in 0..LANES {
            let step = -self.from.value[lane] / self.from.slope[lane];
            self.delay[lane] = step.clamp(-self.range, self.range);
        }
    }
}

/// The cubic through both ends of the first step.
struct Second<'a> {
    ends: [&'a Evaluated; 2],
    first: &'a Lanes,
    range: f64,
    delay: &'a mut Lanes,
}

impl Task for Second<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        let [start, end] = self.ends;
        for lane in 0..LANES {
            let along = end.value[lane] - start.value[lane];
            // Where between the ends zero lies.
            let at = -start.value[lane] / along;
            let rest = 1.0 - at;
            let by_start = at * rest * rest * along / start.slope[lane];
            let by_first = at * at * A::mul_add(-2.0, at, 3.0) * self.first[lane];
            let by_end = at * at * rest * along / end.slope[lane];
            let delay = by_start + (by_first - by_end);
            self.delay[lane] = delay.clamp(-self.range, self.range);
        }
    }
}

/// Newton's step from where the cubic led, and whether all went well.
struct Last<'a> {
    /// At the reference time and after the first step.
    values: [&'a Lanes; 2],
    last: &'a Evaluated,
    first: &'a Lanes,
    reading: &'a Lanes,
    range: f64,
    delay: &'a mut Lanes,
    is_solved: &'a mut [bool; LANES],
}

impl Task for Last<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        let [start, between] = self.values;
        for lane in 0..LANES {
            let (first, second) = (self.first[lane], self.delay[lane]);
            let per_slope = 1.0 / self.last.slope[lane];
            let step = -self.last.value[lane] * per_slope;
            let rounding = 8.0 * f64::EPSILON * (self.reading[lane] * per_slope).abs();
            let tolerance = TOLERANCE.max(4.0 * f64::EPSILON * second.abs()).max(rounding);
            // Not a number makes each of these false.
            let is_nearer = between[lane].abs() <= STEADY * start[lane].abs();
            let is_shorter = (second - first).abs() <= STEADY * first.abs();
            let is_inside = second.abs() < self.range;
            self.is_solved[lane] = is_nearer & is_shorter & is_inside & (step.abs() <= tolerance);
            self.delay[lane] = second + step;
        }
    }
}
