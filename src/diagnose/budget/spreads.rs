//! How the values of inputs are spread: places at which a line bends or has values of its own, and which
//! inputs go in proportion.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use indexmap::IndexMap;

use crate::diagnose::library::structure::spread::{Pairs, Spread};
use crate::engine::Problem;

use super::labels::each_input;

/// Part of an input's variance that another one leaves, below which they go in proportion.
const ALIKE: f64 = 2e-4;
/// Span (rad) above which an angle is treated as periodic.
const PERIODIC: f64 = 1.0;
/// Values of an input, in parts of its span, within one place.
const SAME_PLACE: f64 = 1e-6;
/// Spans between the knots of an input with more places.
const KNOTS: usize = 8;
/// Places that each have a value of their own at most.
const MOST_PLACES: usize = 16;
/// The same of a block for inputs with more places, and the readings of each on average at least.
const MOST_LEVELS: usize = 48;
const READINGS_OF_A_LEVEL: usize = 2;
/// Visits of most parts of an input with still more places at least, and of most pairs of places.
const VISITS_OF_A_LEVEL: usize = 3;
/// Inputs beside which such parts are made at most: of many, one follows another along each path.
const FEW_INPUTS: usize = 4;

/// How the inputs that vary are spread, with the places at which a line over each may bend: all of a few, or
/// octiles of many; none of an angle that is treated as periodic.
pub(super) fn spreads(problem: &Problem) -> Vec<Spread> {
    let mut values: IndexMap<String, (bool, Vec<f64>)> = IndexMap::new();
    each_input(problem, 0, |_, input, here| {
        let (is_angle, all) = values.entry(input.name.clone()).or_default();
        *is_angle |= input.unit.is_angle();
        all.extend(here);
    });
    let alike: Vec<Vec<String>> = values.values().map(|one| alike(one, &values)).collect();
    let mut pairs = pairs(&values);
    let are_few = values.len() <= FEW_INPUTS;
    let spread = values.into_iter().zip(alike);
    spread
        .filter_map(|((name, (is_angle, mut all)), alike)| {
            let in_order = if are_few { all.clone() } else { Vec::new() };
            all.sort_by(f64::total_cmp);
            let span = all.last()? - all.first()?;
            if is_angle && span > PERIODIC {
                let mut places: Vec<f64> = all.iter().map(|one| one.rem_euclid(TAU)).collect();
                places.sort_by(f64::total_cmp);
                // Waves over a circle are finer than parts of it.
                let levels = levels(&distinct(&places, TAU), all.len(), Vec::new);
                let spread = Spread::of_angle(name, &all, span);
                return Some(spread.with_levels(levels).with_alike(alike));
            }
            let mut places = distinct(&all, span);
            if places.len() < 3 {
                return None;
            }
            let levels = levels(&places, all.len(), || parts(in_order, (all[0], span)));
            if places.len() > MOST_PLACES {
                places = (0..=KNOTS).map(|k| all[k * (all.len() - 1) / KNOTS]).collect();
                places = distinct(&places, span);
            }
            let inner = places.len().checked_sub(1)?;
            let knots = places.get(1..inner).filter(|knots| !knots.is_empty())?.to_vec();
            let pairs = pairs.swap_remove(&name).unwrap_or_default();
            let spread = Spread::of_knots(name, knots, span).with_pairs(pairs);
            Some(spread.with_levels(levels).with_alike(alike))
        })
        .collect()
}

/// Inputs whose values go in proportion with some values, either way: what is commanded and what is read of
/// it. Of angles the difference counts, or the sum, which does not jump where one begins anew.
fn alike(own: &(bool, Vec<f64>), all: &IndexMap<String, (bool, Vec<f64>)>) -> Vec<String> {
    let go_together = |other: &(bool, Vec<f64>)| {
        let pairs = || own.1.iter().copied().zip(other.1.iter().copied());
        let left = match own.0 && other.0 {
            true => {
                let whole = scatter(pairs().map(|(a, _)| (a.cos(), a.sin())));
                let left = |sign: f64| {
                    scatter(pairs().map(|(a, b)| ((a - sign * b).cos(), (a - sign * b).sin())))
                };
                left(1.0).min(left(-1.0)) / whole
            }
            false => {
                let (a, b) = (mean(pairs().map(|pair| pair.0)), mean(pairs().map(|pair| pair.1)));
                let product = mean(pairs().map(|(x, y)| (x - a) * (y - b)));
                let squares = scatter(pairs().map(|(x, _)| (x, 0.0)))
                    * scatter(pairs().map(|(_, y)| (y, 0.0)));
                1.0 - product * product / squares
            }
        };
        left < ALIKE
    };
    // Inputs with gaps of their own have no pairs.
    let is_whole = |other: &(bool, Vec<f64>)| own.1.len() == other.1.len();
    let found = all.iter().filter(|(_, other)| is_whole(other) && go_together(other));
    found.map(|(name, _)| name.clone()).collect()
}

fn mean(of: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = of.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
    sum / count
}

/// Mean square distance of points from their mean.
fn scatter(of: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let (x, y) = (mean(of.clone().map(|one| one.0)), mean(of.clone().map(|one| one.1)));
    mean(of.map(|one| (one.0 - x).powi(2) + (one.1 - y).powi(2)))
}

