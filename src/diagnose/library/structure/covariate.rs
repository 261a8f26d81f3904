//! What unknown structure may be a function of, as terms: what moves, the head, time, setups, runs.

use crate::graph::MeasurandKind;
use crate::model::{InputDeclaration, MeasurandDeclaration, Model};
use crate::units::{Dimension, Unit};

use super::spread::Spread;
use crate::diagnose::library::place::{RUN, SETUP, TIME};

/// Signals, or inputs, that count as few.
pub(super) const FEW: usize = 2;
/// Waves over the reading of a circle.
pub(super) const CIRCLE_ORDERS: usize = 4;
/// The axes of a vector.
pub(super) const AXES: [&str; 3] = ["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"];
/// The covariate of what each run does in its course.
pub(super) const RUN_TIME: &str = "run time";

/// A term and its dimension.
pub(super) type Term = (String, Dimension);

/// A covariate: terms with their dimension, one coefficient each.
#[derive(Clone)]
pub(super) struct Covariate {
    pub(super) name: String,
    /// What it is over, and the same in a phrase.
    pub(super) over: String,
    pub(super) words: String,
    pub(super) terms: Vec<Term>,
    /// Where these are a cosine and a sine of each order of a turn, how many orders.
    pub(super) orders: usize,
    pub(super) scope: &'static str,
    /// The line of the family that the terms name; empty without.
    pub(super) family: String,
}

impl Covariate {
    /// With the same coefficients for all that an instrument does.
    pub(super) fn new(
        name: impl Into<String>,
        terms: impl IntoIterator<Item = (impl Into<String>, Dimension)>,
    ) -> Self {
        let name = name.into();
        let (over, words, family) = (name.clone(), name.clone(), String::new());
        let terms = terms.into_iter().map(|(term, of)| (term.into(), of)).collect();
        Self { name, over, words, terms, orders: 0, scope: "instrument", family }
    }

    /// With coefficients of another scope.
    pub(super) fn per(self, scope: &'static str) -> Self {
        Self { scope, ..self }
    }

    /// The same times the sense in which something moves, and that sense.
    fn by_sense(self, signal: &str) -> Self {
        let sense = sense_of(signal);
        let each = self.terms.iter().map(|(term, of)| (format!("{} * {term}", sense.0), *of));
        let terms: Vec<Term> = std::iter::once(sense.clone()).chain(each).collect();
        Self {
            over: format!("{} by sense", self.over),
            words: format!("{}, of the other sign when it goes back", self.words),
            ..Self::new(format!("{} by sense", self.name), terms).per(self.scope)
        }
    }

    /// Each of its terms along each axis.
    pub(super) fn along_axes(self) -> Self {
        let along =
            |axis| self.terms.iter().map(move |(term, of)| (format!("{term} * {axis}"), *of));
        let terms = AXES.into_iter().flat_map(along).collect();
        Self { terms, ..self }
    }

    fn waves(name: &str, orders: usize) -> Self {
        let terms = (1..=orders).flat_map(|order| wave(&format!("{order} * {name}")));
        Self { orders, ..Self::new(name, terms) }
    }
}

/// A wave as a cosine and a sine.
pub(super) fn wave(phase: &str) -> [Term; 2] {
    ["cos", "sin"].map(|wave| (format!("{wave}({phase})"), Dimension::NONE))
}

/// Something of this dimension and its square.
pub(super) fn powers(name: &str, own: Dimension) -> [Term; 2] {
    [(name.to_owned(), own), (format!("{name}^2"), own * own)]
}

/// The sense in which something moves.
pub(super) fn sense_of(name: &str) -> Term {
    (format!("sign(rate({name}))"), Dimension::NONE)
}

