//! A convention on more samples, from where a quick look ended.

use crate::engine::{Point, Problem};
use crate::estimate::minima::better_start;
use crate::estimate::minima::clocks::Clock;
use crate::graph::Kind;

use super::applied::Suspected;
use super::sequence::{Score, Sequence};
use super::suspect::Suspect;
use super::trimmed::{Trimmed, trimmed_fit};
use super::units::{BETTER_NEARBY, nearby_factors};
use super::{GOOD, ITERATIONS, OPPOSITE};

/// Some samples, and how well they fit.
#[derive(Clone)]
pub(super) struct Looked {
    pub(super) problem: Problem,
    /// Where the fit ended.
    pub(super) point: Point,
    /// Without outliers.
    pub(super) variance_factor: f64,
    /// With them.
    pub(super) of_all: f64,
    /// Relative to how far readings were stretched by what was set right last.
    pub(super) score: Score,
}

impl Looked {
    /// The fit from a start, with what was set right.
    pub(super) fn at(
        problem: Problem,
        start: &Point,
        sequence: Option<&Sequence<'_>>,
    ) -> Option<Self> {
        let Trimmed { whole, fit, kept } = trimmed_fit(&problem, start.clone(), ITERATIONS[2])?;
        let variance_factor = fit.variance_factor;
        let score = sequence.map_or(Score::of(variance_factor), |one| one.score(&kept, &fit));
        let of_all = whole.variance_factor;
        Some(Self { problem, point: fit.point, variance_factor, of_all, score })
    }

    /// Scalars and vectors that have the other sign in another fit of the same parameters.
    pub(super) fn opposite(&self, other: &Self) -> Vec<String> {
        let layout = &self.problem.layout;
        let is_opposite = |index: &usize| {
            let one = &layout.instances[*index];
            let size = |sign: f64| -> f64 {
                let [own, other] = [self, other].map(|fit| fit.point.values[*index]);
                own.iter().zip(other).take(3).map(|(a, b)| (a + sign * b).powi(2)).sum()
            };
            one.kind != Kind::Rotation && !one.unit.is_angle() && size(1.0) < OPPOSITE * size(-1.0)
        };
        let all = (0..layout.instances.len()).filter(is_opposite);
        let mut names: Vec<String> =
            all.map(|index| layout.instances[index].name.clone()).collect();
        // Instances of one parameter stand together.
        names.dedup();
        names
    }

    /// Whether a convention that multiplies numbers leaves a bad fit, and a factor beside it a better
    /// one: then it is not what was mistaken. `first` are the numbers as they were read.
    pub(super) fn is_another_factor(&self, first: &Problem, sequence: &Sequence<'_>) -> bool {
        if self.variance_factor < GOOD {
            return false;
        }
        let is_better = |sequence: Sequence<'_>| {
            let fit = Self::at(sequence.applied(first)?, &self.point, Some(&sequence))?;
            Some(BETTER_NEARBY * fit.variance_factor < self.variance_factor)
        };
        sequence.places().any(|(place, suspect)| {
            let Suspect::Columns(own) = suspect else { return false };
            nearby_factors(own.convention).iter().any(|convention| {
                let other = Suspect::Columns(Suspected { convention, ..own.clone() });
                is_better(sequence.clone().replaced(place, other)) == Some(true)
            })
        })
    }

    /// The same with another start, if one fits far better: clocks that were compared with the
    /// numbers misread may be farther apart.
    pub(super) fn improved(mut self) -> Self {
        if self.variance_factor <= GOOD {
            return self;
        }
        let clocks = Clock::all(&self.problem);
        let [clock] = clocks.as_slice() else { return self };
        let found = better_start(&self.problem, clock).map(|(_, found)| found.variance_factors[1]);
        self.variance_factor =
            found.map_or(self.variance_factor, |one| one.min(self.variance_factor));
        self
    }
}
