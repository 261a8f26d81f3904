//! Streams that are the four components of one quaternion: made continuous before each becomes a
//! curve.
//!
//! `q` and `−q` are the same rotation, and most programs log the one whose scalar part is not
//! negative: where the sign leaps a curve through the components would turn by 360° within one
//! interval. Which streams belong together the model says: `quaternion(a, b, c, d)` of inputs.
//! Rows of no length are no rotation and are left out; where the attitude leaps away and back
//! (markers of motion capture that are confused, a board seen the wrong way up) so are the rows
//! between. Components that lie in different files stay as they are.

use crate::campaign::declared::RunEntry;
use crate::campaign::header::TIME;
use crate::campaign::loader::Loader;
use crate::campaign::spline::mean_spacing;
use crate::campaign::table::Table;
use crate::diagnostic::Diagnostic;
use crate::formula::{Expression, ExpressionKind, Function};
use crate::model::Model;
use crate::quaternion::Quaternion;

/// Length below which a quaternion is no rotation.
const NO_ROTATION: f64 = 1e-3;
/// How far the length of a quaternion may be off 1: digits are cut off in logs.
const OFF_LENGTH: f64 = 0.01;
/// The least leap (rad), and how many times what the rows beside it turn in the same time.
const LEAP: (f64, f64) = (0.35, 8.0);
/// Steps on either side of one with which it is compared.
const BESIDE: usize = 8;
/// The largest part of all rows that can be bursts; else it is not known which rows are right.
const MOST_BURSTS: f64 = 0.3;
/// Ranges of rows that a message lists.
const MOST_RANGES: usize = 40;

/// The inputs of a model that are the components of one quaternion.
pub(crate) fn quaternions(model: &Model) -> Vec<[String; 4]> {
    let is_input = |name: &str| model.inputs.iter().any(|input| input.name == name);
    let mut all: Vec<[String; 4]> = Vec::new();
    for formula in model.formulas() {
        formula.root.visit(&mut |expression| {
            let ExpressionKind::Call(Function::Quaternion, arguments) = &expression.kind else {
                return;
            };
            let names: Option<Vec<String>> = arguments.iter().map(component).collect();
            let Some(Ok(names)) = names.map(<[String; 4]>::try_from) else { return };
            if names.iter().all(|name| is_input(name)) && !all.contains(&names) {
                all.push(names);
            }
        });
    }
    all
}

/// The name of a component, which may have a sign.
fn component(expression: &Expression) -> Option<String> {
    match &expression.kind {
        ExpressionKind::Name(name) => Some(name.clone()),
        ExpressionKind::Negate(inner) => component(inner),
        _ => None,
    }
}

impl Loader<'_> {
    /// Makes the quaternions of a stream continuous, and says what was done.
    pub(crate) fn settle_attitudes(&mut self, entry: &RunEntry, stream: &mut Table) {
        let Some(times) = stream.values(TIME).map(<[f64]>::to_vec) else { return };
        for names in quaternions(self.model) {
            let places: Option<Vec<usize>> = names.iter().map(|name| place(stream, name)).collect();
            let Some(Ok(places)) = places.map(<[usize; 4]>::try_from) else { continue };
            let mut rows: Vec<[f64; 4]> = (0..times.len())
                .map(|row| places.map(|place| stream.columns[place].values[row]))
                .collect();
            let found = settle(&times, &mut rows);
            for (component, place) in places.into_iter().enumerate() {
                let values = stream.columns[place].values.iter_mut().zip(&rows);
                values.for_each(|(value, row)| *value = row[component]);
            }
            let of = format!(
                "run `{}`: the quaternion `{}` in `{}`",
                entry.name.text,
                names.join("`, `"),
                stream.file
            );
            self.warnings.extend(found.told(&of, &stream.lines));
        }
    }
}

fn place(table: &Table, name: &str) -> Option<usize> {
    let is_it = |wanted: &Option<String>| wanted.as_deref() == Some(name);
    table.columns.iter().position(|column| is_it(&column.wanted))
}

/// What was found in the rows of one quaternion; rows count from 0.
#[derive(Debug, Default, PartialEq, Eq)]
struct Found {
    /// Changes of sign that were taken back.
    signs: usize,
    /// Rows of no length, left out.
    empty: Vec<[usize; 2]>,
    /// Rows of another length than 1.
    lengths: Vec<[usize; 2]>,
    /// Rows between a leap away and a leap back, left out.
    bursts: Vec<[usize; 2]>,
    /// Rows at which the attitude leaps and does not come back.
    leaps: Vec<[usize; 2]>,
}

