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

/// Attitudes in bursts, and those at which one that lasts begins.
fn leaps(times: &[f64], turns: &[Quaternion<f64>]) -> (Vec<usize>, Vec<usize>) {
    let spacing = mean_spacing(times).max(f64::MIN_POSITIVE);
    let steps: Vec<(f64, f64)> = times
        .windows(2)
        .zip(turns.windows(2))
        .map(|(time, turn)| (angle(turn[0], turn[1]), (time[1] - time[0]).max(spacing)))
        .collect();
    let is_leap = |at: usize| {
        let beside = (at.saturating_sub(BESIDE)..(at + 1 + BESIDE).min(steps.len()))
            .filter(|other| *other != at);
        let mut rates: Vec<f64> = beside.map(|other| steps[other].0 / steps[other].1).collect();
        if rates.len() < BESIDE {
            return false;
        }
        let middle = rates.len() / 2;
        let typical = *rates.select_nth_unstable_by(middle, f64::total_cmp).1;
        steps[at].0 > LEAP.0.max(LEAP.1 * typical * steps[at].1)
    };
    let starts: Vec<usize> = (0..steps.len()).filter(|at| is_leap(*at)).map(|at| at + 1).collect();
    // Each stretch goes on from the last attitude of one before it, or begins a branch of its own.
    let ends = starts.iter().copied().chain([turns.len()]);
    let mut stretches: Vec<(usize, usize, usize)> = Vec::new();
    let mut branches: Vec<(usize, usize)> = Vec::new();
    for (start, end) in std::iter::once(0).chain(starts.iter().copied()).zip(ends) {
        let leap = if start == 0 { 0.0 } else { steps[start - 1].0 };
        let off = |branch: &(usize, usize)| angle(turns[branch.0], turns[start]);
        let nearest = (0..branches.len())
            .filter(|own| off(&branches[*own]) < 0.5 * leap)
            .min_by(|a, b| off(&branches[*a]).total_cmp(&off(&branches[*b])));
        let branch = nearest.unwrap_or_else(|| {
            branches.push((0, 0));
            branches.len() - 1
        });
        branches[branch] = (end.saturating_sub(1), branches[branch].1 + end - start);
        stretches.push((branch, start, end));
    }
    let main = (0..branches.len()).max_by_key(|own| branches[*own].1).unwrap_or(0);
    let is_main = |stretch: &(usize, usize, usize)| stretch.0 == main;
    let first = stretches.iter().position(is_main).unwrap_or(0);
    let last = stretches.iter().rposition(is_main).unwrap_or(0);
    let between = stretches[first..last.max(first)].iter().filter(|one| !is_main(one));
    let bursts: Vec<usize> = between.flat_map(|(_, start, end)| *start..*end).collect();
    let lasting = stretches.iter().enumerate().skip(1);
    let lasting = lasting.filter(|(n, _)| *n <= first || *n > last).map(|(_, one)| one.1);
    if bursts.len() as f64 > MOST_BURSTS * turns.len() as f64 {
        return (Vec::new(), starts);
    }
    (bursts, lasting.collect())
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
