//! Which columns are chosen, by their names: stated by the campaign, called like the wanted column, in
//! a role of the file's format, or added to the stamp.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::column::split;
use crate::campaign::form::Form;
use crate::campaign::formats::{Format, Role};
use crate::campaign::recognise::layout::Layout;
use crate::campaign::wanted::{Choice, Stated, TIME, Wanted};
use crate::units::Unit;

/// A column that was chosen: for what, the unit that the campaign states, that of its format, and
/// whether it is added to another one.
pub(super) struct Chosen<'w> {
    pub(super) want: &'w Wanted,
    pub(super) stated: Option<&'w Unit>,
    pub(super) usual: Option<Unit>,
    pub(super) is_added: bool,
}

/// Files of more columns are in no format that is recognised.
const MOST_OF_FORMAT: usize = 1000;

/// Names of a file's columns with the places of their cells, and of the units in them.
pub(super) struct Names<'a> {
    pub(super) cells: Vec<(&'a str, (usize, usize))>,
    /// The first column of a name, and the second one if it is not the only one; none of `unused`.
    places: HashMap<&'a str, (usize, Option<usize>)>,
    /// Whether a column may be meant by digits: no row of names says otherwise.
    by_digits: bool,
}

impl<'a> Names<'a> {
    pub(super) fn of(layout: &'a Layout, form: &Form) -> Self {
        let Some(header) = &layout.header else {
            let cells = vec![("", (0, 0)); layout.width];
            return Self { cells, places: HashMap::new(), by_digits: true };
        };
        let cells = header.names();
        let mut places: HashMap<&str, (usize, Option<usize>)> = HashMap::new();
        for (index, (cell, _)) in cells.iter().enumerate() {
            let name = split(cell).0;
            if !name.is_empty() && !form.is_unused(name) {
                let known = places.entry(name).or_insert((index, None));
                if known.0 != index {
                    known.1.get_or_insert(index);
                }
            }
        }
        Self { cells, places, by_digits: header.start > 0 }
    }

    /// The names without units; empty where there are none.
    pub(super) fn plain(&self) -> Vec<&'a str> {
        self.cells.iter().map(|(cell, _)| split(cell).0).collect()
    }

    /// The format of the file, as stated or recognised; chooses columns for roles that have none.
    pub(super) fn format<'w>(
        &self,
        layout: &Layout,
        form: &Form,
        chosen: &mut HashMap<usize, Chosen<'w>>,
        wanted: &'w [Wanted],
    ) -> Option<&'static Format> {
        let names = self.plain();
        let recognised = || match &layout.header {
            Some(_) if names.len() <= MOST_OF_FORMAT => Format::with_names(&names),
            None if chosen.is_empty() => Format::with_rows(&layout.numbers(form)),
            _ => None,
        };
        let format = form.format.or_else(recognised)?;
        for want in wanted.iter().filter(|want| want.stated.column.is_none()) {
            let own = chosen.iter().find(|(_, one)| one.want.name == want.name);
            let own = own.map(|(index, one)| (*index, one.stated.is_some()));
            // A column of that name without a unit may be another one.
            let has_unit = |index: usize| split(self.cells[index].0).1.is_some();
            let is_chosen = own.is_some_and(|(index, stated)| stated || has_unit(index));
            let Some(role) = want.role.filter(|_| !is_chosen) else { continue };
            let Some(index) = format.place(role, &names) else { continue };
            if form.is_unused(names[index]) {
                continue;
            }
            if let Some((own, _)) = own {
                chosen.remove(&own);
            }
            let usual = Some(format.unit(role));
            chosen.entry(index).or_insert(Chosen {
                want,
                stated: want.stated.unit.as_ref(),
                usual,
                is_added: false,
            });
        }
        Some(format)
    }

    /// Chooses the columns that are added to the stamp: those that are stated, those of the format, or
    /// the time of day beside a date. Where one of them is not there the file has no stamps. Answers
    /// with those that are something else already, and what.
    pub(super) fn add_to_stamp<'w>(
        &self,
        layout: &Layout,
        format: Option<&'static Format>,
        chosen: &mut HashMap<usize, Chosen<'w>>,
    ) -> Vec<(usize, &'w Wanted)> {
        let time = chosen.iter().find(|(_, one)| one.want.name == TIME);
        let Some((time, want)) = time.map(|(index, one)| (*index, one.want)) else {
            return Vec::new();
        };
        let stated = &want.stated.added;
        let mut added: Vec<(Option<usize>, Option<&Unit>, Option<Unit>)> = stated
            .iter()
            .map(|one| (self.stated(one).map(|(index, _)| index), one.unit.as_ref(), None))
            .collect();
        if let (true, Some(format)) = (stated.is_empty(), format) {
            let names = self.plain();
            let place = |part| format.place(Role::Time(part), &names);
            if place(0) == Some(time) {
                let parts = (1..).map_while(|part| Some((part, place(part)?)));
                added.extend(
                    parts.map(|(part, index)| {
                        (Some(index), None, Some(format.unit(Role::Time(part))))
                    }),
                );
            }
        }
        if added.is_empty() {
            let beside = layout.beside(time).filter(|beside| !chosen.contains_key(beside));
            added.extend(beside.map(|beside| (Some(beside), None, None)));
        }
        let mut taken = Vec::new();
        for (index, stated, usual) in added {
            let Some(index) = index else {
                chosen.retain(|_, one| one.want.name != TIME);
                return Vec::new();
            };
            match chosen.entry(index) {
                Entry::Occupied(known) => taken.push((index, known.get().want)),
                Entry::Vacant(free) => {
                    free.insert(Chosen { want, stated, usual, is_added: true });
                }
            }
        }
        taken
    }

    /// The column that is stated, and one of the same name if there is another.
    fn stated(&self, stated: &Stated) -> Option<(usize, Option<usize>)> {
        let by_number = |number: usize| {
            let index = number.checked_sub(1).filter(|index| *index < self.cells.len())?;
            Some((index, None))
        };
        match stated.column.as_ref()? {
            Choice::Number(number) => by_number(*number),
            Choice::Name(name) => {
                let named = self.places.get(name.as_str()).copied();
                let digits = || name.parse().ok().filter(|_| self.by_digits);
                named.or_else(|| digits().and_then(by_number))
            }
        }
    }

    /// The column that a wanted one is, one of the same name if there is another, and the unit that
    /// the campaign states of it.
    pub(super) fn place<'w>(
        &self,
        want: &'w Wanted,
    ) -> Option<(usize, Option<usize>, Option<&'w Unit>)> {
        let Stated { column, unit, .. } = &want.stated;
        // What is computed may be called like one of the columns that it is computed from.
        let own = || {
            let is_computed = want.stated.formula.is_some();
            self.places.get(want.name.as_str()).copied().filter(|_| !is_computed)
        };
        match self.stated(&want.stated) {
            Some((index, other)) => Some((index, other, unit.as_ref())),
            // A unit alone is that of the column which is called like the wanted one.
            None => own()
                .map(|(index, other)| (index, other, unit.as_ref().filter(|_| column.is_none()))),
        }
    }
}