/// Makes rows continuous; those that are no rotation become NaN.
fn settle(times: &[f64], rows: &mut [[f64; 4]]) -> Found {
    let mut found = Found::default();
    let mut known = Vec::new();
    for (at, row) in rows.iter_mut().enumerate() {
        let length = row.iter().map(|one| one * one).sum::<f64>().sqrt();
        if length < NO_ROTATION {
            push(&mut found.empty, at);
            *row = [f64::NAN; 4];
        } else if length.is_finite() {
            if (length - 1.0).abs() > OFF_LENGTH {
                push(&mut found.lengths, at);
                row.iter_mut().for_each(|one| *one /= length);
            }
            known.push(at);
        }
    }
    let turns: Vec<Quaternion<f64>> =
        known.iter().map(|at| Quaternion::from_components(rows[*at])).collect();
    let moments: Vec<f64> = known.iter().map(|at| times[*at]).collect();
    let (bursts, leaps) = leaps(&moments, &turns);
    leaps.iter().for_each(|at| push(&mut found.leaps, known[*at]));
    for at in bursts {
        push(&mut found.bursts, known[at]);
        rows[known[at]] = [f64::NAN; 4];
    }
    let mut last: Option<[f64; 4]> = None;
    let mut sign_before = 1.0;
    for row in rows.iter_mut().filter(|row| row.iter().all(|one| one.is_finite())) {
        let along = last.map_or(1.0, |last| last.iter().zip(&*row).map(|(a, b)| a * b).sum());
        let sign = if along < 0.0 { -1.0 } else { 1.0 };
        found.signs += usize::from(sign != sign_before);
        sign_before = sign;
        row.iter_mut().for_each(|one| *one *= sign);
        last = Some(*row);
    }
    found
}

/// Adds a row to ranges of rows.
fn push(ranges: &mut Vec<[usize; 2]>, row: usize) {
    match ranges.last_mut() {
        Some([_, last]) if *last + 1 == row => *last = row,
        _ => ranges.push([row, row]),
    }
}

/// The angle between two attitudes (rad), 0 to π.
fn angle(a: Quaternion<f64>, b: Quaternion<f64>) -> f64 {
    2.0 * (a.conjugate() * b).w.abs().min(1.0).acos()
}

/// A turn from one attitude to the next.
struct Step {
    /// In the frame of the body and in that of the room.
    turns: [Quaternion<f64>; 2],
    /// Its angle (rad).
    angle: f64,
    /// How long it takes (s).
    time: f64,
}

/// Attitudes in bursts, and those at which one that lasts begins.
///
/// A leap back undoes a leap away, but for the motion of two steps: their product is nearly no turn,
/// in the frame of the body or in that of the room, however far the body moves in between.
fn leaps(times: &[f64], turns: &[Quaternion<f64>]) -> (Vec<usize>, Vec<usize>) {
    let spacing = mean_spacing(times).max(f64::MIN_POSITIVE);
    let steps: Vec<Step> = times
        .windows(2)
        .zip(turns.windows(2))
        .map(|(time, turn)| Step {
            turns: [turn[0].conjugate() * turn[1], turn[1] * turn[0].conjugate()],
            angle: angle(turn[0], turn[1]),
            time: (time[1] - time[0]).max(spacing),
        })
        .collect();
    // Attitude behind the leap, and how far two steps may lead.
    let starts: Vec<(usize, f64)> = (0..steps.len())
        .filter_map(|at| {
            let typical = beside(&steps, at)? * steps[at].time;
            let is_leap = steps[at].angle > LEAP.0.max(LEAP.1 * typical);
            is_leap.then(|| (at + 1, (0.5 * LEAP.0 + 4.0 * typical).min(0.5 * steps[at].angle)))
        })
        .collect();
    let undoes = |at: usize, before: usize, way: f64| {
        let [one, other] = [&steps[before - 1].turns, &steps[at - 1].turns];
        (0..2).any(|frame| angle(one[frame] * other[frame], Quaternion::identity()) < way)
    };
    // Branches that are left, with the leap away from each; stretches with their branch.
    let mut left: Vec<(usize, usize)> = Vec::new();
    let (mut branch, mut count) = (0, 1);
    let mut stretches = vec![(0, 0)];
    for (at, way) in &starts {
        match left.last() {
            Some((below, before)) if undoes(*at, *before, *way) => {
                branch = *below;
                left.pop();
            }
            _ => {
                left.push((branch, *at));
                branch = count;
                count += 1;
            }
        }
        stretches.push((branch, *at));
    }
    let end = |n: usize| stretches.get(n + 1).map_or(turns.len(), |next| next.1);
    let mut rows = vec![0; count];
    (0..stretches.len()).for_each(|n| rows[stretches[n].0] += end(n) - stretches[n].1);
    let main = (0..count).max_by_key(|own| rows[*own]).unwrap_or(0);
    let first = stretches.iter().position(|one| one.0 == main).unwrap_or(0);
    let last = stretches.iter().rposition(|one| one.0 == main).unwrap_or(0);
    let between = (first..last).filter(|n| stretches[*n].0 != main);
    let bursts: Vec<usize> = between.flat_map(|n| stretches[n].1..end(n)).collect();
    if bursts.len() as f64 > MOST_BURSTS * turns.len() as f64 {
        return (Vec::new(), starts.into_iter().map(|(at, _)| at).collect());
    }
    let lasting = (1..stretches.len()).filter(|n| *n <= first || *n > last);
    (bursts, lasting.map(|n| stretches[n].1).collect())
}

