//! How a walk goes on, within a run and from run to run: of which independent steps it is made.
//!
//! The columns of a walk are, for each run and axis, where it has come to when the run begins
//! (number 0) and the first sines of its Karhunen-Loève series over the time `T` of the longest
//! run, `σ ξ_k √(2 T) / ((k - ½) π) sin((k - ½) π t / T)`. What is between runs is not seen, and so
//! there are several courses ([`Course`]). Where a walk goes on, what its sines have come to at the
//! end of a run is where all later runs of the setup begin, and so is what it does between runs and
//! what the sines leave out: one step then acts in many columns.

use std::collections::HashMap;
use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use crate::diagnose::evidence::{Owner, Projected};
use crate::engine::Problem;

use super::sequence::{Span, in_order, places, spans};

/// The number of a column by its name; 0 is where the walk has come to when a run begins.
pub(super) fn number_of(parameter: &str) -> u8 {
    parameter.rsplit('_').next().and_then(|number| number.parse().ok()).unwrap_or(0)
}

/// How long walks go on.
#[derive(Clone, Debug)]
pub(super) struct Times {
    /// Sines of each run.
    terms: u8,
    /// Duration of the longest run (s).
    run: f64,
    /// Of the longest setup (s).
    setup: f64,
    /// The place of each run in the order in which runs came.
    places: Vec<usize>,
    legs: Vec<Leg>,
}

/// What a walk does between runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Course {
    /// Each run begins anywhere.
    Anywhere,
    /// Runs of a setup go on from each other.
    GoesOn,
    /// Each run begins where the setup began.
    ComesBack,
}

/// Columns up to which all courses are tried: each costs time that grows with their cube.
const MOST_COLUMNS: usize = 1000;

/// Sines over a setup that a walk has in the model where it goes on: 97 % of its variance.
const OF_SETUP: u8 = 8;

/// A column that a walk has in the model.
#[derive(Clone, Debug)]
pub(super) struct Column {
    /// The end of its name.
    pub(super) name: String,
    /// Scope of its coefficient.
    pub(super) scope: &'static str,
    /// What multiplies the coefficient, ` * ...`; empty for 1.
    pub(super) wave: String,
    /// Standard deviation of the coefficient for a walk of one unit.
    pub(super) deviation: f64,
}

/// The part of a walk that one run sees.
#[derive(Clone, Copy, Debug)]
struct Leg {
    /// Number of the first of the runs that go on from each other.
    chain: usize,
    /// How long it takes (s).
    duration: f64,
    /// Variance of a walk of one unit that is new where the run begins, if it goes on from another
    /// one: what the walk did since that ended, and what sines leave out of that.
    new: Option<f64>,
}

impl Times {
    /// Of the runs of a problem, for walks with so many sines.
    pub(super) fn of(problem: &Problem, terms: u8) -> Self {
        Self::between(&spans(problem), terms)
    }

    fn between(spans: &[Span], terms: u8) -> Self {
        let duration = |span: &Span| span.1.map_or(0.0, |[start, end]| end - start);
        // Recordings whose times begin anew take at least as long as all of them.
        let whole = |setup: usize| -> f64 {
            let own = || spans.iter().filter(|one| one.0 == setup);
            let last = own().filter_map(|one| one.1).map(|[_, end]| end).fold(0.0, f64::max);
            last.max(own().map(duration).sum())
        };
        let order = in_order(spans);
        let alone = |run: usize| Leg { chain: run, duration: duration(&spans[run]), new: None };
        let mut times = Self {
            terms,
            run: spans.iter().map(duration).fold(0.0, f64::max),
            setup: spans.iter().map(|(setup, _)| whole(*setup)).fold(0.0, f64::max),
            places: places(&order),
            legs: (0..spans.len()).map(alone).collect(),
        };
        let mut last: HashMap<usize, usize> = HashMap::new();
        for run in order {
            let (setup, Some([start, _])) = spans[run] else { continue };
            if let Some(before) = last.insert(setup, run)
                && let Some(gap) =
                    spans[before].1.map(|[_, end]| start - end).filter(|gap| *gap >= 0.0)
            {
                times.legs[run].chain = times.legs[before].chain;
                times.legs[run].new = Some(gap + times.left_out(before));
            }
        }
        times
    }

    /// Whether some run goes on from another.
    fn goes_on(&self) -> bool {
        self.legs.iter().any(|leg| leg.new.is_some())
    }

