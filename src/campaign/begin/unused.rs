//! Columns of the logs that a campaign does not use: it lists them, so that no command warns of them.

use crate::campaign::begin::log::Log;
use crate::campaign::begin::text::Table;
use crate::campaign::begin::word::quoted;
use crate::campaign::origin::listed;

/// The most columns of a log that are listed.
const MOST_NAMES: usize = 12;

/// Lists in each table the columns of its log that none of the tables takes, with what the model takes;
/// a line for each log.
pub(super) fn list(logs: [&Log; 2], tables: &mut [Table], takes: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let [data, stream] = logs;
    let is_one = std::ptr::eq(data, stream);
    for log in std::iter::once(data).chain((!is_one).then_some(stream)) {
        let path = &log.survey.path;
        let own = tables.iter().filter(|table| table.path == *path);
        let words = own.flat_map(|table| &table.words).map(|word| word.candidate.column);
        let stamps = log.guess.time.iter().flat_map(|time| &time.parts).map(|part| part.column);
        let used: Vec<usize> = words.chain(stamps).collect();
        let columns = log.survey.columns.iter().enumerate();
        let unused = columns.filter(|(at, column)| column.is_named && !used.contains(at));
        let unused: Vec<&str> = unused.map(|(_, column)| column.name.as_str()).collect();
        if unused.is_empty() {
            continue;
        }
        let names = listed(unused.iter().copied(), MOST_NAMES, "`");
        lines.push(format!("not used of `{}`: {names}; the model takes {takes}", path.display()));
        // Where a column is to be chosen, any may be used.
        let mut own = tables.iter().filter(|table| table.path == *path);
        if own.any(|table| !table.open.is_empty()) {
            continue;
        }
        let all: Vec<String> = unused.iter().map(|name| quoted(name)).collect();
        let key = format!("unused = [{}],   # the model takes {takes}", all.join(", "));
        let own = tables.iter_mut().filter(|table| table.path == *path);
        own.for_each(|table| table.unused = Some(key.clone()));
    }
    lines
}
