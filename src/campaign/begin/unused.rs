//! Columns of the logs that a campaign does not use.

use crate::campaign::begin::log::Log;
use crate::campaign::begin::text::Table;
use crate::campaign::origin::listed;

/// The most columns of a log that are listed.
const MOST_NAMES: usize = 12;

/// A line for each log with the columns that none of the tables takes, and what the model takes.
pub(super) fn of(logs: [&Log; 2], tables: &[Table], takes: &str) -> Vec<String> {
    let line = |log: &Log| {
        let path = &log.survey.path;
        let own = tables.iter().filter(|table| table.path == *path);
        let words = own.flat_map(|table| &table.words).map(|word| word.candidate.column);
        let stamps = log.guess.time.iter().flat_map(|time| &time.parts).map(|part| part.column);
        let used: Vec<usize> = words.chain(stamps).collect();
        let columns = log.survey.columns.iter().enumerate();
        let unused = columns.filter(|(at, _)| !used.contains(at));
        let unused: Vec<&str> = unused.map(|(_, column)| column.name.as_str()).collect();
        let names = listed(unused.iter().copied(), MOST_NAMES, "`");
        let line = format!("not used of `{}`: {names}; the model takes {takes}", path.display());
        (!unused.is_empty()).then_some(line)
    };
    let [data, stream] = logs;
    let is_one = std::ptr::eq(data, stream);
    let logs = std::iter::once(data).chain((!is_one).then_some(stream));
    logs.filter_map(line).collect()
}
