//! The header of a table: which of its columns are wanted, and in which units they are.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use crate::campaign::calendar::{FORMS, seeming};
use crate::campaign::column_units::{by_name, counts, read_unit};
use crate::campaign::computed::Computation;
use crate::campaign::form::{Form, is_missing};
use crate::campaign::formats::{Format, Role, ahead_of_utc, unit_since_1970};
use crate::campaign::origin::Origin;
use crate::campaign::recognise::Head;
use crate::campaign::recognise::layout::Layout;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::units::Unit;

pub(crate) use crate::campaign::wanted::{ADDED, ONE_COLUMN};
pub use crate::campaign::wanted::{Choice, Stated, TIME, Wanted};

/// The columns of a file, and the format in which it is.
pub(crate) struct Header {
    pub(crate) columns: Vec<Column>,
    pub(crate) format: Option<&'static Format>,
    /// Wanted columns that are computed from others.
    pub(crate) computed: Vec<(String, Computation)>,
}

/// A column that was chosen: for what, the unit that the campaign states, that of its format, and
/// whether it is added to another one.
struct Chosen<'w> {
    want: &'w Wanted,
    stated: Option<&'w Unit>,
    usual: Option<Unit>,
    is_added: bool,
}

/// A column of a table.
#[derive(Clone, Debug)]
pub struct Column {
    /// Its name in the file; its number where it has none.
    pub name: String,
    /// Whether the file names it.
    pub is_named: bool,
    /// The wanted column it is, if any.
    pub wanted: Option<String>,
    /// Its unit in the file (`1` where it is not wanted).
    pub unit: Unit,
    /// Number of the column, from 0.
    pub index: usize,
    /// Values in SI, NaN where missing; empty where it is not wanted.
    pub values: Vec<f64>,
}

/// Splits a header cell into its name and its unit with the unit's bytes within the cell: `x [m]`,
/// or `x (m)` where that is a unit.
pub fn split(cell: &str) -> (&str, Option<(&str, usize)>) {
    let parts = |open: char, close: char| {
        let open = cell.find(open).filter(|_| cell.ends_with(close))?;
        Some((cell[..open].trim(), (&cell[open + 1..cell.len() - 1], open + 1)))
    };
    // `q[0]` names an element; `[1]` may be the unit 1.
    let is_index = |text: &str| text.parse::<u32>().is_ok_and(|index| index != 1);
    if let Some((name, unit)) = parts('[', ']').filter(|(_, unit)| !is_index(unit.0)) {
        return (name, Some(unit));
    }
    match parts('(', ')') {
        Some((name, unit)) if !name.is_empty() && Unit::parse(unit.0).is_ok() => (name, Some(unit)),
        _ => (cell.trim(), None),
    }
}

/// Files of more columns are in no format that is recognised.
const MOST_OF_FORMAT: usize = 1000;
/// How many faults of a header are reported.
const MOST_FAULTS: usize = 20;

/// Names of a file's columns with the places of their cells, and of the units in them.
struct Names<'a> {
    cells: Vec<(&'a str, (usize, usize))>,
    /// The first column of a name, and the second one if it is not the only one.
    places: HashMap<&'a str, (usize, Option<usize>)>,
    /// Whether a column may be meant by digits: no row of names says otherwise.
    by_digits: bool,
}

impl<'a> Names<'a> {
    fn of(layout: &'a Layout) -> Self {
        let Some(header) = &layout.header else {
            let cells = vec![("", (0, 0)); layout.width];
            return Self { cells, places: HashMap::new(), by_digits: true };
        };
        let cells = header.names();
        let mut places: HashMap<&str, (usize, Option<usize>)> = HashMap::new();
        for (index, (cell, _)) in cells.iter().enumerate() {
            let name = split(cell).0;
            if !name.is_empty() {
                let known = places.entry(name).or_insert((index, None));
                if known.0 != index {
                    known.1.get_or_insert(index);
                }
            }
        }
        Self { cells, places, by_digits: header.start > 0 }
    }

