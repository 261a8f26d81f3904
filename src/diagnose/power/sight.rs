//! How well one effect is seen and distinguished from others, from the columns of one pass.
//!
//! The *size* of an effect is the length of its parameters together, each weighed by its typical
//! value and counted in the unit of the first: the amplitude of a cosine and sine pair. A value for
//! each setup, run or measurand has that size in each of them. The phase is not known:
//! probabilities are means over directions (`DIRECTIONS` random ones, always the same) and over the
//! members of a family. Values and directions that nominal parameters absorb are left aside.

use std::collections::BTreeSet;

use indexmap::IndexMap;
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::diagnose::evidence::{Entry, Evidence};
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::thresholds::NEAR_ALIAS;
use crate::statistics::noncentral_chi_squared;

use super::Row;
use super::detection::{CriticalGains, leads, solved};

/// Directions over which probabilities are taken, of effects with more than one value.
const DIRECTIONS: usize = 48;
/// Part of the strongest direction's squared length below which a direction is none.
const NOTHING: f64 = 1e-6;
/// Part of the longest value's signature below which a value is not seen.
const UNSEEN: f64 = 1e-4;
/// Probability with which an effect of the stated size enters a budget, or is named.
pub const CAUGHT: f64 = 0.9;
/// Sizes beyond so many times the typical and the detectable one are not thought of.
pub(super) const FAR: f64 = 30.0;
/// Other explanations looked at in each direction, and named at most: the nearest ones.
pub(super) const NEAREST: usize = 4;

/// One way of an effect with its columns.
#[derive(Clone, Copy, Debug)]
pub struct Way<'a> {
    /// The effect.
    pub candidate: &'a Candidate,
    /// What a pass over the readings gives for it.
    pub entry: &'a Entry,
}

/// Directions in the space of an entry's values: for each setup, run and measurand of length one,
/// each value weighed by its typical size over the first one's.
pub fn directions(way: Way<'_>) -> Vec<DVector<f64>> {
    let (scale, groups) = groups(way);
    let count = if scale.len() > 1 { DIRECTIONS } else { 1 };
    let contrast = way.candidate.sums_to_zero();
    let seen = seen(way, &scale);
    let mut generator = ChaCha12Rng::seed_from_u64(1);
    let mut draw = || {
        // What no reading shows is no part of the size.
        let mut direction = DVector::from_fn(scale.len(), |k, _| {
            let drawn = StandardNormal.sample(&mut generator);
            if seen[k] { drawn } else { 0.0 }
        });
        normalise(&mut direction, &groups);
        if contrast {
            // Values over one scope sum to zero, parameter by parameter.
            let mean = direction.mean();
            direction.add_scalar_mut(-mean);
            let length = direction.norm() / (groups.len() as f64).sqrt();
            direction /= if length > 0.0 { length } else { 1.0 };
        }
        direction.component_mul(&scale)
    };
    // Values that sum to zero may all be zero: drawn again, a few times.
    (0..count)
        .filter_map(|_| (0..DIRECTIONS).map(|_| draw()).find(|one| one.norm() > 0.0))
        .collect()
}

/// Which values change readings beyond the nominal parameters; all where none does.
fn seen(way: Way<'_>, scale: &DVector<f64>) -> Vec<bool> {
    let lengths = way.entry.lengths.column_iter().zip(scale.iter());
    let lengths: Vec<f64> = lengths.map(|(column, scale)| column.norm() * scale).collect();
    let most = lengths.iter().copied().fold(0.0, f64::max);
    lengths.iter().map(|length| *length >= UNSEEN * most).collect()
}

/// The weight of each value, and the values that belong to one setup, run and measurand.
fn groups(way: Way<'_>) -> (DVector<f64>, Vec<Vec<usize>>) {
    let typical = |k: usize| way.candidate.typical(&way.entry.owners[k].parameter).unwrap_or(1.0);
    let count = way.entry.owners.len();
    let scale = DVector::from_fn(count, |k, _| typical(k) / typical(0));
    let mut groups: IndexMap<_, Vec<usize>> = IndexMap::new();
    for (k, owner) in way.entry.owners.iter().enumerate() {
        let key = (&owner.of, way.candidate.measurand(&owner.parameter));
        groups.entry(key).or_default().push(k);
    }
    (scale, groups.into_values().collect())
}

fn normalise(direction: &mut DVector<f64>, groups: &[Vec<usize>]) {
    for group in groups {
        let length = group.iter().map(|k| direction[*k].powi(2)).sum::<f64>().sqrt();
        if length > 0.0 {
            group.iter().for_each(|k| direction[*k] /= length);
        }
    }
}

/// What a direction of one member does, for size one.
struct Ray {
    member: usize,
    degrees: usize,
    /// The gains that it must reach.
    critical_gains: CriticalGains,
    /// Squared length of its signature.
    square: f64,
    /// The nearest other explanations: number, length that they do not follow, degrees.
    others: Vec<(usize, f64, usize)>,
}

impl Ray {
    /// Probability that an effect of a size exceeds a gain.
    fn exceeds(&self, gain: f64, size: f64) -> f64 {
        noncentral_chi_squared(gain, self.degrees, size * size * self.square)
    }

    fn detected(&self, size: f64) -> f64 {
        self.exceeds(self.critical_gains.enters, size)
    }

