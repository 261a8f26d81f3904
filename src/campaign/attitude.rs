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
use crate::campaign::table::Table;
use crate::diagnostic::Diagnostic;
use crate::formula::{BinaryOperator, Expression, ExpressionKind, Function};
use crate::model::Model;
use crate::quaternion::Quaternion;

/// Lengths below and above which a quaternion is no rotation.
const NO_ROTATION: [f64; 2] = [1e-3, 1e3];
/// How many names a component may have, one for the other.
const DEPTH: usize = 8;
/// How far the length of a quaternion may be off 1: digits are cut off in logs.
const OFF_LENGTH: f64 = 0.01;

mod leaps;
mod messages;

use leaps::leaps;

/// The inputs of a model that are the components of one quaternion.
pub(crate) fn quaternions(model: &Model) -> Vec<[String; 4]> {
    let is_input = |name: &str| model.inputs.iter().any(|input| input.name == name);
    let mut all: Vec<[String; 4]> = Vec::new();
    for formula in model.formulas() {
        formula.root.visit(&mut |expression| {
            let ExpressionKind::Call(Function::Quaternion, arguments) = &expression.kind else {
                return;
            };
            let names: Option<Vec<String>> =
                arguments.iter().map(|one| component(model, one, DEPTH)).collect();
            let Some(Ok(names)) = names.map(<[String; 4]>::try_from) else { return };
            if names.iter().all(|name| is_input(name)) && !all.contains(&names) {
                all.push(names);
            }
        });
    }
    all
}

/// The input that is a component, which may have a sign or a factor and another name.
fn component(model: &Model, expression: &Expression, depth: usize) -> Option<String> {
    let of = |part: &Expression| component(model, part, depth.checked_sub(1)?);
    match &expression.kind {
        ExpressionKind::Name(name) => match model.quantities.get(name) {
            Some(formula) => of(&formula.root),
            None => Some(name.clone()),
        },
        ExpressionKind::Negate(inner) => of(inner),
        ExpressionKind::Binary(BinaryOperator::Multiply | BinaryOperator::Divide, a, b) => {
            match (&a.kind, &b.kind) {
                (_, ExpressionKind::Number(..)) => of(a),
                (ExpressionKind::Number(..), _) => of(b),
                _ => None,
            }
        }
        _ => None,
    }
}

impl Loader<'_> {
    /// Makes the quaternions of a stream continuous, and says what was done.
    pub(crate) fn settle_attitudes(&mut self, entry: &RunEntry, stream: &mut Table) {
        let Some(times) = stream.values(TIME).map(<[f64]>::to_vec) else { return };
        for names in quaternions(self.model) {
            let places: Vec<Option<usize>> = names.iter().map(|name| place(stream, name)).collect();
            let is_split = places[0].is_some() && places.contains(&None);
            let is_logged = |name: &String| entry.inputs.iter().all(|(one, _)| one.text != *name);
            if is_split && names.iter().all(is_logged) {
                let message = format!(
                    "run `{}`: the quaternion `{}` comes from several files: its signs are not made continuous",
                    entry.name.text,
                    names.join("`, `")
                );
                let help = "put its four columns into one file, or see that the sign never changes";
                self.warnings.push(Diagnostic::warning(message).help(help));
            }
            let places: Option<Vec<usize>> = places.into_iter().collect();
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
    /// Rows without a length that a rotation may have, left out.
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
        let [least, most] = NO_ROTATION;
        if length < least || length > most {
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
