//! What the parameters' covariance does to the predictions of a chunk, lane by lane.

use crate::engine::lanes::arithmetic::Arithmetic;
use crate::engine::lanes::dispatch::{Simd, Task};
use crate::engine::lanes::{LANES, Lanes};
use crate::estimate::newton::Given;

/// The covariance of a run along some directions, row by row, for [`Quadratic`]: the upper triangle
/// counts double.
pub(super) fn along(given: &Given<'_>, part: usize, run: usize, directions: &[usize]) -> Vec<f64> {
    let problem = given.problem;
    let touched = problem.layout.columns.touched_by(problem.run_index(part, run));
    let movers = problem.movers(part, run);
    let count = directions.len();
    let mut along = vec![0.0; count * count];
    for i in 0..count {
        for j in i..count {
            let mut sum = 0.0;
            for (a, p) in &movers[directions[i]] {
                for (b, q) in &movers[directions[j]] {
                    sum += p * q * given.covariance[(touched[*a], touched[*b])];
                }
            }
            along[i * count + j] = if i == j { sum } else { 2.0 * sum };
        }
    }
    along
}

/// Numbers that are summed side by side: as many as registers hold.
const ABREAST: usize = 16;

/// `sum = Σ_i column_i Σ_{j >= i} covariance_ij column_j`, lane by lane.
pub(super) struct Quadratic<'a> {
    pub(super) columns: &'a [&'a Lanes],
    pub(super) covariance: &'a [f64],
    pub(super) sum: &'a mut Lanes,
}

impl Task for Quadratic<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        let count = self.columns.len();
        for (block, sum) in self.sum.as_chunks_mut::<ABREAST>().0.iter_mut().enumerate() {
            for i in 0..count {
                let mut inner = [0.0; ABREAST];
                for (entry, right) in
                    self.covariance[i * count..(i + 1) * count].iter().zip(self.columns).skip(i)
                {
                    multiply_add::<A>(&mut inner, &[*entry; ABREAST], part(right, block));
                }
                multiply_add::<A>(sum, &inner, part(self.columns[i], block));
            }
        }
    }
}

/// `Σ weight column_i` over the lanes is added to `sums_i`; where the weight is zero, nothing.
pub(super) struct Weighted<'a> {
    pub(super) columns: &'a [&'a Lanes],
    pub(super) weights: &'a Lanes,
    pub(super) sums: &'a mut [f64],
}

impl Task for Weighted<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        for (sum, column) in self.sums.iter_mut().zip(self.columns) {
            let mut parts = [0.0; ABREAST];
            for block in 0..LANES / ABREAST {
                let weights = part(self.weights, block);
                let mut values = *part(column, block);
                for (value, weight) in values.iter_mut().zip(weights) {
                    *value = if *weight == 0.0 { 0.0 } else { *value };
                }
                multiply_add::<A>(&mut parts, weights, &values);
            }
            *sum += parts.iter().sum::<f64>();
        }
    }
}

#[inline(always)]
fn part(lanes: &Lanes, block: usize) -> &[f64; ABREAST] {
    &lanes.as_chunks::<ABREAST>().0[block]
}

/// `sum += a b`
#[inline(always)]
fn multiply_add<A: Arithmetic>(sum: &mut [f64; ABREAST], a: &[f64; ABREAST], b: &[f64; ABREAST]) {
    for k in 0..ABREAST {
        sum[k] = A::mul_add(a[k], b[k], sum[k]);
    }
}

/// The standard uncertainty of a delay (s) from a variance of the prediction and its slope.
pub(super) struct Seconds<'a> {
    pub(super) variance: &'a Lanes,
    pub(super) slope: &'a Lanes,
    pub(super) seconds: &'a mut Lanes,
}

impl Task for Seconds<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        for lane in 0..LANES {
            let root = self.variance[lane].max(0.0).sqrt();
            self.seconds[lane] = root / self.slope[lane].abs();
        }
    }
}
