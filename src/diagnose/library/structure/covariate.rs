//! What unknown structure may be a function of: what moves, what the head does, time, setups and
//! runs, as terms with one coefficient each.

use crate::graph::MeasurandKind;
use crate::model::{InputDeclaration, MeasurandDeclaration, Model};
use crate::units::{Dimension, Unit};

use crate::diagnose::library::place::RUN;

/// Signals, or inputs, that count as few.
pub(super) const FEW: usize = 2;
/// Waves over the reading of a circle.
pub(super) const CIRCLE_ORDERS: usize = 4;
/// The covariate of what a setup does in its course.
const TIME: &str = "time";
/// The covariate of what each run does in its course.
const RUN_TIME: &str = "run time";

/// A covariate: terms with their dimension, one coefficient each.
#[derive(Clone)]
pub(super) struct Covariate {
    pub(super) name: String,
    /// What it is over, and the same in a phrase.
    pub(super) over: String,
    pub(super) words: String,
    pub(super) terms: Vec<(String, Dimension)>,
    pub(super) scope: &'static str,
    /// The line of the family that the terms name; empty without.
    pub(super) family: String,
}

impl Covariate {
    fn new(name: impl Into<String>, scope: &'static str, terms: Vec<(String, Dimension)>) -> Self {
        let name = name.into();
        let (over, words, family) = (name.clone(), name.clone(), String::new());
        Self { name, over, words, terms, scope, family }
    }

    /// Waves of one of the orders that a line says, by its name.
    pub(super) fn family(angle: &str, order: &str, family: String) -> Self {
        Self {
            over: angle.to_owned(),
            words: format!("{angle}, {{member}} waves a turn"),
            family,
            ..Self::new(format!("fine {angle}"), "instrument", wave(&format!("{order} * {angle}")))
        }
    }

    /// Waves over a length, of one of the numbers a metre that a line says, by its name.
    pub(super) fn ripple(length: &str, number: &str, family: String) -> Self {
        Self {
            over: length.to_owned(),
            words: format!("{length}, {{member}} waves a metre"),
            family,
            ..Self::new(
                format!("fine {length}"),
                "instrument",
                wave(&format!("2 * pi * {number} * {length}")),
            )
        }
    }

    /// Waves over a setup of one of the periods that a line says, by its name.
    pub(super) fn swing(period: &str, family: String) -> Self {
        let phase = format!("2 * pi * setup_time / {period}");
        Self {
            over: TIME.to_owned(),
            words: format!("{TIME}, a wave every {{member}} s"),
            family,
            ..Self::new("slow time", "setup", wave(&phase))
        }
    }

    /// What comes to rest after each run begins, in the same way or by the sense in which any of
    /// some signals moves, in one of the times that a line says, by its name.
    pub(super) fn settling(time: &str, signals: &[&str], family: String) -> Self {
        let rest = format!("exp(-(run_time / {time}))");
        let by_sense = signals.iter().map(|signal| format!("sign(rate({signal})) * {rest}"));
        let terms = std::iter::once(rest.clone()).chain(by_sense);
        Self {
            over: RUN_TIME.to_owned(),
            words: format!("{RUN_TIME}, coming to rest in {{member}} s"),
            family,
            ..Self::new(
                format!("rest in {RUN_TIME}"),
                "instrument",
                terms.map(|term| (term, Dimension::NONE)).collect(),
            )
        }
    }

    /// The same times the sense in which something moves, and that sense.
    fn by_sense(self, signal: &str) -> Self {
        let sense = format!("sign(rate({signal}))");
        let each = self.terms.iter().map(|(term, of)| (format!("{sense} * {term}"), *of));
        let terms = [(sense.clone(), Dimension::NONE)].into_iter().chain(each).collect();
        Self {
            over: format!("{} by sense", self.over),
            words: format!("{}, of the other sign when it goes back", self.words),
            ..Self::new(format!("{} by sense", self.name), self.scope, terms)
        }
    }

    /// Each of its terms along each axis.
    pub(super) fn along_axes(self) -> Self {
        let axes = ["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"];
        let along =
            |axis| self.terms.iter().map(move |(term, of)| (format!("{term} * {axis}"), *of));
        let terms = axes.into_iter().flat_map(along).collect();
        Self { terms, ..self }
    }

    /// The acceleration of something, of whose rate this is the dimension.
    fn acceleration(name: &str, rate: Dimension) -> Self {
        let term = (format!("rate(rate({name}))"), rate / Dimension::TIME);
        Self::new(format!("acceleration of {name}"), "instrument", vec![term])
    }

    fn waves(name: &str, orders: usize) -> Self {
        let pair = |order: usize| wave(&format!("{order} * {name}"));
        Self::new(name, "instrument", (1..=orders).flat_map(pair).collect())
    }
}

/// A wave as a cosine and a sine.
fn wave(phase: &str) -> Vec<(String, Dimension)> {
    ["cos", "sin"].map(|wave| (format!("{wave}({phase})"), Dimension::NONE)).to_vec()
}

/// An input: waves of so many orders over what turns, powers of anything else.
pub(super) fn of_itself(input: &InputDeclaration, orders: usize) -> Covariate {
    let (name, own) = (&input.name, input.unit.dimension);
    if turns(&input.unit) {
        return Covariate::waves(name, orders);
    }
    let powers = vec![(name.clone(), own), (format!("{name}^2"), own * own)];
    Covariate::new(name.clone(), "instrument", powers)
}

