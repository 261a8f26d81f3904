//! Whether a convention was mistaken, where the model fits badly: the order of a quaternion's
//! components, an inverse pose, swapped columns, a mirrored axis, a sign, a unit, a turn by 90°; and
//! the order of a model's turns.
//!
//! [`mistaken`] reads the logged numbers as each convention of the library has it, and puts turns in
//! other orders, fits some of the samples from several attitudes, and names what fits far better than
//! the numbers as they stand, from as many starts; readings that a convention makes smaller are judged
//! by their relative scatter. Where one run alone does not fit, its numbers alone are read so. It does
//! not change the problem: what to type is part of the answer.
//!
//! | file | answers |
//! |---|---|
//! | `channels` | which numbers are vectors, quaternions and poses |
//! | `applied` | the numbers as a convention has them |
//! | `unit_length` | numbers whose values show that they have no unit |
//! | `units` | other units than those that are stated |
//! | `composed` | two conventions for one number |
//! | `sequence` | one after the other, for whatever numbers |
//! | `turns` | products of turns in another order, about other axes, the other way |
//! | `one_run` | the run that does not fit beside the others |
//! | `periods` | angles whose period nobody stated |
//! | `residuals` | conventions that the readings do not bear out as they stand |
//! | `next` | what fits best of all that may be set right |
//! | `set_right` | one convention after the other, or two together |
//! | `quick`, `looked` | a convention on few samples, and on more |
//! | `trimmed` | fits that a few outliers do not bend |
//! | `streams` | streams smoothed as they are where a line is typed |
//! | `typed` | the fit that the line to type makes |
//! | `suspect` | what may have been mistaken, of either kind |

use crate::campaign::loaded::HeadUnit;
use crate::convention::{Convention, Form};
use crate::engine::{Part, Point, Problem};
use crate::estimate::minima::thinned::Thinned;
use crate::estimate::start::start;
use crate::graph::Kind;
use crate::units::Dimension;

mod applied;
mod channels;
mod composed;
mod looked;
mod next;
mod one_run;
mod periods;
mod quick;
mod residuals;
mod sequence;
mod set_right;
mod streams;
mod suspect;
mod trimmed;
mod turns;
mod typed;
mod unit_length;
mod units;

use applied::Suspected;
use channels::Channels;
use composed::composed;
use looked::Looked;
use one_run::run_that_does_not_fit;
use periods::with_periods;
use set_right::{set_right, set_two_right};
use suspect::Suspect;
pub use turns::ChangedFormula;
use turns::Reordered;
use unit_length::of_unit_length;
use units::other_units;

/// Samples on which each convention is tried, and on which the best are compared.
const SAMPLES: [usize; 2] = [120, 4_000];
/// Iterations of each.
const ITERATIONS: [usize; 3] = [4, 30, 60];
/// A variance factor with which no convention is asked for.
const GOOD: f64 = 4.0;
/// A variance factor beyond which two conventions are tried together where neither helps by itself.
const VERY_BAD: f64 = 100.0;
/// How many times better a convention must fit: at all, and where it fits well then and no file
/// states the unit that it doubts.
const BETTER: [f64; 2] = [25.0, 4.0];
/// Conventions that fit up to so many times worse than the best are listed with it.
const ALIKE: f64 = 1.5;
/// Variance factor from which a convention set right is not all that is wrong.
const DOUBTFUL: f64 = 30.0;
/// Starts of a convention that are fitted further.
const STARTS: usize = 3;
/// A parameter has the other sign where its sum is so small a part of its difference, squared.
const OPPOSITE: f64 = 0.01;
/// Mistaken conventions that are looked for, one on top of the other.
const MOST: usize = 2;

/// A convention that was mistaken, or several together.
#[derive(Clone, Debug)]
pub struct Mistaken {
    /// What was mistaken for what, each with the numbers for which it was.
    pub what: Vec<Instead>,
    /// Others that fit about as well in place of the last: the readings do not tell them apart.
    pub alike: Vec<Instead>,
    /// A parameter without whose stated value the numbers fit about as well as they stand.
    pub stated: Option<String>,
    /// The run in whose files alone it was; `None` for all runs.
    pub run: Option<String>,
    /// What each number is, as a formula of the columns as they were read.
    pub columns: Vec<(String, String)>,
    /// Numbers whose unit the header of a file states.
    pub in_headers: Vec<String>,
    /// The model's formulas that are to be changed.
    pub formulas: Vec<ChangedFormula>,
    /// Variance factors of all readings: as the numbers stand, and of the fit that the line to type
    /// makes.
    pub variance_factors: [f64; 2],
    /// The same without the samples that are outliers beside these fits.
    pub without_outliers: [f64; 2],
    /// How many conventions were tried, with each of the numbers or formulas to which they may apply.
    pub tried: usize,
    /// How many more there are.
    pub not_tried: usize,
}

impl Mistaken {
    /// Whether something else is wrong beside it, or in its place.
    pub fn is_doubtful(&self) -> bool {
        self.without_outliers[1] > DOUBTFUL
    }

    /// Whether a fit with this variance factor, of the numbers as they stand, is about as good.
    pub fn is_as_good_as(&self, variance_factor: f64) -> bool {
        variance_factor < (ALIKE * self.without_outliers[1]).max(GOOD)
    }

    /// Nothing was.
    fn none(stands: &Looked) -> Self {
        Self {
            what: Vec::new(),
            alike: Vec::new(),
            stated: None,
            run: None,
            columns: Vec::new(),
            in_headers: Vec::new(),
            formulas: Vec::new(),
            variance_factors: [stands.of_all; 2],
            without_outliers: [stands.variance_factor; 2],
            tried: 0,
            not_tried: 0,
        }
    }
}