    /// The courses beside [`Course::Anywhere`] that differ from it here; none where there are very
    /// many columns.
    pub(super) fn other_courses(&self, columns: usize) -> Vec<Course> {
        let mut all = vec![Course::ComesBack];
        all.extend(self.goes_on().then_some(Course::GoesOn));
        all.retain(|_| columns <= MOST_COLUMNS);
        all
    }

    /// The columns of a walk that takes a course, each with a coefficient of its own. Steps of one
    /// run that act in later ones are sines over the setup here.
    pub(super) fn columns(&self, course: Course) -> Vec<Column> {
        let wave = |number: u8, time: &str, whole: f64| {
            if number == 0 {
                return String::new();
            }
            format!(" * sin({} Hz * {time})", angle(number) / whole)
        };
        let first = u8::from(course == Course::ComesBack);
        let of_run = (first..=self.terms).map(|number| Column {
            name: number.to_string(),
            scope: "run",
            wave: wave(number, "run_time", self.run),
            deviation: match (number, course) {
                (0, Course::GoesOn) => self.left_of_setup(),
                _ => self.term(number),
            },
        });
        let of_setup = (1..=OF_SETUP).map(|number| Column {
            name: format!("setup_{number}"),
            scope: "setup",
            wave: wave(number, "setup_time", self.setup),
            deviation: share(number, self.setup),
        });
        of_run.chain(of_setup.filter(|_| course == Course::GoesOn)).collect()
    }

    /// Standard deviation of what sines over a setup leave out, on average.
    fn left_of_setup(&self) -> f64 {
        let known = (1..=OF_SETUP).map(|number| angle(number).powi(-2)).sum::<f64>();
        (self.setup * (0.5 - known)).sqrt()
    }

    /// Standard deviation of a coefficient for a walk of one unit, of number 0 if it begins
    /// anywhere.
    fn term(&self, number: u8) -> f64 {
        if number == 0 { (0.5 * self.setup).sqrt() } else { share(number, self.run) }
    }

    /// What a sine has come to when a run ends.
    fn at_end(&self, number: u8, run: usize) -> f64 {
        (angle(number) * self.legs[run].duration / self.run).sin()
    }

    /// Variance that sines leave out at the end of a run.
    fn left_out(&self, run: usize) -> f64 {
        let known = |k| (self.term(k) * self.at_end(k, run)).powi(2);
        (self.legs[run].duration - (1..=self.terms).map(known).sum::<f64>()).max(0.0)
    }
}

/// The independent steps of a walk of one unit: of each the columns in which it acts, and how much.
#[derive(Clone, Debug)]
pub(super) struct Steps(Vec<Vec<(usize, f64)>>);

/// What a column is of.
#[derive(Clone, Copy, Debug)]
struct Own<'a> {
    number: u8,
    axis: (&'a str, usize),
    run: usize,
}

impl Steps {
    /// Of a walk with such columns that takes a course.
    pub(super) fn of(own: &Projected, times: &Times, course: Course) -> Self {
        let columns = own.owners().iter().zip(own.runs());
        let columns: Vec<Own<'_>> = columns.map(|(owner, run)| own_of(owner, run)).collect();
        Self::made(&columns, times, course)
    }