/// The middle rate (rad/s) of the steps beside one; `None` where there are few.
fn beside(steps: &[Step], at: usize) -> Option<f64> {
    let all = at.saturating_sub(BESIDE)..(at + 1 + BESIDE).min(steps.len());
    let others = all.filter(|other| *other != at);
    let mut rates: Vec<f64> = others.map(|other| steps[other].angle / steps[other].time).collect();
    let middle = rates.len() / 2;
    (rates.len() >= BESIDE).then(|| *rates.select_nth_unstable_by(middle, f64::total_cmp).1)
}

impl Found {
    /// What is to be said of `of`, whose rows stand in these lines.
    fn told(&self, of: &str, lines: &[usize]) -> Vec<Diagnostic> {
        let rows = |ranges: &[[usize; 2]]| listed(ranges, lines);
        let count = |ranges: &[[usize; 2]]| ranges.iter().map(|[a, b]| b - a + 1).sum::<usize>();
        let mut all = Vec::new();
        if self.signs > 0 {
            let message = format!("{of} changes its sign {} times: made continuous", self.signs);
            let help =
                "q and -q are the same rotation; a curve through the components needs one sign";
            all.push(Diagnostic::warning(message).help(help));
        }
        if !self.empty.is_empty() {
            let message = format!(
                "{of} has length 0 in {} rows: left out ({})",
                count(&self.empty),
                rows(&self.empty)
            );
            all.push(Diagnostic::warning(message));
        }
        if !self.lengths.is_empty() {
            let message = format!(
                "{of} has a length off 1 by more than 1 % in {} rows: scaled to 1 ({})",
                count(&self.lengths),
                rows(&self.lengths)
            );
            let help = "are these the four components of one quaternion?";
            all.push(Diagnostic::warning(message).help(help));
        }
        if !self.bursts.is_empty() {
            let message = format!(
                "{of} leaps away and back {} times: {} rows left out ({})",
                self.bursts.len(),
                count(&self.bursts),
                rows(&self.bursts)
            );
            let help =
                "markers or a board may have been confused there; the curve bridges these rows";
            all.push(Diagnostic::warning(message).help(help));
        }
        if !self.leaps.is_empty() {
            let message = format!(
                "{of} leaps {} times and does not come back ({})",
                self.leaps.len(),
                rows(&self.leaps)
            );
            let help = "the leap is taken for a motion: is it another frame or another marker from there on?";
            all.push(Diagnostic::warning(message).help(help));
        }
        all
    }
}

/// Ranges of rows in the words of a message.
fn listed(ranges: &[[usize; 2]], lines: &[usize]) -> String {
    let words = |[first, last]: &[usize; 2]| match (lines[*first], lines[*last]) {
        (first, last) if first == last => first.to_string(),
        (first, last) => format!("{first}-{last}"),
    };
    let some: Vec<String> = ranges.iter().take(MOST_RANGES).map(words).collect();
    let more = match ranges.len().saturating_sub(MOST_RANGES) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let rows = if some.len() == 1 && !some[0].contains('-') { "row" } else { "rows" };
    format!("{rows} {}{more}", some.join(", "))
}