/// A convention and the numbers to which it was applied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instead {
    /// The convention's name.
    pub name: String,
    /// What is mistaken for what.
    pub title: String,
    /// The model's names of the numbers, or of the formulas.
    pub numbers: Vec<String>,
    /// Of one that fits as well as another: parameters that have the other sign there.
    pub opposite: Vec<String>,
}

/// The conventions with which a problem fits far better, from its start or from where a fit of it
/// ended; `None` where it fits well as it is, or none helps.
pub fn mistaken(
    problem: &Problem,
    fitted: Option<&Point>,
    conventions: &[Convention],
) -> Option<Mistaken> {
    let first = problem.parts.first()?;
    let heads: Vec<&HeadUnit> = problem.parts.iter().flat_map(|part| &part.head_units).collect();
    let whole = Thinned::of(&with_periods(problem), SAMPLES[1]);
    let numbers = whole.late_by(0.0, &[])?;
    let channels = Channels::of(&first.system.assembly.names, &heads, &of_unit_length(&numbers));
    // A convention belongs to files: several campaigns of one model are read alike.
    let names = |part: &Part| -> Vec<(String, Dimension)> {
        let names = &part.system.assembly.names;
        let read = names.measurands.iter().map(|one| (one.name.clone(), one.unit.dimension));
        let logged = names.inputs.iter().map(|one| (one.name.clone(), one.unit.dimension));
        read.chain(logged).collect()
    };
    if problem.parts.iter().any(|part| names(part) != names(first)) {
        return None;
    }
    let units = channels.units();
    let of_form = |form| other_units(form, &channels.heads(form), &units, conventions);
    let others = [Form::Number, Form::Vector].map(of_form).concat();
    let conventions: Vec<&Convention> = conventions.iter().chain(&others).collect();
    let mut not_tried = 0;
    let mut read: Vec<Suspected<'_>> = Vec::new();
    for convention in conventions.iter().copied() {
        let (all, more) = channels.for_convention(convention);
        read.extend(all.into_iter().map(|channels| Suspected { convention, channels, only: None }));
        not_tried += more;
    }
    let turns = Reordered::all(&first.system.assembly.names).into_iter().map(Suspect::Turns);
    let of_all: Vec<Suspect<'_>> =
        read.iter().cloned().map(Suspect::Columns).chain(turns).collect();
    let problem = numbers;
    let stated = start(&problem).0;
    let fitted = fitted.and_then(|point| with_stated(&problem, point, &stated));
    let begins = [Some(stated), fitted].into_iter().flatten();
    let stands = begins
        .filter_map(|begin| Looked::at(problem.clone(), &begin, None))
        .min_by(|a, b| a.variance_factor.total_cmp(&b.variance_factor))?;
    let mut found = Mistaken::none(&stands);
    let mut odd = run_that_does_not_fit(&problem, stands.variance_factor);
    // Where all the others fit well, no convention of them is mistaken.
    if odd.is_none_or(|(rest, _)| rest >= GOOD) {
        let pairs;
        (found, pairs) = set_right(stands.clone(), [&of_all, &of_all]);
        if found.without_outliers[1] >= GOOD {
            let both = composed(&conventions);
            let both = both.iter().flat_map(|convention| {
                let all = channels.for_convention(convention).0.into_iter();
                all.map(move |channels| Suspected { convention, channels, only: None })
            });
            let both: Vec<Suspect<'_>> = both.map(Suspect::Columns).collect();
            let (other, _) = set_right(stands.clone(), [&both, &of_all]);
            let tried = found.tried + both.len();
            if other.without_outliers[1] * BETTER[0] < found.without_outliers[1] {
                found = other;
            }
            found.tried = tried;
            if found.what.is_empty() {
                let tried = found.tried + pairs.len();
                found = Mistaken { tried, ..set_two_right(&stands, &pairs).unwrap_or(found) };
            }
        }
        odd = odd.filter(|(rest, _)| rest * BETTER[0] < found.without_outliers[1]);
    }
    if let Some((_, only)) = odd {
        read.iter_mut().for_each(|one| one.only = Some(only));
        let of_run: Vec<Suspect<'_>> = read.into_iter().map(Suspect::Columns).collect();
        let before = found.tried;
        (found, _) = set_right(stands, [&of_run, &of_run]);
        found.tried += before;
        found.run = Some(problem.parts[only.part].runs[only.run].name.clone());
    }
    found.not_tried = not_tried;
    let in_headers = heads.iter().filter(|head| head.is_in_header);
    found.in_headers = in_headers.map(|head| head.name.clone()).collect();
    (!found.what.is_empty()).then_some(found)
}

/// Where a fit ended, with the values that are not estimated as they are stated: the fit may have been
/// one in which a wrong one of them was free. `None` where it was one of another model.
fn with_stated(problem: &Problem, fitted: &Point, stated: &Point) -> Option<Point> {
    let count = problem.layout.instances.len();
    let mut point = (fitted.values.len() == count).then(|| fitted.clone())?;
    for index in 0..count {
        let own: Vec<usize> = problem.layout.own_columns(index).map(|(own, _)| own).collect();
        if problem.layout.instances[index].kind == Kind::Rotation {
            if own.is_empty() {
                point.values[index] = stated.values[index];
            }
            continue;
        }
        for component in (0..3).filter(|component| !own.contains(component)) {
            point.values[index][component] = stated.values[index][component];
        }
    }
    Some(point)
}