    fn made(columns: &[Own<'_>], times: &Times, course: Course) -> Self {
        let step = |(column, one): (usize, &Own<'_>)| {
            let run = times.legs[one.run];
            let (size, at_end) = match (one.number, course) {
                (0, Course::ComesBack) => return None,
                (0, Course::GoesOn) => (run.new.map_or_else(|| times.term(0), f64::sqrt), 1.0),
                (0, Course::Anywhere) => (times.term(0), 1.0),
                (number, _) => (times.term(number), times.at_end(number, one.run)),
            };
            let goes_on = |(_, other): &(usize, &Own<'_>)| {
                course == Course::GoesOn
                    && other.number == 0
                    && times.places[other.run] > times.places[one.run]
                    && times.legs[other.run].chain == run.chain
                    && other.axis == one.axis
            };
            let after = columns.iter().enumerate().filter(goes_on);
            let after = after.map(|(column, _)| (column, size * at_end));
            Some(std::iter::once((column, size)).chain(after).collect())
        };
        Self(columns.iter().enumerate().filter_map(step).collect())
    }

    /// Scores of the steps from those of columns.
    pub(super) fn scores(&self, of_columns: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(self.0.len(), |j, _| {
            self.0[j].iter().map(|(column, by)| by * of_columns[*column]).sum()
        })
    }

    /// Covariance of the scores from that of columns.
    pub(super) fn covariance(&self, of_columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut across = DMatrix::zeros(of_columns.nrows(), self.0.len());
        for (mut made, of) in across.column_iter_mut().zip(&self.0) {
            for (column, by) in of {
                made.axpy(*by, &of_columns.column(*column), 1.0);
            }
        }
        let mut covariance = DMatrix::zeros(self.0.len(), self.0.len());
        for (column, mut made) in across.column_iter().zip(covariance.column_iter_mut()) {
            for (made, of) in made.iter_mut().zip(&self.0) {
                *made = of.iter().map(|(row, by)| by * column[*row]).sum();
            }
        }
        covariance
    }
}

/// The angle of a sine at the end of what it is a sine over.
fn angle(number: u8) -> f64 {
    (f64::from(number) - 0.5) * PI
}

/// Standard deviation of the coefficient of a sine over so long a time (s) for a walk of one unit.
fn share(number: u8, whole: f64) -> f64 {
    (2.0 * whole).sqrt() / angle(number)
}

fn own_of(owner: &Owner, run: usize) -> Own<'_> {
    let axis = owner.parameter.rsplit_once('_').map_or("", |(axis, _)| axis);
    Own { number: number_of(&owner.parameter), axis: (axis, owner.component), run }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Covariance of columns of a walk of one unit.
    fn covariance(steps: &Steps, columns: usize) -> DMatrix<f64> {
        let mut covariance = DMatrix::zeros(columns, columns);
        for step in &steps.0 {
            for (a, p) in step {
                for (b, q) in step {
                    covariance[(*a, *b)] += p * q;
                }
            }
        }
        covariance
    }

    /// Four runs of setup 0 with another one's between them, the last recorded as if it began anew,
    /// and one without samples.
    const SPANS: [Span; 6] = [
        (0, Some([0.0, 50.0])),
        (1, Some([0.0, 60.0])),
        (0, None),
        (0, Some([55.0, 115.0])),
        (0, Some([115.0, 130.0])),
        (0, Some([0.0, 20.0])),
    ];

    #[test]
    fn a_walk_that_goes_on_has_the_covariance_of_a_walk_where_runs_begin() {
        let times = Times::between(&SPANS, 3);
        let begins = |run| Own { number: 0, axis: ("x", 0), run };
        let sines =
            (0..6).flat_map(|run| (1..=3).map(move |number| Own { number, axis: ("x", 0), run }));
        let columns: Vec<Own<'_>> = (0..6).map(begins).chain(sines).collect();
        let steps = Steps::made(&columns, &times, Course::GoesOn);
        let found = covariance(&steps, columns.len());
        // Where the first run of a chain begins is anywhere.
        let first = 0.5 * times.setup;
        assert_eq!(times.setup, 145.0);
        for (a, b, expected) in [
            (0, 0, first),
            (0, 3, first),
            (3, 3, first + 55.0),
            (3, 4, first + 55.0),
            (4, 4, first + 115.0),
            (1, 1, first),
            (0, 1, 0.0),
            (5, 5, first),
            (4, 5, 0.0),
        ] {
            let found = found[(a, b)];
            assert!((found - expected).abs() < 1e-9, "{a} {b}: {found}, not {expected}");
        }
        let back = covariance(&Steps::made(&columns, &times, Course::ComesBack), columns.len());
        assert_eq!(back.view((0, 0), (6, 6)).norm(), 0.0);
        let last = Times::between(&SPANS[5..], 3);
        assert_eq!(last.other_courses(24), [Course::ComesBack]);
        assert_eq!(last.other_courses(2400), []);
    }

    #[test]
    fn what_stands_in_the_model_has_the_variance_of_a_walk() {
        let times = Times::between(&SPANS[..1], 3);
        let columns = times.columns(Course::GoesOn);
        // On average over the setup, half of its time; a sine squared is a half.
        let of_setup = columns.iter().filter(|one| one.scope == "setup");
        let sines: f64 = of_setup.map(|one| 0.5 * one.deviation.powi(2)).sum();
        let left = columns[0].deviation.powi(2);
        assert!((sines + left - 25.0).abs() < 1e-9 && left < 1.0, "{sines} {left}");
    }
}
