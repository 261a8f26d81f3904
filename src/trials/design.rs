//! The campaign as trials need it: at its truth, with the signatures of everything that may be put
//! into it, summed once.
//!
//! The truth of the nominal parameters is a fit of the campaign's own readings, or, of a campaign
//! that is only planned, what it states. From the signatures follow the values that give an effect
//! a wanted `λ`, and which effects are alike.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use nalgebra::DVector;

use crate::campaign::Sample;
use crate::diagnose::evidence::{Entry, Evidence};
use crate::diagnose::library::candidate::{self, Candidate};
use crate::diagnose::library::catalogue::written;
use crate::diagnose::library::offer::offer;
use crate::diagnose::library::wanted::Wanted;
use crate::engine::gram::LeastSquares;
use crate::engine::open::{Opened, Recipe};
use crate::engine::{Point, Problem};
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::calibrate;
use crate::progress::Progress;
use crate::system::Selected;

use super::shapes::{Shape, shapes};

/// Share of the squared length of one signature that lies in another's, from which on the two count
/// as one name.
pub const ALIKE: f64 = 0.98;

/// Why a campaign cannot be tried.
#[derive(Debug, thiserror::Error)]
pub enum DesignError {
    /// The fit of its own readings cannot be built on.
    #[error(
        "the campaign's own readings do not determine the values from which trials would be drawn; `homepoint calibrate` says what is missing"
    )]
    NotDetermined,
    /// Its values, as stated, leave its parameters undetermined.
    #[error(
        "readings of this campaign would not determine the model's parameters, whatever they are; `homepoint check` says more"
    )]
    Undetermined,
    /// The fit failed.
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// Something that may be put into a campaign.
#[derive(Clone, Debug)]
pub struct Cause {
    /// The effect, with its head; of a shape the name of the shape.
    pub name: String,
    /// The effects of the library that it may be called; none of a shape without counterpart.
    pub names: Vec<String>,
    /// Whether the library holds it in this very form.
    pub in_library: bool,
    /// Its members, by their number among the design's ways.
    ways: Vec<usize>,
}

/// A cause of a certain size and direction.
#[derive(Clone, Debug)]
pub struct Dose {
    /// The cause.
    pub cause: Cause,
    /// Length of its signature, in units of the noise.
    pub lambda: f64,
    /// Its member, among the design's ways.
    way: usize,
    /// What is put into the model.
    pub selected: Selected,
    /// Its values: parameter, component, of which setup or run, value (SI).
    pub values: Vec<(String, usize, Option<String>, f64)>,
    /// Direction of its signature, of unit length.
    direction: DVector<f64>,
}

/// A campaign, ready for trials.
#[derive(Debug)]
pub struct Design {
    /// The campaigns with their runs; readings are replaced by drawn ones.
    pub problem: Problem,
    /// From what their models were put together.
    pub recipes: Vec<Recipe>,
    /// The nominal parameters' true values.
    pub truth: Point,
    /// Whether the campaign has no readings of its own: then all are drawn.
    pub planned: bool,
    /// What may be put in.
    pub causes: Vec<Cause>,
    /// Effects on the noise.
    pub noise: Vec<Candidate>,
    /// What the diagnosis may use: everything that has been made of the models so far.
    pub wanted: Wanted,
    ways: Vec<Candidate>,
    evidence: Evidence,
    alike: Mutex<HashMap<(String, String), bool>>,
}

