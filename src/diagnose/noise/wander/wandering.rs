//! What a walk would do to the readings: of which course it is, and what of it is left beyond
//! something known.

use crate::diagnose::evidence::{Entry, Evidence, Owner, Projected};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::Candidate;

use super::course::{Course, Steps, Times, number_of};
use super::variance::{Scores, Walk};

/// The signatures of a walk, and of all that may be known beside it.
pub(super) struct Wandering {
    /// The pass over the readings, with an entry for each thing that may be known.
    pub(super) evidence: Evidence,
    /// The columns of the walk beyond the nominal parameters.
    pub(super) own: Projected,
    /// Of what independent steps the walk is made, by its course.
    steps: Vec<(Course, Steps)>,
    /// Logarithm of the share of false alarms.
    pub(super) level: f64,
}

/// A walk of the likeliest course.
pub(super) struct Likeliest {
    pub(super) course: Course,
    pub(super) walk: Walk,
    /// Logarithm of its likelihood ratio.
    pub(super) likelihood: f64,
}

impl Wandering {
    /// Of columns beside what may be known. `None` where a walk whose runs begin anywhere does not
    /// show: of most campaigns that is all one needs to know.
    pub(super) fn of(
        fitted: &Fitted,
        beside: &[&Candidate],
        columns: &Candidate,
        times: &Times,
        level: f64,
    ) -> Option<Self> {
        let all: Vec<&Candidate> = beside.iter().copied().chain([columns]).collect();
        let fit = &fitted.fit;
        let (evidence, own) = Evidence::beside(&fitted.problem, &fit.normal, &fit.point, &all)?;
        let anywhere = Steps::of(&own, times, Course::Anywhere);
        if Scores::of(&own.score, &own.left, &anywhere)?.ln_p() > level {
            return None;
        }
        let others = times.other_courses(own.owners().len());
        let others = others.into_iter().map(|course| (course, Steps::of(&own, times, course)));
        // Last, for of courses that are as likely the last is taken.
        let steps = others.chain([(Course::Anywhere, anywhere)]).collect();
        Some(Self { evidence, own, steps, level })
    }

    /// What is left of the walk beyond something known, by its course.
    fn left(&self, known: &Entry) -> impl Iterator<Item = (Course, Scores)> {
        self.steps.iter().filter_map(move |(course, steps)| {
            Some((*course, Scores::beyond(&self.evidence, known, &self.own, steps)?))
        })
    }

    /// The walk of the likeliest course beyond something known, if anything of one is left.
    pub(super) fn beyond(&self, known: &Entry) -> Option<Likeliest> {
        self.left(known)
            .map(|(course, scores)| {
                let walk = Walk::of(scores);
                Likeliest { course, likelihood: walk.likelihood(), walk }
            })
            .filter(|one| one.likelihood.is_finite())
            .max_by(|a, b| a.likelihood.total_cmp(&b.likelihood))
    }

    /// Whether nothing of the walk shows beyond something known, whatever its course.
    pub(super) fn is_gone(&self, known: &Entry) -> bool {
        self.left(known).all(|(_, scores)| scores.ln_p() > self.level)
    }

    /// All that the walk may do in a run.
    pub(super) fn course_of(&self, run: usize) -> Entry {
        self.evidence.tied(&self.own, |_, other| other == run)
    }

    /// One displacement along each of the walk's axes, the same in some of the runs.
    pub(super) fn displacement(&self, is_displaced: impl Fn(usize) -> bool) -> Entry {
        let begins = |owner: &Owner| number_of(&owner.parameter) == 0;
        self.evidence.tied(&self.own, |owner, run| begins(owner) && is_displaced(run))
    }
}