    /// The names without units; empty where there are none.
    fn plain(&self) -> Vec<&'a str> {
        self.cells.iter().map(|(cell, _)| split(cell).0).collect()
    }

    /// The format of the file, as stated or recognised; chooses columns for roles that have none.
    fn format<'w>(
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
    fn add_to_stamp<'w>(
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
    fn place<'w>(&self, want: &'w Wanted) -> Option<(usize, Option<usize>, Option<&'w Unit>)> {
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

impl Choice {
    /// Whether it is one of these columns.
    pub(crate) fn is_among(&self, columns: &[Column]) -> bool {
        match self {
            Self::Number(number) => (1..=columns.len()).contains(number),
            Self::Name(name) => columns.iter().any(|column| column.name == *name),
        }
    }
}

/// The first cell of a column, where it is neither a number nor a date, a time of day or a reading
/// that is missing.
fn no_stamp<'a>(layout: &'a Layout, form: &Form, column: usize) -> Option<&'a str> {
    let cell = layout.first_cell(column)?;
    let is_number = form.decimal.clone().number(cell, layout.separator).is_some();
    let is_known = is_number || seeming(cell).is_some() || is_missing(&form.missing, cell);
    Some(cell).filter(|cell| !cell.is_empty() && !is_known)
}

/// The fault of a file that does not say what its columns are.
pub(crate) fn no_header(origin: &Origin, layout: &Layout) -> Diagnostic {
    let (line, text) = &layout.first;
    Diagnostic::error("the file has no header row")
        .at(origin.place(*line, text, (0, text.len())))
        .help("the first row names the columns, each with its unit: `time [s],distance [m]`")
        .help("where the row of names is in another line, write its number beside `file`: header = 4")
        .help("where there is none, count the columns: header = false, columns = { time = { column = 1, unit = \"s\" } }")
}

/// The fault of a file of which no line is a row.
pub(crate) fn no_rows(origin: &Origin, head: &Head<'_>) -> Diagnostic {
    let is_list = |(_, text): &&(usize, &str)| text.contains([',', ';', '\t']);
    match head.comments.iter().find(is_list) {
        Some((number, text)) => {
            let begin = text.chars().next().unwrap_or('#');
            let help = format!(
                "rows of numbers come behind it; a line that begins with `{begin}` is a comment"
            );
            Diagnostic::error("the file has no rows: all of its lines are comments")
                .at(origin.place(*number, text, (0, text.len())))
                .help(help)
        }
        None => Diagnostic::error("the file has no header row")
            .at(origin.place(1, "", (0, 0)))
            .help("start the file with a row of column names, `name [unit]`, separated by commas"),
    }
}