    fn identified(&self, size: f64) -> f64 {
        let least = |least: f64, (_, apart, degrees): &(usize, f64, usize)| {
            least.min(leads(size * apart, self.degrees, *degrees))
        };
        let leads = self.others.iter().take(NEAREST).fold(1.0, least);
        self.exceeds(self.critical_gains.named, size) * leads
    }
}

/// How well an effect, given by its `ways`, is seen among others: its sizes, those of the members of its
/// family, and what does the same. `critical_gains` are what an entry of so many degrees must reach.
pub(super) fn sight(
    evidence: &Evidence,
    ways: &[Way<'_>],
    others: &[Way<'_>],
    critical_gains: impl Fn(usize) -> CriticalGains,
) -> Row {
    let row = Row::new(&ways[0].candidate.name);
    let rays = rays(evidence, ways, others, critical_gains);
    // Of no rays it is no number: they are never caught.
    let mean = |rays: &[&Ray], size: f64, of: fn(&Ray, f64) -> f64| {
        rays.iter().map(|ray| of(ray, size)).sum::<f64>() / rays.len() as f64
    };
    let first = ways.iter().find_map(|way| Some((way, way.entry.owners.first()?)));
    let Some((first, owner)) = first else { return row };
    let typical = first.candidate.typical(&owner.parameter).unwrap_or(1.0);
    let caught = |rays: &[&Ray], of: fn(&Ray, f64) -> f64| {
        let size = typical * solved(|size| mean(rays, size * typical, of) >= CAUGHT);
        size.is_finite().then_some(size)
    };
    let all: Vec<&Ray> = rays.iter().collect();
    let detectable = caught(&all, Ray::detected);
    let most = FAR * typical.max(detectable.unwrap_or(0.0));
    let identifiable = caught(&all, Ray::identified).filter(|size| *size <= most);
    let members = ways.iter().enumerate().filter(|_| ways.len() > 1).filter_map(|(number, way)| {
        let own: Vec<&Ray> = rays.iter().filter(|ray| ray.member == number).collect();
        Some((way.candidate.selected.member.clone(), caught(&own, Ray::detected)?))
    });
    let with = alike(&rays, others, identifiable.is_none().then_some(most));
    Row { detectable, identifiable, with, members: members.collect(), ..row }
}

fn rays(
    evidence: &Evidence,
    ways: &[Way<'_>],
    others: &[Way<'_>],
    critical_gains: impl Fn(usize) -> CriticalGains,
) -> Vec<Ray> {
    let mut rays = Vec::new();
    for (member, way) in ways.iter().enumerate().filter(|(_, way)| way.entry.degrees() > 0) {
        let cosines: Vec<DMatrix<f64>> =
            others.iter().map(|other| evidence.overlap(other.entry, way.entry)).collect();
        let degrees = way.entry.degrees();
        let critical_gains = critical_gains(degrees);
        for direction in directions(*way) {
            let signature = &way.entry.lengths * &direction;
            let square = signature.norm_squared();
            let left = |(number, cosines): (usize, &DMatrix<f64>)| {
                let left = (square - (cosines * &signature).norm_squared()).max(0.0);
                (number, left.sqrt(), others[number].entry.degrees())
            };
            let mut apart: Vec<(usize, f64, usize)> =
                cosines.iter().enumerate().map(left).collect();
            apart.sort_by(|a, b| a.1.total_cmp(&b.1));
            // Many members of a family may be near: of each effect only the nearest.
            let mut named = BTreeSet::new();
            apart.retain(|(number, ..)| named.insert(&others[*number].candidate.name));
            rays.push(Ray { member, degrees, critical_gains, square, others: apart });
        }
    }
    let most = rays.iter().map(|ray| ray.square).fold(0.0, f64::max);
    rays.retain(|ray| ray.square > NOTHING * most);
    rays
}

/// The effects that stand in the way of naming this one, nearest first: those that it cannot be
/// distinguished from at a size, if one is given, else those that do nearly the same.
fn alike(rays: &[Ray], others: &[Way<'_>], size: Option<f64>) -> Vec<String> {
    let mut found: IndexMap<&str, (f64, f64)> = IndexMap::new();
    for ray in rays {
        for (number, apart, degrees) in &ray.others {
            let name = others[*number].candidate.name.as_str();
            let share = apart * apart / ray.square;
            let leading = size.map_or(0.0, |size| leads(size * apart, ray.degrees, *degrees));
            let (sum, all) = found.entry(name).or_default();
            *sum += share;
            *all += leading;
        }
    }
    let count = rays.len() as f64;
    found.retain(|_, (share, leading)| match size {
        Some(_) => *leading / count < CAUGHT,
        None => *share / count < 1.0 - NEAR_ALIAS,
    });
    found.sort_by(|a, one, b, other| one.0.total_cmp(&other.0).then(a.cmp(b)));
    found.into_keys().take(NEAREST).map(str::to_owned).collect()
}

/// The largest shift that an effect of size one causes in a nominal combination of columns (`row`:
/// column and coefficient), whatever its direction.
pub(super) fn shift(way: Way<'_>, row: &[(usize, f64)]) -> f64 {
    let (scale, groups) = groups(way);
    let moves = |k: usize| -> f64 {
        row.iter().map(|(column, by)| by * way.entry.coupling[(*column, k)]).sum::<f64>() * scale[k]
    };
    let length = |group: &Vec<usize>| group.iter().map(|k| moves(*k).powi(2)).sum::<f64>().sqrt();
    groups.iter().map(length).sum()
}
