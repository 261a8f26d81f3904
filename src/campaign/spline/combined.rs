//! Curves made of other curves over the same knots.

use crate::campaign::spline::pieces::Pieces;
use crate::campaign::spline::{Smoothing, Spline};

/// Part of a curve's own time constant with which another is drawn through values at its knots.
const FINE: f64 = 0.01;

impl Spline {
    /// Shares its knots with those of another curve, if they are the same.
    pub(crate) fn share_knots(&mut self, other: &Self) {
        if self.origin == other.origin && self.knots == other.knots {
            self.knots = other.knots.clone();
        }
    }

    /// The times of the knots (s).
    pub(crate) fn moments(&self) -> impl Iterator<Item = f64> + '_ {
        self.knots.iter().map(|knot| self.origin + knot)
    }

    /// A constant and a sum of curves with factors; `None` where those with a factor do not share
    /// their knots, or there is none.
    pub(crate) fn sum(constant: f64, terms: &[(f64, &Self)]) -> Option<Self> {
        let used: Vec<&(f64, &Self)> = terms.iter().filter(|(factor, _)| *factor != 0.0).collect();
        let first = used.first()?.1;
        let is_alike = |one: &Self| one.origin == first.origin && one.knots == first.knots;
        if !used.iter().all(|(_, one)| is_alike(one)) {
            return None;
        }
        let pieces: Vec<(f64, &Pieces)> =
            used.iter().map(|(factor, one)| (*factor, &one.pieces)).collect();
        let mut sum = Self { pieces: Pieces::sum(constant, &pieces)?, ..first.clone() };
        sum.raw = match used[..] {
            [(factor, one)] => one.raw.as_ref().map(|raw| raw.scaled(constant, *factor)),
            _ => None,
        };
        sum.scatter = match used[..] {
            [(factor, one)] => one.scatter.map(|[raw, of_knot]| [raw * factor.abs(), of_knot]),
            _ => None,
        };
        for (at, end) in sum.ends.iter_mut().enumerate() {
            *end = constant + used.iter().map(|(factor, one)| factor * one.ends[at]).sum::<f64>();
        }
        Some(sum)
    }

    /// A curve with other values at the knots.
    pub(crate) fn through(&self, values: &[f64]) -> Option<Self> {
        let times: Vec<f64> = self.moments().collect();
        let own = (FINE * self.time_constant).max(f64::MIN_POSITIVE);
        let mut curve = Self::fit(&times, values, Smoothing::TimeConstant(own)).ok()?;
        curve.gaps.clone_from(&self.gaps);
        Some(curve)
    }
}
