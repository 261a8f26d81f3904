//! What two quantities do together: products of two inputs, and loads by the sense of a motion.

use crate::model::{InputDeclaration, MeasurandDeclaration, Model};
use crate::units::Dimension;

use super::covariate::{Covariate, Term, offset_from, powers, sense_of, wave};
use super::directions;
use super::spread::{Pairs, Spread};

/// Inputs of which products are looked at, at most.
const MOST_TOGETHER: usize = 4;
/// Angles of which products of waves are looked at, at most, and the orders of these.
const MOST_TURNING: usize = 3;
const ORDERS_TOGETHER: [usize; 2] = [1, 2];
/// Pairs of inputs with a value for each pair of their places at most.
const MOST_OF_PAIRS: usize = 3;
/// Loads by senses of a reading at most.
const MOST_LOADS: usize = 12;

/// Loads by the sense of motion, for a reading that is one itself: what a gear, a seal or a bearing loses
/// grows with the force, the torque, the pressure or the current that goes through it. Senses are those
/// of rates that are inputs, and those in which signals move. None of models with many of both.
pub(super) fn loads_by_sense(model: &Model, of: &MeasurandDeclaration) -> Vec<Covariate> {
    if !of.unit.dimension.is_of_a_load() {
        return Vec::new();
    }
    let is_rate = |input: &InputDeclaration| {
        let way = input.unit.dimension * Dimension::TIME;
        [Dimension::NONE, Dimension::LENGTH].contains(&way)
    };
    let inputs = model.inputs.iter().map(|input| (&input.name, input.unit.dimension));
    let loads = inputs.filter(|one| one.1.is_of_a_load()).chain([(&of.name, of.unit.dimension)]);
    let loads: Vec<(&String, Dimension)> = loads.collect();
    let mut all = Vec::new();
    for moves in &model.inputs {
        let sense = match is_rate(moves) {
            true => format!("sign({})", moves.name),
            false if moves.signal && !moves.unit.dimension.is_of_a_load() => {
                sense_of(&moves.name).0
            }
            false => continue,
        };
        for (name, own) in &loads {
            let terms = [(*name).clone(), format!("abs({name})")];
            let terms = terms.map(|term| (format!("{sense} * {term}"), *own));
            let of = if is_rate(moves) { "" } else { "the rate of " };
            let moves = &moves.name;
            all.push(Covariate {
                words: format!("{name}, direction-dependent (sign of {of}{moves})"),
                ..Covariate::new(format!("{name} by sense of {moves}"), terms)
            });
        }
    }
    if all.len() > MOST_LOADS { Vec::new() } else { all }
}

/// A value of its own for each pair of places of two inputs that were visited several times, such as marks on
/// a plate.
pub(super) fn of_pairs(model: &Model, spreads: &[Spread]) -> Vec<Covariate> {
    let declared = |name: &str| model.inputs.iter().find(|one| one.name == name);
    let of = |own: &Spread| -> Vec<Covariate> {
        let covariate = |Pairs { other, places, visited }: &Pairs| {
            let (first, second) = (declared(&own.input)?, declared(other)?);
            let at = |&[one, two]: &[usize; 2]| {
                let both = [within(first, &places[0], one), within(second, &places[1], two)];
                (both.join(" * "), Dimension::NONE)
            };
            let over = format!("{} and {other} together", own.input);
            let name = format!("pairs of {} and {other}", own.input);
            Some(Covariate { name, ..Covariate::new(over, visited.iter().map(at)) })
        };
        own.pairs.iter().filter_map(covariate).collect()
    };
    spreads.iter().flat_map(of).take(MOST_OF_PAIRS).collect()
}

/// One where an input is nearer to one of some places (SI, in order) than to the others, else zero.
fn within(input: &InputDeclaration, places: &[f64], at: usize) -> String {
    let edge = |first: usize| {
        let middle = 0.5 * (places.get(first)? + places.get(first + 1)?);
        Some(format!("sign({})", offset_from(input, middle)))
    };
    let from = at.checked_sub(1).and_then(edge).unwrap_or_else(|| "1".to_owned());
    let to = edge(at).unwrap_or_else(|| "(-1)".to_owned());
    format!("(({from} - {to}) / 2)")
}