impl Design {
    /// Looks at a campaign.
    ///
    /// # Errors
    /// Where nothing can be drawn or diagnosed from it.
    pub fn new(opened: Opened) -> Result<Self, DesignError> {
        let Opened { mut problem, recipes, .. } = opened;
        problem.progress = Progress::default();
        let planned = problem.reading_count() == 0;
        let truth = if planned {
            Point::stated(&problem.layout)
        } else {
            let found = calibrate(problem.clone(), &Options::default())?;
            if !found.is_sound() {
                return Err(DesignError::NotDetermined);
            }
            found.fit.point
        };
        let mut full = problem.clone();
        if planned {
            crate::engine::simulate::simulate(&mut full, &truth, 0, true);
        }
        full.reweight(&truth);
        let offer = offer(&recipes).of_runs(&recipes, &full);
        let mut ways = offer.effects;
        let library = ways.len();
        let foreign = shapes();
        for shape in &foreign {
            ways.extend(fitting(shape, &recipes));
        }
        let all: Vec<&Candidate> = ways.iter().collect();
        let evidence = Evidence::new(&full, &full.normal(&truth), &truth, &all)
            .ok_or(DesignError::Undetermined)?;
        let causes = causes(&ways, &evidence, library, &foreign);
        Ok(Self {
            problem,
            recipes,
            truth,
            planned,
            causes,
            noise: offer.noise,
            wanted: Wanted::default(),
            ways,
            evidence,
            alike: Mutex::default(),
        })
    }

    /// A cause with values drawn about zero, in proportion to their usual sizes, and then scaled to
    /// a length of its signature. `member` (from 0 to 1) says which of a family, `chance` gives
    /// normal numbers.
    pub fn dose(
        &self,
        cause: &Cause,
        lambda: f64,
        member: f64,
        chance: &mut dyn FnMut() -> f64,
    ) -> Dose {
        let count = cause.ways.len();
        let way = cause.ways[((member * count as f64) as usize).min(count - 1)];
        let (candidate, entry) = (&self.ways[way], &self.evidence.entries[way]);
        let drawn = DVector::from_iterator(
            entry.owners.len(),
            entry
                .owners
                .iter()
                .map(|owner| candidate.typical(&owner.parameter).unwrap_or(1.0) * chance()),
        );
        let signature = &entry.lengths * &drawn;
        let length = signature.norm();
        let by = if length > 0.0 { lambda / length } else { 0.0 };
        let values = entry.owners.iter().zip(drawn.iter()).map(|(owner, value)| {
            (owner.parameter.clone(), owner.component, owner.of.clone(), by * value)
        });
        Dose {
            cause: cause.clone(),
            lambda,
            way,
            selected: candidate.selected.clone(),
            values: values.collect(),
            direction: if length > 0.0 { signature / length } else { signature },
        }
    }

    /// Share of the squared length of a dose's signature that an effect of the library explains.
    pub fn share(&self, dose: &Dose, name: &str) -> f64 {
        let truth = &self.evidence.entries[dose.way];
        self.members(name)
            .map(|entry| (self.evidence.overlap(entry, truth) * &dose.direction).norm_squared())
            .fold(0.0, f64::max)
    }

    /// Squared cosine between the signatures of two doses.
    pub fn alike_parts(&self, a: &Dose, b: &Dose) -> f64 {
        let (one, other) = (&self.evidence.entries[a.way], &self.evidence.entries[b.way]);
        let cosine = a.direction.dot(&(self.evidence.overlap(one, other) * &b.direction));
        cosine * cosine
    }

    /// Whether an effect of the library counts as the name of a dose.
    pub fn is_named(&self, dose: &Dose, name: &str) -> bool {
        dose.cause.names.iter().any(|own| own == name || self.are_alike(own, name))
            || (!dose.cause.names.is_empty() && self.share(dose, name) >= ALIKE)
    }

    /// The effects of the library to withhold so that nothing in it can be told from a dose.
    pub fn like(&self, dose: &Dose) -> Vec<String> {
        let known = self.causes.iter().filter(|one| one.in_library);
        known
            .filter(|one| {
                let own = dose.cause.names.iter();
                own.clone().any(|name| *name == one.name)
                    || own.clone().any(|name| self.are_alike(name, &one.name))
                    || self.share(dose, &one.name) >= ALIKE
            })
            .map(|one| self.ways[one.ways[0]].selected.effect.name.clone())
            .collect()
    }