/// The rate of something of this dimension, with a third term, and its acceleration.
fn rates(name: &str, own: Dimension, third: Term) -> [Covariate; 2] {
    let rate = own / Dimension::TIME;
    let terms = [(format!("rate({name})"), rate), (format!("abs(rate({name}))"), rate), third];
    let acceleration = (format!("rate(rate({name}))"), rate / Dimension::TIME);
    [
        Covariate::new(format!("rate of {name}"), terms),
        Covariate::new(format!("acceleration of {name}"), [acceleration]),
    ]
}

/// An input: waves of so many orders over what turns, powers of anything else.
pub(super) fn of_itself(input: &InputDeclaration, orders: usize) -> Covariate {
    if input.unit.is_angle() {
        return Covariate::waves(&input.name, orders);
    }
    Covariate::new(&input.name, powers(&input.name, input.unit.dimension))
}

/// What moves, with waves of so many orders.
pub(super) fn of_motion(model: &Model, orders: usize) -> Vec<Covariate> {
    let (signals, still): (Vec<_>, Vec<_>) = model.inputs.iter().partition(|input| input.signal);
    let mut all: Vec<Covariate> = still.into_iter().map(|one| of_itself(one, orders)).collect();
    for signal in signals {
        let (name, own) = (&signal.name, signal.unit.dimension);
        all.push(of_itself(signal, orders));
        if signal.unit.is_angle() {
            all.push(Covariate::new(format!("turns of {name}"), powers(name, own)));
        }
        all.push(Covariate::new(format!("sense of {name}"), [sense_of(name)]));
        let rate = own / Dimension::TIME;
        all.extend(rates(name, own, (format!("rate({name})^2"), rate * rate)));
    }
    all
}

/// What moves, otherwise one way than the other: waves of so many orders over what turns, a slope
/// and a bend over what goes along a length.
pub(super) fn by_sense(model: &Model, orders: usize) -> Vec<Covariate> {
    let signals = model.inputs.iter().filter(|input| input.signal);
    signals.map(|signal| of_itself(signal, orders).by_sense(&signal.name)).collect()
}

/// A unit as a formula of quantities: a number before `1/m` or `s^2/kg` is none.
fn of_quantities(symbol: &str) -> String {
    let all: Vec<char> = symbol.chars().collect();
    let words = all.chunk_by(|a, b| a.is_alphabetic() == b.is_alphabetic());
    let of = |word: &[char]| -> String {
        let text: String = word.iter().collect();
        if word[0].is_alphabetic() { format!("(1 {text})") } else { text }
    };
    words.map(of).collect()
}

/// A line over an input that bends at some places (SI).
pub(super) fn bent(input: &InputDeclaration, knots: &[f64]) -> Covariate {
    let (name, own) = (&input.name, input.unit.dimension);
    let bend = |knot: &f64| (format!("abs({})", offset_from(input, *knot)), own);
    let terms = std::iter::once((name.clone(), own)).chain(knots.iter().map(bend));
    Covariate { name: format!("bends of {name}"), ..Covariate::new(name, terms) }
}

/// A value of its own for each of many places of an input at which it is read again and again: over what
/// turns as waves up to half their number.
pub(super) fn levels(input: &InputDeclaration, spread: &Spread) -> Covariate {
    let (name, places) = (&input.name, &spread.levels);
    let own = match spread.knots.is_empty() {
        true => Covariate::waves(name, places.len() / 2),
        false => bent(input, &places[1..places.len() - 1]),
    };
    Covariate { name: format!("levels of {name}"), ..own }
}

/// How far an input is from a place (SI).
pub(super) fn offset_from(input: &InputDeclaration, place: f64) -> String {
    let unit = match input.unit.dimension {
        Dimension::NONE => String::new(),
        own => format!(" * {}", of_quantities(&Unit::coherent(own).si_symbol())),
    };
    let sign = if place < 0.0 { '+' } else { '-' };
    format!("{} {sign} {:e}{unit}", input.name, place.abs())
}

