//! Terms of a budget: columns with a price. A library effect, a basis block and whatever else may
//! explain the gap are terms of the same form.

use std::collections::BTreeSet;

use crate::diagnose::evidence::columns::shows;
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::library::place::Place;
use crate::diagnose::library::variant::Variant;

use super::sums::Sums;
use crate::diagnose::price::Gain;

/// A linear combination of columns.
pub type Combination = Vec<(usize, f64)>;

/// A column of a candidate that has one value for each run: which candidate, and which of its
/// parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Base {
    /// The candidate.
    pub candidate: usize,
    /// Which of its signatures.
    pub signature: usize,
}

/// A change found beside a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// What changes: its first column.
    pub base: Base,
    /// How many columns of the candidate change together: one, but for those along axes and for a form over a
    /// covariate.
    pub width: usize,
    /// Index of the run among all, and the first sample after the change.
    pub at: (usize, usize),
    /// The sample of that run before which it ends; `None` if it goes on to the end of the campaign.
    pub end: Option<usize>,
    /// What it takes off chi squared.
    pub gain: Gain,
    /// Moments that were tried.
    pub members: usize,
}

/// Samples of a stretch at least: fewer are outliers.
pub const LEAST_STRETCH: usize = 8;

impl Change {
    /// Whether it is another one in nearly the same samples: the two together would be outliers at their
    /// ends.
    pub fn is_near(&self, other: &Self) -> bool {
        let near = |a: usize, b: usize| a.abs_diff(b) < LEAST_STRETCH;
        let is_same_end = match (self.end, other.end) {
            (Some(own), Some(other)) => near(own, other),
            (own, other) => own == other,
        };
        let place = |one: &Self| (one.base, one.at, one.end);
        self.base == other.base
            && self.at.0 == other.at.0
            && near(self.at.1, other.at.1)
            && is_same_end
            && place(self) != place(other)
    }

    /// What its columns are, one after the other.
    pub fn bases(&self) -> impl Iterator<Item = Base> + use<> {
        let first = self.base;
        (0..self.width).map(move |own| Base { signature: first.signature + own, ..first })
    }

    /// Keeps of changes, best first, the first of each value from a moment on and in a stretch, and
    /// so many at most.
    pub fn keep_one_of_a_kind(all: &mut Vec<Self>, most: usize) {
        let mut known = BTreeSet::new();
        all.retain(|one| known.insert((one.base, one.end.is_some())));
        all.truncate(most);
    }
}

/// Columns with a price.
#[derive(Clone, Debug)]
pub struct Term {
    /// Index of its candidate.
    pub candidate: usize,
    /// Name.
    pub name: String,
    /// Its columns.
    pub columns: Vec<Combination>,
    /// Members of its family that were tried.
    pub members: usize,
    /// Log prior odds against the other terms of its kind.
    pub ln_prior: f64,
    /// Where it sits, if it is no effect of the library but a basis block: an unmodelled effect as a
    /// free function of a covariate.
    pub place: Option<Place>,
    /// The change at a moment that it is, if it is one.
    pub change: Option<Change>,
    /// Whether it is in the fit: its columns are among the nominal ones.
    pub in_fit: bool,
    /// The block of which it is what rows leave, if it is that.
    pub reduced_from: Option<usize>,
    /// The relaxed form that it has, if it is not the library's.
    pub variant: Option<Variant>,
    /// Relaxed forms that it may take.
    pub variants: Vec<Variant>,
    /// Whether it is an effect of the user's own.
    pub is_own: bool,
    /// Whether it may enter a model: a block that was reduced beside rows may not.
    pub may_enter: bool,
}

impl Term {
    /// A term of no candidate, one among equals.
    pub fn new(name: String, place: Option<Place>, columns: Vec<Combination>) -> Self {
        Self {
            candidate: usize::MAX,
            name,
            columns,
            members: 1,
            ln_prior: 0.0,
            place,
            change: None,
            in_fit: false,
            reduced_from: None,
            variant: None,
            variants: Vec::new(),
            is_own: false,
            may_enter: true,
        }
    }

    /// Whether it is an effect of the library.
    pub fn is_effect(&self) -> bool {
        self.place.is_none()
    }

    /// The change that its column was appended for, if it was.
    pub fn appended(&self) -> Option<&Change> {
        self.change.as_ref().filter(|_| !self.in_fit)
    }

    /// Whether it is a form over a covariate in a run, and no other value.
    pub fn is_form_in_run(&self) -> bool {
        self.change.is_some() && !self.place.as_ref().is_some_and(Place::is_of_runs)
    }

    /// How many values it has; where they sum to zero there are fewer columns.
    pub fn values(&self) -> usize {
        let columns: BTreeSet<usize> = self.columns.iter().flatten().map(|one| one.0).collect();
        columns.len()
    }

    /// Whether it has a value for each run.
    pub fn is_of_runs(&self) -> bool {
        self.change.is_none() && self.place.as_ref().is_some_and(Place::is_of_runs)
    }

    /// The term of a candidate that is not in the fit.
    pub fn of(sums: &Sums, number: usize, candidate: &Candidate, members: usize) -> Self {
        let of_effect = candidate.place.is_none();
        let is_shown = |column: &usize| {
            let measurands = 0..sums.readings.len();
            let square = measurands.map(|own| sums.product_in(own, *column, *column)).sum();
            !of_effect || shows(square, sums.typical_of(*column))
        };
        let own = sums.of_candidate[number].iter().copied();
        let own: Vec<usize> = own.filter(is_shown).collect();
        let columns = if candidate.sums_to_zero() && own.len() > 1 {
            let key = |column: &usize| {
                let owner = &sums.owners[column - sums.nominal];
                (owner.parameter.as_str(), owner.component)
            };
            let mut own = own;
            own.sort_by(|a, b| key(a).cmp(&key(b)));
            own.chunk_by(|a, b| key(a) == key(b)).flat_map(contrasts).collect()
        } else {
            own.into_iter().map(|column| vec![(column, 1.0)]).collect()
        };
        let place = candidate.place.clone();
        Self {
            candidate: number,
            members,
            may_enter: !place.as_ref().is_some_and(Place::is_of_a_parameter),
            ..Self::new(candidate.name.clone(), place, columns)
        }
    }
}

/// A model without one of its terms.
pub fn without(model: &[usize], term: usize) -> Vec<usize> {
    model.iter().copied().filter(|own| *own != term).collect()
}

/// Combinations of columns whose coefficients sum to zero, orthonormal (Helmert).
fn contrasts(columns: &[usize]) -> Vec<Combination> {
    let helmert = |k: usize| {
        let norm = ((k * (k + 1)) as f64).sqrt();
        let mut one: Combination = columns[..k].iter().map(|c| (*c, 1.0 / norm)).collect();
        one.push((columns[k], -(k as f64) / norm));
        one
    };
    (1..columns.len()).map(helmert).collect()
}
