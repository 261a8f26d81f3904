//! A convention on few samples, before it is compared on more.

use crate::engine::Point;
use crate::estimate::minima::starts::Attitudes;
use crate::estimate::minima::thinned::{Thinned, Tried};
use crate::estimate::start::start;

use super::sequence::{Score, Sequence};
use super::trimmed::{Trimmed, trimmed_fit};
use super::{ITERATIONS, STARTS};

/// A convention on few samples, from several attitudes.
pub(super) struct Quick {
    /// Relative to how far readings were stretched.
    pub(super) score: Score,
    pub(super) point: Point,
}

impl Quick {
    /// `None` where the model has no values.
    pub(super) fn of(few: &Thinned, sequence: Option<&Sequence<'_>>) -> Option<Self> {
        let stands = few.late_by(0.0, &[])?;
        let problem = match sequence {
            Some(sequence) => sequence.applied(&stands)?,
            None => stands,
        };
        let attitudes = Attitudes::of(&problem);
        let begin = start(&problem).0;
        let fit = |point: Point, iterations| Tried::fit(problem.clone(), point, 0.0, iterations);
        let mut all: Vec<Tried> = (0..attitudes.count())
            .filter_map(|attitude| {
                let mut point = begin.clone();
                attitudes.apply(attitude, &mut point);
                fit(point, ITERATIONS[0])
            })
            .collect();
        all.sort_by(|a, b| a.variance_factor.total_cmp(&b.variance_factor));
        let further = all
            .iter()
            .take(STARTS)
            .map(|one| trimmed_fit(&problem, one.point.clone(), ITERATIONS[1]));
        let Trimmed { fit: best, kept, .. } = further
            .flatten()
            .min_by(|a, b| a.fit.variance_factor.total_cmp(&b.fit.variance_factor))?;
        let stands = Score::of(best.variance_factor);
        let score = sequence.map_or(stands, |sequence| sequence.score(&kept, &best));
        Some(Self { score, point: best.point })
    }
}
