//! Where each input of a measured run comes from: a constant, a column of the data, a stream.

use crate::campaign::captured::columns_of;
use crate::campaign::declared::RunEntry;
use crate::campaign::header::Column;
use crate::campaign::loader::Loader;
use crate::campaign::signal::Track;
use crate::campaign::table::Table;
use crate::diagnostic::{Diagnostic, nearest};

impl Loader<'_> {
    /// Where an input comes from in this run.
    pub(crate) fn track(
        &mut self,
        index: usize,
        entry: &RunEntry,
        data: &Table,
        streams: &[Table],
    ) -> Track {
        let model = self.model;
        let input = &model.inputs[index];
        let constant = entry.inputs.iter().find(|(name, _)| name.text == input.name);
        let tables: Vec<&Table> = [data].into_iter().chain(streams).collect();
        let streams: Vec<_> = streams.iter().filter(|t| t.column(&input.name).is_some()).collect();
        let captured = data.values(&input.name).is_some();
        if usize::from(constant.is_some()) + usize::from(captured) + streams.len() > 1 {
            let message = format!("run `{}` has `{}` twice", entry.name.text, input.name);
            let help = "it is a column of the data, of one stream, or a constant of the run: keep one (`unused` beside `file` takes a column away)";
            self.reader.fault(entry.name.span, message, help);
            return Track::Absent;
        }
        if let Some((_, quantity)) = constant {
            self.reader.accept(quantity, &format!("`{}`", input.name), &input.unit);
            let mut constant = Track::Constant(quantity.value);
            if let Some(corrections) = &self.inputs[index].corrections {
                corrections.correct_track(&mut constant);
            }
            return constant;
        }
        if captured {
            return self.captured(index, data);
        }
        match streams.first() {
            Some(stream) => self.logged(index, entry, stream),
            None => {
                if self.inputs[index].needed {
                    let message =
                        format!("run `{}` has no column `{}`", entry.name.text, input.name);
                    let symbol = &input.unit.symbol;
                    let help = format!(
                        "write it as `{} [{symbol}]`, as a stream in `signals`, or as a constant in `inputs`; {}",
                        input.name,
                        columns_found(&input.name, &tables)
                    );
                    self.reader.fault(entry.name.span, message, help);
                }
                Track::Absent
            }
        }
    }

    /// An input recorded with each sample: which columns it has.
    fn captured(&mut self, index: usize, data: &Table) -> Track {
        let input = &self.model.inputs[index];
        let [_, rate, acceleration] = columns_of(&input.name);
        if let (None, Some(column)) = (data.column(&rate), data.column(&acceleration)) {
            self.reader.report(
                Diagnostic::error(format!("`{acceleration}` needs `{rate}` beside it"))
                    .at(data.header_place(column)),
            );
        }
        let empty = |name: &str| data.column(name).map(|_| Vec::new());
        Track::Captured {
            value: Vec::new(),
            rate: empty(&rate),
            acceleration: empty(&acceleration),
        }
    }
}

/// The columns of a run's files, and where one that nothing uses is called nearly like the input.
fn columns_found(name: &str, tables: &[&Table]) -> String {
    let each: Vec<String> =
        tables.iter().map(|table| format!("{} in `{}`", table.names(), table.name())).collect();
    let found = format!("columns found: {}", each.join("; "));
    let near = tables.iter().filter(|table| !table.is_outside()).find_map(|table| {
        let is_open = |one: &&Column| one.wanted.is_none() && !table.form.is_unused(&one.name);
        let unused = table.columns.iter().filter(|one| one.is_named).filter(is_open);
        Some((nearest(name, unused.map(|one| one.name.as_str()))?, table.name()))
    });
    match near {
        Some((near, file)) => format!(
            "did you mean `{near}` in `{file}`? columns = {{ {name} = \"{near}\" }} reads it so; {found}"
        ),
        None => found,
    }
}