/// What moves, with waves of so many orders.
pub(super) fn of_motion(model: &Model, orders: usize) -> Vec<Covariate> {
    let mut all = Vec::new();
    all.extend(model.inputs.iter().filter(|one| !one.signal).map(|one| of_itself(one, orders)));
    for signal in model.inputs.iter().filter(|input| input.signal) {
        let (name, own) = (&signal.name, signal.unit.dimension);
        let rate = own / Dimension::TIME;
        let angle = turns(&signal.unit);
        if angle {
            all.push(Covariate::waves(name, orders));
        }
        let turns = vec![(name.clone(), own), (format!("{name}^2"), own * own)];
        all.push(Covariate::new(
            if angle { format!("turns of {name}") } else { name.clone() },
            "instrument",
            turns,
        ));
        all.push(Covariate::new(
            format!("sense of {name}"),
            "instrument",
            vec![(format!("sign(rate({name}))"), Dimension::NONE)],
        ));
        all.push(Covariate::new(
            format!("rate of {name}"),
            "instrument",
            vec![
                (format!("rate({name})"), rate),
                (format!("abs(rate({name}))"), rate),
                (format!("rate({name})^2"), rate * rate),
            ],
        ));
        all.push(Covariate::acceleration(name, rate));
    }
    all
}

/// What moves, otherwise one way than the other: waves of so many orders over what turns, a slope
/// and a bend over what goes along a length.
pub(super) fn by_sense(model: &Model, orders: usize) -> Vec<Covariate> {
    let signals = model.inputs.iter().filter(|input| input.signal);
    signals.map(|signal| of_itself(signal, orders).by_sense(&signal.name)).collect()
}

/// A line over an input that bends at some places (SI).
pub(super) fn bent(input: &InputDeclaration, knots: &[f64]) -> Covariate {
    let (name, own) = (&input.name, input.unit.dimension);
    let unit = if own == Dimension::NONE {
        String::new()
    } else {
        format!(" {}", Unit::coherent(own).si_symbol())
    };
    let mut terms = vec![(name.clone(), own)];
    let bend = |knot: &f64| {
        let sign = if *knot < 0.0 { '+' } else { '-' };
        (format!("abs({name} {sign} {:e}{unit})", knot.abs()), own)
    };
    terms.extend(knots.iter().map(bend));
    Covariate {
        over: name.clone(),
        words: name.clone(),
        ..Covariate::new(format!("bends of {name}"), "instrument", terms)
    }
}

/// The reading of a measurand, otherwise one way than the other.
pub(super) fn reading_by_sense(measurand: &MeasurandDeclaration) -> Option<Covariate> {
    let (name, own) = (&measurand.name, measurand.unit.dimension);
    let whole = match measurand.kind {
        MeasurandKind::Rotation => return None,
        MeasurandKind::Angle { .. } => Covariate::waves(name, CIRCLE_ORDERS),
        MeasurandKind::Plain => Covariate::new(name, "instrument", vec![(name.clone(), own)]),
    };
    Some(whole.by_sense(name))
}

/// What moves, and time, setups and runs.
pub(super) fn of_the_rig(model: &Model, orders: usize) -> Vec<Covariate> {
    let mut all = of_motion(model, orders);
    all.push(over_time());
    all.push(over_campaign());
    let run_time = vec![("run_time".to_owned(), Dimension::TIME)];
    all.push(Covariate::new(RUN_TIME, "instrument", run_time));
    all.push(Covariate::new("setup", "setup", vec![("1".to_owned(), Dimension::NONE)]));
    all.push(over_runs());
    all
}

/// A value for each run.
pub(super) fn over_runs() -> Covariate {
    Covariate::new(RUN, "run", vec![("1".to_owned(), Dimension::NONE)])
}

/// The course of a setup.
pub(super) fn over_time() -> Covariate {
    let powers =
        [("setup_time", Dimension::TIME), ("setup_time^2", Dimension::TIME * Dimension::TIME)];
    let powers = powers.map(|(power, dimension)| (power.to_owned(), dimension));
    Covariate::new(TIME, "setup", powers.to_vec())
}

/// The course of a campaign: what drifts goes on while the instrument is put to another place.
fn over_campaign() -> Covariate {
    let powers = [("time", Dimension::TIME), ("time^2", Dimension::TIME * Dimension::TIME)];
    let powers = powers.map(|(power, dimension)| (power.to_owned(), dimension));
    let own = Covariate::new("campaign time", "instrument", powers.to_vec());
    Covariate { over: TIME.to_owned(), words: TIME.to_owned(), ..own }
}

/// A scale of what a measurand of this dimension reads that drifts in the course of a campaign.
pub(super) fn scale_over_campaign(name: &str, own: Dimension) -> Covariate {
    let whole = over_campaign();
    let of_it = |(power, of): &(String, Dimension)| (format!("{power} * {name}"), *of * own);
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

/// Whether a signal of this unit is an angle.
pub(in crate::diagnose) fn turns(unit: &Unit) -> bool {
    unit.dimension == Dimension::NONE && unit.symbol != "1"
}

/// What the head does.
pub(super) fn of_the_head(model: &Model) -> Vec<Covariate> {
    let mut all = Vec::new();
    for measurand in &model.measurands {
        let (name, own) = (&measurand.name, measurand.unit.dimension);
        let rate = own / Dimension::TIME;
        match measurand.kind {
            MeasurandKind::Rotation => continue,
            MeasurandKind::Angle { .. } => all.push(Covariate::waves(name, CIRCLE_ORDERS)),
            MeasurandKind::Plain => all.push(Covariate::new(
                name,
                "instrument",
                vec![(name.clone(), own), (format!("{name}^2"), own * own)],
            )),
        }
        all.push(Covariate::new(
            format!("rate of {name}"),
            "instrument",
            vec![
                (format!("rate({name})"), rate),
                (format!("abs(rate({name}))"), rate),
                (format!("sign(rate({name}))"), Dimension::NONE),
            ],
        ));
        all.push(Covariate::acceleration(name, rate));
    }
    all
}
