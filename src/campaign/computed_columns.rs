//! The columns of a table that are computed from others of its file.

use crate::campaign::computed::Computation;
use crate::campaign::header::{Column, Wanted};
use crate::campaign::table::{Table, TableError};
use crate::diagnostic::Diagnostic;
use crate::units::Unit;

impl Table {
    /// The same with columns that are computed from others.
    pub(super) fn with(mut self, computed: Vec<(String, Computation)>, wanted: &[Wanted]) -> Self {
        for (name, computation) in computed {
            let want = wanted.iter().find(|want| want.name == name);
            self.computed.push((self.columns.len(), computation.clone()));
            self.columns.push(Column {
                name: name.clone(),
                is_named: false,
                wanted: Some(name),
                unit: want.map_or_else(Unit::one, |want| want.unit.clone()),
                is_unit_in_header: false,
                is_sexagesimal: false,
                index: computation.sources.first().copied().unwrap_or(0),
                values: Vec::new(),
            });
        }
        self
    }

    /// Fills the columns that are computed from others.
    pub(super) fn compute(&mut self) -> Result<(), TableError> {
        let mut computed = std::mem::take(&mut self.computed);
        for (place, computation) in &mut computed {
            let sources = computation.sources.clone();
            let (before, own) = self.columns.split_at_mut(*place);
            let Some(column) = own.first_mut() else { continue };
            for row in 0..self.lines.len() {
                let source = |name: usize| before[sources[name]].values[row];
                let value = computation.value(source);
                let is_missing = (0..sources.len()).any(|name| source(name).is_nan());
                if !value.is_finite() && !is_missing {
                    let message = format!("the formula for `{}` has no value here", column.name);
                    let at = column.clone();
                    let fault = Diagnostic::error(message).at(self.cell_place(row, &at));
                    return Err(TableError::Content(fault.into()));
                }
                column.values.push(value);
            }
        }
        self.computed = computed;
        Ok(())
    }
}
