//! Rows of a table that are held in memory and shown in another order than that of the file.

use crate::campaign::header::Column;

/// Rows held in memory, and their order.
#[derive(Debug)]
pub(crate) struct Reordered {
    /// Line of each row in the file.
    pub(super) lines: Vec<usize>,
    /// Values of each column.
    pub(super) columns: Vec<Vec<f64>>,
    /// The rows in the order of time.
    pub(super) order: Vec<usize>,
    /// Rows that were shown.
    pub(super) shown: usize,
    /// Whether the rows at hand are the first ones.
    pub(super) begins: bool,
}

impl Reordered {
    /// Puts the next rows in the place of those at hand.
    pub(crate) fn more(&mut self, most: usize, lines: &mut Vec<usize>, columns: &mut [Column]) {
        self.begins = self.shown == 0;
        let end = self.order.len().min(self.shown.saturating_add(most));
        let rows = &self.order[self.shown..end];
        lines.extend(rows.iter().map(|row| self.lines[*row]));
        for (column, values) in columns.iter_mut().zip(&self.columns) {
            column.values.extend(rows.iter().filter_map(|row| values.get(*row)));
        }
        self.shown = end;
    }
}
