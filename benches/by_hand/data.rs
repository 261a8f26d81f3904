//! Campaigns of any size, made in memory: the polar instrument on a rotating arm, readings drawn
//! from the model itself.

use std::f64::consts::TAU;
use std::path::Path;

use homepoint::campaign::record::Record;
use homepoint::campaign::{Role, Run, Samples, Track};
use homepoint::diagnostic::Diagnostics;
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Part, Point, Problem};
use homepoint::graph::Scope;
use homepoint::library::Library;
use homepoint::model::Override;
use homepoint::system::System;
use homepoint::units::Unit;

use super::COLUMNS;

/// The effects of the model by hand.
pub(crate) const EFFECTS: [&str; 3] = ["collimation", "vertical_index", "distance_offset"];

/// Standard uncertainties of the readings: rad, rad, m.
pub(crate) const SIGMA: [f64; 3] = [6e-6, 6e-6, 8e-6];

/// Triggers a second.
const TRIGGER: f64 = 40.0;
/// Rates of the runs in turn (deg/s): both senses, fast and slow.
const RATES: [f64; 8] = [190.0, -190.0, 50.0, -50.0, 120.0, -120.0, 5.0, -5.0];

/// A covariance with every element different from zero, of the sizes that estimates have.
pub(crate) fn covariance() -> [[f64; COLUMNS]; COLUMNS] {
    let factor = |i: usize, j: usize| 1e-5 * ((3 * i + 5 * j) as f64).sin();
    let product = |i, j| -> f64 { (0..COLUMNS).map(|k| factor(i, k) * factor(j, k)).sum() };
    let mut covariance = [[0.0; COLUMNS]; COLUMNS];
    for (i, row) in covariance.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = product(i, j) + if i == j { 1e-10 } else { 0.0 };
        }
    }
    covariance
}

/// What a campaign is made of.
#[derive(Clone, Debug)]
pub(crate) struct Plan<'a> {
    /// Samples in all runs together.
    pub(crate) samples: usize,
    /// Runs, of equal length.
    pub(crate) runs: usize,
    /// Setups, of as many runs each; every setup has six unknowns of its own.
    pub(crate) setups: usize,
    /// Effects, by name.
    pub(crate) effects: &'a [&'a str],
    /// Whether every run has delays of its own.
    pub(crate) delays_by_run: bool,
    /// Orientation as a rotation vector (rad).
    pub(crate) orientation: [f64; 3],
    /// Position (m).
    pub(crate) position: [f64; 3],
}

impl Plan<'_> {
    /// One setup, the model by hand: 13 unknowns.
    pub(crate) fn of(samples: usize) -> Self {
        Self {
            samples,
            runs: 8,
            setups: 1,
            effects: &EFFECTS,
            delays_by_run: false,
            orientation: [0.3, 1.2, -0.4],
            position: [0.3, 1.6, 0.2],
        }
    }

    /// The campaign with drawn readings, and the point they were drawn at.
    ///
    /// # Errors
    /// A plan that names effects which do not fit.
    pub(crate) fn make(&self) -> Result<(Problem, Point), Diagnostics> {
        let library = Library::builtin()?;
        let model = library.model("polar_one_rotation", Path::new("."))?;
        let selected =
            self.effects.iter().map(|name| library.select(name)).collect::<Result<Vec<_>, _>>()?;
        let system = System::build(&model, &selected, &self.stated(), &[None])?;
        let setups = (0..self.setups).map(|setup| format!("S{setup}")).collect();
        let part = Part::new(system, setups, self.runs(), SIGMA.to_vec());
        let mut problem = Problem::new(vec![part]);
        let point = self.truth(&problem);
        simulate(&mut problem, &point, 1, true);
        // The weights are made while readings are there.
        Ok((Problem::new(problem.parts), point))
    }

    /// What is said of parameters: start values, the radius with its prior, scopes.
    fn stated(&self) -> Vec<Override> {
        let in_unit = |values: &[f64], symbol: &str| {
            let unit = Unit::parse(symbol).unwrap_or_else(|_| Unit::one());
            Some(values.iter().map(|value| (*value, unit.clone())).collect::<Vec<_>>())
        };
        let named = |name: &str| Override { name: name.to_owned(), ..Override::default() };
        let mut stated = vec![
            Override {
                value: in_unit(&[1.146], "m"),
                sigma: in_unit(&[2e-5], "m"),
                ..named("radius")
            },
            Override { start: in_unit(&self.orientation, "rad"), ..named("orientation") },
            Override { start: in_unit(&self.position, "m"), ..named("position") },
        ];
        if self.delays_by_run {
            for name in ["horizontal.delay", "vertical.delay", "distance.delay"] {
                stated.push(Override { scope: Some(Scope::Run), ..named(name) });
            }
        }
        stated
    }

    /// Delays of milliseconds, effects at their typical sizes, all else as stated.
    fn truth(&self, problem: &Problem) -> Point {
        let mut point = Point::stated(&problem.layout);
        for (value, instance) in point.values.iter_mut().zip(&problem.layout.instances) {
            match instance.name.as_str() {
                "horizontal.delay" => value[0] = 1.2e-3,
                "vertical.delay" => value[0] = 2.1e-3,
                "distance.delay" => value[0] = -0.7e-3,
                _ if instance.setting.value.is_none() => {
                    if let Some(typical) = instance.setting.typical {
                        value[..instance.dimension()].fill(typical);
                    }
                }
                _ => {}
            }
        }
        point
    }

    fn runs(&self) -> Vec<Run> {
        let of_setup = self.runs.div_ceil(self.setups.max(1));
        (0..self.runs)
            .map(|run| {
                let last = run + 1 == self.runs;
                let even = self.samples / self.runs;
                let count = if last { self.samples - even * run } else { even };
                let time: Vec<f64> = (0..count).map(|i| i as f64 / TRIGGER).collect();
                let rate = RATES[run % RATES.len()].to_radians();
                // The encoder counts within one turn.
                let angle = time.iter().map(|t| (rate * t).rem_euclid(TAU)).collect();
                Run {
                    name: format!("R{run}"),
                    setup: run / of_setup,
                    role: Role::Kinematic,
                    record: Record::held(Samples {
                        is_untimed: false,
                        elapsed_time: time.clone(),
                        run_time: time.clone(),
                        setup_time: time.clone(),
                        uniform_time: time.clone(),
                        jump_time: Vec::new(),
                        jump_ends: [0.0; 2],
                        inputs: vec![Track::Captured {
                            value: angle,
                            rate: Some(vec![rate; count]),
                            acceleration: None,
                        }],
                        readings: vec![vec![f64::NAN; count]; 3],
                        rows: (1..=count).collect(),
                        time,
                    }),
                }
            })
            .collect()
    }
}
