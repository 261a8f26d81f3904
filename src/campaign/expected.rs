//! Which columns the files of a run may have, and what is said of others.

use crate::campaign::columns::{derived, reading_columns};
use crate::campaign::declared::{ColumnWord, RunEntry, TableEntry};
use crate::campaign::header::{Choice, Column, Stated, TIME, Wanted};
use crate::campaign::loader::Loader;
use crate::campaign::origin::listed;
use crate::campaign::roles::roles;
use crate::campaign::table::Table;
use crate::campaign::timing::COLUMNS;
use crate::campaign::words::{NO_FORMULA, OF_TIME};
use crate::diagnostic::{Diagnostic, nearest, shortened};
use crate::document::OUTSIDE;
use crate::graph::MeasurandKind;
use crate::units::Unit;

/// Unused columns that a message names.
const MOST_NAMES: usize = 8;

impl Loader<'_> {
    /// The columns a file may hold: all for the data file, else time and inputs. `own` are the words
    /// of the file, which count over those of its run.
    pub(crate) fn wanted(
        &self,
        entry: &RunEntry,
        own: &[ColumnWord],
        readings: bool,
    ) -> Vec<Wanted> {
        let roles = roles(self.model, readings);
        let words: Vec<&ColumnWord> = own.iter().chain(&entry.columns).collect();
        let want = |name: String, unit: Unit| {
            let word = words.iter().find(|word| word.name.text == name);
            let stated = word.map(|word| stated(word, &words));
            let role = roles.iter().find(|(own, _)| *own == name).map(|(_, role)| *role);
            Wanted { name, stated: stated.unwrap_or_default(), unit, role }
        };
        let times = if readings && self.timing.is_some() { &COLUMNS[..] } else { &[TIME][..] };
        let time = |name: &&str| want((*name).into(), Unit::second());
        let mut found: Vec<Wanted> = times.iter().map(time).collect();
        for input in &self.model.inputs {
            for (order, suffix) in ["", "_rate", "_acceleration"].iter().enumerate() {
                if order == 0 || readings {
                    let unit = derived(&input.unit, order as u8);
                    found.push(want(format!("{}{suffix}", input.name), unit));
                }
            }
        }
        if readings {
            for (index, name) in reading_columns(self.model) {
                let measurand = &self.model.measurands[index];
                let unit = match measurand.kind {
                    MeasurandKind::Rotation => Unit::one(),
                    _ => measurand.unit.clone(),
                };
                found.push(want(name, unit));
            }
        }
        found
    }

    /// Faults names of `columns` that mean nothing and warns of columns that nothing declares. `of`
    /// are the tables of files that may have words of their own.
    pub(crate) fn check_columns(
        &mut self,
        entry: &RunEntry,
        all: &[Wanted],
        tables: &[&Table],
        of: &[(&TableEntry, &Table)],
    ) {
        let known: Vec<&str> = all.iter().map(|want| want.name.as_str()).collect();
        let run = format!("no file of run `{}`", entry.name.text);
        self.check_words(&entry.columns, &known, tables, &run);
        for (file, table) in of {
            self.check_used(file);
            self.check_words(&file.columns, &known, &[table], &format!("`{}`", file.name.text));
        }
        let is_missing = |name: &&str| tables.iter().all(|table| table.column(name).is_none());
        let missing: Vec<&str> = known.into_iter().filter(is_missing).collect();
        for table in tables {
            self.tell_unused(table, &missing, tables);
        }
    }

    /// Faults words for what the model does not declare, and for columns that `tables` do not have.
    fn check_words(&mut self, words: &[ColumnWord], known: &[&str], tables: &[&Table], who: &str) {
        let in_formulas = words.iter().filter_map(|word| word.formula.as_ref());
        let in_formulas: Vec<&str> =
            in_formulas.flat_map(|formula| formula.root.names()).map(|(name, _)| name).collect();
        for word in words {
            let name = word.name.text.as_str();
            if in_formulas.contains(&name) && !known.contains(&name) {
                continue;
            }
            let is_there = |table: &&Table, column: Option<&Choice>| match column {
                Some(column) => {
                    let is_formula = word.formula.is_some() && name != TIME;
                    let is_computed = is_formula && table.column(name).is_some();
                    table.has(name, column) || is_computed
                }
                None => table.column(name).is_some(),
            };
            let added = word.added.iter().map(|(column, _)| Some(column));
            let mut parts = [word.column.as_ref()].into_iter().chain(added);
            let missing = parts.find(|column| !tables.iter().any(|table| is_there(table, *column)));
            if !known.contains(&name) {
                self.reader.unknown(word.name.span, "input or measurand", name, known);
            } else if let Some(column) = missing {
                let column = column.map_or(name.to_owned(), ToString::to_string);
                let has = if who.starts_with("no ") { "has a" } else { "has no" };
                let message = format!("{who} {has} column `{column}`");
                let found: Vec<String> = tables.iter().map(|table| table.names()).collect();
                let found = format!("columns found: {}", found.join("; "));
                let has_header = tables.iter().any(|table| table.layout.header.is_some());
                let is_digits = has_header && column.parse::<usize>().is_ok();
                let help = match &word.formula {
                    Some(_) if name == TIME => format!("{NO_FORMULA}: {OF_TIME}; {found}"),
                    _ if is_digits => format!(
                        "{found}; in quotes a number counts columns of a file without header row alone: where there is none, say `header = false` beside `file`; else write `{name} = {{ column = {column}, unit = \"...\" }}`"
                    ),
                    _ => found,
                };
                let fault = Diagnostic::error(message).at(word.name.place.clone()).help(help);
                let doubt = tables.iter().find_map(|table| table.header_help());
                self.reader.report(doubt.into_iter().fold(fault, Diagnostic::help));
            }
        }
    }

    /// Warns of names in `unused` that are none of a column, each once.
    fn warn_of_wrong_unused(&mut self, table: &Table) {
        let is_there = |name: &&String| table.columns.iter().any(|one| one.name == **name);
        for name in table.form.unused.iter().filter(|name| !is_there(name)) {
            let file = table.path.display();
            let message = format!("`unused` names `{name}`, which is no column of `{file}`");
            if self.warned.insert(message.clone()) {
                self.warnings.push(Diagnostic::warning(message));
            }
        }
    }

    /// Faults words of a file for columns that its `unused` takes away.
    fn check_used(&mut self, file: &TableEntry) {
        for word in &file.columns {
            let stated = word.column.iter().chain(word.added.iter().map(|(column, _)| column));
            for column in stated.map(ToString::to_string) {
                if file.form.is_unused(&column) {
                    let file = &file.name.text;
                    let message = format!("the column `{column}` of `{file}` is in `unused`, too");
                    self.reader.fault(word.name.span, message, "keep one of the two entries");
                }
            }
        }
    }

    /// Warns of columns that nothing declares, each once; `missing` are names that no column has.
    fn tell_unused(&mut self, table: &Table, missing: &[&str], tables: &[&Table]) {
        self.warn_of_wrong_unused(table);
        // One file may be the data and a stream.
        let is_used_or_known = |column: &&Column| {
            let mut same = tables.iter().filter(|other| other.path == table.path);
            same.any(|other| {
                let own = other.columns.get(column.index);
                own.is_some_and(|own| own.wanted.is_some()) || other.form.is_unused(&column.name)
            })
        };
        let named = table.columns.iter().filter(|column| column.is_named);
        let unused = named.filter(|column| !is_used_or_known(column));
        let unused: Vec<_> =
            unused.filter(|column| self.warned.insert(column.name.clone())).collect();
        let Some(first) = unused.first() else { return };
        let names = unused.iter().map(|column| column.name.as_str());
        let (is_one, model) = (unused.len() == 1, &self.model.name);
        let columns = match (table.is_outside(), is_one) {
            (true, true) => "a column is".to_owned(),
            (true, false) => format!("{} columns are", unused.len()),
            (false, true) => format!("the column `{}` is", shortened(&first.name)),
            (false, false) => format!("the columns {} are", listed(names, MOST_NAMES, "`")),
        };
        let does = if is_one { "does not declare it" } else { "does not declare them" };
        let near = |column: &&&Column| nearest(&column.name, missing.iter().copied());
        let place = if table.is_outside() {
            *first
        } else {
            unused.iter().find(|column| near(column).is_some()).unwrap_or(first)
        };
        let warning = Diagnostic::warning(format!("{columns} not used: model `{model}` {does}"));
        let mut warning = warning.at(table.header_place(place));
        if table.is_outside() {
            let why = format!(
                "their names are not shown, for the file {OUTSIDE}; --show-outside shows them, and `unused = [...]` beside `file` ends this warning"
            );
            self.warnings.push(warning.help(why));
            return;
        }
        for column in unused.iter().take(MOST_NAMES) {
            warning = match near(&column) {
                Some(near) if is_one => warning.help(format!("did you mean `{near}`?")),
                Some(near) => warning.help(format!("`{}`: did you mean `{near}`?", column.name)),
                None => warning,
            };
        }
        self.warnings.push(warning);
    }
}

/// What a word states of a column; `all` may say more of the columns that its formula names.
fn stated(word: &ColumnWord, all: &[&ColumnWord]) -> Stated {
    let column = |column: &Option<Choice>, unit: &Option<Unit>| Stated {
        column: column.clone(),
        unit: unit.clone(),
        ..Stated::default()
    };
    let plain = |word: &ColumnWord| Stated {
        added: word.added.iter().map(|(own, unit)| column(&Some(own.clone()), unit)).collect(),
        ..column(&word.column, &word.unit)
    };
    let formula = word.formula.as_ref().filter(|_| word.name.text != TIME);
    let Some(formula) = formula else { return plain(word) };
    let names = formula.root.names().into_iter().map(|(name, _)| name);
    let of = |name: &str| {
        let own = all.iter().find(|own| own.name.text == name && own.formula.is_none())?;
        Some((name.to_owned(), plain(own)))
    };
    Stated {
        formula: Some(formula.clone()),
        sources: names.filter_map(of).collect(),
        ..plain(word)
    }
}
