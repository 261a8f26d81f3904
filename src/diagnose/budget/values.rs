//! Values of a term by the parameters that they are of, as the sums find them: where a fit begins,
//! and the size of what is not in the fit. It fits nothing.

use std::collections::BTreeMap;

use crate::engine::point::NamedValue;
use crate::units::Unit;

use super::answer::Size;
use super::linear::Linear;
use super::selection::Selection;

impl Linear {
    /// A value (SI) of a column with its parameter; `None` of columns of no parameter.
    pub fn size(&self, column: usize, value: f64) -> Option<Size> {
        let own = column.checked_sub(self.sums.nominal);
        let (parameter, component, of) = if let Some(own) = own {
            let owner = self.sums.owners.get(own)?;
            (owner.parameter.clone(), owner.component, owner.of.clone())
        } else {
            let layout = &self.fitted.problem.layout;
            layout.instances.iter().enumerate().find_map(|(index, instance)| {
                let mut own = layout.own_columns(index);
                let (component, _) = own.find(|(_, other)| *other == column)?;
                Some((instance.name.clone(), component, instance.whose().map(str::to_owned)))
            })?
        };
        Some(Size { unit: self.unit_of(&parameter), parameter, component, of, value })
    }

    /// The unit in which a parameter of a candidate or of a row is declared.
    fn unit_of(&self, parameter: &str) -> Unit {
        let instances = &self.fitted.problem.layout.instances;
        if let Some(own) = instances.iter().find(|one| one.name == parameter) {
            return own.unit.clone();
        }
        let own = self.candidates.iter().filter(|one| {
            parameter.strip_prefix(one.name.as_str()).is_some_and(|rest| rest.starts_with('.'))
        });
        own.filter_map(|one| one.unit(parameter)).next().unwrap_or_else(Unit::one)
    }

    /// Values of a term's parameters beside a model, as the sums find them best.
    pub fn sizes(&self, selection: &Selection<'_>, model: &[usize], term: usize) -> Vec<Size> {
        let with = [model, &[term]].concat();
        let values = selection.values(&with);
        let own = &selection.terms[term].columns;
        let first = values.len() - own.len();
        let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
        for (number, combination) in own.iter().enumerate() {
            for (column, by) in combination {
                *sums.entry(*column).or_default() += by * values[first + number];
            }
        }
        sums.into_iter().filter_map(|(column, value)| self.size(column, value)).collect()
    }

    /// The same as the start of a fit.
    pub fn start(
        &self,
        selection: &Selection<'_>,
        model: &[usize],
        term: usize,
    ) -> Vec<NamedValue> {
        let sizes = self.sizes(selection, model, term).into_iter();
        sizes.map(|one| (one.parameter, one.component, one.of, one.value)).collect()
    }
}