    /// Whether two effects of the library are alike: all that a member of one can do, some member
    /// of the other can.
    pub fn are_alike(&self, a: &str, b: &str) -> bool {
        if a == b {
            return true;
        }
        let key = if a < b { (a.to_owned(), b.to_owned()) } else { (b.to_owned(), a.to_owned()) };
        let known = |this: &Self| {
            let table = this.alike.lock().unwrap_or_else(PoisonError::into_inner);
            table.get(&key).copied()
        };
        if let Some(known) = known(self) {
            return known;
        }
        let found = self.members(a).any(|one| {
            self.members(b).any(|other| {
                let fewer = one.degrees().min(other.degrees()).max(1);
                self.evidence.overlap(one, other).norm_squared() >= ALIKE * fewer as f64
            })
        });
        self.alike.lock().unwrap_or_else(PoisonError::into_inner).insert(key, found);
        found
    }

    fn members(&self, name: &str) -> impl Iterator<Item = &Entry> {
        let of = self.causes.iter().filter(move |one| one.in_library && one.name == name);
        of.flat_map(|one| &one.ways).map(|way| &self.evidence.entries[*way])
    }

    /// A number that tells designs apart: of models and effects as written, times, inputs, noise
    /// and what may be put in.
    pub fn stamp(&self) -> u64 {
        let mut stamp = Stamp(0xcbf2_9ce4_8422_2325);
        self.recipes.iter().for_each(|recipe| stamp.bytes(written(recipe).as_bytes()));
        for way in &self.ways {
            stamp.bytes(way.name.as_bytes());
            way.selected.member.values().for_each(|value| stamp.number(*value));
        }
        for part in &self.problem.parts {
            part.sigma.iter().for_each(|sigma| stamp.number(*sigma));
            for run in &part.runs {
                stamp.bytes(run.name.as_bytes());
                run.record.walk(|stretch| {
                    stretch.each().for_each(|sample| stamp.sample(&sample));
                });
            }
        }
        self.truth.values.iter().flatten().for_each(|value| stamp.number(*value));
        stamp.0
    }
}

/// Fowler, Noll and Vo's hash, which is the same everywhere.
struct Stamp(u64);

impl Stamp {
    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Time and inputs of a sample, and which of its readings there are.
    fn sample(&mut self, sample: &Sample<'_>) {
        let time = sample.time();
        self.number(time);
        for input in &sample.samples.inputs {
            (0..=2).for_each(|order| self.number(input.at(sample.at, time, 0.0, order)));
        }
        let readings = sample.samples.readings.iter();
        self.bytes(&readings.map(|one| u8::from(one[sample.at].is_nan())).collect::<Vec<u8>>());
    }

    /// To nine digits: values from a fit may differ in the last ones from machine to machine.
    fn number(&mut self, value: f64) {
        self.bytes(format!("{value:.8e}").as_bytes());
    }
}

/// A shape as a candidate, where it fits a campaign.
fn fitting(shape: &Shape, recipes: &[Recipe]) -> Option<Candidate> {
    let selected = Selected {
        effect: shape.effect.clone(),
        head: None,
        member: std::collections::BTreeMap::new(),
    };
    candidate::fitting(recipes, &selected, None)
}

/// Everything of which something is left beyond the nominal parameters, members of a family
/// together.
fn causes(
    ways: &[Candidate],
    evidence: &Evidence,
    library: usize,
    foreign: &[Shape],
) -> Vec<Cause> {
    let mut causes: Vec<Cause> = Vec::new();
    for (number, (way, entry)) in ways.iter().zip(&evidence.entries).enumerate() {
        if entry.degrees() == 0 || !entry.finite {
            continue;
        }
        if let Some(known) = causes.iter_mut().find(|known| known.name == way.name) {
            known.ways.push(number);
            continue;
        }
        let in_library = number < library;
        let shape = foreign.iter().find(|shape| shape.effect.name == way.name);
        let names = match shape {
            Some(shape) if !in_library => {
                shape.names.iter().map(|name| (*name).to_owned()).collect()
            }
            _ => vec![way.name.clone()],
        };
        causes.push(Cause { name: way.name.clone(), names, in_library, ways: vec![number] });
    }
    causes
}