/// Products of two inputs: powers from the middle of where values lie, and waves over what turns. What
/// each of both does by itself is mostly no part of it.
pub(super) fn products(model: &Model, spreads: &[Spread]) -> Vec<Covariate> {
    if model.inputs.len() > MOST_TOGETHER {
        return Vec::new();
    }
    let spread = |input: &InputDeclaration| spreads.iter().find(|known| known.input == input.name);
    let factor = |input: &InputDeclaration| -> Option<Vec<Term>> {
        let (name, own) = (&input.name, input.unit.dimension);
        let knots = &spread(input)?.knots;
        Some(match knots.get(knots.len() / 2) {
            Some(middle) => powers(&format!("({})", offset_from(input, *middle)), own).to_vec(),
            None => (1..=2).flat_map(|order| wave(&format!("{order} * {name}"))).collect(),
        })
    };
    let turns =
        |input: &InputDeclaration| spread(input).is_some_and(|known| known.knots.is_empty());
    let inputs = model.inputs.iter().filter_map(|one| Some((one, factor(one)?)));
    let inputs: Vec<(&InputDeclaration, Vec<Term>)> = inputs.collect();
    let mut all = Vec::new();
    // A target is displaced over each angle, and pairs of many joints are too many.
    let are_few = inputs.iter().filter(|one| turns(one.0)).count() <= MOST_TURNING;
    let is_looked_at = are_few && directions(model).is_empty();
    for (number, (first, left)) in inputs.iter().enumerate() {
        let is_alike = |other: &InputDeclaration| {
            spread(first).is_some_and(|own| own.alike.contains(&other.name))
        };
        for (second, right) in inputs[..number].iter().filter(|other| !is_alike(other.0)) {
            let turning = [first, second].iter().filter(|one| turns(one)).count();
            if turning > 1 {
                let both = spread(second).zip(spread(first)).filter(|_| is_looked_at);
                all.extend(both.into_iter().flat_map(|(one, other)| of_angles(one, other)));
                continue;
            }
            let product = |(k, (one, own)): (usize, &Term)| {
                // Squares of both are too much of a power.
                let others = right.iter().take(if turning == 0 && k > 0 { 1 } else { right.len() });
                let of_both = |(other, of): &Term| (format!("{one} * {other}"), *own * *of);
                others.map(of_both).collect::<Vec<_>>()
            };
            let terms = left.iter().enumerate().flat_map(product);
            let name = format!("{} and {} together", second.name, first.name);
            all.push(Covariate::new(name, terms));
        }
    }
    all
}

/// Products of waves over two angles, of one order each: together they would cost more than a small error
/// gains. A wave that is mostly a constant is without it, for times that a wave over the other angle alone
/// would be one of both.
fn of_angles(first: &Spread, second: &Spread) -> Vec<Covariate> {
    let over = format!("{} and {} together", first.input, second.input);
    let mut all = Vec::new();
    for one in ORDERS_TOGETHER {
        for other in ORDERS_TOGETHER {
            let right = without_constants(second, other);
            let of_both = |left: String| {
                let product = |right: &String| (format!("{left} * {right}"), Dimension::NONE);
                right.iter().map(product).collect::<Vec<Term>>()
            };
            let terms = without_constants(first, one).into_iter().flat_map(of_both);
            let name = format!("{over} {one} {other}");
            all.push(Covariate { name, ..Covariate::new(&over, terms) });
        }
    }
    all
}

/// A wave over an angle without what of it is constant where its values lie.
fn without_constants(spread: &Spread, order: usize) -> [String; 2] {
    let constants = spread.constants(order);
    let waves = wave(&format!("{order} * {}", spread.input));
    std::array::from_fn(|at| match constants[at] {
        Some(mean) if mean < 0.0 => format!("({} + {:e})", waves[at].0, -mean),
        Some(mean) => format!("({} - {mean:e})", waves[at].0),
        None => waves[at].0.clone(),
    })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use crate::diagnostic::Source;

    fn products_of(inputs: &[&str], quantities: &str) -> Vec<Covariate> {
        let lines: String =
            inputs.iter().map(|name| format!("{name} = {{ unit = \"rad\" }}\n")).collect();
        let text = format!(
            "name = \"head\"\ntitle = \"Head\"\n[inputs]\n{lines}[quantities]\n{quantities}\n\
             [measurands]\ny = {{ value = 'rate(time)', unit = \"1\" }}\n"
        );
        let model = Model::parse(Source::new("head.toml", text)).unwrap();
        let values: Vec<f64> = (-10..=10).map(|step| 0.1 * f64::from(step)).collect();
        let spread = |name: &&str| Spread::of_angle((*name).to_owned(), &values, 2.0);
        products(&model, &inputs.iter().map(spread).collect::<Vec<_>>())
    }

    /// What turns has waves of the other one's; of a target and of many joints none.
    #[test]
    fn two_angles_have_products_of_waves() {
        let two = products_of(&["a", "c"], "");
        let names: Vec<&str> = two.iter().map(|one| one.name.as_str()).collect();
        let due = ["1 1", "1 2", "2 1", "2 2"].map(|orders| format!("a and c together {orders}"));
        assert_eq!(names, due);
        assert!(two.iter().all(|one| one.words == "a and c together" && one.terms.len() == 4));
        let target = "target = '[cos(a) * 1 m, sin(c) * 1 m, 0 m]'";
        assert!(products_of(&["a", "c"], target).is_empty());
        assert!(products_of(&["a", "b", "c", "d"], "").is_empty());
        assert_eq!(products_of(&["a", "b", "c"], "").len(), 12);
    }

    /// Over a part of a turn the mean of a cosine is taken off it, and no wave over the other angle alone is
    /// left in the product.
    #[test]
    fn waves_over_a_part_of_a_turn_are_about_their_means() {
        let first = &products_of(&["a", "c"], "")[0].terms[0].0;
        let mean = (-10..=10).map(|step| (0.1 * f64::from(step)).cos()).sum::<f64>() / 21.0;
        assert!(first.starts_with(&format!("(cos(1 * a) - {mean:e})")), "{first}");
    }
}
