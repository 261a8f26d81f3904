//! Candidates put together, and columns of which some are one.

use super::columns::Column;
use super::{Entry, Evidence, Owner, Projected};

impl Evidence {
    /// Several candidates as one.
    pub fn together(&self, entries: &[&Entry]) -> Entry {
        let owners = entries.iter().flat_map(|one| one.owners.clone()).collect();
        let columns = entries.iter().flat_map(|one| one.columns.clone()).collect();
        self.entry(owners, columns)
    }

    /// The columns of a candidate that are wanted, those of a parameter in several runs as one: it
    /// has the same value in all of them. `wanted` sees whose value a column is, and its run.
    pub fn tied(&self, own: &Projected, wanted: impl Fn(&Owner, usize) -> bool) -> Entry {
        self.tied_of(&own.owners, &own.columns, |owner, column| {
            column.at.iter().copied().filter(|(run, _)| wanted(owner, *run)).collect()
        })
    }

    /// The same of an entry, in the runs that are wanted.
    pub fn tied_over(&self, own: &Entry, wanted: impl Fn(usize) -> bool) -> Entry {
        self.tied_of(&own.owners, &own.columns, |_, column| {
            column.at.iter().copied().filter(|(run, _)| wanted(*run)).collect()
        })
    }

    fn tied_of(
        &self,
        owners: &[Owner],
        columns: &[Column],
        wanted: impl Fn(&Owner, &Column) -> Vec<(usize, usize)>,
    ) -> Entry {
        let mut tied: Vec<(Owner, Column)> = Vec::new();
        for (owner, column) in owners.iter().zip(columns) {
            let at = wanted(owner, column);
            if at.is_empty() {
                continue;
            }
            let same = tied.iter_mut().find(|(known, _)| {
                (&known.parameter, known.component) == (&owner.parameter, owner.component)
            });
            match same {
                Some((_, known)) => known.at.extend(at),
                None => {
                    let owner = Owner { of: None, ..owner.clone() };
                    tied.push((owner, Column { at, typical: column.typical }));
                }
            }
        }
        tied.iter_mut().for_each(|(_, column)| column.at.sort_unstable());
        let (owners, columns) = tied.into_iter().unzip();
        self.entry(owners, columns)
    }
}
