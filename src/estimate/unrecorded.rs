//! Accelerations that nobody recorded, and that the readings miss.
//!
//! A signal captured with its rate alone is taken to move at that rate until the reading, `½ a τ²` short of where
//! it is. Whether that matters depends on the delay `τ`, so it is asked at an estimate. The accelerations are
//! differences of neighbouring rates, whose errors must not pass for motion: those just before and just after a sample
//! have none in common, so the mean of the product of what both would change is what true accelerations change. It
//! asks nothing where rates are sparser than the motion, for such differences say nothing of it; and it mends nothing.

use crate::campaign::{Record, Run, Track};
use crate::engine::part::SampleLeaves;
use crate::engine::problem::Problem;
use crate::engine::{Part, Point};

/// Samples of a run that are looked at.
const LOOK: usize = 1_000;
/// Length of what is missed, in units of the noise, from which on estimates are wrong by as much.
const SEEN: f64 = 3.0;
/// It must exceed what errors of the rates give by chance so many times (in standard deviations).
const SURE: f64 = 4.0;

/// A signal whose acceleration would change readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Unrecorded {
    /// The campaign.
    pub part: usize,
    /// The signal.
    pub input: String,
    /// Length of what the readings miss, in units of their noise.
    pub lambda: f64,
    /// The measurand that misses most.
    pub measurand: String,
    /// What it misses in the run that misses most, rms in units of its noise.
    pub most: f64,
    /// That run.
    pub run: String,
}

/// The signals of all campaigns whose accelerations are missed at a point.
pub fn unrecorded(problem: &Problem, point: &Point) -> Vec<Unrecorded> {
    let parts = problem.parts.iter().enumerate();
    let of_part = |(p, part): (usize, &Part)| {
        let inputs = part.system.assembly.names.inputs.len();
        (0..inputs).filter_map(|input| missed(problem, p, input, point)).collect::<Vec<_>>()
    };
    parts.flat_map(of_part).collect()
}

/// What is missed of a measurand in a run: sums over its readings, in units of their noise.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    readings: usize,
    /// Of the products of both changes.
    products: f64,
    /// Of their squares.
    squares: f64,
}

fn missed(problem: &Problem, p: usize, input: usize, point: &Point) -> Option<Unrecorded> {
    let part = &problem.parts[p];
    let (mut products, mut chance) = (0.0, 0.0);
    let mut worst: Option<(f64, usize, usize)> = None;
    for (r, run) in part.runs.iter().enumerate() {
        if !run.record.inputs()[input].has_rate_alone() {
            continue;
        }
        let head = run.record.head(LOOK);
        let share = run.record.len() as f64 / head.len().max(1) as f64;
        let parameters = problem.parameters::<f64>(p, r, point);
        for (measurand, sums) in in_run(part, (r, run), input, &parameters).into_iter().enumerate()
        {
            products += share * sums.products;
            chance += share * share * sums.squares;
            let mean = sums.products / sums.readings.max(1) as f64;
            if worst.is_none_or(|(most, ..)| mean > most) {
                worst = Some((mean, r, measurand));
            }
        }
    }
    let (most, run, measurand) = worst?;
    if products < SEEN * SEEN || products < SURE * chance.sqrt() {
        return None;
    }
    let names = &part.system.assembly.names;
    Some(Unrecorded {
        part: p,
        input: names.inputs[input].name.clone(),
        lambda: products.sqrt(),
        measurand: names.measurands[measurand].name.clone(),
        most: most.max(0.0).sqrt(),
        run: part.runs[run].name.clone(),
    })
}

/// By measurand, what accelerations would change in the first samples of a run.
fn in_run(
    part: &Part,
    (r, run): (usize, &Run),
    input: usize,
    parameters: &[[f64; 4]],
) -> Vec<Sums> {
    let slots = part.slots();
    let mut sums = vec![Sums::default(); slots.len()];
    let head = run.record.head(LOOK);
    let Some([before, after]) = accelerations(&head.time, &head.inputs[input]) else { return sums };
    let with = |acceleration: Option<&Vec<f64>>| {
        let mut samples = head.clone();
        if let Track::Captured { acceleration: column, .. } = &mut samples.inputs[input] {
            *column = acceleration.cloned();
        }
        residuals(part, samples.into(), parameters)
    };
    let [plain, before, after] = [with(None), with(Some(&before)), with(Some(&after))];
    for ((plain, before), after) in plain.iter().zip(&before).zip(&after) {
        for (measurand, (slot, sums)) in slots.iter().zip(&mut sums).enumerate() {
            let sigma = part.sigma_in(r, measurand);
            let range = slot.residual..slot.residual + slot.components;
            let change = |other: &[f64], k: usize| (other[k] - plain[k]) / sigma;
            let each = range.map(|k| change(before, k) * change(after, k));
            let product: f64 = each.sum();
            if product.is_finite() {
                sums.readings += 1;
                sums.products += product;
                sums.squares += product * product;
            }
        }
    }
    sums
}

/// Differences of the rates just before each sample and just after it, by time; NaN at the ends.
fn accelerations(time: &[f64], track: &Track) -> Option<[Vec<f64>; 2]> {
    let Track::Captured { rate: Some(rate), .. } = track else { return None };
    let slope = |from: Option<usize>| {
        let (from, to) = (from?, from? + 1);
        let passed = time.get(to)? - time[from];
        (passed > 0.0).then(|| (rate[to] - rate[from]) / passed)
    };
    let all = |ahead: bool| {
        let one = |i: usize| slope(if ahead { Some(i + 1) } else { i.checked_sub(1) });
        (0..time.len()).map(|i| one(i).unwrap_or(f64::NAN)).collect()
    };
    Some([all(false), all(true)])
}

/// The residuals of each sample; NaN where there is no reading.
fn residuals(part: &Part, record: Record, parameters: &[[f64; 4]]) -> Vec<Vec<f64>> {
    let randoms = vec![0.0; part.random_sigma.len()];
    let mut workspace = Vec::new();
    let mut all = Vec::with_capacity(record.len());
    record.walk(|stretch| {
        for sample in stretch.each() {
            let (randoms, columns) = (&randoms[..], part.columns());
            let leaves = SampleLeaves { parameters, randoms, columns, sample };
            let outputs = part.evaluate(&leaves, &mut workspace);
            let mut own = vec![f64::NAN; part.residual_count()];
            for slot in part.slots().iter().filter(|slot| part.is_present(sample, slot)) {
                let residual = part.residual(sample, slot, outputs);
                own[slot.residual..slot.residual + slot.components]
                    .copy_from_slice(&residual[..slot.components]);
            }
            all.push(own);
        }
    });
    all
}
