//! An input's certificate read: `calibration = { ... }` with its table of corrections.

use std::f64::consts::TAU;

use crate::campaign::calibration::Corrections;
use crate::campaign::form::Form;
use crate::campaign::header::{Stated, Wanted};
use crate::campaign::loader::Loader;
use crate::campaign::statement::{self, Spread};
use crate::diagnostic::Diagnostic;
use crate::document::entries::{Item, Named, get};
use crate::model::InputDeclaration;

/// The most rows of a table of corrections.
const MOST_CORRECTIONS: usize = 1_000_000;
/// Column of the corrections.
const CORRECTION: &str = "correction";
const KEYS: [&str; 1] = ["corrections"];

impl Loader<'_> {
    /// Reads `calibration = { ... }` of an input.
    pub(crate) fn calibration(
        &mut self,
        input: &InputDeclaration,
        item: &Item,
    ) -> (Option<Spread>, Option<Corrections>) {
        let entries = self.reader.table(item, "calibration = { U = \"4.2 arcsec\", k = 2 }");
        self.reader.only(entries, &[&statement::KEYS[..], &KEYS[..]].concat());
        let what = format!("the calibration of `{}`", input.name);
        let spread = statement::spread(&mut self.reader, entries, &what, &input.unit);
        if get(entries, "sigma").or(get(entries, "U")).is_none() {
            let help = "state `sigma`, or `U` with its `k`";
            self.reader.fault(item.span, format!("{what} has no uncertainty"), help);
        }
        let corrections =
            get(entries, KEYS[0]).and_then(|item| self.corrections(input, item, &what));
        (spread, corrections)
    }

    fn corrections(
        &mut self,
        input: &InputDeclaration,
        item: &Item,
        what: &str,
    ) -> Option<Corrections> {
        let text = self.reader.text(item, "corrections = \"encoder.csv\"")?;
        let place = self.reader.place(item.span);
        let name = Named { text, span: item.span, place };
        let want = |name: &str| Wanted {
            name: name.to_owned(),
            stated: Stated::default(),
            unit: input.unit.clone(),
            role: None,
        };
        let wanted = [want(&input.name), want(CORRECTION)];
        let mut table = self.table(&name, &Form::default(), &wanted)?;
        self.whole(&name, &mut table, MOST_CORRECTIONS)?;
        let (Some(at), Some(by)) = (table.column(&input.name), table.column(CORRECTION)) else {
            let message = format!("`{}` lacks a column", name.text);
            let help = format!(
                "{what} needs `{} [{unit}]` and `{CORRECTION} [{unit}]`; columns found: {}",
                input.name,
                table.names(),
                unit = input.unit.symbol
            );
            self.reader.fault(item.span, message, help);
            return None;
        };
        let is_angle = input.unit.is_angle();
        let period = if is_angle { input.period.unwrap_or(TAU) } else { 0.0 };
        let (mut positions, mut values) = (at.values.clone(), by.values.clone());
        let mut fault = |row: usize, message: &str, help: &str| {
            let fault = Diagnostic::error(message).at(table.cell_place(row, at)).help(help);
            self.reader.report(fault);
        };
        for row in 0..positions.len() {
            if positions[row].is_nan() || values[row].is_nan() {
                fault(row, "the row is not complete", "each row is a position and its correction");
                return None;
            }
            if row > 0 && positions[row] <= positions[row - 1] {
                fault(row, "the positions are out of order here", "each is beyond the one before");
                return None;
            }
            if is_angle && positions[row] - positions[0] > period * (1.0 + 1e-9) {
                fault(row, "the positions go on after a whole turn", "corrections repeat by turns");
                return None;
            }
        }
        let last = positions.len() - 1;
        if is_angle && last > 0 && positions[last] - positions[0] > period * (1.0 - 1e-9) {
            // The end of the turn is its beginning.
            positions.pop();
            values.pop();
        }
        Some(Corrections { positions, values, period })
    }
}
