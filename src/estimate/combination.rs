//! Combinations of parameters that the readings determine although each of them is open.

use nalgebra::DMatrix;

use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::estimate::covariance::of_combination;
use crate::estimate::observability::{Direction, Kind as Exactness};
use crate::estimate::withheld::{TRACE, along, sensitivities};
use crate::graph::Kind;
use crate::units::{Dimension, Unit};

/// Components with a smaller share of a direction are no good partners: their factor is large.
const PARTNER: f64 = 0.1;
/// Combinations of one direction.
const MOST: usize = 3;
/// A combination is worth a line where its uncertainty is below this part of its first term's.
const BETTER: f64 = 0.1;

/// A sum of components with factors.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Name and factor (SI); the first factor is 1.
    pub terms: Vec<(String, f64)>,
    /// SI unit of each factor, `1` where the units are alike.
    pub factor_units: Vec<String>,
    /// Its value, SI.
    pub value: f64,
    /// Its standard uncertainty, SI.
    pub sigma: f64,
    /// Unit in which its first term is declared.
    pub declared: Unit,
}

/// One component that takes part.
struct Part {
    name: String,
    value: f64,
    sensitivity: Vec<(usize, f64)>,
    moved: f64,
    share: f64,
    unit: Unit,
}

/// The combinations of the first component of a direction with each of the next that the direction
/// leaves alone, as far as the readings determine them.
pub fn combinations(
    problem: &Problem,
    point: &Point,
    covariance: &DMatrix<f64>,
    directions: &[Direction],
    at: usize,
) -> Vec<Combination> {
    let parts = parts(problem, point, &directions[at]);
    let [first, others @ ..] = parts.as_slice() else { return Vec::new() };
    let is_exact = |one: &&Direction| one.kind == Exactness::Exact;
    let own = (directions[at].kind == Exactness::UpToNoise)
        .then(|| of_combination(covariance, &first.sensitivity));
    let of_pair = |other: &Part| {
        let factor = -first.moved / other.moved;
        let scaled = other.sensitivity.iter().map(|(column, by)| (*column, factor * by));
        let factors: Vec<(usize, f64)> = first.sensitivity.iter().copied().chain(scaled).collect();
        let moves = |one: &Direction| along(one, &factors).1.abs() > TRACE;
        let is_same = |one: &Direction| std::ptr::eq(one, &directions[at]);
        if directions.iter().filter(is_exact).any(|one| !is_same(one) && moves(one)) {
            return None;
        }
        let variance = of_combination(covariance, &factors).max(0.0);
        if own.is_some_and(|own| variance > BETTER * BETTER * own) || !variance.is_finite() {
            return None;
        }
        let unit = quotient(&first.unit, &other.unit);
        Some(Combination {
            terms: vec![(first.name.clone(), 1.0), (other.name.clone(), factor)],
            factor_units: vec!["1".to_owned(), unit],
            value: first.value + factor * other.value,
            sigma: variance.sqrt(),
            declared: first.unit.clone(),
        })
    };
    let partners = others.iter().filter(|one| one.share >= PARTNER);
    partners.filter_map(of_pair).take(MOST).collect()
}

/// The SI unit of the factor on a second term; `1` where the units are alike.
pub(crate) fn quotient(first: &Unit, other: &Unit) -> String {
    let [of_first, of_other] = [first, other].map(Unit::si_symbol);
    if of_first == of_other {
        return "1".to_owned();
    }
    // Where no angle stays the unit follows from the dimensions; an angle has none.
    if first.has_angle() == other.has_angle() {
        let dimension = first.dimension / other.dimension;
        let is_long = |text: &String| text.contains('(');
        let whole = dimension.to_string();
        if !is_long(&whole) {
            return whole;
        }
        let short = |symbol: String, unit: &Unit| match is_long(&symbol) {
            true => named(unit.dimension).unwrap_or(symbol),
            false => symbol,
        };
        let [of_first, of_other] = [short(of_first, first), short(of_other, other)];
        let is_clear = !of_first.contains('/') && !is_long(&of_other);
        let parts = is_clear.then(|| over(of_first, &of_other));
        return named(dimension).or(parts).unwrap_or(whole);
    }
    over(of_first, &of_other)
}