/// Reads a header.
pub(crate) fn read(
    origin: &Origin,
    layout: &Layout,
    form: &Form,
    wanted: &[Wanted],
) -> Result<Header, Diagnostics> {
    let all = Names::of(layout);
    let header = layout.header.as_ref();
    let (line, text) =
        header.map_or((layout.first.0, &layout.first.1), |header| (header.line, &header.text));
    let at = |span| origin.place(line, text, span);
    let is_number = |(cell, _): &(&str, _)| split(cell).0.parse::<f64>().is_ok();
    let is_mixed = header.is_some() && form.header.is_none() && all.cells.iter().any(is_number);
    let mut chosen: HashMap<usize, Chosen<'_>> = HashMap::new();
    let mut faults = Vec::new();
    // What the campaign states comes before what is called like it.
    let is_stated = |want: &&Wanted| want.stated.column.is_some();
    for want in wanted.iter().filter(is_stated).chain(wanted.iter().filter(|w| !is_stated(w))) {
        let Some((index, other, unit)) = all.place(want) else { continue };
        if let Some(other) = other.filter(|_| !chosen.contains_key(&index)) {
            let (cell, span) = all.cells[other];
            let message = format!("the column `{}` is here twice", origin.word(split(cell).0));
            let help = format!(
                "say which one by its number: columns = {{ {} = {{ column = {} }} }}",
                want.name,
                index + 1
            );
            faults.push(Diagnostic::error(message).at(at(span)).help(help));
        }
        chosen.entry(index).or_insert(Chosen { want, stated: unit, usual: None, is_added: false });
    }
    if is_mixed {
        return Err(no_header(origin, layout).into());
    }
    let format = all.format(layout, form, &mut chosen, wanted);
    if let Some(format) = format.filter(|_| form.format.is_some()) {
        let lacks =
            format.columns.iter().all(|(role, ..)| format.place(*role, &all.plain()).is_none());
        if lacks {
            let message = format!("the file is not in the format `{}`", format.name);
            let help = format!("expected: {}", format.about);
            let fault = Diagnostic::error(message).at(at((0, text.len()))).help(help);
            return Err(fault.into());
        }
    }
    let taken = all.add_to_stamp(layout, format, &mut chosen);
    let is_sum = chosen.values().any(|one| one.is_added);
    let sources = sources(wanted, &all, &chosen);
    let mut of_formulas = Vec::new();
    for (own, want) in sources.iter().flat_map(|(own, all)| all.iter().map(move |one| (*own, one)))
    {
        if let Some((index, _, unit)) = all.place(want) {
            // The parts of a sum have no values of their own.
            if chosen.get(&index).is_some_and(|known| is_sum && known.want.name == TIME) {
                of_formulas.push((index, own));
            }
            chosen.entry(index).or_insert(Chosen {
                want,
                stated: unit,
                usual: None,
                is_added: false,
            });
        }
    }
    for (index, other) in taken.into_iter().chain(of_formulas) {
        let (cell, span) = all.cells[index];
        let name = match split(cell).0 {
            "" => (index + 1).to_string(),
            name => origin.word(name).into_owned(),
        };
        let (message, help) = match other.name.as_str() {
            TIME => (format!("the list has the column `{name}` twice"), "keep one of them"),
            other => (format!("`{TIME}` and `{other}` name the same column, `{name}`"), ONE_COLUMN),
        };
        faults.push(Diagnostic::error(message).at(at(span)).help(help));
    }
    let first_stamp =
        |index: usize| form.decimal.clone().number(layout.first_cell(index)?, layout.separator);
    let is_dated = |index| layout.first_cell(index).and_then(seeming).is_some();
    let mut columns = Vec::with_capacity(all.cells.len());
    for (index, (cell, span)) in all.cells.iter().enumerate() {
        if faults.len() >= MOST_FAULTS {
            break;
        }
        let (name, unit) = split(cell);
        let is_named = !name.is_empty();
        let name = if is_named { name.to_owned() } else { (index + 1).to_string() };
        let mut column =
            Column { name, is_named, wanted: None, unit: Unit::one(), index, values: Vec::new() };
        if let Some(Chosen { want, stated, usual, is_added }) = chosen.get(&index) {
            let is_source = !wanted.iter().any(|own| std::ptr::eq(own, *want));
            column.wanted = Some(match (is_source, is_added) {
                (true, _) => format!("{} of a formula", want.name),
                (_, true) => ADDED.to_owned(),
                _ => want.name.clone(),
            });
            let since_1970 = match want.role {
                Some(Role::Time(_)) if !is_added => first_stamp(index).and_then(unit_since_1970),
                _ => None,
            };
            let usual =
                usual.clone().filter(|_| unit.is_none_or(|(unit, _)| unit.trim().is_empty()));
            let usual = usual.map(|usual| {
                since_1970.and_then(|symbol| Unit::parse(symbol).ok()).unwrap_or(usual)
            });
            let stated = stated.cloned().or(usual);
            // A date has no unit, whatever stands there.
            let is_dated = want.role == Some(Role::Time(0)) && is_dated(index);
            if let Some(hours) = ahead_of_utc(&column.name).filter(|_| is_dated) {
                let message =
                    format!("stamps in `{}` are {hours} h ahead of UTC", origin.word(&column.name));
                let help = "let the program that writes the file write UTC or GPST";
                faults.push(Diagnostic::error(message).at(at(*span)).help(help));
            }
            let (stated, unit) =
                if is_dated { (Some(Unit::second()), None) } else { (stated, unit) };
            let is_without = !is_source && stated.is_none() && unit.is_none();
            let is_stamp = want.role == Some(Role::Time(0)) && is_without;
            if let Some(word) = no_stamp(layout, form, index).filter(|_| is_stamp) {
                let message = format!(
                    "expected a number, a date or a time of day in column `{}`, found `{}`",
                    origin.word(&column.name),
                    origin.word(word)
                );
                faults.push(Diagnostic::error(message).at(at(*span)).help(FORMS));
                columns.push(column);
                continue;
            }
            let hint = since_1970.or_else(|| by_name(&column.name, &want.unit));
            let accepts = (!is_source).then_some(&want.unit);
            let read = read_unit(origin, want, accepts, stated, (&column.name, hint), unit);
            match read.and_then(|unit| counts(unit, since_1970)) {
                Ok(unit) => column.unit = unit,
                Err(fault) => {
                    let (diagnostic, inside) = *fault;
                    let inside = inside.map_or(*span, |(a, b)| (span.0 + a, span.0 + b));
                    faults.push(diagnostic.at(at(inside)));
                }
            }
        }
        columns.push(column);
    }
    let computed = match faults.is_empty() {
        true => computed(&sources, &all, &columns, &mut faults),
        false => Vec::new(),
    };
    Diagnostics(faults).into_result(Header { columns, format, computed })
}

/// A wanted column that is computed, and the columns from which.
type Sources<'w> = (&'w Wanted, Vec<Wanted>);

/// What the formulas need that this file can compute: those all of whose names are columns of it.
fn sources<'w>(
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
fn computed(
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