/// For each of some inputs that have few places the pairs with those of the inputs behind it, where there are
/// more of them than places of either and most were visited several times: what comes back with a pair is no
/// noise, and of what was done once nothing does.
fn pairs(all: &IndexMap<String, (bool, Vec<f64>)>) -> IndexMap<String, Vec<Pairs>> {
    let few = |(name, (_, values)): (&String, &(bool, Vec<f64>))| {
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        let places = distinct(&sorted, sorted.last()? - sorted.first()?);
        let at = |value: &f64| places.partition_point(|place| place <= value).saturating_sub(1);
        let at: Vec<usize> = values.iter().map(at).collect();
        (3..=MOST_PLACES).contains(&places.len()).then_some((name.clone(), places, at))
    };
    let few: Vec<(String, Vec<f64>, Vec<usize>)> = all.iter().filter_map(few).collect();
    let of = |(number, (name, places, at)): (usize, &(String, Vec<f64>, Vec<usize>))| {
        let pair = |(other, theirs, there): &(String, Vec<f64>, Vec<usize>)| {
            let mut visits: BTreeMap<[usize; 2], usize> = BTreeMap::new();
            let mut last = None;
            for here in at.iter().zip(there).map(|(own, other)| [*own, *other]) {
                if last.replace(here) != Some(here) {
                    *visits.entry(here).or_default() += 1;
                }
            }
            let mut counts: Vec<usize> = visits.values().copied().collect();
            counts.sort_unstable();
            let is_more = visits.len() > places.len().max(theirs.len());
            let is_visited =
                counts.get(counts.len() / 2).is_some_and(|own| *own >= VISITS_OF_A_LEVEL);
            // Inputs with gaps of their own have no pairs.
            let is_whole = at.len() == there.len();
            (is_whole && is_more && is_visited && visits.len() <= MOST_LEVELS).then(|| Pairs {
                other: other.clone(),
                places: [places.clone(), theirs.clone()],
                visited: visits.into_keys().collect(),
            })
        };
        (name.clone(), few[number + 1..].iter().filter_map(pair).collect())
    };
    few.iter().enumerate().map(of).collect()
}

/// The places among values in order that go over a span.
fn distinct(sorted: &[f64], span: f64) -> Vec<f64> {
    let mut places = sorted.to_vec();
    places.dedup_by(|a, b| (*a - *b).abs() <= SAME_PLACE * span);
    places
}

/// Places that are too many for knots, where each has several of so many readings: none else. Of more than
/// `MOST_LEVELS` the middles of parts of the span, where these are wanted.
fn levels(places: &[f64], readings: usize, parts: impl FnOnce() -> Vec<f64>) -> Vec<f64> {
    if places.len() > MOST_LEVELS {
        return parts();
    }
    let is_read_again = readings >= READINGS_OF_A_LEVEL * places.len();
    if places.len() > MOST_PLACES && is_read_again { places.to_vec() } else { Vec::new() }
}

/// The middles of `MOST_LEVELS` equal parts of a span, where most of those that are visited have several visits:
/// what comes back with the place is no noise, and of what passes once nothing does.
fn parts(in_order: Vec<f64>, (first, span): (f64, f64)) -> Vec<f64> {
    let part = span / MOST_LEVELS as f64;
    let (mut last, mut visits) = (f64::NEG_INFINITY, [0_usize; MOST_LEVELS]);
    for place in in_order.into_iter().map(|value| (value - first) / part) {
        // What scatters about the edge of two parts visits neither anew.
        if (place - last).abs() > 1.0 {
            last = place.floor() + 0.5;
            visits[(place as usize).min(MOST_LEVELS - 1)] += 1;
        }
    }
    let mut visited: Vec<usize> = visits.into_iter().filter(|one| *one > 0).collect();
    visited.sort_unstable();
    if visited.len() <= MOST_PLACES || visited[visited.len() / 2] < VISITS_OF_A_LEVEL {
        return Vec::new();
    }
    (0..MOST_LEVELS).map(|at| first + (at as f64 + 0.5) * part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Marks in rows and columns are pairs where they are visited again; those of one visit, and those of which
    /// each has a place of its own on either axis, are none.
    #[test]
    fn pairs_are_those_that_are_visited_again() {
        let of = |rounds: u32, at: fn(u32) -> [u32; 2]| {
            let marks = || (0..rounds).flat_map(|_| (0..12).map(at));
            let axis = |k: usize| (false, marks().map(|mark| f64::from(mark[k])).collect());
            let all = [("x", axis(0)), ("y", axis(1))].map(|(name, one)| (name.to_owned(), one));
            let found = pairs(&all.into_iter().collect());
            found["x"].iter().map(|one| one.visited.len()).collect::<Vec<_>>()
        };
        assert_eq!(of(4, |mark| [mark % 4, mark / 4]), [12]);
        assert!(of(1, |mark| [mark % 4, mark / 4]).is_empty());
        assert!(of(4, |mark| [mark, 11 - mark]).is_empty());
    }

    /// A way to and fro has parts; what goes on, and comes back to some parts alone, has none.
    #[test]
    fn parts_are_those_that_are_visited_again() {
        let passes = (0..600).map(|row| f64::from(row % 200).min(f64::from(200 - row % 200)));
        assert_eq!(parts(passes.collect(), (0.0, 100.0)).len(), MOST_LEVELS);
        let jogging = (0..600).map(|row| f64::from(row % 5) * 4.0);
        let on = (0..400).map(|row| 0.25 * f64::from(row));
        assert!(parts(jogging.chain(on).collect(), (0.0, 100.0)).is_empty());
    }
}