/// The quotient of two units.
fn over(first: String, other: &str) -> String {
    match other.contains([' ', '/', '*']) {
        _ if other == "1" => first,
        true => format!("{first}/({other})"),
        false => format!("{first}/{other}"),
    }
}

/// The named SI unit of a dimension, or that of which it is the inverse.
fn named(dimension: Dimension) -> Option<String> {
    let of = |dimension: Dimension| {
        let is_of = |unit: &Unit| unit.dimension == dimension;
        NAMED.into_iter().find(|symbol| Unit::parse(symbol).is_ok_and(|unit| is_of(&unit)))
    };
    let inverse = || of(Dimension::NONE / dimension).map(|symbol| over("1".to_owned(), symbol));
    of(dimension).map(str::to_owned).or_else(inverse)
}

/// Named units of SI.
const NAMED: [&str; 7] = ["N", "N m", "W", "Pa", "V", "ohm", "T"];

/// The components that take part in a direction, largest share first.
fn parts(problem: &Problem, point: &Point, direction: &Direction) -> Vec<Part> {
    let layout = &problem.layout;
    let mut parts = Vec::new();
    for (index, instance) in layout.instances.iter().enumerate() {
        // The components of a rotation vector follow a large turn in curves: no sum of them stays.
        if instance.kind == Kind::Rotation {
            continue;
        }
        let values = point.components(layout, index);
        let rows = sensitivities(layout, point, index);
        let names = component_names(problem, index);
        for ((name, value), sensitivity) in names.into_iter().zip(values).zip(rows) {
            let (moved, share) = along(direction, &sensitivity);
            let unit = instance.unit.clone();
            if share.abs() >= PARTNER && moved != 0.0 {
                parts.push(Part { name, value, sensitivity, moved, share: share.abs(), unit });
            }
        }
    }
    // Equal shares keep the order of parameters, whatever their rounding.
    let rounded = |part: &Part| (part.share * 1e6).round();
    parts.sort_by(|a, b| rounded(b).total_cmp(&rounded(a)));
    parts
}

/// The setup or run of an instance, where the parameter has several.
pub fn place_of(problem: &Problem, index: usize) -> Option<&str> {
    let instances = &problem.layout.instances;
    let alike = instances.iter().filter(|one| one.name == instances[index].name).count();
    if alike > 1 { instances[index].of.as_deref() } else { None }
}

/// `radius`, `position.x` ..., with `@` and the setup or run where the parameter has several.
pub fn component_names(problem: &Problem, index: usize) -> Vec<String> {
    let instance = &problem.layout.instances[index];
    let of = place_of(problem, index).map_or_else(String::new, |of| format!("@{of}"));
    match instance.kind {
        Kind::Scalar => vec![format!("{}{of}", instance.name)],
        Kind::Vector | Kind::Rotation => {
            ["x", "y", "z"].map(|axis| format!("{}.{axis}{of}", instance.name)).to_vec()
        }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    #[test]
    fn the_unit_of_a_factor_makes_the_second_term_one_of_the_first() {
        for (first, other, right) in [
            ("mm", "m", "1"),
            ("m", "m/s", "s"),
            ("N", "N/kg", "kg"),
            ("m/s", "N m/s", "1/N"),
            ("1", "W", "1/W"),
            ("K", "W", "K/W"),
            ("hPa", "m", "Pa/m"),
            ("mm", "1", "m"),
            ("1", "mm", "1/m"),
            ("m", "deg", "m/rad"),
            ("deg", "1", "rad"),
            ("rad", "rad/s", "s"),
            ("urad/m", "urad/m^2", "m"),
        ] {
            let [a, b] = [first, other].map(|symbol| Unit::parse(symbol).unwrap());
            assert_eq!(quotient(&a, &b), right, "{first} over {other}");
        }
    }
}