/// The reading of a measurand, otherwise one way than the other.
pub(super) fn reading_by_sense(measurand: &MeasurandDeclaration) -> Option<Covariate> {
    let (name, own) = (&measurand.name, measurand.unit.dimension);
    let whole = match measurand.kind {
        MeasurandKind::Rotation => return None,
        MeasurandKind::Angle { .. } => Covariate::waves(name, CIRCLE_ORDERS),
        MeasurandKind::Plain => Covariate::new(name, [(name, own)]),
    };
    Some(whole.by_sense(name))
}

/// What moves, and time, setups and runs.
pub(super) fn of_the_rig(model: &Model, orders: usize) -> Vec<Covariate> {
    let mut all = of_motion(model, orders);
    all.extend([
        over_time(),
        over_campaign(),
        Covariate::new(RUN_TIME, [("run_time", Dimension::TIME)]),
        Covariate::new(SETUP, [("1", Dimension::NONE)]).per("setup"),
        over_runs(),
    ]);
    all
}

/// A value for each run.
pub(super) fn over_runs() -> Covariate {
    Covariate::new(RUN, [("1", Dimension::NONE)]).per("run")
}

/// The course of a setup.
pub(super) fn over_time() -> Covariate {
    Covariate::new(TIME, powers("setup_time", Dimension::TIME)).per("setup")
}

/// The course of a campaign: what drifts goes on while the instrument is put to another place.
fn over_campaign() -> Covariate {
    let own = Covariate::new(TIME, powers("time", Dimension::TIME));
    Covariate { name: "campaign time".to_owned(), ..own }
}

/// A scale of what a measurand of this dimension reads that drifts in the course of a campaign.
pub(super) fn scale_over_campaign(name: &str, own: Dimension) -> Covariate {
    let whole = over_campaign();
    let of_it = |(power, of): &Term| (format!("{power} * {name}"), *of * own);
    Covariate {
        name: format!("scale of {name} over time"),
        words: format!("{TIME} and {name}"),
        terms: whole.terms.iter().map(of_it).collect(),
        ..whole
    }
}

/// Whether few things move: a robot's joints are many.
pub(super) fn few_move(model: &Model) -> bool {
    model.inputs.iter().filter(|input| input.signal).count() <= FEW
}

/// What the head does.
pub(super) fn of_the_head(model: &Model) -> Vec<Covariate> {
    let mut all = Vec::new();
    for measurand in &model.measurands {
        let (name, own) = (&measurand.name, measurand.unit.dimension);
        match measurand.kind {
            MeasurandKind::Rotation => continue,
            MeasurandKind::Angle { .. } => all.push(Covariate::waves(name, CIRCLE_ORDERS)),
            MeasurandKind::Plain => all.push(Covariate::new(name, powers(name, own))),
        }
        all.extend(rates(name, own, sense_of(name)));
    }
    all
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::super::made::blocks_over;
    use super::*;
    use crate::diagnose::library::place::Of;
    use crate::diagnostic::Source;

    /// A bent line is an effect whatever the unit of its input.
    #[test]
    fn a_line_bends_over_inputs_of_all_units() {
        for unit in ["1", "m", "rad", "1/m", "1/(m*s)", "m/N", "degC"] {
            let text = format!(
                "name = \"s\"\ntitle = \"s\"\n[inputs]\nk = {{ unit = \"{unit}\" }}\n\
                 [measurands]\ny = {{ value = 'rate(time)', unit = \"1\" }}\n"
            );
            let model = Model::parse(Source::new("s.toml", text)).unwrap();
            let covariate = bent(&model.inputs[0], &[-11.7, 0.03, 2.0]);
            let of = Of::Measurand("y".to_owned());
            let patch = |sum: &str| format!("y = 'y + {sum}'\n");
            let made = blocks_over(&of, "an error of `y`", &[covariate], &Unit::one(), patch);
            assert_eq!(made.len(), 1, "{unit}");
        }
    }
}
