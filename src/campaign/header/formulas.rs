//! Wanted columns that are computed from others of the file, by a formula that the campaign states.

use std::collections::HashMap;

use super::column::Column;
use super::names::{Chosen, Names};
use crate::campaign::computed::Computation;
use crate::campaign::wanted::Wanted;
use crate::diagnostic::Diagnostic;
use crate::units::Unit;

/// A wanted column that is computed, and the columns from which.
pub(super) type Sources<'w> = (&'w Wanted, Vec<Wanted>);

/// What the formulas need that this file can compute: those all of whose names are columns of it.
pub(super) fn sources<'w>(
    wanted: &'w [Wanted],
    all: &Names<'_>,
    chosen: &HashMap<usize, Chosen<'_>>,
) -> Vec<Sources<'w>> {
    let is_chosen = |want: &Wanted| chosen.values().any(|one| one.want.name == want.name);
    let open = wanted.iter().filter(|want| !is_chosen(want));
    let of = |want: &'w Wanted| {
        let formula = want.stated.formula.as_ref()?;
        let mut sources: Vec<Wanted> = Vec::new();
        for (name, _) in formula.root.names() {
            if name == "pi" || sources.iter().any(|known| known.name == name) {
                continue;
            }
            let stated = want.stated.sources.iter().find(|(own, _)| own == name);
            let stated = stated.map(|(_, stated)| stated.clone()).unwrap_or_default();
            let source = Wanted { name: name.to_owned(), stated, unit: Unit::one(), role: None };
            all.place(&source)?;
            sources.push(source);
        }
        Some((want, sources))
    };
    open.filter_map(of).collect()
}

/// Columns that are computed from others.
pub(super) fn computed(
    sources: &[Sources<'_>],
    all: &Names<'_>,
    columns: &[Column],
    faults: &mut Vec<Diagnostic>,
) -> Vec<(String, Computation)> {
    let mut found = Vec::new();
    for (want, sources) in sources {
        let own: Vec<(&str, usize, Unit)> = sources
            .iter()
            .filter_map(|source| {
                let (index, ..) = all.place(source)?;
                Some((source.name.as_str(), index, columns[index].unit.clone()))
            })
            .collect();
        let formula = want.stated.formula.as_ref();
        match formula.map(|formula| Computation::of(formula, &own, &want.unit)) {
            Some(Ok(computation)) => found.push((want.name.clone(), computation)),
            Some(Err(fault)) => faults.push(fault),
            None => {}
        }
    }
    found
}
