//! A file with what its columns seem to be.

use crate::campaign::begin::candidate::base;
use crate::campaign::begin::guess::Guess;
use crate::campaign::begin::survey::{Survey, Surveyed};
use crate::campaign::origin::listed;

/// A log.
#[derive(Clone, Debug)]
pub(super) struct Log {
    pub(super) survey: Survey,
    pub(super) guess: Guess,
}

/// The most columns that are listed.
const MOST_NAMES: usize = 20;
/// Rows farther apart (s) are stops, not a motion.
const STOPS: f64 = 10.0;

impl Log {
    /// The names of its columns.
    pub(super) fn heads(&self) -> Vec<&str> {
        self.survey.columns.iter().map(|column| column.name.as_str()).collect()
    }

    /// Its columns with their units, as far as they are known.
    pub(super) fn column_list(&self) -> String {
        let columns = self.survey.columns.iter().map(|column| match &column.unit {
            Some(unit) => format!("{} [{}]", column.name, unit.symbol),
            None => column.name.clone(),
        });
        let columns: Vec<String> = columns.collect();
        let columns = listed(columns.iter().map(String::as_str), MOST_NAMES, "");
        format!("columns of `{}`: {columns}", self.survey.path.display())
    }

    /// Its columns that move, each with its unit.
    pub(super) fn moving_list(&self) -> String {
        let is_time = |at: usize| self.guess.time.as_ref().is_some_and(|time| time.has(at));
        let columns = self.survey.columns.iter().enumerate();
        let moving = columns.filter(|(at, column)| !is_time(*at) && column.moves());
        let moving = moving.map(|(_, column)| match column.unit.clone().or(base(&column.name).1) {
            Some(unit) => format!("{} in {}", column.name, unit.symbol),
            None => format!("{} without a unit", column.name),
        });
        let moving: Vec<String> = moving.collect();
        let list = listed(moving.iter().map(String::as_str), MOST_NAMES, "");
        format!(
            "`{}` moves in: {}",
            self.survey.path.display(),
            if moving.is_empty() { "no column" } else { &list }
        )
    }

    /// Warnings about units that are not known and about rows that are no numbers.
    pub(super) fn faults(&self) -> Vec<String> {
        let file = self.survey.path.display();
        let rows = |count: usize, what: &str| {
            let rows = if count == 1 { "1 row has" } else { &format!("{count} rows have") };
            (count > 0).then(|| format!("`{file}`: {rows} {what}"))
        };
        let cells = rows(
            self.survey.bad_rows,
            "cells that are no numbers: say what stands for a missing reading (`missing = [\"nan\"]` beside `file`), or compute with --skip-bad-rows",
        );
        let texts = rows(
            self.survey.text_rows,
            "no number at all, but text: compute with --skip-bad-rows, or delete such rows",
        );
        let unit = |column: &Surveyed| {
            let why = column.unknown.as_ref()?;
            let name = &column.name;
            Some(format!("`{file}`: {why} of the column `{name}`: state one that is known"))
        };
        let units = self.survey.columns.iter().filter_map(unit);
        cells.into_iter().chain(texts).chain(units).collect()
    }

    /// Its first and last stamp (s).
    pub(super) fn span(&self) -> Option<[f64; 2]> {
        self.guess.time.as_ref()?.span()
    }

    /// Whether its rows are stops: without stamps, far apart, or in no curve.
    pub(super) fn stands_still(&self) -> bool {
        let Some(spacing) = self.spacing() else { return true };
        let is_time = |at: usize| self.guess.time.as_ref().is_some_and(|time| time.has(at));
        let columns = self.survey.columns.iter().enumerate();
        let mut moving = columns.filter(|(at, column)| !is_time(*at) && column.moves());
        spacing > STOPS || moving.all(|(_, column)| column.leaps())
    }

    /// The mean time between its rows (s).
    pub(super) fn spacing(&self) -> Option<f64> {
        let [first, last] = self.span()?;
        Some((last - first) / self.survey.rows().max(1) as f64)
    }
}
